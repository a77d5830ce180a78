"""The wiring check: do signs, ratios and zeros of the motors fit the measured tool?"""

from .base import BaseOffset
from .check import check_wiring
from .log import WiringLog, read_log
from .report import MotorVerdict, Residual, WiringReport

__all__ = ["BaseOffset", "MotorVerdict", "Residual", "WiringLog", "WiringReport", "check_wiring", "read_log"]
