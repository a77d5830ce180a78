"""Subproblems of inverse kinematics: one or two joints move a point to its place. MLS §3.3.2.

Joints have unit twists xi (6,) = (v, w), linear part first, as the columns of `arm.screws`. w is a unit vector, or 0
and v one for a joint that slides. Points are (3,) [m], values in rad or m. InputError names an invalid screw or unit
twist, or an argument of another shape.

Each function returns `Roots`: all values, and how far the best of them misses. A problem without a solution returns the
nearest values, so only `residual` tells. Where two solutions have come together, as for a stretched arm, one is
returned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_direction, as_number, as_twist, as_vector, frozen, require_one
from ..support.errors import InputError
from .closed_form.chain import JointAxis, Point, across, along, axis_of, nearest_motion, product
from .ranges import Mask

UNIT = 1e-6
"""How far a twist's length may be from 1."""

SAME = 1e-6
"""Values nearer together than this [rad, m] are one if the halfway miss is below theirs plus `MISS_ROUNDING`."""

MISS_ROUNDING = 1e-14
"""[m]"""

BEST = 1e-6
"""A value that misses by this much more [m] than the best is not a root."""

NEGLIGIBLE = 1e-9
"""A coefficient below this part of the equation's scale is zero."""

DOUBLE_ROOT = 1e-13
"""A discriminant below this part of its size is rounding, and two roots are one."""

WELL_CONDITIONED = 1e-3
"""Above this ratio of singular values a pair (cos x, sin x) is solved for as two numbers."""


@dataclass(frozen=True, eq=False)
class Roots:
    """The values of one subproblem.

    values (k,), or (k, 2) for two joints [rad, m]: angles in (−π, π]. residual [m]: how far the best of them misses;
    with a solution 0, up to rounding. free: whether other values solve it too, because the point lies on an axis.
    """

    values: Array
    residual: float
    free: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", frozen(self.values))


def subproblem_1(xi: ArrayLike, p: ArrayLike, q: ArrayLike) -> Roots:
    """The turn about one axis that takes p to q: e^{ξ̂θ} p = q, one value. Paden–Kahan subproblem 1, MLS §3.3.2.

    θ = atan2(w · (p' × q'), p' · q'). p' and q' are the parts of p − r and q − r across the axis (w, r). The residual
    is the difference of p and q along the axis and in distance from it. A joint that slides goes w · (q − p). For a
    point on the axis every θ is a solution: `free`, and 0 is given.

    Args:
        xi: Twist (6,) of a joint that turns or slides.
        p: Point (3,) [m].
        q: The wanted point (3,) [m].
    """
    axis, start, goal = _axis(xi, "xi"), _point(p, "p"), _point(q, "q")
    x, free = nearest_motion(axis, start, goal)
    return _roots((axis,), [x], lambda value: _distance(start.moved(axis.motion(value)), goal), free)


def subproblem_2(xi_1: ArrayLike, xi_2: ArrayLike, p: ArrayLike, q: ArrayLike) -> Roots:
    """The turns about two axes that take p to q: e^{ξ̂₁θ₁} e^{ξ̂₂θ₂} p = q. Paden–Kahan subproblem 2, MLS §3.3.2.

    Turning about the first axis changes neither w₁ · (x − r₁) nor ‖x − r₁‖. So θ₂ has to give the values of q: two
    conditions, linear in cos θ₂ and sin θ₂. θ₁ is then subproblem 1. There are values (k, 2), k ≤ 2. Intersecting axes
    have up to two solutions, and so have parallel ones (the two-link arm). Skew ones, which MLS leaves out, in general
    have one or none. Either joint may slide.

    Args:
        xi_1: Twist (6,) of the joint nearer to the base.
        xi_2: Twist (6,) of the other.
        p: Point (3,) [m].
        q: The wanted point (3,) [m].
    """
    axes, start, goal = (_axis(xi_1, "xi_1"), _axis(xi_2, "xi_2")), _point(p, "p"), _point(q, "q")
    seconds, free = _second(*axes, start, goal)
    values = [(0.0, 0.0)] * (not seconds)  # no value of the second joint helps: any pair shows how far off it is
    for second in seconds:
        first, any_first = nearest_motion(axes[0], start.moved(axes[1].motion(second)), goal)
        values.append((first, second))
        free = free or any_first
    return _roots(axes, values, lambda value: _distance(start.moved(product(axes, np.array(value))), goal), free)


def subproblem_3(xi: ArrayLike, p: ArrayLike, q: ArrayLike, distance: float) -> Roots:
    """The turn about an axis that brings p to a distance from q: ‖e^{ξ̂θ} p − q‖ = δ. Paden–Kahan 3, MLS §3.3.2.

    By the law of cosines θ = θ₀ ± acos((‖p'‖² + ‖q'‖² − δ'²) / (2 ‖p'‖ ‖q'‖)). θ₀ turns p' to q'. δ'² is the part of δ²
    across the axis. There are up to two values. A point on a sliding joint meets the sphere in up to two places.

    Args:
        xi: Twist (6,) of a joint that turns or slides.
        p: Point (3,) [m].
        q: Centre of the sphere (3,) [m].
        distance: Radius δ [m]. InputError if it is negative.
    """
    axis, start, centre = _axis(xi, "xi"), _point(p, "p"), _point(q, "q")
    radius = as_number(distance, "distance [m]")
    if radius < 0.0:
        raise InputError(f"distance must not be negative, in metres; got {radius:g}")

    def off(value: float) -> float:
        return abs(_distance(start.moved(axis.motion(value)), centre) - radius)

    constant, first, second = along(axis, lambda g: ((start.moved(g).p - centre.p) ** 2).sum())
    return _level(axis, (constant - radius**2, first, second), off)


def subproblem_4(xi: ArrayLike, p: ArrayLike, normal: ArrayLike, offset: float) -> Roots:
    """The turn about one axis that takes p into a plane: n · e^{ξ̂θ} p = d. Subproblem 4 of IK-Geo.

    The circle of p meets the plane where a cos θ + b sin θ = c. So θ = atan2(b, a) ± acos(c / √(a² + b²)). There are up
    to two values. The line of a sliding joint meets it once, unless they are parallel.

    Args:
        xi: Twist (6,) of a joint that turns or slides.
        p: Point (3,) [m].
        normal: Normal n (3,), which is made a unit vector. InputError for zero.
        offset: d [m], the plane's distance from the origin along the normal.

    Source: A. J. Elias & J. T. Wen, IK-Geo: Unified Robot Inverse Kinematics Using Subproblem Decomposition, 2022.
    """
    axis, start, d = _axis(xi, "xi"), _point(p, "p"), as_number(offset, "offset [m]")
    n = require_one(as_direction(normal, "normal"), "normal", 1)

    def off(value: float) -> float:
        return abs(float(n @ start.moved(axis.motion(value)).p) - d)

    constant, first, second = along(axis, lambda g: n @ start.moved(g).p)
    return _level(axis, (constant - d, first, second), off)


def _axis(xi: ArrayLike, name: str) -> JointAxis:
    twist = require_one(as_twist(xi, name), name, 1)
    rate = float(np.linalg.norm(twist[3:]) or np.linalg.norm(twist[:3]))
    if abs(rate - 1.0) > UNIT:
        raise InputError(f"{name} must be a unit twist, ‖w‖ = 1, or w = 0 and ‖v‖ = 1; divide it by {rate:.6g}")
    return axis_of(twist)


def _point(value: ArrayLike, name: str) -> Point:
    return Point(require_one(as_vector(value, name), name, 1))


def _distance(a: Point, b: Point) -> float:
    return float(np.linalg.norm(a.p - b.p))


def _second(first: JointAxis, second: JointAxis, start: Point, goal: Point) -> tuple[list[float], bool]:
    """Values of the second joint that give a point what the first cannot, and whether all of them do."""
    constant, *parts = along(second, lambda g: _kept(first, start.moved(g)))
    matrix, e = np.stack(parts, axis=1), _kept(first, goal) - constant
    if second.slides:
        linear, square = matrix.T
        if np.abs(square).max() > NEGLIGIBLE * np.abs(matrix).max():
            return [x for i in range(2) if matrix[i].any() for x in _quadratic(square[i], linear[i], -e[i])], False
        size = float(linear @ linear)
        return ([float(linear @ e) / size], False) if size > 0.0 else ([0.0], True)
    U, sizes, Vt = np.linalg.svd(matrix)
    if sizes[0] <= NEGLIGIBLE:
        return [0.0], True
    if sizes[1] > WELL_CONDITIONED * sizes[0]:
        cosine, sine = np.linalg.solve(matrix, e)
        return [math.atan2(sine, cosine)], False
    a, b = (sizes[0] * Vt[0]).tolist()
    return _harmonic(a, b, float(U[:, 0] @ e), float(sizes[0])) or [], False


def _kept(axis: JointAxis, X: Point) -> Array:
    """The two numbers (2,) of a point that a motion along the axis does not change."""
    if axis.slides:
        u, v = across(axis.w)
        return np.array([u @ X.p, v @ X.p])
    away = X.p - axis.o
    return np.array([axis.w @ away, away @ away])


def _harmonic(a: float, b: float, c: float, scale: float) -> list[float] | None:
    """Angles x with a cos x + b sin x = c, or nearest: atan2(b, a) ± acos(c / √(a² + b²)). None: every x is as near.

    `scale`: the size of the equation's other coefficients, by which zero is judged.
    """
    amplitude = math.hypot(a, b)
    if amplitude <= NEGLIGIBLE * scale:
        return None
    square = (amplitude - c) * (amplitude + c)
    middle, opening = math.atan2(b, a), math.sqrt(square) if square > DOUBLE_ROOT * amplitude**2 else 0.0
    half = math.atan2(opening, c)
    return [middle + half] if opening == 0.0 else [middle + half, middle - half]


def _quadratic(f: float, b: float, c: float) -> list[float]:
    """Lengths x with f x² + b x + c = 0, or nearest, without cancellation."""
    if abs(f) <= NEGLIGIBLE * abs(b):
        return [] if b == 0.0 else [-c / b]
    discriminant, size = b * b - 4.0 * f * c, b * b + abs(4.0 * f * c)
    root = math.sqrt(discriminant) if discriminant > DOUBLE_ROOT * size else 0.0
    q = -0.5 * (b + math.copysign(root, b))
    return [0.0] if q == 0.0 else [q / f, c / q] if root > 0.0 else [q / f]


def _level(axis: JointAxis, coefficients: tuple[Array, Array, Array], off: Callable[[float], float]) -> Roots:
    """Where k₀ + k₁ u + k₂ v is zero, or nearest to it."""
    k = [float(value) for value in coefficients]
    scale = max(map(abs, k)) or 1.0
    found: list[float] | None
    if not axis.slides:
        found = _harmonic(k[1], k[2], -k[0], scale)
    elif max(abs(k[1]), abs(k[2])) <= NEGLIGIBLE:
        found = None
    else:
        found = _quadratic(k[2], k[1], k[0])
    return _roots((axis,), found or [0.0], off, free=found is None)


def _roots(
    axes: tuple[JointAxis, ...],
    values: Sequence[float] | Sequence[tuple[float, ...]],
    off: Callable[..., float],
    free: bool,
) -> Roots:
    """The best values, each once."""
    turns = np.array([not axis.slides for axis in axes]).reshape(np.shape(values[0]))
    misses = [off(value) for value in values]
    best = min(misses)
    kept: list[Array] = []
    for value, miss in zip(values, misses, strict=True):
        root = _wrapped(np.asarray(value, dtype=np.float64), turns)
        if miss <= best + BEST and not any(_same(root, other, turns, off, best) for other in kept):
            kept.append(root)
    return Roots(np.array(kept), best, free)


def _same(a: Array, b: Array, turns: Mask, off: Callable[..., float], best: float) -> bool:
    difference = _wrapped(a - b, turns)
    return bool(np.abs(difference).max() < SAME) and off(b + 0.5 * difference) <= best + MISS_ROUNDING


def _wrapped(x: Array, turns: Mask) -> Array:
    """Angles in (−π, π]; lengths as they are."""
    return np.where(turns, math.pi - (math.pi - x) % (2.0 * math.pi), x)
