"""Directions by a rule instead of rounding (equal singular values, signs, equal components), and vectors in words."""

from __future__ import annotations

import math

import numpy as np

from .checks import Array

EQUAL = 1e-6  # Components of unit vectors that differ by less are equally large.
ALONG_AXIS = 0.995  # Cosine from which on a direction goes by the name of an axis, 5.7° from it.


def leading(sizes: Array) -> int:
    """The index of the largest number of (k,), the first of equally large ones."""
    return int(np.argmax(sizes >= sizes.max() - EQUAL))


def signed(U: Array) -> Array:
    """The columns of (..., m, k) with the largest component of each positive, the first of equal ones."""
    sizes = np.abs(U)
    largest = np.argmax(sizes >= sizes.max(axis=-2, keepdims=True) - EQUAL, axis=-2, keepdims=True)
    return U * np.where(np.take_along_axis(U, largest, axis=-2) < 0.0, -1.0, 1.0)


def nearest_axes(P: Array, count: int) -> Array:
    """Orthonormal columns (m, count) in the range of a projector P (m, m), independent of its eigenvectors.

    The first is the projection of the coordinate axis nearest to the range, the first of equally near ones. The next
    follow from the rest of the range.
    """
    axes = np.zeros((len(P), count))
    for i in range(count):
        toward = P[:, leading(np.diagonal(P))]
        axes[:, i] = toward / np.linalg.norm(toward)
        P = P - np.outer(axes[:, i], axes[:, i])
    return axes


def axis_in_words(axis: Array, frame: str) -> str:
    """The line of a unit vector (3,) as the name of an axis of the "base" or the "tool", or as numbers."""
    return direction_in_words(axis * np.sign(axis[leading(np.abs(axis))]), frame)


def direction_in_words(direction: Array, frame: str) -> str:
    """A unit vector (3,) by the signed name of its axis, or in numbers."""
    largest = int(np.argmax(np.abs(direction)))
    if abs(direction[largest]) >= ALONG_AXIS:
        owner = "its" if frame == "tool" else "the base's"
        sign = "−" if direction[largest] < 0 else ""
        return f"{owner} {sign}{'xyz'[largest]} axis"
    components = ", ".join(f"{value:.2f}" for value in np.round(direction, 2) + 0.0)  # + 0.0: −0 is 0
    return f"({components}) in {frame} axes"


def value_in_words(value: float, unit: str) -> str:
    """A joint's value as a person reads it: metres or degrees."""
    return f"{value:.4g} m" if unit == "m" else f"{math.degrees(value):.1f}°"


def length_in_words(metres: float) -> str:
    """A length in m, mm or µm, by its size."""
    if metres >= 0.1:
        return f"{metres:.3f} m"
    return f"{1e3 * metres:.3g} mm" if metres >= 1e-5 else f"{1e6 * metres:.2g} µm" if metres >= 1e-8 else "nothing"


def angle_in_words(radians: float) -> str:
    """An angle in degrees. A tiny angle in rad."""
    return f"{math.degrees(radians):.2g}°" if radians > 1e-4 else f"{radians:.1e} rad"


def metres(p: Array) -> str:
    """A point (3,) [m]."""
    return f"{numbers(p)} m"


def numbers(values: Array) -> str:
    """Numbers in brackets, none of them −0."""
    return "(" + ", ".join(f"{value:.4g}" for value in np.round(values, 6) + 0.0) + ")"
