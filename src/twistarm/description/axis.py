"""A joint's axis: a unit vector, or the reason why there is none."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from ..support.checks import Array
from .document import Reading
from .numerals import floats

AXIS_TOL = 1e-3
"""A longer or shorter axis than this is worth a word: no rounding of a CAD export is that coarse."""

SNAP = 2e-12
"""So near to x, y or z, an axis is that one: Pinocchio's parser rounds so too, at 1e-12."""


def read_axis(element: ET.Element, kind: str, reading: Reading) -> tuple[Array, float]:
    """The unit axis and its length as written; for a joint that needs none, x."""
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
