"""Elimination: all configurations of five or six turning joints with any axes, by an eigenvalue problem.

E₃E₄E₅ = E₂⁻¹E₁⁻¹ G E₆⁻¹. Applied to point p and direction d of the last axis, both sides are free of x₆:

    p, d, p·p, p·d, p × d, (p·p) d − 2 (p·d) p

are fourteen equations. p is measured from a point of axis 2. The right side is then linear in eight sin–cos products of
x₁ and x₂. The left is linear in those of x₄ and x₅. Its coefficients are linear in cos x₃, sin x₃. The six combinations
without x₁ and x₂ are a 6 × 9 matrix in x₃. With t = tan(x/2), each multiplied by t₄, they are a 12 × 12 matrix M₀ +
M₁t₃ + M₂t₃². It is singular at the answers, and at t₃ = ±i. An arm has at most sixteen.

Sources: Raghavan & Roth, Inverse kinematics of the general 6R manipulator, ASME J. Mech. Des. 115, 1993; Manocha &
Canny, Efficient inverse kinematics for general 6R manipulators, IEEE T-RA 10, 1994 (the eigenvalue problem).

Five joints get a sixth that stands still, about an unrelated line. The answers of the five are those where its angle is
0.

For special axes the matrix may be singular everywhere. G closes the chain of joints, so it may begin at any joint, in
either direction. `elimination_for` keeps those of these twelve ways that find random configurations, the best first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...theory.rotations import cross, skew
from ...theory.screws import exp, inverse_of
from .chain import JointAxis, across, product

SIX = 6

# Three angles at which a function a + b cos x + c sin x is known.
THIRDS = np.array([0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0])
SINES, VERSINES = np.sin(THIRDS)[:, None, None], (1.0 - np.cos(THIRDS))[:, None, None]
# (a, b, c) from its values there, and the same for functions of two and of three angles.
FROM_SAMPLES = np.linalg.inv(np.stack([np.ones(3), np.cos(THIRDS), np.sin(THIRDS)], axis=1))
OF_TWO = np.kron(FROM_SAMPLES, FROM_SAMPLES)
OF_THREE = np.kron(FROM_SAMPLES, OF_TWO)
# 1, cos x and sin x times 1 + t², as powers t⁰ … t² of t = tan(x/2).
IN_TANGENT = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [0.0, 2.0, 0.0]])
# The eigenvalue is u = tan(x₃/2 − INFINITY_SHIFT). It makes roots at infinity finite.
INFINITY_SHIFT = 0.7
COS, SIN = math.cos(2.0 * INFINITY_SHIFT), math.sin(2.0 * INFINITY_SHIFT)
IN_SHIFTED = np.array([[1.0, 0.0, 0.0], [0.0, COS, -SIN], [0.0, SIN, COS]]) @ IN_TANGENT
# Products of 1, cos, sin of x₃, x₄ and x₅ in powers of u, t₄ and t₅.
IN_POWERS = np.kron(IN_SHIFTED, np.kron(IN_TANGENT, IN_TANGENT))
UPPER = np.eye(12, 24, k=12)  # The rows of the companion matrix that say which half of a vector is the other times u.
# An eigenvalue with a smaller imaginary part may be a double root that rounding has split; below this it is real.
REAL, SURELY_REAL = 1e-3, 1e-9
WELL_CONDITIONED = 1e8  # Up to this condition the eigenvalues are believed.
RANK = 1e-10  # Relative singular values of the right side below this are 0.
TRIALS = 4  # Random configurations by which a way is judged.
FOUND = 1e-5  # Greatest error of an uncorrected candidate, as a share of the reach.
MOST_WAYS = 4  # Ways that are tried in turn until the eigenvalues of one are believed.
# Greatest angle of the joint that is added to five, before correction. Double roots have few digits.
EXTRA_JOINT_TOL, EXTRA_JOINT_EXACT = 0.1, 1e-6
# Direction of that joint, and a point on it in shares of the reach.
EXTRA_AXIS = np.array([0.48, -0.6, 0.64]), np.array([0.31, 0.23, -0.41])


NEARBY_POSES = (
    np.eye(4),
    exp(1e-5 * np.array([0.53, -0.31, 0.79, 0.41, 0.67, -0.62])),
    exp(1e-4 * np.array([-0.37, 0.83, 0.29, -0.71, 0.23, 0.59])),
)
"""The pose and two nearby ones [m, rad]: near enough for Newton's method, far enough to separate eigenvalues."""


class Candidates(NamedTuple):
    """Candidates x (m, k) of one elimination, and the number of `answers` to expect. None: that is in doubt.

    The eigenvalues are beyond doubt if their problem is well conditioned and none is nearly real. Then x has every
    answer, provided that as many different ones come from it as expected.
    """

    x: Array
    answers: int | None


class Lines(NamedTuple):
    """Directions w (6, 3) and points o (6, 3) [m] of six axes."""

    w: Array
    o: Array


class Way(NamedTuple):
    """The joint with which the chain starts, and whether it is walked backward."""

    start: int
    backward: bool

    @property
    def joints(self) -> list[int]:
        """The joint of each place."""
        joints = [*range(self.start, SIX), *range(self.start)]
        return joints[::-1] if self.backward else joints

    def chain(self, lines: Lines, G: Array) -> tuple[Lines, Array]:
        """Axes and G of the chain this way."""
        (w, o), k, R = lines, self.start, G[:3, :3]
        w, o = np.concatenate([w[k:], w[:k] @ R]), np.concatenate([o[k:], (o[:k] - G[:3, 3]) @ R])
        return (Lines(-w[::-1], o[::-1]), inverse_of(G)) if self.backward else (Lines(w, o), G)


@dataclass(frozen=True, eq=False)
class Elimination:
    """How elimination solves five or six axes: `ways`, the best first. `still`: the joint that is added to five."""

    ways: tuple[Way, ...]
    still: tuple[JointAxis, ...]

    def lines(self, axes: tuple[JointAxis, ...]) -> Lines:
        """The lines of six axes."""
        six = (*axes, *self.still)
        return Lines(np.array([axis.w for axis in six]), np.array([axis.o for axis in six]))

    def candidates(self, lines: Lines, way: Way, G: Array) -> Candidates:
        """Candidates for E₁(x₁) ⋯ Eₖ(xₖ) = G (4, 4), k = 6 or 5, mostly to six digits."""
        found, sure = _solved(*way.chain(lines, G))
        x = np.empty_like(found)
        x[:, way.joints] = found
        own = SIX - len(self.still)
        extra = np.abs((x[:, own:] + math.pi) % (2.0 * math.pi) - math.pi).max(axis=1, initial=0.0)
        answers = int((extra <= EXTRA_JOINT_EXACT).sum()) if sure else None
        return Candidates(x[extra <= EXTRA_JOINT_TOL, :own], answers)

    def nearby(self, lines: Lines, G: Array) -> Array:
        """The candidates x (m, k) for G and for poses beside it, in unrelated directions. Their answers are near.

        At special joint angles the matrix may be singular for this G alone. Its result is noise.
        """
        return np.vstack([self.candidates(lines, self.ways[0], G @ beside).x for beside in NEARBY_POSES])


def elimination_for(axes: tuple[JointAxis, ...], reach: float) -> Elimination | None:
    """The ways that find random configurations. None where the matrix is singular every way."""
    if not SIX - 1 <= len(axes) <= SIX or any(axis.slides for axis in axes):
        return None
    rng = np.random.default_rng(0)
    trials = rng.uniform(-np.pi, np.pi, (TRIALS, len(axes)))
    still = (JointAxis(EXTRA_AXIS[0], reach * EXTRA_AXIS[1], slides=False),) * (SIX - len(axes))
    ways = [Way(start, backward) for start in range(SIX) for backward in (False, True)]
    missed = {way: max(_missed(axes, Elimination((way,), still), x, reach) for x in trials) for way in ways}
    best = sorted((way for way in ways if missed[way] <= FOUND), key=lambda way: missed[way])
    return Elimination(tuple(best[:MOST_WAYS]), still) if best else None


def _missed(axes: tuple[JointAxis, ...], by: Elimination, x: Array, reach: float) -> float:
    """Distance of the nearest answer from the pose at x, in shares of the reach or rad."""
    G = product(axes, x)
    errors = [np.inf]
    for found in by.candidates(by.lines(axes), by.ways[0], G).x:
        off = np.abs(product(axes, found) - G)
        distance = float(np.abs((found - x + np.pi) % (2.0 * np.pi) - np.pi).max())
        if distance < 1e-2:
            errors.append(max(float(off[:3, :3].max()), float(off[:3, 3].max()) / reach))
    return min(errors)


def _solved(lines: Lines, G: Array) -> tuple[Array, bool]:
    """Candidates x (m, 6) of a chain, and whether the eigenvalues are beyond doubt."""
    w, o = lines
    hat = skew(w)
    square = hat @ hat
    turns = np.eye(3) + SINES * hat[:, None] + VERSINES * square[:, None]  # (6, 3, 3, 3): each axis by each third
    points = np.zeros((SIX, 3, 2))
    points[..., 0] = o
    tip = np.stack([o[5], w[5]], axis=1)
    seen = G[:3, :3] @ tip
    seen[:, 0] += G[:3, 3]
    left = OF_THREE @ _fourteen(tip, points, turns, (4, 3, 2))  # (27, 14): of products of 1, cos, sin of x₃, x₄, x₅
    right = OF_TWO @ _fourteen(seen, points, np.swapaxes(turns, -1, -2), (0, 1))  # (9, 14): of x₂ and x₁
    U, size, Vt = np.linalg.svd(right[1:].T)
    without = U[:, 8:].T  # the six combinations that x₁ and x₂ do not enter
    equations = without @ left.T
    equations[:, 0] -= without @ right[0]
    x3, vectors, sure = _eigenpairs((equations @ IN_POWERS).reshape(6, 3, 9))
    x = np.empty((len(x3), SIX))
    x[:, 2], x[:, 3] = x3, _angles(vectors[:, :3], vectors[:, 1:])
    x[:, 4] = _angles(vectors[:, :, :2], vectors[:, :, 1:])
    x[:, 1], x[:, 0] = _first_two(x[:, 2:5], left, right[0], U[:, :8], size, Vt)
    # x₆ by the turn that is left over.
    u, v = across(w[5])
    left_over = (G[:3, :3] @ u)[:, None]
    five = x[:, :5, None, None]
    sine, versine = np.sin(five), 1.0 - np.cos(five)
    for k in range(5):
        left_over = left_over - sine[:, k] * (hat[k] @ left_over) + versine[:, k] * (square[k] @ left_over)
    x[:, 5] = np.arctan2(left_over[..., 0] @ v, left_over[..., 0] @ u)
    return x, sure


def _fourteen(tip: Array, points: Array, turns: Array, order: tuple[int, ...]) -> Array:
    """The fourteen numbers of p and d, turned by each third about these axes in their order. tip (3, 2): p and d.

    (3 ⋯ 3, 14), of the last axis first. points (6, 3, 2): of the axes, and 0. p is seen from the second.
    """
    for k in order:
        rotation = turns[k].reshape(3, *(1,) * (tip.ndim - 2), 3, 3)
        tip = rotation @ (tip - points[k]) + points[k]
    p, d = np.moveaxis((tip - points[1]).reshape(-1, 3, 2), -1, 0)
    pp, pd = (p * p).sum(axis=1, keepdims=True), (p * d).sum(axis=1, keepdims=True)
    return np.concatenate([p, d, pp, pd, cross(p, d), pp * d - 2.0 * pd * p], axis=1)


def _first_two(middle: Array, left: Array, constant: Array, U: Array, size: Array, Vt: Array) -> tuple[Array, Array]:
    """x₂ and x₁ (m,) of x₃, x₄, x₅ (m, 3), by least squares from the fourteen equations with U diag(size) Vt right."""
    of_3, of_4, of_5 = np.stack([np.ones(middle.shape), np.cos(middle), np.sin(middle)]).transpose(2, 1, 0)
    products = (of_3[:, :, None, None] * of_4[:, None, :, None] * of_5[:, None, None, :]).reshape(-1, 27)
    inverse = np.divide(1.0, size, out=np.zeros(8), where=size > RANK * size[0])
    found = ((products @ left - constant) @ U * inverse) @ Vt
    return np.arctan2(found[:, 5], found[:, 2]), np.arctan2(found[:, 1], found[:, 0])


def _eigenpairs(powers: Array) -> tuple[Array, Array, bool]:
    """x₃ (m,) and vectors (m, 4, 3) of t₄ⁱ t₅ʲ, i ≤ 3 and j ≤ 2, where (M₀ + M₁u + M₂u²) vector = 0.

    powers (6, 3, 9): of u, and of t₄ and t₅, in the six equations. Also whether the eigenvalues are beyond doubt.
    """
    M = np.zeros((3, 12, 12))
    M[:, :6, :9] = M[:, 6:, 3:] = powers.swapaxes(0, 1)
    try:
        last = np.linalg.solve(M[2], np.hstack([M[0], M[1]]))
        first = np.linalg.solve(M[0], np.hstack([M[1], M[2]]))
        values, vectors = np.linalg.eig(np.vstack([UPPER, -last]))  # refuses what is not finite
    except np.linalg.LinAlgError:
        return np.empty(0), np.empty((0, 4, 3)), False
    off = np.abs(values.imag) / (1.0 + np.abs(values) ** 2)
    real = off <= REAL
    # The Frobenius norms of the companion and of its inverse, each with an identity in it.
    condition = math.sqrt((12.0 + np.square(last).sum()) * (12.0 + np.square(first).sum()))
    sure = condition <= WELL_CONDITIONED and not (real & (off > SURELY_REAL)).any()
    u, both = values[real].real, vectors[:, real].T
    half = np.where(np.abs(u)[:, None] <= 1.0, both[:, :12], both[:, 12:])
    largest = half[range(len(u)), np.abs(half).argmax(axis=1)]
    return 2.0 * (np.arctan(u) + INFINITY_SHIFT), (half / largest[:, None]).real.reshape(-1, 4, 3), sure


def _angles(lower: Array, upper: Array) -> Array:
    """x (m,) with upper = tan(x/2) lower, tables (m, …), by least squares from the longer of the two.

    Neighbours in the vector of products differ by the factor t.
    """
    pairs = (lower, lower), (upper, upper), (lower, upper)
    a, b, both = ((first * second).sum(axis=(1, 2)) for first, second in pairs)
    return 2.0 * np.where(a >= b, np.arctan2(both, a), np.arctan2(b, both))
