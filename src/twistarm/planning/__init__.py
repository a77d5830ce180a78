"""Motions in time: planning inside the limits, evaluation at any instant, files."""

from .active_limits import ActiveLimit, active_limits
from .joint_space import plan_joint
from .keep import Keep
from .motion import plan
from .motion_file import MotionFile, load_motion
from .refusal import PathError
from .segments import ArcMove, Dwell, FreeMove, JointMove, LineMove, ScrewMove, Segment
from .trajectory import Samples, Trajectory
from .trajectory_files import load_trajectory, save_trajectory

__all__ = [
    "ActiveLimit", "ArcMove", "Dwell", "FreeMove", "JointMove", "Keep", "LineMove", "MotionFile", "PathError",
    "Samples", "ScrewMove", "Segment", "Trajectory", "active_limits", "load_motion", "load_trajectory", "plan",
    "plan_joint", "save_trajectory",
]  # fmt: skip
