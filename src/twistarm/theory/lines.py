"""Lines in space: their points nearest to others, where they meet, and the turn from one direction to another."""

from __future__ import annotations

import numpy as np

from ..support.checks import Array
from .screws import to_screw

NO_LINE = 1e9  # m/rad. The axis of a twist with a larger pitch is far off: a slide that other machines round otherwise.

OPPOSITE = 1e-12
"""Two unit vectors whose cross product is shorter than this leave the axis between them to rounding."""


def least_turn(a: Array, b: Array) -> Array:
    """The rotation vector (3,) of the least turn from a unit vector a to b (3,), about some axis if opposite.

    The vectors are not checked.
    """
    axis, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(axis))
    if sine < OPPOSITE and cosine < 0.0:
        axis = np.cross(a, np.eye(3)[int(np.abs(a).argmin())])
    return axis * (np.arctan2(sine, cosine) / max(float(np.linalg.norm(axis)), 1e-200))


def nearest_on_line(axis: Array, point: Array, to: Array) -> Array:
    """The point (3,) nearest to `to` (3,) on the line through `point` along the unit vector `axis`."""
    return np.asarray(point + axis * (axis @ (to - point)))


def axis_points(screws: Array, start: Array) -> Array:
    """A point (m, 3) on the axis of each twist (6, m), nearest to the one before, the first to `start` (3,).

    A translation, which has no line, repeats the point before. A pitch beyond `NO_LINE` is one with rounding.
    """
    all_of_them, points = to_screw(screws.T), [start]
    for axis, point, pitch in zip(all_of_them.axis, all_of_them.point, all_of_them.pitch, strict=True):
        points.append(nearest_on_line(axis, point, points[-1]) if abs(pitch) < NO_LINE else points[-1])
    return np.reshape(points[1:], (-1, 3))


def meeting_point(axes: Array, points: Array) -> tuple[Array, float]:
    """The point (3,) with the least squared distances to lines, and the greatest of the distances [m].

    The lines have unit `axes` (k, 3) and go through `points` (k, 3). For parallel axes it is the one nearest to 0.
    """
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    target = np.einsum("kij,kj->i", across, points)
    centre = np.linalg.lstsq(across.sum(axis=0), target, rcond=1e-9)[0]
    off = np.linalg.norm(np.einsum("kij,kj->ki", across, centre - points), axis=1)
    return centre, float(off.max())
