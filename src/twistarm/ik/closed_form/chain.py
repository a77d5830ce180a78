"""The axes of joints, their effect on points and planes, and the chain to solve.

The chain has an arm's joints, and joints for what a target leaves free.

E₁(x₁) ⋯ Eₙ(xₙ) V₁(y₁) ⋯ Vₖ(yₖ) = G. A `Pose` adds nothing, and G = g home⁻¹. An `Approach` leaves the turn about the
tool axis free. That is one more joint behind the last, with a value that does not matter. A `Position` leaves every
rotation free, which adds three. So `Approach` with five joints and `Position` with three are equations of six joints.

A joint that is held at a value is no longer unknown. E_h is moved behind all others, which it carries along. G becomes
G E_h⁻¹.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...support.errors import InputError
from ...theory.rotations import cross
from ...theory.screws import inverse_of
from ..targets import AnyTarget, Approach, Pose, Position, TolerancedPose

NO_PITCH = 1e-9  # A pitch [m/rad] below this is the rounding of none.
NO_TURN = 1e-12  # A twist with less rotation than this is a slide.
# A point nearer to an axis than this [m], or a direction this close to it, hardly moves when turned about it.
ON_AXIS = 1e-7


@dataclass(frozen=True, eq=False)
class JointAxis:
    """A line along the unit vector w (3,) through the point o (3,) [m]. The joint turns about it, or slides along it.

    E(x) = e^{ξ̂x} with ξ = (o × w, w) for a turning joint, (w, 0) for a sliding one.
    """

    w: Array
    o: Array
    slides: bool

    def motion(self, x: float) -> Array:
        """E(x), (4, 4), for x in rad or m. MLS §2.3.2."""
        g = np.eye(4)
        if self.slides:
            g[:3, 3] = x * self.w
        else:
            g[:3, :3] = turn(self.w, x)
            g[:3, 3] = self.o - g[:3, :3] @ self.o
        return g

    def seen(self, g: Array) -> JointAxis:
        """The same axis moved by g (4, 4): g E(x) g⁻¹ is its motion."""
        return JointAxis(g[:3, :3] @ self.w, g[:3, :3] @ self.o + g[:3, 3], self.slides)

    @property
    def twist(self) -> Array:
        """ξ (6,) with unit w, or unit v where it slides."""
        return np.concatenate([self.w, np.zeros(3)] if self.slides else [np.cross(self.o, self.w), self.w])


@dataclass(frozen=True, eq=False)
class Point:
    """A point at p (3,) [m]."""

    p: Array

    def moved(self, g: Array) -> Point:
        """The point moved by g (4, 4)."""
        return Point(g[:3, :3] @ self.p + g[:3, 3])


@dataclass(frozen=True, eq=False)
class Plane:
    """The points x with n · x = d, n (3,) a unit vector, d [m]. −n makes another plane."""

    n: Array
    d: float

    def moved(self, g: Array) -> Plane:
        """The plane moved by g (4, 4): n' = R n, d' = d + n' · p."""
        n = g[:3, :3] @ self.n
        return Plane(n, float(self.d + n @ g[:3, 3]))


def axis_of(xi: Array) -> JointAxis:
    """The axis of a twist (6,), with w and v of any length but zero. InputError for a screw, which turns and slides."""
    v, w = xi[:3], xi[3:]
    rate = float(np.linalg.norm(w))
    if rate < NO_TURN:
        speed = float(np.linalg.norm(v))
        if speed < NO_TURN:
            raise InputError(f"a twist must turn or slide; got {xi.tolist()}")
        return JointAxis(v / speed, np.zeros(3), slides=True)
    pitch = float(v @ w) / rate**2
    if abs(pitch) > NO_PITCH:
        raise InputError(f"a joint that turns and slides by {pitch:.3g} m/rad has no closed form; got {xi.tolist()}")
    return JointAxis(w / rate, np.cross(w, v) / rate**2, slides=False)


def product(axes: tuple[JointAxis, ...], x: Array) -> Array:
    """E₁(x₁) ⋯ Eₖ(xₖ), (4, 4)."""
    g = np.eye(4)
    for axis, value in zip(axes, x, strict=True):
        g = g @ axis.motion(float(value))
    return g


def nearest_motion(axis: JointAxis, X: Point, Y: Point) -> tuple[float, bool]:
    """The x that brings E(x) X nearest to Y, and whether all do: Paden–Kahan subproblem 1, MLS §3.3.2."""
    if axis.slides:
        return float(axis.w @ (Y.p - X.p)), False
    a, b = (Z.p - axis.o for Z in (X, Y))
    a, b = a - axis.w * (axis.w @ a), b - axis.w * (axis.w @ b)
    if np.linalg.norm(a) < ON_AXIS or np.linalg.norm(b) < ON_AXIS:
        return 0.0, True
    return math.atan2(float(axis.w @ np.cross(a, b)), float(a @ b)), False


def along(axis: JointAxis, value: Callable[[Array], Array]) -> tuple[Array, Array, Array]:
    """(k₀, k₁, k₂) of value(E(x)) = k₀ + k₁ cos x + k₂ sin x. Where the joint slides, it is k₀ + k₁ x + k₂ x²."""
    if axis.slides:
        back, here, on = (value(axis.motion(x)) for x in (-1.0, 0.0, 1.0))
        return here, 0.5 * (on - back), 0.5 * (on + back) - here
    start, quarter, half = (value(axis.motion(x)) for x in (0.0, math.pi / 2, math.pi))
    centre = 0.5 * (start + half)
    return centre, start - centre, quarter - centre


def turn(w: Array, x: float) -> Array:
    """The rotation (3, 3) by x about the unit vector w: Rodrigues' formula. MLS §2.2.1, eq. 2.14."""
    c, s = math.cos(x), math.sin(x)
    hat = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    return np.eye(3) + s * hat + (1.0 - c) * (hat @ hat)


def across(w: Array) -> tuple[Array, Array]:
    """Unit vectors u and w × u (3,) that span the plane across the unit vector w."""
    u = cross(w, np.eye(3)[int(np.argmin(np.abs(w)))])
    u /= np.linalg.norm(u)
    return u, cross(w, u)


INDEPENDENT = 1e-6  # Singular values above this, lengths over the arm's reach, tell motions apart.

MOST_JOINTS = 6


@dataclass(frozen=True, eq=False)
class AxisChain:
    """`axes`: of the arm's n joints, then of what the target leaves free. `rates` (n,): x = rate · theta."""

    axes: tuple[JointAxis, ...]
    rates: Array
    reach: float

    @property
    def n(self) -> int:
        """The arm's own joints."""
        return len(self.rates)

    def held(self, joints: tuple[int, ...], values: Array) -> tuple[tuple[JointAxis, ...], Array]:
        """The axes without these joints, held at `values` of x, and the factor (4, 4) for G."""
        carried, left = np.eye(4), []
        for i, axis in enumerate(self.axes):
            if i in joints:
                carried = carried @ axis.motion(float(values[joints.index(i)]))
            else:
                left.append(axis.seen(carried))
        return tuple(left), inverse_of(carried)

    def left(self, held: tuple[int, ...]) -> list[int]:
        """The places of the axes without these joints."""
        return [i for i in range(len(self.axes)) if i not in held]

    def surplus(self, held: tuple[int, ...] = ()) -> int:
        """How many joints there are beyond those held and the motions that they make. That many more are held."""
        # The largest rank of three draws: one alone may be singular by chance.
        rng, left = np.random.default_rng(0), self.left(held)
        return len(left) - max(_rank(self._jacobian(rng)[:, left]) for _ in range(3))

    def idle(self, joint: int) -> bool:
        """Whether the joint moves only free parts of the target, as a roll about the tool axis."""
        rng = np.random.default_rng(0)
        J = self._jacobian(rng)
        columns = [joint, *range(self.n, len(self.axes))]
        return len(columns) > 1 and _rank(J[:, columns]) == _rank(J[:, columns[1:]])

    def _jacobian(self, rng: np.random.Generator) -> Array:
        """The twists (6, n + k) at a random configuration, metres over the reach."""
        g, columns = np.eye(4), []
        for axis in self.axes:
            columns.append(axis.seen(g).twist / [*[self.reach] * 3, 1.0, 1.0, 1.0])
            g = g @ axis.motion(float(rng.uniform(-1.0, 1.0)) * (self.reach if axis.slides else 2.0))
        return np.array(columns).T


def chain_for(arm: Arm, like: AnyTarget) -> AxisChain:
    """The chain for targets like this one. InputError says why an arm or a target has none."""
    A = arm.coupling.A
    if A.shape[0] != arm.n or np.count_nonzero(A - np.diag(np.diagonal(A))) or not np.diagonal(A).all():
        raise InputError("its joints are coupled: some follow others, by mimic or a linkage")
    own = tuple(axis_of(xi) for xi in arm.screws.T)
    linear, angular = (np.linalg.norm(part, axis=0) for part in np.split(arm.screws, 2))
    scale = np.where([axis.slides for axis in own], linear, angular)
    return AxisChain((*own, *_left_free(arm, like)), np.diagonal(A) * scale, arm.reach)


def goal(arm: Arm, target: AnyTarget) -> Array:
    """G (4, 4) for a target: g home⁻¹, with any pose g that reaches it."""
    return _any_pose(target) @ inverse_of(arm.home)


def _left_free(arm: Arm, like: AnyTarget) -> tuple[JointAxis, ...]:
    R, p = arm.home[:3, :3], arm.home[:3, 3]
    if isinstance(like, Pose):
        return ()
    if isinstance(like, Approach):
        return (JointAxis(R @ like.axis, p, slides=False),)
    if isinstance(like, Position):
        return tuple(JointAxis(w, p, slides=False) for w in np.eye(3))
    raise InputError(
        "a TolerancedPose's tolerances leave a whole range of poses; ask for a Pose, an Approach or a Position"
    )


def _any_pose(target: AnyTarget) -> Array:
    """A pose (4, 4) that reaches the target."""
    assert not isinstance(target, TolerancedPose)
    if isinstance(target, Pose):
        return target.g
    g = np.eye(4)
    g[:3, 3] = target.p
    if isinstance(target, Approach):
        tool, base = (np.array([axis, *across(axis)]).T for axis in (target.axis, target.direction))
        g[:3, :3] = base @ tool.T
    return g


def _rank(matrix: Array) -> int:
    return int(np.linalg.matrix_rank(matrix, tol=INDEPENDENT))
