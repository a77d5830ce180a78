"""Two conditions on two joints, A u(x) + B u(y) = e: the intersection of two ellipses.

u(x) is (cos x, sin x) for a turning joint and (x, x²) for a sliding one. A and B are (2, 2), e (2,). For two joints
that turn this is subproblem 6 of Elias & Wen, IK-Geo, 2022: a quartic. Only the second condition has squares of
lengths.

What just misses counts (see `trigonometric`). If one joint may have any value, but then the other has no root, the
nearest value counts. Newton's method moves both from there. If one condition is nearly a multiple of the other, both
ways of solving are taken. So the answers hold every root, and some values that are not roots.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from .trigonometric import NEAREST, NEGLIGIBLE, harmonic, quadratic, second_harmonic

CLEARLY_TWO = 1e-6
"""Ratio of a matrix's singular values above which its two rows are two conditions."""

BARELY_TWO = 1e-12
"""Below this they are one."""

WELL_CONDITIONED = 1e-3
"""Above this ratio a pair (cos x, sin x) is solved for as two numbers."""


class Side(NamedTuple):
    """One joint's part: the matrix (2, 2), whether it slides, and its value where every one solves."""

    matrix: Array
    slides: bool
    near: float


class Pair(NamedTuple):
    """Values of both joints, and whether each is as good as any other."""

    x: float
    y: float
    x_free: bool = False
    y_free: bool = False

    @property
    def swapped(self) -> Pair:
        """The same with the joints in the other order."""
        return Pair(self.y, self.x, self.y_free, self.x_free)


def two_conditions(a: Side, b: Side, e: Array, slack: float) -> list[Pair]:
    """All (x, y) with A u(x) + B u(y) = e."""
    if a.slides and not b.slides:
        return [pair.swapped for pair in two_conditions(b, a, e, slack)]
    if a.slides:
        return _two_lengths(a, b, e, slack)
    return _angle_and_length(a, b, e, slack) if b.slides else _two_angles(a, b, e, slack)


def one_joint(a: Side, e: Array, slack: float) -> list[tuple[float, bool]]:
    """All x with A u(x) = e, and whether every x solves it: two conditions, one would suffice."""
    if a.slides:
        linear, square = a.matrix[:, 0], a.matrix[:, 1]
        if np.abs(square).max() <= NEGLIGIBLE * np.abs(a.matrix).max():
            square_of = float(linear @ linear)
            return [(float(linear @ e) / square_of, False)] if square_of > 0.0 else [(a.near, True)]
        roots = [x for i in range(2) if a.matrix[i].any() for x in quadratic(square[i], linear[i], -e[i], slack)]
        return [(x, False) for x in roots]
    U, size, Vt = np.linalg.svd(a.matrix)
    if size[0] <= NEGLIGIBLE:
        return [(a.near, True)]
    if size[1] > WELL_CONDITIONED * size[0]:
        both = np.linalg.solve(a.matrix, e)
        return [(math.atan2(both[1], both[0]), False)]
    roots = _harmonic(size[0] * Vt[0], float(U[:, 0] @ e), float(size[0]), max(slack, CLEARLY_TWO)) or []
    return [(x, False) for x in roots]


def _two_lengths(a: Side, b: Side, e: Array, slack: float) -> list[Pair]:
    """Both slide: one length follows from the first condition; with parallel slides one is free."""
    A, B = a.matrix, b.matrix
    if np.abs(A[:, 1]).max() + np.abs(B[:, 1]).max() <= NEGLIGIBLE:
        return _two_linear(a, b, e)
    if abs(B[0, 0]) > abs(A[0, 0]):
        return [pair.swapped for pair in _two_lengths(b, a, e, slack)]
    if abs(A[0, 0]) <= NEGLIGIBLE:
        rest = e[1] - B[1, 0] * b.near - B[1, 1] * b.near**2
        return [Pair(x, b.near, False, True) for x in quadratic(A[1, 1], A[1, 0], -rest, NEAREST)]
    p, q = e[0] / A[0, 0], -B[0, 0] / A[0, 0]  # x = p + q y
    square = A[1, 1] * q * q + B[1, 1]
    linear = A[1, 0] * q + 2.0 * A[1, 1] * p * q + B[1, 0]
    constant = A[1, 0] * p + A[1, 1] * p * p - e[1]
    if abs(square) <= NEGLIGIBLE and abs(linear) <= NEGLIGIBLE:
        return [Pair(p + q * b.near, b.near, False, True)]
    return [Pair(p + q * y, y) for y in quadratic(square, linear, constant, slack)]


def _two_linear(a: Side, b: Side, e: Array) -> list[Pair]:
    """Both conditions are linear. Where they are one condition the second length keeps its value."""
    both = np.stack([a.matrix[:, 0], b.matrix[:, 0]], axis=1)
    if abs(np.linalg.det(both)) > NEGLIGIBLE:
        return [Pair(*np.linalg.solve(both, e))]
    first, second = one_joint(a, e, 0.0), one_joint(b, e, 0.0)
    if not first or not second:  # squares that are nothing beside the conditions, but something beside these lengths
        return []
    (x, x_free), (y, y_free) = first[0], second[0]
    if x_free or y_free:
        return [Pair(x, y, x_free, y_free)]
    rest = one_joint(a, e - both[:, 1] * b.near, 0.0)
    return [Pair(x, b.near, False, True) for x, _ in rest[:1]]


def _angle_and_length(a: Side, b: Side, e: Array, slack: float) -> list[Pair]:
    """x turns, y slides: y follows from a condition linear in it, or x from one without y."""
    A, linear, square = a.matrix, b.matrix[:, 0], b.matrix[:, 1]
    scale = float(np.abs(A).max() + np.abs(b.matrix).max())
    if np.abs(square).max() <= NEGLIGIBLE:
        i = int(np.argmax(np.abs(linear)))
        if abs(linear[i]) <= NEGLIGIBLE * scale:
            return [Pair(x, b.near, free, True) for x, free in one_joint(a, e, slack)]
        share = linear[1 - i] / linear[i]
        cosine, sine = A[1 - i] - share * A[i]
        roots = harmonic(cosine, sine, e[1 - i] - share * e[i], scale, slack)
        return [Pair(x, (e[i] - A[i] @ _u(x)) / linear[i], free) for x, free in _or_any(roots, a.near)]
    if abs(linear[0]) > CLEARLY_TWO:
        p, q = e[0] / linear[0], -A[0] / linear[0]  # y = p + q · u(x)
        f, g = square[1], linear[1]
        first = A[1] + (g + 2.0 * f * p) * q
        k = np.array([g * p + f * p * p - e[1], *first, f * q[0] ** 2, 2.0 * f * q[0] * q[1], f * q[1] ** 2])
        roots = second_harmonic(k, slack, max(abs(g * p), abs(f * p * p), abs(e[1])))
        return [Pair(x, float(p + q @ _u(x)), free) for x, free in _or_any(roots, a.near)]
    roots = harmonic(A[0, 0], A[0, 1], e[0], scale, slack)
    return [
        Pair(x, y, free)
        for x, free in _or_any(roots, a.near)
        for y in quadratic(square[1], linear[1], float(A[1] @ _u(x)) - e[1], NEAREST if free else slack)
    ]


def _two_angles(a: Side, b: Side, e: Array, slack: float) -> list[Pair]:
    """Both turn: the inverse of the better A eliminates x, or the row that A lacks does."""
    (U, size_a, _), size_b = np.linalg.svd(a.matrix), np.linalg.svd(b.matrix)[1]
    scale = float(max(size_a[0], size_b[0]))
    if size_a[0] <= NEGLIGIBLE * scale:
        return [Pair(a.near, y, True, free) for y, free in one_joint(b, e, slack)]
    if size_b[0] <= NEGLIGIBLE * scale:
        return [Pair(x, b.near, free, True) for x, free in one_joint(a, e, slack)]
    ratio = size_a[1] / size_a[0]
    if size_b[1] / size_b[0] > ratio:
        return [pair.swapped for pair in _two_angles(b, a, e, slack)]
    pairs = _by_inverse(a, b, e, slack) if ratio > BARELY_TWO else []
    return pairs if ratio > CLEARLY_TWO else pairs + _one_by_one(a, b, e, U, scale, max(slack, CLEARLY_TWO))


def _by_inverse(a: Side, b: Side, e: Array, slack: float) -> list[Pair]:
    """u(x) = A⁻¹ (e − B u(y)) has length 1."""
    m, B = np.linalg.solve(a.matrix, e), np.linalg.solve(a.matrix, b.matrix)
    first, second = -2.0 * m @ B, B.T @ B
    k = np.array([m @ m - 1.0, *first, second[0, 0], 2.0 * second[0, 1], second[1, 1]])
    pairs = []
    for y, free in _or_any(second_harmonic(k, slack), b.near):
        cosine, sine = m - B @ _u(y)
        pairs.append(Pair(math.atan2(sine, cosine), y, False, free))
    return pairs


def _one_by_one(a: Side, b: Side, e: Array, U: Array, scale: float, slack: float) -> list[Pair]:
    """A has rank 1: one combination of the conditions has y alone; x follows."""
    row, alone = U[:, 0], U[:, 1]
    pairs = []
    for y, y_free in _or_any(_harmonic(alone @ b.matrix, float(alone @ e), scale, slack), b.near):
        rest = float(row @ (e - b.matrix @ _u(y)))
        for x, x_free in _or_any(_harmonic(row @ a.matrix, rest, scale, NEAREST if y_free else slack), a.near):
            pairs.append(Pair(x, y, x_free, y_free))
    return pairs


def _harmonic(k: Array, c: float, scale: float, slack: float) -> list[float] | None:
    return harmonic(float(k[0]), float(k[1]), c, scale, slack)


def _u(x: float) -> Array:
    return np.array([math.cos(x), math.sin(x)])


def _or_any(roots: list[float] | None, near: float) -> list[tuple[float, bool]]:
    """The roots, not free; or, where every value is a root, the current one."""
    return [(near, True)] if roots is None else [(x, False) for x in roots]
