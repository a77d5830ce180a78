"""twistarm: the kinematics of robot arms in the language of screws.

Conventions, everywhere: SI units and radians; `theta` (..., n) is one number per degree of freedom, base to tip; a
pose `g_ab` (..., 4, 4) is frame b seen from frame a, p_a = g_ab @ p_b; a twist is (v, w), linear part first, as in
Murray, Li & Sastry and in Pinocchio; s is the space frame (the base link), t the tool frame (the tip link).
"""

from typing import TYPE_CHECKING, Any

from . import joints, poe, rotations, screws
from .actuators import Actuators
from .arm import Arm, Coupling, Proof
from .arm_builder import ArmBuilder
from .building import arm_from_screws
from .comparison import Comparison, CrossCheck, crosscheck
from .description.findings import Finding
from .doctor import diagnose
from .errors import (
    ComparisonError,
    DescriptionError,
    InputError,
    LimitError,
    MissingExtraError,
    NotConvergedError,
    TwistarmError,
    UnknownNameError,
)
from .golden import Difference, compare, freeze
from .ik import Approach, IKSolution, Pose, Position, StopReason, Task, solve_ik
from .limits import JointLimits
from .loading import available_arms, load_arm
from .manipulability import Manipulability
from .planning import Trajectory, plan_joint

if TYPE_CHECKING:
    from .viewer import Viewer, save_html

__version__ = "0.1.0"

__all__ = [
    "Actuators",
    "Approach",
    "Arm",
    "ArmBuilder",
    "Comparison",
    "ComparisonError",
    "Coupling",
    "CrossCheck",
    "DescriptionError",
    "Difference",
    "Finding",
    "IKSolution",
    "InputError",
    "JointLimits",
    "LimitError",
    "Manipulability",
    "MissingExtraError",
    "NotConvergedError",
    "Pose",
    "Position",
    "Proof",
    "StopReason",
    "Task",
    "Trajectory",
    "TwistarmError",
    "UnknownNameError",
    "Viewer",
    "arm_from_screws",
    "available_arms",
    "compare",
    "crosscheck",
    "diagnose",
    "freeze",
    "joints",
    "load_arm",
    "plan_joint",
    "poe",
    "rotations",
    "save_html",
    "screws",
    "solve_ik",
]


def __getattr__(name: str) -> Any:
    """The view's names, imported when first used: nothing else needs its modules."""
    if name in ("Viewer", "save_html"):
        from . import viewer

        return getattr(viewer, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
