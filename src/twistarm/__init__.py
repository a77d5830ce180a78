"""twistarm: the kinematics of robot arms in the language of screws.

Conventions, everywhere: SI units and radians; `theta` (..., n) is one number per degree of freedom, base to tip; a
pose `g_ab` (..., 4, 4) is frame b seen from frame a, p_a = g_ab @ p_b; a twist is (v, w), linear part first, as in
Murray, Li & Sastry and in Pinocchio; s is the space frame (the base link), t the tool frame (the tip link).
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from .description.findings import Finding
    from .doctor import diagnose
    from .ik import Approach, IKBatch, IKSolution, Pose, Position, StopReason, Task, solve_ik, solve_ik_batch
    from .limits.actuators import Actuators
    from .limits.joint_limits import JointLimits
    from .loading.arm_builder import ArmBuilder
    from .loading.load import available_arms, load_arm
    from .model.arm import Arm, Coupling, Proof
    from .model.from_screws import arm_from_screws
    from .planning import Trajectory, plan_joint
    from .proof.crosscheck import Comparison, CrossCheck, crosscheck
    from .proof.difference import Difference, compare
    from .proof.golden_file import freeze
    from .servo import (
        JogCommand,
        PoseCommand,
        ServoOutput,
        ServoSettings,
        ServoState,
        ServoStatus,
        TwistCommand,
        servo_step,
    )
    from .support.errors import (
        ComparisonError,
        DescriptionError,
        InputError,
        LimitError,
        MissingExtraError,
        NotConvergedError,
        TwistarmError,
        UnknownNameError,
    )
    from .theory import joints, poe, rotations, screws
    from .theory.manipulability import Manipulability
    from .viewer import Viewer, save_html, save_png
    from .wiring import check_wiring

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
    "IKBatch",
    "IKSolution",
    "InputError",
    "JogCommand",
    "JointLimits",
    "LimitError",
    "Manipulability",
    "MissingExtraError",
    "NotConvergedError",
    "Pose",
    "PoseCommand",
    "Position",
    "Proof",
    "ServoOutput",
    "ServoSettings",
    "ServoState",
    "ServoStatus",
    "StopReason",
    "Task",
    "Trajectory",
    "TwistCommand",
    "TwistarmError",
    "UnknownNameError",
    "Viewer",
    "arm_from_screws",
    "available_arms",
    "check_wiring",
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
    "save_png",
    "screws",
    "servo_step",
    "solve_ik",
    "solve_ik_batch",
]

_NAMES = {
    "theory": ("joints", "poe", "rotations", "screws"),
    "limits.actuators": ("Actuators",),
    "model.arm": ("Arm", "Coupling", "Proof"),
    "loading.arm_builder": ("ArmBuilder",),
    "model.from_screws": ("arm_from_screws",),
    "proof.crosscheck": ("Comparison", "CrossCheck", "crosscheck"),
    "description.findings": ("Finding",),
    "doctor": ("diagnose",),
    "support.errors": (
        "ComparisonError",
        "DescriptionError",
        "InputError",
        "LimitError",
        "MissingExtraError",
        "NotConvergedError",
        "TwistarmError",
        "UnknownNameError",
    ),
    "proof.difference": ("Difference", "compare"),
    "proof.golden_file": ("freeze",),
    "ik": ("Approach", "IKBatch", "IKSolution", "Pose", "Position", "StopReason", "Task", "solve_ik", "solve_ik_batch"),
    "limits.joint_limits": ("JointLimits",),
    "loading.load": ("available_arms", "load_arm"),
    "theory.manipulability": ("Manipulability",),
    "planning": ("Trajectory", "plan_joint"),
    "servo": (
        "JogCommand",
        "PoseCommand",
        "ServoOutput",
        "ServoSettings",
        "ServoState",
        "ServoStatus",
        "TwistCommand",
        "servo_step",
    ),
    "stream": (),
    "viewer": ("Viewer", "save_html", "save_png"),
    "wiring": ("check_wiring",),
}
"""Names by module: each is imported when it is first asked for, so that the program can heed Ctrl-C
before; typing and importlib too.
"""


def __getattr__(name: str) -> Any:
    from importlib import import_module

    for module, names in _NAMES.items():
        if name == module or name in names:
            found = import_module(f".{module}", __name__)
            # Kept, so that this is asked once for each name.
            return globals().setdefault(name, found if name == module else getattr(found, name))
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
