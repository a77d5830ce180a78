"""The distance of a configuration from singularities in words: the motions that the tool nearly lacks."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ...support.directions import leading
from ...theory.manipulability import Manipulability

SLIGHT = 0.05
"""A part of a unit direction below this is left unsaid."""


def standing(found: Manipulability, rank: int, below: float) -> str:
    """The rank, and the directions, in tool axes, of singular values under `below`."""
    values = found.singular_values
    if not len(values):
        return "No joint moves the tool."
    weak = [_motion(found.axes[:, i]) for i in range(len(values)) if values[i] < below]
    hard = weak[: len(weak) - (len(values) - rank)]
    lost = weak[len(hard) :]
    said = f"Rank {rank} of {len(values)}"
    if lost:
        said += f", singular: the tool cannot {', nor '.join(lost)}"
    if hard:
        said += f"{'; it' if lost else ', nearly singular: the tool'} can hardly {', nor '.join(hard)}"
    return f"{said}."


def _motion(direction: Array) -> str:
    """A tool twist (v, w), v in units of the length, in words."""
    v, w = direction[:3], direction[3:]
    if np.linalg.norm(w) < SLIGHT:
        return f"move along {_direction(v)}"
    if np.linalg.norm(v) < SLIGHT:
        return f"turn about {_direction(w)}"
    return f"move along {_direction(v)} while it turns about {_direction(w)}"


def _direction(vector: Array) -> str:
    """`its x`, or three numbers."""
    unit = vector / np.linalg.norm(vector)
    largest = leading(np.abs(unit))
    if abs(unit[largest]) > 1.0 - SLIGHT**2:
        return f"its {'xyz'[largest]}"
    x, y, z = np.round(unit, 2) + 0.0  # no minus before 0
    return f"its ({x:.2f}, {y:.2f}, {z:.2f})"
