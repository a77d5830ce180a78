"""What a log shows of an arm: its motors' wiring, its geometry, and a camera (hand-eye calibration)."""

from .calibrate import calibrate
from .calibration import Calibration, Estimate, corrected_urdf
from .camera import HandEye
from .geometry import Parameter
from .measurements import Measurements, read_measurements
from .wiring_verdicts import MotorVerdict, WiringReport, check_wiring

__all__ = [
    "Calibration", "Estimate", "HandEye", "Measurements", "MotorVerdict", "Parameter", "WiringReport", "calibrate",
    "check_wiring", "corrected_urdf", "read_measurements",
]  # fmt: skip
