"""Inverse kinematics: targets, the solver, and solutions that say what was reached and why not more."""

from . import subproblems
from .all_solutions import IKSolutions
from .batch import IKBatch, solve_ik_batch
from .request import POSTURES
from .solution import IKSolution
from .solve import solve_ik
from .solve_all import solve_ik_all
from .stop_reason import StopReason
from .targets import AnyTarget, Approach, Pose, Position, TargetLike, Task
from .task_space import Target

__all__ = [
    "POSTURES",
    "AnyTarget",
    "Approach",
    "IKBatch",
    "IKSolution",
    "IKSolutions",
    "Pose",
    "Position",
    "StopReason",
    "Target",
    "TargetLike",
    "Task",
    "solve_ik",
    "solve_ik_all",
    "solve_ik_batch",
    "subproblems",
]
