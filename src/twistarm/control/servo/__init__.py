"""The servo: from a command to joint rates, one pure step at a time."""

from .command import AnyCommand, CommandLike, JogCommand, PoseCommand, TwistCommand
from .output import ServoOutput, ServoReason, ServoStatus
from .settings import ServoSettings
from .state import ServoState
from .step import servo_step

__all__ = [
    "AnyCommand", "CommandLike", "JogCommand", "PoseCommand", "ServoOutput", "ServoReason", "ServoSettings",
    "ServoState", "ServoStatus", "TwistCommand", "servo_step",
]  # fmt: skip
