"""One table of units: numbers with a unit, units in the headers of columns, and numbers plainly in another unit."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from math import isfinite, pi

import numpy as np

from .checks import Array
from .errors import InputError, quote
from .messages import Quantity, Text

UNITS: Mapping[str, Mapping[str, float]] = {
    "m": {"m": 1.0, "km": 1000.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    "rad": {"rad": 1.0, "radians": 1.0, "deg": pi / 180, "degrees": pi / 180, "°": pi / 180, "turn": 2 * pi},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "kg": {"kg": 1.0, "g": 0.001},
    "N": {"n": 1.0},
    "N m": {"n m": 1.0, "nm": 1.0},
    "Hz": {"hz": 1.0, "khz": 1000.0},
    "1": {"1": 1.0, "-": 1.0},
}
"""Quantities, named by their SI unit, and the units of each in small letters with their sizes in it.

A rate such as "rad/s" or "m/s²" is a quantity, too: see `factor`.
"""

RATE = re.compile(r"(.*?)\s*/\s*s(?:(?:\^|\*\*)?([23²³]))?")  # A unit per s, s² or s³: the unit and the power.
# A number and its unit.
NUMBER = re.compile(r"\s*([-+−]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*(.*?)\s*", re.DOTALL)
# A column's name with or without its unit: `x`, `x [mm]`, `roll (deg)`, `elbow_deg`.
HEADER = re.compile(r"(.*?)(?:\s*[\[(]\s*([^\])]*?)\s*[\])]|[_ ](m|cm|mm|rad|deg|degrees))?")


def units_of(quantity: str) -> tuple[str, ...]:
    """The units of a quantity, as they are written: those of "rad/s" are rad/s, deg/s and so on."""
    of, _, rate = quantity.partition("/")
    return tuple(f"{unit}/{rate}" if rate else unit for unit in UNITS.get(of, {of: 1.0}))


def factor(unit: str, quantity: str) -> float:
    """The size of a unit in the SI unit of `quantity`, 1 for no unit. That of deg/s in rad/s is π/180.

    Capitals do not matter, and a power may be written s2, s^2 or s². Raises InputError for a unit of another quantity.
    """
    of, power = _rate(quantity)
    base, given_power = _rate(unit.strip())
    size = UNITS.get(of, {}).get(base.casefold())
    if not unit.strip():
        return 1.0
    if size is None or power != given_power:
        raise InputError(f"the unit must be one of {', '.join(units_of(quantity))}; got {quote(unit)}")
    return size


def _rate(unit: str) -> tuple[str, str]:
    """A unit without its rate, and the power of s in the rate: "deg/s^2" gives deg and 2."""
    found = RATE.fullmatch(unit)
    return (found[1], (found[2] or "1").translate({178: "2", 179: "3"})) if found else (unit, "0")


def parse(text: str, quantity: str, default: str = "") -> float:
    """A written number such as `30 deg/s` or `500 g` in the SI unit of `quantity`. `default` is its unit without one.

    Raises InputError for anything else, and for a number beyond the floats.
    """
    found = NUMBER.fullmatch(text)
    value = float(found[1].replace("−", "-")) * factor(found[2] or default, quantity) if found else float("nan")
    if not isfinite(value):
        raise InputError(f"a finite number in {' or '.join(units_of(quantity))} is wanted; got {quote(text)}")
    return value


def column(header: str, known: Mapping[str, str]) -> tuple[str | None, str]:
    """The quantity that a column's header names, by the names in `known`, and its unit. None if none is known."""
    found = HEADER.fullmatch(header.strip())
    name, unit = (found[1], found[2] or found[3] or "") if found else (header, "")
    for written, its_unit in ((header.strip(), ""), (name, unit)):
        quantity = known.get(written) or known.get(written.casefold())
        if quantity is not None:
            return quantity, its_unit
    return None, ""


TURN = 2.0 * math.pi  # A larger roll, pitch or yaw is one in degrees.
FAR = 20.0  # Nobody asks for a target at so many times the arm's reach.


def angle_hint(angles: Array) -> str:
    """`an angle of 90 rad looks like degrees`; nothing where none goes beyond a whole turn."""
    largest = float(np.abs(angles).max(initial=0.0))
    return Text("an angle of {angle} looks like degrees", angle=Quantity(largest, "rad")) if largest > TURN else ""


def theta_hint(theta: Array, units: Sequence[str], lower: Array, upper: Array) -> str:
    """`angles of up to 90 rad look like degrees`, of joints (..., n).

    One is outside its limits and beyond two turns, and none beyond 360.
    """
    if not np.abs(theta).max(initial=0.0) > 2.0 * TURN:
        return ""
    turning = np.array(units) == "rad"
    angles = np.abs(theta[..., turning])
    outside = ((theta < lower) | (theta > upper))[..., turning]
    beyond = angles[outside & (angles > 2.0 * TURN)]  # less may have been turned up
    plainly = beyond.size and angles.max() <= 360.0  # nobody types more than a turn in degrees
    if not plainly:
        return ""
    return Text("angles of up to {angle} look like degrees", angle=Quantity(float(beyond.max()), "rad"))


def length_hint(distance: float, reach: float) -> str:
    """`583 m from the base looks like millimetres`. Nothing for a distance that may be in metres."""
    return f"{distance:.4g} m from the base looks like millimetres" if distance > FAR * reach else ""
