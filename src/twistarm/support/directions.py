"""Directions by a rule instead of rounding: equal singular values, signs, equal components."""

from __future__ import annotations

import numpy as np

from .checks import Array

EQUAL = 1e-6
"""Components of unit vectors that differ by less are equally large."""


def leading(sizes: Array) -> int:
    """The index of the largest number of (k,), the first of equally large ones."""
    return int(np.argmax(sizes >= sizes.max() - EQUAL))


def signed(U: Array) -> Array:
    """The columns of (..., m, k) with the largest component of each positive, the first of equal ones."""
    sizes = np.abs(U)
    largest = np.argmax(sizes >= sizes.max(axis=-2, keepdims=True) - EQUAL, axis=-2, keepdims=True)
    turned: Array = U * np.where(np.take_along_axis(U, largest, axis=-2) < 0.0, -1.0, 1.0)
    return turned


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
