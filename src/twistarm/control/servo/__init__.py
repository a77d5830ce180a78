"""The servo: from a command to joint rates, one pure step at a time."""

from .command import AnyCommand, CommandLike, JogCommand, PoseCommand, TwistCommand
from .core_step import STATUSES, ServoReason
from .output import ServoOutput
from .settings import ServoSettings
from .state import ServoState
from .step import servo_step

__all__ = [
    "STATUSES", "AnyCommand", "CommandLike", "JogCommand", "PoseCommand", "ServoOutput", "ServoReason", "ServoSettings",
    "ServoState", "TwistCommand", "servo_step",
]  # fmt: skip
