"""Answers without twistarm's theory: the exponential's power series, SciPy's rotations, algebra."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...support.checks import Array
from ...support.errors import missing_extra


def expm(matrix: Array) -> Array:
    """The exponential of a square matrix by its power series, with halving and squaring.

    For small matrices SciPy's is a thousand times slower if its threads wait for each other.
    """
    halvings = max(int(np.ceil(np.log2(max(float(np.abs(matrix).sum()), 1e-9)))) + 4, 0)
    term = power = np.eye(len(matrix))
    for k in range(1, 13):
        term = term @ matrix / (k * 2.0**halvings)
        power = power + term
    for _ in range(halvings):
        power = power @ power
    return power


def pose_log(g: Array) -> Array:
    """The twist (v, ω) of a pose. ω is SciPy's rotation vector, and p = (∫₀¹ exp(ω̂s) ds) v gives v.

    The integral is a corner of the exponential of [ω̂, I; 0, 0].
    """
    w = scipy_rotation().from_matrix(g[:3, :3]).as_rotvec()
    both = np.zeros((6, 6))
    both[:3, :3], both[:3, 3:] = crossing(w), np.eye(3)
    return np.concatenate([np.linalg.solve(expm(both)[:3, 3:], g[:3, 3]), w])


def scipy_rotation() -> Any:
    """The class `Rotation` of SciPy."""
    return _scipy("spatial.transform").Rotation


def crossing(w: Array) -> Array:
    """The matrix (3, 3) of w ×: its columns are the cross products with the axes."""
    return np.cross(w, np.eye(3)).T


def twist_matrix(xi: Array) -> Array:
    """ξ̂ (4, 4) of ξ = (v, ω)."""
    matrix = np.zeros((4, 4))
    matrix[:3, :3], matrix[:3, 3] = crossing(xi[3:]), xi[:3]
    return matrix


def twist_of(matrix: Array) -> Array:
    """(v, ω) of ξ̂ (4, 4)."""
    return np.array([*matrix[:3, 3], matrix[2, 1], matrix[0, 2], matrix[1, 0]])


def inverted(g: Array) -> Array:
    """The inverse of a matrix, by elimination."""
    return np.array(np.linalg.inv(g), float)


def conjugated(g: Array, xi: Array) -> Array:
    """The twist with the matrix g ξ̂ g⁻¹, the definition of the Adjoint of g."""
    return twist_of(g @ twist_matrix(xi) @ inverted(g))


def motion_of(screws: Array, x: Array) -> Array:
    """exp(ξ̂₁x₁) ⋯ exp(ξ̂ₘxₘ) (4, 4), by the power series."""
    g = np.eye(4)
    for xi, value in zip(screws.T, x, strict=True):
        g = g @ expm(twist_matrix(xi) * value)
    return g


def tool(screws: Array, home: Array, x: Array) -> Array:
    """g_st (4, 4): the motion of all joints, of the home pose."""
    return motion_of(screws, x) @ home


def spatial_columns(screws: Array, x: Array) -> Array:
    """Jˢ (6, m): each joint's screw where the joints before it have brought it."""
    columns = [conjugated(motion_of(screws[:, :i], x[:i]), screws[:, i]) for i in range(len(x))]
    return np.column_stack(columns)


def body_columns(screws: Array, home: Array, x: Array) -> Array:
    """Jᵇ (6, m): the same screws seen from the tool."""
    back = inverted(tool(screws, home, x))
    return np.column_stack([conjugated(back, column) for column in spatial_columns(screws, x).T])


def wrapped(angle: Any) -> Any:
    """The angle, or angles, in (−π, π], through the complex number of that direction."""
    found = np.angle(np.exp(1j * np.asarray(angle)))
    return np.where(found <= -np.pi + 1e-12, np.pi, found)


def _scipy(part: str) -> Any:
    from importlib import import_module

    try:
        return import_module(f"scipy.{part}")
    except ImportError as error:
        raise missing_extra("grading exercises", "SciPy", "guide") from error
