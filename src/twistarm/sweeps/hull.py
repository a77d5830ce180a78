"""The surface around the cubes of a map, as triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array

SMOOTHINGS = 2
"""Each moves every corner to the mean of its faces' middles. One is naive surface nets (S. F. F. Gibson, 1998)."""


def hull(values: Array) -> tuple[Array, NDArray[np.int64], Array]:
    """The closed surface of the cubes (nx, ny, nz) above 0, smoothed.

    Returns vertices (V, 3) in sides of a cube from the centre of the first, triangles (F, 3) that are counterclockwise
    seen from outside, and for each vertex (V,) the mean value of the cubes behind it.
    """
    padded = np.pad(values, 1)
    corners, behind = [np.empty((0, 4, 3), dtype=np.int64)], [np.empty(0)]
    for k, (step, a, b) in enumerate(np.roll(np.eye(3, dtype=np.int64), -k, axis=0) for k in range(3)):
        change = np.diff((padded > 0).astype(np.int8), axis=k)
        for towards, ends in ((-1, [0 * a, a, a + b, b]), (1, [0 * a, b, a + b, a])):
            cells = np.argwhere(change == towards)
            corners.append(cells[:, None] + step + ends)
            behind.append(padded[tuple((cells + (step if towards > 0 else 0)).T)])
    lattice, places = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    places = places.ravel()  # of NumPy 2.0 a column
    count = np.maximum(np.bincount(places), 1)

    def spread(faces: Array) -> Array:
        """The mean (V,) at each corner of what its faces have (F,)."""
        return np.array(np.bincount(places, np.repeat(faces, 4)) / count)

    axes: list[Array] = [*(lattice.T - 1.5)]
    for _ in range(SMOOTHINGS):
        axes = [spread(axis[places].reshape(-1, 4).mean(axis=1)) for axis in axes]
    faces = places.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
    return np.stack(axes, axis=-1), faces, spread(np.concatenate(behind))
