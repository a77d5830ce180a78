"""Elimination: all configurations of five or six turning joints with any axes, by an eigenvalue problem.

E₃E₄E₅ = E₂⁻¹E₁⁻¹ G E₆⁻¹. Applied to point p and direction d of the last axis, both sides are free of x₆:

    p, d, p·p, p·d, p × d, (p·p) d − 2 (p·d) p

are fourteen equations. With p measured from a point of axis 2, the right side is linear in eight sin–cos products of x₁
and x₂. The left is linear in those of x₄ and x₅. Its coefficients are linear in cos x₃, sin x₃. The six combinations
without x₁ and x₂ are a 6 × 9 matrix in x₃. With t = tan(x/2), each multiplied by t₄, they are a 12 × 12 matrix M₀ +
M₁t₃ + M₂t₃². It is singular at the answers, and at t₃ = ±i. An arm has at most sixteen.

Sources: Raghavan & Roth, Inverse kinematics of the general 6R manipulator, ASME J. Mech. Des. 115, 1993; Manocha &
Canny, Efficient inverse kinematics for general 6R manipulators, IEEE T-RA 10, 1994 (the eigenvalue problem).

Five joints get a sixth that stands still, about an unrelated line. The answers of the five are those where its angle is
0.

For special axes the matrix may be singular everywhere. G closes the chain of joints, so it may begin at any joint, in
either direction. `rooted` takes the one of these twelve ways that finds random configurations best.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ...support.checks import Array
from ...theory.screws import exp, inverse
from .chain import JointAxis, Point, across, product, settle

SIX = 6

# Three angles at which a function a + b cos x + c sin x is known.
THIRDS = (0.0, 2.0 * math.pi / 3.0, 4.0 * math.pi / 3.0)
# (a, b, c) from its values there.
FROM_SAMPLES = np.linalg.inv(np.stack([np.ones(3), np.cos(THIRDS), np.sin(THIRDS)], axis=1))
# 1, cos x and sin x times 1 + t², as powers t⁰ … t² of t = tan(x/2).
IN_TANGENT = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [0.0, 2.0, 0.0]])
# t₃ = tan(y + INFINITY_SHIFT) for the eigenvalue tan y. It makes roots at infinity finite.
INFINITY_SHIFT = 0.7
REAL = 1e-3  # An eigenvalue with a smaller imaginary part may be a double root that rounding has split.
TRIALS = 4  # Random configurations by which a way is judged.
FOUND = 1e-5  # Greatest error of an uncorrected candidate, as a share of the reach.
# Greatest angle of the joint that is added to five, before correction. Double roots have few digits.
EXTRA_JOINT_TOL = 0.1
# Direction of that joint, and a point on it in shares of the reach.
EXTRA_AXIS = np.array([0.48, -0.6, 0.64]), np.array([0.31, 0.23, -0.41])


NEARBY_POSES = (
    np.eye(4),
    exp(1e-5 * np.array([0.53, -0.31, 0.79, 0.41, 0.67, -0.62])),
    exp(1e-4 * np.array([-0.37, 0.83, 0.29, -0.71, 0.23, 0.59])),
)
"""The pose and two nearby ones [m, rad]: near enough for Newton's method, far enough to separate eigenvalues."""


@dataclass(frozen=True, eq=False)
class Rooted:
    """The start of the chain, and whether it is walked backward. `worst`: its error at random configurations.

    `still`: the joint added to five.
    """

    start: int
    backward: bool
    worst: float
    still: tuple[JointAxis, ...] = ()

    def chain(self, axes: tuple[JointAxis, ...], G: Array) -> tuple[tuple[JointAxis, ...], Array, list[int]]:
        """Axes and G of the chain from this start, and the joint of each place."""
        behind = inverse(G)
        walked = [*axes[self.start :], *(axis.seen(behind) for axis in axes[: self.start])]
        joints = [*range(self.start, SIX), *range(self.start)]
        if not self.backward:
            return tuple(walked), G, joints
        return tuple(replace(axis, w=-axis.w) for axis in walked[::-1]), behind, joints[::-1]


def rooted(axes: tuple[JointAxis, ...], reach: float) -> Rooted | None:
    """The way that finds random configurations best. None where the matrix is singular every way."""
    if not SIX - 1 <= len(axes) <= SIX or any(axis.slides for axis in axes):
        return None
    rng = np.random.default_rng(0)
    trials = rng.uniform(-np.pi, np.pi, (TRIALS, len(axes)))
    still = (JointAxis(EXTRA_AXIS[0], reach * EXTRA_AXIS[1], slides=False),) * (SIX - len(axes))
    ways = [Rooted(start, backward, math.inf, still) for start in range(SIX) for backward in (False, True)]
    judged = [replace(way, worst=max(_missed(axes, way, x, reach) for x in trials)) for way in ways]
    best = min(judged, key=lambda way: way.worst)
    return best if best.worst <= FOUND else None


def _missed(axes: tuple[JointAxis, ...], way: Rooted, x: Array, reach: float) -> float:
    """Distance of the nearest answer from the pose at x, in shares of the reach or rad."""
    G = product(axes, x)
    errors = [np.inf]
    for found in _candidates_for(axes, way, G):
        off = np.abs(product(axes, found) - G)
        apart = float(np.abs((found - x + np.pi) % (2.0 * np.pi) - np.pi).max())
        if apart < 1e-2:
            errors.append(max(float(off[:3, :3].max()), float(off[:3, 3].max()) / reach))
    return min(errors)


def eliminated(axes: tuple[JointAxis, ...], way: Rooted, G: Array) -> list[Array]:
    """Candidates x (k,) for E₁(x₁) ⋯ Eₖ(xₖ) = G (4, 4), k = 6 or 5: every answer, mostly to six digits.

    At special joint angles the matrix may be singular for this G alone. Its result is noise. So poses beside it are
    solved too, in unrelated directions. Their answers are near.
    """
    return [x for beside in NEARBY_POSES for x in _candidates_for(axes, way, G @ beside)]


def _candidates_for(axes: tuple[JointAxis, ...], way: Rooted, G: Array) -> list[Array]:
    """Candidates for this G alone."""
    chain, closed, joints = way.chain((*axes, *way.still), G)
    left, right = _left_side(chain), _right_side(chain, closed)
    found = []
    for middle in _middle_angles(left, right):
        x = np.empty(SIX)
        x[joints] = _completed(chain, closed, left, right, middle)
        if all(abs((angle + math.pi) % (2.0 * math.pi) - math.pi) <= EXTRA_JOINT_TOL for angle in x[len(axes) :]):
            found.append(x[: len(axes)])
    return found


def _fourteen(p: Array, d: Array) -> Array:
    """The fourteen numbers of p and d (3,)."""
    pp, pd = p @ p, p @ d
    return np.concatenate([p, d, [pp, pd], np.cross(p, d), pp * d - 2.0 * pd * p])


def _left_side(chain: tuple[JointAxis, ...]) -> Array:
    """(14, 3, 3, 3): coefficients of 1, cos, sin of x₃, x₄ and x₅ on the left."""
    _, second, third, fourth, fifth, sixth = chain
    values = np.empty((3, 3, 3, 14))
    for i, j, k in np.ndindex(3, 3, 3):
        g: Array = third.motion(THIRDS[i]) @ fourth.motion(THIRDS[j]) @ fifth.motion(THIRDS[k])
        values[i, j, k] = _fourteen(g[:3, :3] @ sixth.o + g[:3, 3] - second.o, g[:3, :3] @ sixth.w)
    return np.einsum("ai,bj,ck,ijke->eabc", FROM_SAMPLES, FROM_SAMPLES, FROM_SAMPLES, values)


def _right_side(chain: tuple[JointAxis, ...], G: Array) -> Array:
    """(14, 9): coefficients of the products of 1, cos, sin of x₂ and of x₁ on the right."""
    first, second, *_, sixth = chain
    p, d = G[:3, :3] @ sixth.o + G[:3, 3], G[:3, :3] @ sixth.w
    values = np.empty((3, 3, 14))
    for i, j in np.ndindex(3, 3):
        g: Array = second.motion(-THIRDS[i]) @ first.motion(-THIRDS[j])
        values[i, j] = _fourteen(g[:3, :3] @ p + g[:3, 3] - second.o, g[:3, :3] @ d)
    return np.einsum("ai,bj,ije->eab", FROM_SAMPLES, FROM_SAMPLES, values).reshape(14, 9)


def _middle_angles(left: Array, right: Array) -> list[tuple[float, float, float]]:
    """x₃, x₄, x₅ where the matrix is singular."""
    without = np.linalg.svd(right[:, 1:])[0][:, 8:].T  # the six combinations that x₁ and x₂ do not enter
    equations = np.einsum("re,eabc->rabc", without, left)
    equations[:, 0, 0, 0] -= without @ right[:, 0]
    powers = np.einsum("rabc,ai,bj,ck->irjk", equations, IN_TANGENT, IN_TANGENT, IN_TANGENT)
    M = np.zeros((3, 12, 4, 3))
    M[:, :6, :3], M[:, 6:, 1:] = powers, powers
    return [_angles_of(*pair) for pair in _real_eigenpairs(M.reshape(3, 12, 12))]


def _real_eigenpairs(M: Array) -> list[tuple[float, Array]]:
    """(x₃, vector (12,)) with (M₀ + M₁t + M₂t²) vector = 0, t = tan(x₃/2)."""
    c, s = math.cos(INFINITY_SHIFT), math.sin(INFINITY_SHIFT)
    above, below = np.array([s, c]), np.array([c, -s])  # t = (s + c u) / (c − s u), lowest power first
    squares = np.convolve(below, below), np.convolve(above, below), np.convolve(above, above)
    turned = np.einsum("kij,kd->dij", M, np.array(squares))
    try:
        lower = -np.linalg.solve(turned[2], np.hstack([turned[0], turned[1]]))
    except np.linalg.LinAlgError:
        return []
    companion = np.vstack([np.hstack([np.zeros((12, 12)), np.eye(12)]), lower])
    if not np.isfinite(companion).all():
        return []
    values, vectors = np.linalg.eig(companion)
    real = np.abs(values.imag) <= REAL * (1.0 + np.abs(values) ** 2)
    pairs = []
    for u, vector in zip(values[real].real, vectors[:, real].T, strict=True):
        half = vector[:12] if abs(u) <= 1.0 else vector[12:]
        largest = half[int(np.abs(half).argmax())]
        pairs.append((2.0 * math.atan2(s + c * u, c - s * u), (half / largest).real))
    return pairs


def _angles_of(x3: float, vector: Array) -> tuple[float, float, float]:
    """x₄ and x₅ from the vector of products t₄ⁱ t₅ʲ, i ≤ 3 and j ≤ 2. Neighbours differ by the factor t."""
    table = vector.reshape(4, 3)
    return x3, _angle(table[:3], table[1:]), _angle(table[:, :2], table[:, 1:])


def _angle(lower: Array, upper: Array) -> float:
    """x with upper = tan(x/2) lower, by least squares from the longer of the two."""
    a, b, both = float((lower**2).sum()), float((upper**2).sum()), float((lower * upper).sum())
    return 2.0 * math.atan2(both, a) if a >= b else 2.0 * math.atan2(b, both)


def _completed(
    chain: tuple[JointAxis, ...], G: Array, left: Array, right: Array, middle: tuple[float, float, float]
) -> Array:
    """All six angles: x₁ and x₂ by least squares from the fourteen equations, x₆ by the remaining turn."""
    factors = [np.array([1.0, math.cos(x), math.sin(x)]) for x in middle]
    value = np.einsum("eabc,a,b,c->e", left, *factors) - right[:, 0]
    products = np.concatenate([[1.0], np.linalg.lstsq(right[:, 1:], value, rcond=1e-10)[0]]).reshape(3, 3)
    x2, x1 = math.atan2(products[2, 0], products[1, 0]), math.atan2(products[0, 2], products[0, 1])
    five = np.array([x1, x2, *middle])
    left_over = inverse(product(chain[:5], five)) @ G
    u = across(chain[5].w)[0]
    axis = replace(chain[5], o=np.zeros(3))
    return np.append(five, settle(axis, Point(u), Point(left_over[:3, :3] @ u))[0])
