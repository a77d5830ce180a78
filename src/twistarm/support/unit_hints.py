"""Numbers that are plainly in another unit: angles in degrees, lengths in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from .checks import Array
from .messages import Quantity, Text

TURN = 2.0 * math.pi
"""A larger roll, pitch or yaw is one in degrees."""

FAR = 20.0
"""Nobody asks for a target at so many times the arm's reach."""


def angle_hint(angles: Array) -> str:
    """`an angle of 90 rad looks like degrees`; nothing where none goes beyond a whole turn."""
    largest = float(np.abs(angles).max(initial=0.0))
    return Text("an angle of {angle} looks like degrees", angle=Quantity(largest, "rad")) if largest > TURN else ""


def theta_hint(theta: Array, units: Sequence[str], lower: Array, upper: Array) -> str:
    """`angles of up to 90 rad look like degrees`, of joints (..., n).

    One stands outside its limits and beyond two turns, and none beyond 360.
    """
    if not np.abs(theta).max(initial=0.0) > 2.0 * TURN:
        return ""
    turning = np.array(units) == "rad"
    angles = np.abs(theta[..., turning])
    outside = ((theta < lower) | (theta > upper))[..., turning]
    beyond = angles[outside & (angles > 2.0 * TURN)]  # less may have been turned up
    plainly = beyond.size and angles.max() <= 360.0
    if not plainly:
        return ""
    return Text("angles of up to {angle} look like degrees", angle=Quantity(float(beyond.max()), "rad"))


def length_hint(distance: float, reach: float) -> str:
    """`583 m from the base looks like millimetres`; nothing for a distance that may be in metres."""
    return f"{distance:.4g} m from the base looks like millimetres" if distance > FAR * reach else ""
