"""The names of a motion's columns in CSV, each with its unit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

TIME = "time [s]"
LABEL = "label"

JOINTS = {"position": "", "velocity": "/s", "acceleration": "/s^2"}
MOTORS = {"motor_position": "", "motor_velocity": "/s"}
COUNTS = {"counts": "", "counts_rate": "/s"}
"""Rates and what follows their unit, in ASCII: spreadsheets guess at anything else. Motors are on their own side of the
gears; counts are what their drives count.
"""


def columns(rates: Mapping[str, str], names: Sequence[str], units: Sequence[str]) -> list[list[str]]:
    """Of every joint or motor its position, then its velocity, and so on."""
    return [
        [f"{name}.{rate} [{unit}{per}]" for name, unit in zip(names, units, strict=True)] for rate, per in rates.items()
    ]
