"""The wiring check: do signs, ratios and zeros of the motors fit the measured tool?"""

from .check import check_wiring
from .log import WiringLog, read_log
from .model import BaseOffset
from .report import MotorVerdict, Residual, WiringReport

__all__ = ["BaseOffset", "MotorVerdict", "Residual", "WiringLog", "WiringReport", "check_wiring", "read_log"]
