"""Families of arms that have a closed form of inverse kinematics, recognised from the axes.

Consecutive joints are a *group* if together they keep something in place. Axes that meet in a point keep the point (a
spherical group). Parallel axes, and slides across them, keep every plane across the axes (a planar group). At most
three joints beside the group place its point or plane for the target. The group does the rest. That covers a spherical
wrist or shoulder with three other joints. It covers three parallel axes and all four-joint arms too. A slide along
parallel axes commutes with them, so another order is possible too.

Up to three turns in different directions and three slides are a *decoupled* group that keeps nothing. The rotation
alone gives the turns.

Sources: Pieper 1968 (three axes that meet, three that are parallel); Elias & Wen, IK-Geo, 2022; MLS §3.3.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...support.directions import angle_in_words, length_in_words
from ...theory.lines import meeting_point
from .chain import JointAxis, Plane, Point, product

PARALLEL = 1e-6  # Sines below this are those of parallel axes: their distance is measured across them.
# For each axis of a chain its place in the arm; what a target leaves free has places behind the arm's joints.
Joints = Sequence[int]
# Axes are exact if they miss a point by less than this share of the reach, or a direction by less than this [rad].
EXACT_MISS = 1e-9
# Up to this share of the reach, or angle [rad], the nearest exact arm's family gives starts for Newton's method.
NEAR_MISS = 2e-3
MAX_OTHERS = 3  # Joints beside the group that can be solved for.
INDEPENDENT = 1e-5  # Motions with singular values above this are independent.
TRIALS = 3  # Random configurations among which a rank is the largest; almost every one has it.

SPHERICAL, PLANAR, DECOUPLED = "spherical", "planar", "decoupled"


@dataclass(frozen=True)
class Family:
    """Which joints are the group, for any values of held joints.

    `order` (k,): the joints of the chain in the order in which they are taken. Those from `first` to before `last` are
    the group of this `kind`.
    """

    kind: str
    order: tuple[int, ...]
    first: int
    last: int

    @property
    def group(self) -> tuple[int, ...]:
        """The joints of the group, base to tip."""
        return self.order[self.first : self.last]

    def fitted(self, axes: tuple[JointAxis, ...]) -> FittedFamily:
        """The family for these axes (k,), the group's made exact."""
        ordered = [axes[i] for i in self.order]
        group = ordered[self.first : self.last]
        if self.kind == DECOUPLED:
            return FittedFamily(self, tuple(ordered), None, 0.0)
        kept, exact, off = _meeting(group) if self.kind == SPHERICAL else _parallel(group)
        ordered[self.first : self.last] = exact
        return FittedFamily(self, tuple(ordered), kept, off)


@dataclass(frozen=True, eq=False)
class FittedFamily:
    """A family with its axes, in its order. `kept`: the point or plane that the group keeps in place.

    `off`: how far the axes miss the family, in m for a point and rad for a plane.
    """

    family: Family
    axes: tuple[JointAxis, ...]
    kept: Point | Plane | None
    off: float

    def off_share(self, reach: float) -> float:
        """`off` in shares of the arm's reach [m], or in rad."""
        return self.off / reach if self.family.kind == SPHERICAL else self.off


def families(axes: tuple[JointAxis, ...], reach: float, tolerance: float = NEAR_MISS) -> list[FittedFamily]:
    """All families of at most six axes (k,), exact ones first, then by simplicity.

    `tolerance`: share of the reach [m], or angle [rad], by which the axes may miss.
    """
    turning = [axis for axis in axes if not axis.slides]
    if len(turning) <= MAX_OTHERS and len(axes) - len(turning) <= MAX_OTHERS:
        whole = Family(DECOUPLED, tuple(range(len(axes))), 0, len(axes)).fitted(axes)
        if _decoupled(whole):
            return [whole]
    found = []
    for order in _orders(axes):
        for first, last in itertools.combinations(range(len(axes) + 1), 2):
            if last - first > MAX_OTHERS or len(axes) - (last - first) > MAX_OTHERS:
                continue
            for kind in _kinds([axes[i] for i in order[first:last]]):
                fitted = Family(kind, order, first, last).fitted(axes)
                if fitted.off_share(reach) <= tolerance and _determined(fitted):
                    found.append(fitted)
    return sorted(found, key=lambda fitted: _preference(fitted, reach))


def closest_miss(axes: tuple[JointAxis, ...], reach: float) -> FittedFamily | None:
    """The family that the axes miss by least, at any distance. None where no three could be one."""
    found = families(axes, reach, np.inf)
    return min(found, key=lambda fitted: fitted.off_share(reach), default=None)


def _preference(fitted: FittedFamily, reach: float) -> tuple[object, ...]:
    """A key that sorts families: exact ones, then the largest group, then the arm's order."""
    off = fitted.off_share(reach)
    family = fitted.family
    size = family.last - family.first
    # Rounded, so that of families that are missed by nearly the same the larger group comes first.
    return off > EXACT_MISS, round(off, 6) if off > EXACT_MISS else 0.0, -size, family.kind != SPHERICAL, family.order


def _kinds(group: list[JointAxis]) -> list[str]:
    """The kinds the group may be: axes that slide do not meet in a point. Planes need a normal."""
    kinds = [] if any(axis.slides for axis in group) else [SPHERICAL]
    return [*kinds, PLANAR] if len(group) > 1 and any(not axis.slides for axis in group) else kinds


def _meeting(group: list[JointAxis]) -> tuple[Point, list[JointAxis], float]:
    """The point nearest to all axes, the axes through it, and their greatest distance [m]."""
    centre, off = meeting_point(np.array([axis.w for axis in group]), np.array([axis.o for axis in group]))
    return Point(centre), [replace(axis, o=centre) for axis in group], off


def _parallel(group: list[JointAxis]) -> tuple[Plane, list[JointAxis], float]:
    """A plane across all turning axes, the axes made parallel, and their greatest angle [rad]."""
    turning = [axis.w for axis in group if not axis.slides]
    normal = np.sum([w * np.sign(w @ turning[0]) for w in turning], axis=0)
    normal = normal / max(float(np.linalg.norm(normal)), 1e-12)
    off, exact = 0.0, []
    for axis in group:
        along = float(normal @ axis.w)
        across = axis.w - along * normal
        off = max(off, abs(along) if axis.slides else float(np.linalg.norm(across)))
        w = across / max(float(np.linalg.norm(across)), 1e-12) if axis.slides else normal * np.sign(along)
        exact.append(replace(axis, w=w))
    return Plane(normal, 0.0), exact, off


def _orders(axes: tuple[JointAxis, ...]) -> list[tuple[int, ...]]:
    """The orders of the joints, the arm's first: neighbours that commute may change places."""
    known = {tuple(range(len(axes))): None}
    for order in (todo := list(known)):
        for i in range(len(axes) - 1):
            a, b = axes[order[i]], axes[order[i + 1]]
            # Two slides commute too, but no group gains by that.
            if a.slides != b.slides and np.linalg.norm(np.cross(a.w, b.w)) < EXACT_MISS:
                swapped = (*order[:i], order[i + 1], order[i], *order[i + 2 :])
                if swapped not in known:
                    known[swapped] = None
                    todo.append(swapped)
    return list(known)


def _decoupled(fitted: FittedFamily) -> bool:
    """Whether the turns change the rotation, and the slides the position, in independent ways."""
    rng = np.random.default_rng(0)
    for _ in range(TRIALS):
        J = _columns(fitted.axes, rng.uniform(-2.0, 2.0, len(fitted.axes)))
        turns = [xi[3:] for xi, axis in zip(J, fitted.axes, strict=True) if not axis.slides]
        slides = [xi[:3] for xi, axis in zip(J, fitted.axes, strict=True) if axis.slides]
        if _independent(turns) and _independent(slides):
            return True
    return False


def _columns(axes: tuple[JointAxis, ...], x: Array) -> list[Array]:
    """The twists (6,) of the joints at x (k,): the columns of the spatial Jacobian."""
    return [axis.seen(product(axes[:i], x[:i])).twist for i, axis in enumerate(axes)]


def _determined(fitted: FittedFamily) -> bool:
    """Whether joints beside the group and joints in it move independently.

    Tried at random configurations, each with the pose that it makes. For a pose out of reach these tests would mislead.
    """
    rng = np.random.default_rng(0)
    first, last = fitted.family.first, fitted.family.last
    for _ in range(TRIALS):
        x = rng.uniform(-2.0, 2.0, len(fitted.axes))
        J = _columns(fitted.axes, x)
        assert fitted.kept is not None
        moved = fitted.kept.moved(product(fitted.axes[:first], x[:first]))
        beside = [_velocity(moved, xi) for xi in (*J[:first], *J[last:])]
        if _independent(beside) and _independent(J[first:last]):
            return True
    return False


def _velocity(X: Point | Plane, xi: Array) -> Array:
    """The velocity of X with the twist xi (6,): (ṅ, ḋ) or ṗ."""
    v, w = xi[:3], xi[3:]
    return np.append(np.cross(w, X.n), v @ X.n) if isinstance(X, Plane) else v + np.cross(w, X.p)


def _independent(rows: list[Array]) -> bool:
    return not rows or bool(np.linalg.matrix_rank(np.array(rows), tol=INDEPENDENT) == len(rows))


def family_in_words(arm: Arm, fitted: FittedFamily, joints: Joints) -> str:
    """The group of joints, and what makes it one."""
    group = fitted.family.group
    if fitted.family.kind == DECOUPLED:
        return "the joints that turn follow from the rotation alone, those that slide from the position"
    names = _names(arm, [joints[i] for i in group])
    if min(joints[i] for i in group) >= arm.n:
        return "the joints place a point, and the target leaves the turns about it free"
    if len(group) == 1:
        return f"the other joints place a point of the axis of {names}"
    if fitted.family.kind == SPHERICAL:
        return f"the axes of {names} meet in a point"
    slides = any(axis.slides for axis in fitted.axes[fitted.family.first : fitted.family.last])
    return f"{names} turn and slide in parallel planes" if slides else f"the axes of {names} are parallel"


def off_in_words(fitted: FittedFamily) -> str:
    """How much the axes miss the family: `0.4 mm`."""
    return length_in_words(fitted.off) if fitted.family.kind == SPHERICAL else angle_in_words(fitted.off)


def missed_in_words(arm: Arm, fitted: FittedFamily, axes: Sequence[JointAxis], joints: Joints) -> str:
    """The two axes of the group that are farthest from making it one."""
    group = fitted.family.group
    spherical = fitted.family.kind == SPHERICAL
    between = _distance if spherical else _from_parallel
    pairs = itertools.combinations(group, 2)
    far, i, j = max(((between(axes[i], axes[j]), i, j) for i, j in pairs), default=(0.0, 0, 0))
    names = _names(arm, [joints[i], joints[j]])
    if spherical and far > fitted.off:
        return f"the axes of {names} pass at {length_in_words(far)}"
    if spherical:  # each two of them meet, but not all three
        names = _names(arm, [joints[i] for i in group])
        return f"the axes of {names} pass a common point at {length_in_words(fitted.off)}"
    kind = "square" if axes[i].slides != axes[j].slides else "parallel"
    return f"the axes of {names} are {angle_in_words(far)} from {kind}"


def _distance(a: JointAxis, b: JointAxis) -> float:
    normal, offset = np.cross(a.w, b.w), b.o - a.o
    sine = float(np.linalg.norm(normal))
    return abs(float(normal @ offset)) / sine if sine > PARALLEL else float(np.linalg.norm(np.cross(a.w, offset)))


def _from_parallel(a: JointAxis, b: JointAxis) -> float:
    """The angle [rad] by which they are not parallel, or not square if one slides."""
    sine, cosine = float(np.linalg.norm(np.cross(a.w, b.w))), abs(float(a.w @ b.w))
    if a.slides != b.slides:
        return float(np.arctan2(cosine, sine))
    return 0.0 if a.slides else float(np.arctan2(sine, cosine))


def _names(arm: Arm, joints: Joints) -> str:
    names = [arm.joint_names[i] for i in joints if i < arm.n]
    names += ["the turns that the target leaves free"] * (len(names) < len(joints))
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
