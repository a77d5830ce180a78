"""The servo: from a command to joint rates, one pure step at a time."""

from .command import AnyCommand, CommandLike, JogCommand, PoseCommand, TwistCommand
from .output import STATUSES, ServoOutput, ServoReason
from .settings import ServoSettings
from .step import ServoState, servo_step

__all__ = [
    "STATUSES", "AnyCommand", "CommandLike", "JogCommand", "PoseCommand", "ServoOutput", "ServoReason", "ServoSettings",
    "ServoState", "TwistCommand", "servo_step",
]  # fmt: skip
