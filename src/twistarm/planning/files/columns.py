"""The names of a motion's columns in CSV, each with its unit."""

from __future__ import annotations

from collections.abc import Sequence

from ...limits.actuators import Actuators

TIME = "time [s]"
LABEL = "label"

RATES = {"position": "", "velocity": "/s", "acceleration": "/s^2"}
"""In ASCII: spreadsheets guess at anything else."""


def joint_columns(names: Sequence[str], units: Sequence[str]) -> list[list[str]]:
    """Of every joint its position, then its velocity, then its acceleration."""
    joints = list(zip(names, units, strict=True))
    return [[f"{name}.{rate} [{unit}{per}]" for name, unit in joints] for rate, per in RATES.items()]


def motor_columns(motors: Actuators) -> list[list[str]]:
    """Of every motor its position, then its velocity, on its own side of the gears."""
    units = list(zip(motors.names, motors.motor_units, strict=True))
    return [
        [f"{name}.motor_position [{unit}]" for name, unit in units],
        [f"{name}.motor_velocity [{unit}/s]" for name, unit in units],
    ]


def count_columns(motors: Actuators) -> list[list[str]]:
    """Of every motor what its drive counts, then how fast."""
    units = list(zip(motors.names, motors.units, strict=True))
    return [
        [f"{name}.counts [{unit}]" for name, unit in units],
        [f"{name}.counts_rate [{unit}/s]" for name, unit in units],
    ]
