"""The chain to solve: an arm's joints, and joints for what a target leaves free.

E₁(x₁) ⋯ Eₙ(xₙ) V₁(y₁) ⋯ Vₖ(yₖ) = G. A `Pose` adds nothing, and G = g home⁻¹. An `Approach` leaves the turn about the
tool axis free. That is one more joint behind the last, with a value that does not matter. A `Position` leaves every
rotation free, which adds three. So `Approach` with five joints and `Position` with three are equations of six joints.

A joint that is held at a value is no longer unknown. E_h is moved behind all others, which it carries along. G becomes
G E_h⁻¹.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...support.errors import InputError
from ...theory.screws import inverse
from ..targets import AnyTarget, Approach, Pose, Position, TolerancedPose
from .joint_axis import JointAxis, across, axis_of

INDEPENDENT = 1e-6
"""Singular values above this, lengths over the arm's reach, tell motions apart."""

MOST_JOINTS = 6


@dataclass(frozen=True, eq=False)
class Chain:
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
        return tuple(left), inverse(carried)

    def left(self, held: tuple[int, ...]) -> list[int]:
        """The places of the axes without these joints."""
        return [i for i in range(len(self.axes)) if i not in held]

    def surplus(self, held: tuple[int, ...] = ()) -> int:
        """How many joints there are beyond those held and the motions that they make. That many more are held."""
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


def chain_for(arm: Arm, like: AnyTarget) -> Chain:
    """The chain for targets like this one. InputError says why an arm or a target has none."""
    A = arm.coupling.A
    if A.shape[0] != arm.n or np.count_nonzero(A - np.diag(np.diagonal(A))) or not np.diagonal(A).all():
        raise InputError("its joints are coupled: some follow others, by mimic or a linkage")
    own = tuple(axis_of(xi) for xi in arm.screws.T)
    linear, angular = (np.linalg.norm(part, axis=0) for part in np.split(arm.screws, 2))
    scale = np.where([axis.slides for axis in own], linear, angular)
    return Chain((*own, *_left_free(arm, like)), np.diagonal(A) * scale, arm.reach)


def goal(arm: Arm, target: AnyTarget) -> Array:
    """G (4, 4) for a target: g home⁻¹, with any pose g that meets it."""
    return _any_pose(target) @ inverse(arm.home)


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
    """A pose (4, 4) that meets the target."""
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
    return int((np.linalg.svd(matrix)[1] > INDEPENDENT).sum())
