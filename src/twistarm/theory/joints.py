"""The six lower-pair joints as twists of one degree of freedom each, columns from base to tip.

A joint of k degrees of freedom moves by g(x) = e^{ξ̂₁x₁} ⋯ e^{ξ̂ₖxₖ}, a column for each. All columns are given in one
frame, for `poe` the space frame, with the joint at rest. MLS §3.2.

Directions may have any length but zero. InputError names a zero direction, another shape, or a number that is not
finite.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_direction, as_floats, as_rotation, as_vector, require_one
from ..support.errors import InputError


def revolute(axis: ArrayLike, point: ArrayLike) -> Array:
    """(6, 1): the turn [rad] about the line along `axis` (3,) through `point` (3,) [m]. ξ = (−ω × q, ω).

    Args:
        axis: Direction (3,).
        point: A point of the axis (3,) [m].
    """
    return helical(axis, point, 0.0)


def prismatic(axis: ArrayLike) -> Array:
    """(6, 1): the slide [m] along `axis` (3,). ξ = (v, 0) with the unit vector v."""
    return _column(_unit(axis, "axis"), np.zeros(3))


def helical(axis: ArrayLike, point: ArrayLike, pitch: float) -> Array:
    """(6, 1): the turn [rad] about a line, `pitch` [m/rad] of slide with it. ξ = (−ω × q + hω, ω). MLS §2.3.3.

    A thread that advances l metres per full turn has the pitch l/2π. Pitch 0 is `revolute`.

    Args:
        axis: Direction (3,).
        point: A point of the axis (3,) [m].
        pitch: Advance h [m/rad].
    """
    w, q, h = _unit(axis, "axis"), _vector(point, "point"), as_floats(pitch, "pitch")
    if h.ndim:
        raise InputError(f"pitch must be one number [m/rad]; got shape {h.shape}")
    return _column(np.cross(q, w) + h * w, w)


def cylindrical(axis: ArrayLike, point: ArrayLike) -> Array:
    """(6, 2): columns rz, z: the turn [rad] about a line and the slide [m] along it, which commute.

    Args:
        axis: Direction (3,).
        point: A point of the axis (3,) [m].
    """
    return np.hstack([revolute(axis, point), prismatic(axis)])


def spherical(point: ArrayLike, axes: ArrayLike | None = None) -> Array:
    """(6, 3): columns rz, ry, rx: every turn about `point` (3,) [m], as ZYX Euler angles [rad].

    A ball joint has no singularity, but these coordinates have: ry = ±π/2.

    Args:
        point: The ball's centre (3,) [m].
        axes: The rotation (3, 3) with the joint's x, y, z at rest as columns. By default the identity.
    """
    R = np.eye(3) if axes is None else require_one(as_rotation(axes, "axes"), "axes", 2)
    return np.hstack([revolute(R[:, i], point) for i in (2, 1, 0)])


def planar(normal: ArrayLike, point: ArrayLike = (0.0, 0.0, 0.0), x_axis: ArrayLike | None = None) -> Array:
    """(6, 3): columns x, y, rz. Slides [m] along the axes of a plane, then the turn [rad] about its normal.

    The line of the turn goes through `point` at rest and rides on the slides. The axes are those of
    `plane_axes(normal, x_axis)`.

    Args:
        normal: The plane's normal (3,).
        point: A point of the line of the turn (3,) [m].
        x_axis: Direction of the first slide (3,), or None.
    """
    R = plane_axes(normal, x_axis)
    return np.hstack([prismatic(R[:, 0]), prismatic(R[:, 1]), revolute(R[:, 2], point)])


def plane_axes(normal: ArrayLike, x_axis: ArrayLike | None = None) -> Array:
    """The rotation (3, 3) with the columns x, y = n × x and the unit normal n of a plane.

    Args:
        normal: The plane's normal (3,).
        x_axis: A direction (3,), which is projected into the plane. By default it is (1, 0, 0), or (0, 1, 0) where the
            normal is within some 26° of ±(1, 0, 0). InputError where it lies along the normal.
    """
    n = _unit(normal, "normal")
    if x_axis is None:
        x_axis = (0.0, 1.0, 0.0) if abs(n[0]) > 0.9 else (1.0, 0.0, 0.0)  # in the plane it keeps 0.43 of its length
    x = _unit(x_axis, "x_axis")
    x = x - n * (n @ x)
    if np.linalg.norm(x) <= 1e-6:  # ten of 16 digits of its direction are left there
        raise InputError("x_axis must not lie along the normal: give an axis in the plane, or leave it out")
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(n, x), n])


def _column(v: Array, w: Array) -> Array:
    return np.concatenate([v, w])[:, None]


def _unit(value: ArrayLike, name: str) -> Array:
    return as_direction(_vector(value, name), name)


def _vector(value: ArrayLike, name: str) -> Array:
    return require_one(as_vector(value, name), name, 1)
