"""Placing a point or a plane by up to three joints: all x with E₁(x₁) ⋯ Eₖ(xₖ) X = Y.

A motion along the middle joint keeps two numbers. E₃(x₃) X and E₁(x₁)⁻¹ Y must agree in both:

| middle joint | of a point p | of a plane (n, d) |
|---|---|---|
| turns about (w, o) | w · (p − o), ‖p − o‖² | w · n, d − n · o |
| slides along w | the two coordinates of p across w | — |

These are two conditions on x₁ and x₃, linear in sines and cosines (length and square for slides). Then x₂ is the turn
or slide that is left (subproblem 1). For points Pieper (1968) solves three joints before a spherical wrist like this.
For planes it solves three parallel axes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from .joint_axis import JointAxis, Plane, Point, across, along
from .trigonometric import NEGLIGIBLE
from .two_conditions import Side, one_joint, two_conditions

ON_AXIS = 1e-7
"""A point nearer to an axis than this [m], or a direction this close to it, hardly moves when turned about it. A double
root has half the digits, so which angle brought it there is unknown. Any angle serves as a start.
"""


class Placed(NamedTuple):
    """Values of the joints, and the indices of those with arbitrary values."""

    x: tuple[float, ...]
    free: frozenset[int] = frozenset()


def place(
    axes: tuple[JointAxis, ...], X: Point | Plane, Y: Point | Plane, near: tuple[float, ...], slack: float
) -> list[Placed]:
    """All x (k,), k ≤ 3, with E₁(x₁) ⋯ Eₖ(xₖ) X = Y. Least squares where there are too few joints.

    A joint that may have any value takes that of `near` (k,). What just misses by `slack` counts.
    """
    if not axes:
        return [Placed(())]
    if len(axes) == 1:
        x, free = settle(axes[0], X, Y, near[0])
        return [Placed((x,), frozenset({0} if free else ()))]
    return _by_two(axes, X, Y, near, slack) if len(axes) == 2 else _by_three(axes, X, Y, near, slack)


def settle(axis: JointAxis, X: Point | Plane, Y: Point | Plane, near: float) -> tuple[float, bool]:
    """The x that brings E(x) X nearest to Y, and whether all do (subproblem 1)."""
    if axis.slides:
        return _slid(axis, X, Y, near)
    a, b = (Z.n if isinstance(Z, Plane) else Z.p - axis.o for Z in (X, Y))
    a, b = a - axis.w * (axis.w @ a), b - axis.w * (axis.w @ b)
    if np.linalg.norm(a) < ON_AXIS or np.linalg.norm(b) < ON_AXIS:
        return near, True
    return math.atan2(float(axis.w @ np.cross(a, b)), float(a @ b)), False


def _slid(axis: JointAxis, X: Point | Plane, Y: Point | Plane, near: float) -> tuple[float, bool]:
    if isinstance(X, Plane) and isinstance(Y, Plane):
        share = float(axis.w @ X.n)
        return (near, True) if abs(share) < NEGLIGIBLE else ((Y.d - X.d) / share, False)
    assert isinstance(X, Point)
    assert isinstance(Y, Point)
    return float(axis.w @ (Y.p - X.p)), False


def _by_two(
    axes: tuple[JointAxis, ...], X: Point | Plane, Y: Point | Plane, near: tuple[float, ...], slack: float
) -> list[Placed]:
    """The first joint is the middle one: none comes before it."""
    first, second = axes
    found = []
    k = _kept_along(first, second, X)
    for y, y_free in one_joint(Side(k[:, 1:], second.slides, near[1]), _kept(first, Y) - k[:, 0], slack):
        x, x_free = settle(first, X.moved(second.motion(y)), Y, near[0])
        found.append(Placed((x, y), _indices(x_free, y_free)))
    return found


def _by_three(
    axes: tuple[JointAxis, ...], X: Point | Plane, Y: Point | Plane, near: tuple[float, ...], slack: float
) -> list[Placed]:
    first, middle, last = axes
    k1, k3 = _kept_along(middle, first, Y, -1.0), _kept_along(middle, last, X)
    sides = Side(-k1[:, 1:], first.slides, near[0]), Side(k3[:, 1:], last.slides, near[2])
    found = []
    for pair in two_conditions(*sides, k1[:, 0] - k3[:, 0], slack):
        before, after = Y.moved(first.motion(-pair.x)), X.moved(last.motion(pair.y))
        x, free = settle(middle, after, before, near[1])
        found.append(Placed((pair.x, x, pair.y), _indices(pair.x_free, free, pair.y_free)))
    return found


def _kept(middle: JointAxis, X: Point | Plane) -> Array:
    """The two numbers (2,) of X that a motion along the middle joint does not change."""
    if isinstance(X, Plane):
        if middle.slides:  # the normal is kept: two of its components, across the slide
            u, v = across(middle.w)
            return np.array([u @ X.n, v @ X.n])
        return np.array([middle.w @ X.n, X.d - X.n @ middle.o])
    if middle.slides:
        u, v = across(middle.w)
        return np.array([u @ X.p, v @ X.p])
    away = X.p - middle.o
    return np.array([middle.w @ away, away @ away])


def _kept_along(middle: JointAxis, axis: JointAxis, X: Point | Plane, sense: float = 1.0) -> Array:
    """(2, 3): the kept numbers of E(sense · x) X as k₀ + k₁ cos x + k₂ sin x, or k₀ + k₁ x + k₂ x² for slides."""
    return np.stack(along(axis, lambda g: _kept(middle, X.moved(g)), sense), axis=1)


def _indices(*free: bool) -> frozenset[int]:
    return frozenset(i for i, each in enumerate(free) if each)
