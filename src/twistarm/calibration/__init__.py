"""What a log tells of an arm: the wiring of its motors, and its geometry."""

from .calibrate import calibrate
from .calibration import Calibration, Estimate
from .check import check_wiring
from .corrected import corrected_urdf
from .geometry import Parameter
from .log import WiringLog, read_log
from .measurements import Measurements, read_measurements
from .model import BaseOffset
from .plot import plot_of
from .report import MotorVerdict, Residual, WiringReport

__all__ = [
    "BaseOffset", "Calibration", "Estimate", "Measurements", "MotorVerdict", "Parameter", "Residual", "WiringLog",
    "WiringReport", "calibrate", "check_wiring", "corrected_urdf", "plot_of", "read_log", "read_measurements",
]  # fmt: skip
