"""The servo: from a command to joint rates, one pure step at a time."""

from .command import AnyCommand, JogCommand, PoseCommand, TwistCommand
from .output import ServoOutput, ServoStatus
from .settings import ServoSettings
from .state import ServoState
from .step import servo_step

__all__ = [
    "AnyCommand",
    "JogCommand",
    "PoseCommand",
    "ServoOutput",
    "ServoSettings",
    "ServoState",
    "ServoStatus",
    "TwistCommand",
    "servo_step",
]
