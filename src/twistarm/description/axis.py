"""A joint's axis from the description: a unit vector, or the reason why it is unusable."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..support.checks import Array
from .document import Reading, floats

AXIS_TOL = 1e-3
"""Deviation of an axis's length from 1 that gives a finding. The rounding of CAD exports is finer."""

SNAP = 2e-12
"""An axis so near to x, y or z is rounded to it. Pinocchio's parser rounds too, at 1e-12."""


def read_axis(element: ET.Element, kind: str, reading: Reading) -> tuple[Array, float]:
    """The unit axis and its length as written. The axis is x for a joint that needs none."""
    default = np.array([1.0, 0.0, 0.0])
    axis = element.find("axis")
    if axis is None or kind in ("fixed", "floating"):
        return default, 1.0
    try:
        vector = np.array(floats(axis.get("xyz", "1 0 0"), 3))
    except ValueError as error:
        raise reading.error(element, "axis-malformed", f"its <axis> is malformed: {error}") from error
    norm = float(np.linalg.norm(vector))
    if norm < 1e-9:
        remedy = "give the axis it moves along or about"
        raise reading.error(element, "axis-zero", "a moving joint with a zero axis", remedy)
    if abs(norm - 1.0) > AXIS_TOL:
        reading.note(
            "axis-not-unit",
            element,
            f"its axis {axis.get('xyz')} has length {norm:.4g}; only the direction counts",
            "write a unit vector",
            repaired=True,
        )
    unit = vector / norm
    nearest = np.round(unit)
    return (nearest if np.abs(unit - nearest).max() <= SNAP else unit), norm
