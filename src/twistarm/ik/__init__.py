"""Inverse kinematics: targets, solvers, and solutions that explain what was missed and why."""

from . import subproblems
from .all_solutions import AllSolutions
from .all_solutions_batch import AllSolutionsBatch, solve_ik_all_batch
from .answer import StopReason
from .batch import IKBatch, solve_ik_batch
from .closed_form.methods import ClosedFormReport, closed_form_of
from .reached import Reached, reachable
from .request import POSTURES
from .solution import IKResult
from .solve import solve_ik
from .solve_all import solve_ik_all
from .targets import AnyTarget, Approach, Pose, Position, Target, TargetLike, TolerancedPose

__all__ = [
    "POSTURES", "AllSolutions", "AllSolutionsBatch", "AnyTarget", "Approach", "ClosedFormReport", "IKBatch",
    "IKResult", "Pose", "Position", "Reached", "StopReason", "Target", "TargetLike", "TolerancedPose",
    "closed_form_of", "reachable", "solve_ik", "solve_ik_all", "solve_ik_all_batch", "solve_ik_batch",
    "subproblems",
]  # fmt: skip
