"""`solve_ik_all`: every configuration that meets a target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..model.arm import Arm, require_arm
from ..support.caller_words import quantity
from ..support.checks import Array, as_flag, as_number, as_whole
from ..support.errors import InputError, NoClosedFormError, shown, unknown_name
from .all_solutions import IKSolutions
from .batch import solve_ik_batch
from .closed_form.methods import Method, closest_miss_of, method_for
from .closed_form.roots import ROUNDED_LIMIT, Root, inside, roots
from .closed_form.roots import copies as copied
from .ranges import TURN, joint_ranges
from .request import checked
from .targets import AnyTarget, TargetLike, checked_target
from .task_space import Tolerances

STARTS = 1000
"""Searches where no closed form is known."""

BESIDE = 64
"""Searches beside elimination, and beside a family that the axes miss: what rounding loses is found by chance."""

MOST_COMBINATIONS = 4096
"""Values of several sampled joints together."""


def solve_ik_all(
    arm: Arm,
    target: TargetLike,
    theta0: ArrayLike | None = None,
    *,
    given: Mapping[str, float] | None = None,
    samples: int = 32,
    copies: bool = False,
    closed_form: bool = False,
    position_tol: float = 1e-9,
    orientation_tol: float = 1e-9,
) -> IKSolutions:
    """Every configuration inside the limits that meets `target`, verified, nearest to `theta0` first.

    By the closed form of the arm's family (a group of joints whose axes meet in a point or are parallel, at most three
    joints beside it), or, for six joints that turn, by elimination (an eigenvalue problem, for whatever axes); each
    answer is corrected by Newton's method until forward kinematics meets the target to rounding, and kept only if it
    does. Where there is neither, searches from many starts are tried, and `complete` is False.

    A `Pose` takes arms of up to six joints, an `Approach` of up to five, a `Position` of up to three. Arms with fewer
    meet the targets that fit them; `explain()` says how far off another is. Where there are more joints than the target
    determines, `given` holds some at values of your own; else they are held at `samples` values over their range. A
    joint that only rolls the tool about an `Approach`'s axis keeps theta0's value. Two answers are one where halfway
    between them the target is met too; that of a stretched arm is one.

    Sources: MLS §3.3; Pieper 1968; Elias & Wen, IK-Geo, 2022; Raghavan & Roth 1993.

    Args:
        arm: The arm.
        target: `Pose`, `Position`, `Approach` or a pose (4, 4); of a `Task` only a search is made.
        theta0: Configuration (n,) [rad, m] from which distances are counted, by default `arm.ready`.
        given: {joint: value} [rad, m] of joints that are to stand there.
        samples: Number of values of each joint that is held, in (0, 1000]; at most 4,096 combinations are tried.
        copies: Whether configurations that differ by whole turns count as different, inside the limits.
        closed_form: Whether to raise NoClosedFormError rather than to search.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].

    Returns:
        The `IKSolutions`: theta (k, n), k ≥ 0, and whether these are all.

    Raises:
        InputError: The target, theta0, a given value or a number cannot be used.
        UnknownNameError: `given` names no joint of the arm.
        NoClosedFormError: `closed_form` is set and the arm has none for such a target; the message says why.
    """
    asked = checked_target(require_arm(arm), target)
    request = checked(arm, theta0, None, position_tol, orientation_tol, 1, 0, None)
    as_flag(copies, "copies")
    as_flag(closed_form, "closed_form")
    count = as_whole(samples, "samples", 1, 1000)
    stands = _given(arm, given)
    method = method_for(arm, asked, tuple(stands))
    if closed_form and method.family is None:
        raise NoClosedFormError(_none(arm, asked, method))
    near = np.array(request.theta0)
    near[list(stands)] = list(stands.values())
    task = _Task(arm, asked, near, request.tolerances, tuple(stands))
    found, starts, hits = task.solved(method, count) if method.there else ([], 0, 0)
    if not method.exact and not method.swept:
        more = BESIDE if method.there else STARTS
        beside, met = task.searched(more, found)
        found, starts, hits = found + beside, starts + more, hits + met
    return task.told(request.theta0, method, found, copies, (starts, hits))


@dataclass(frozen=True, eq=False)
class _Task:
    """What is asked: a target, near which configuration, how exactly, and which joints are given."""

    arm: Arm
    target: AnyTarget
    near: Array
    tolerances: Tolerances
    given: tuple[int, ...]

    def solved(self, method: Method, count: int) -> tuple[list[Root], int, int]:
        """Roots by the method, for every value of the joints that are held; how many values, and how many had roots."""
        values = self._held_values(method, count)
        found: list[Root] = []
        hits = 0
        for each in values:
            candidates = method.candidates(self.arm, self.target, self.near, each)
            new = roots(self.arm, self.target, candidates, self.tolerances, method.held)
            for root in new:
                free = {*root.free, *method.idle, *method.swept} - {*self.given}
                found.append(replace(root, free=tuple(sorted(free))))
            hits += bool(new)
        return (found, len(values), hits) if len(values) > 1 else (found, 0, 0)

    def _held_values(self, method: Method, count: int) -> Array:
        """Values (k, h) of the joints held: those given, theta0's of idle ones, and a grid of the others."""
        swept = [i for i in method.swept if i not in self.given]
        while count ** len(swept) > MOST_COMBINATIONS:
            count -= 1
        grid = {i: np.append(self.near[i], self._spread(i, count)) for i in swept}
        choices = [grid.get(i, np.array([self.near[i]])) for i in method.held]
        combinations = list(product(*choices))
        return np.array(combinations).reshape(len(combinations), len(method.held))

    def _spread(self, joint: int, count: int) -> Array:
        """Values over the range of a joint; an unbounded one's about theta0."""
        lower, upper = self.arm.limits.lower[joint], self.arm.limits.upper[joint]
        half = 0.5 if self.arm.units[joint] == "m" else np.pi
        lower = lower if np.isfinite(lower) else self.near[joint] - half
        upper = upper if np.isfinite(upper) else self.near[joint] + half
        spread: Array = np.linspace(lower, upper, count)
        return spread

    def searched(self, count: int, known: list[Root]) -> tuple[list[Root], int]:
        """Roots from many starts that are not known yet, and how many searches met the target."""
        starts = np.vstack([self.near, self.arm.random_theta(0, count - 1)])
        batch = solve_ik_batch(self.arm, [self.target] * count, starts, restarts=1)
        met = batch.theta[batch.converged]
        met = met[(np.abs(met[:, self.given] - self.near[list(self.given)]) <= ROUNDED_LIMIT).all(axis=1)]
        everything = roots(self.arm, self.target, [*(root.theta for root in known), *met], self.tolerances, self.given)
        return everything[len(known) :], len(met)

    def told(
        self, theta0: Array, method: Method, found: list[Root], copies: bool, tries: tuple[int, int]
    ) -> IKSolutions:
        """The roots inside the limits, nearest first, and those outside."""
        arm = self.arm
        pairs: list[tuple[Array, tuple[int, ...]]] = []
        outside: list[Array] = []
        for root in found:
            theta = inside(arm, self.target, root.theta, self.near, self.tolerances)
            if theta is None:
                outside.append(_toward_middle(arm, root.theta))
            else:
                pairs += [(each, root.free) for each in (copied(arm, theta) if copies else [theta])]
        pairs.sort(key=lambda pair: distance(arm, pair[0], self.near))
        complete = method.exact and not any(i not in self.given for i in method.swept)
        return IKSolutions(
            arm, self.target, theta0, np.array([theta for theta, _ in pairs]).reshape(-1, arm.n),
            tuple(tuple(arm.joint_names[i] for i in free) for _, free in pairs),
            np.array(outside).reshape(-1, arm.n), complete, method.name, method.in_words(arm), *tries,
        )  # fmt: skip


def _toward_middle(arm: Arm, theta: Array) -> Array:
    """theta (n,) by whole turns as near to the middle of the limits as they bring it: so it is least outside."""
    lower, upper = arm.limits.lower, arm.limits.upper
    bounded = np.isfinite(lower) & np.isfinite(upper)
    middle = 0.5 * (np.where(bounded, lower, 0.0) + np.where(bounded, upper, 0.0))
    return np.where(joint_ranges(arm).periodic, theta + TURN * np.round((middle - theta) / TURN), theta)


def distance(arm: Arm, theta: Array, near: Array) -> float:
    """The largest joint difference, in shares of the joint's range, 2π or 1 m where it has none."""
    span = arm.limits.upper - arm.limits.lower
    usual = np.where(np.array(arm.units) == "m", 1.0, 2.0 * np.pi)
    return float((np.abs(theta - near) / np.where(np.isfinite(span) & (span > 0.0), span, usual)).max(initial=0.0))


def _given(arm: Arm, given: Mapping[str, float] | None) -> dict[int, float]:
    """{joint's index: value}, base to tip."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        raise InputError(f"given must be a mapping such as {{'elbow': 0.3}}; got {shown(given)}")
    stands = {}
    for name, value in given.items():
        if name not in arm.joint_names:
            raise unknown_name("joint", name, arm.joint_names, within=arm.name, listing="arm.joint_names")
        number = as_number(value, f"given[{name!r}]")
        i = arm.joint_names.index(name)
        if not arm.limits.lower[i] <= number <= arm.limits.upper[i]:
            raise InputError(
                f"joint {name!r} cannot be given at {quantity(number, arm.units[i])}, outside its limits "
                f"{quantity(arm.limits.lower[i], arm.units[i])} … {quantity(arm.limits.upper[i], arm.units[i])}"
            )
        stands[i] = number
    return dict(sorted(stands.items()))


def _none(arm: Arm, target: AnyTarget, method: Method) -> str:
    kind = type(target).__name__
    miss = f"{closest_miss_of(arm, method)[1]}; elimination solves it numerically, without closed_form=True"
    why = method.reason or miss
    return f"{arm.name} has no closed form for a {kind}: {why}"
