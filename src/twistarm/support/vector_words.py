"""Points, numbers and axes in words."""

from __future__ import annotations

import math

import numpy as np

from .checks import Array
from .directions import leading

ALONG_AXIS = 0.995
"""Cosine from which on a direction goes by the name of an axis, 5.7° from it."""


def axis_in_words(axis: Array, frame: str) -> str:
    """The line of a unit vector (3,) as the name of an axis of the "base" or the "tool", or as numbers."""
    return direction_in_words(axis * np.sign(axis[leading(np.abs(axis))]), frame)


def direction_in_words(direction: Array, frame: str) -> str:
    """A unit vector (3,) by the signed name of its axis, or in numbers."""
    largest = int(np.argmax(np.abs(direction)))
    if abs(direction[largest]) >= ALONG_AXIS:
        owner = "its" if frame == "tool" else "the base's"
        return f"{owner} {'−' * int(direction[largest] < 0)}{'xyz'[largest]} axis"
    components = ", ".join(f"{value:.2f}" for value in np.round(direction, 2) + 0.0)
    return f"({components}) in {frame} axes"


def value_in_words(value: float, unit: str) -> str:
    """A joint's value as a person reads it: metres or degrees."""
    return f"{value:.4g} m" if unit == "m" else f"{math.degrees(value):.1f}°"


def metres(p: Array) -> str:
    """A point (3,) [m]."""
    return f"{numbers(p)} m"


def numbers(values: Array) -> str:
    """Numbers in brackets, none of them −0."""
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 6) + 0.0) + ")"
