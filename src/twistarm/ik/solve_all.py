"""`solve_ik_all`: every configuration that meets a target."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..model.arm import Arm, require_arm
from ..support.caller_words import quantity
from ..support.checks import Array, as_flag, as_number, as_whole, frozen, require_callback
from ..support.errors import InputError, NoClosedFormError, shown, unknown_name
from .all_answers import AllAnswers, roots_in
from .all_solutions import IKSolutions
from .batch import Progress
from .certainty import is_exact
from .closed_form.methods import Method, closest_miss_of, known_method, method_for
from .closed_form.roots import (
    DEPENDENT,
    ROUNDED_DIRECTION,
    ROUNDED_LIMIT,
    Root,
    corrected,
    inside,
    met,
    roots,
    rows_of,
    self_motion,
    twin,
)
from .closed_form.roots import copies as copied
from .deadline import Deadline
from .ranges import holding, joint_ranges, standing
from .request import checked
from .searches import searched
from .self_motions import SelfMotions
from .solve import as_given, solve_ik
from .targets import AnyTarget, Approach, Pose, TargetLike, checked_target
from .task_space import Tolerances

if TYPE_CHECKING:
    from .._core import AllAnswers as CoreAllAnswers

STARTS = 1000
"""Searches where no closed form is known."""

BESIDE = 64
"""Searches beside elimination, and beside a family that the axes miss: what rounding loses is found by chance."""

IN_FAMILY = 32
"""Searches along a continuous family whose configuration nearest to theta0 lies outside the limits."""

KEPT = 1e-9
"""A joint nearer than this [rad, m] to theta0's value has it."""

DEFAULT_SAMPLES = 32

MOST_COMBINATIONS = 4096
"""Values of several sampled joints together."""


def solve_ik_all(
    arm: Arm,
    target: TargetLike,
    theta0: ArrayLike | None = None,
    *,
    given: Mapping[str, float] | None = None,
    samples: int = DEFAULT_SAMPLES,
    copies: bool = False,
    closed_form: bool = False,
    position_tol: float = 1e-9,
    orientation_tol: float = 1e-9,
    max_time: float | None = None,
    progress: Progress | None = None,
) -> IKSolutions:
    """Every configuration inside the limits that meets `target`, verified, nearest to `theta0` first.

    Nearest by the largest joint difference, in shares of the joint's range (2π or 1 m where it has none).

    By the closed form of the arm's family (a group of joints whose axes meet in a point or are parallel, at most three
    joints beside it), or, for five or six joints that turn, by elimination (an eigenvalue problem, for whatever axes);
    each answer is corrected by Newton's method until forward kinematics meets the target to rounding, and kept only if
    it does. Where there is neither, searches from many starts are tried, and `complete` is False.

    A `Pose` takes arms of up to six joints, an `Approach` of up to five, a `Position` of up to three. Arms with fewer
    meet the targets that fit them; `explain()` says how far off another is. Where there are more joints than the target
    determines, `given` holds some at values of your own; else they are held at `samples` values over their range. A
    joint that only rolls the tool about an `Approach`'s axis keeps theta0's value. Two answers less than 0.01 rad or m
    apart are one where halfway between them the target is met too; that of a stretched arm is one. What lies on one
    connected self-motion is one answer, which keeps a free joint at theta0's value where it can.

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
        max_time: Greatest time [s], of which a microsecond's closed form takes no notice; None for no limit.
        progress: Called with how many of the values of sampled joints and of the searches are done, and of how many,
            or None.

    Returns:
        The `IKSolutions`: theta (k, n), k ≥ 0, and whether these are all. Where the time was up before, what was found,
        `complete` False and `timed_out` True.

    Raises:
        InputError: The target, theta0, a given value or a number cannot be used.
        UnknownNameError: `given` names no joint of the arm.
        NoClosedFormError: `closed_form` is set and the arm has none for such a target; the message says why.
    """
    # What is plainly right goes straight to the core; checking it here would cost more than solving it.
    usual = given is None and samples is DEFAULT_SAMPLES and copies is False and max_time is None and progress is None
    if usual and type(closed_form) is bool:
        answer = _at_once(require_arm(arm), target, theta0, position_tol, orientation_tol)
        if answer is not None and (len(answer) or (answer.complete and not any(arm.rounding))):
            return answer
    asked = checked_target(require_arm(arm), target)
    request = checked(arm, theta0, None, position_tol, orientation_tol, 1, 0, max_time)
    require_callback(progress, "progress", "(done, count)")
    as_flag(copies, "copies")
    as_flag(closed_form, "closed_form")
    count = as_whole(samples, "samples", 1, 1000)
    stands = given_joints(arm, given)
    method = method_for(arm, asked, tuple(stands))
    if closed_form and method.family is None:
        raise NoClosedFormError(_none(arm, asked, method))
    near = np.array(request.theta0)
    near[list(stands)] = list(stands.values())
    deadline = Deadline.after(request.max_time)
    task = _Task(arm, asked, near, request.tolerances, method.given, method.idle, deadline, progress)
    answer = _answered(task, method, count, copies)
    if len(answer) or answer.timed_out or not any(arm.rounding):
        return answer
    wider = replace(task, tolerances=request.tolerances.or_rounding(arm.rounding), rounded=True)
    return _answered(wider, method, count, copies)


def _answered(task: _Task, method: Method, count: int, copies: bool) -> IKSolutions:
    """What the method finds, with `count` values of each joint that is sampled."""
    values = task.held_values(method, count)
    known = None if method.compiled is None or task.rounded else task.compiled(method, values)
    if known is not None and not method.swept:
        if known.families:
            known = None  # the core keeps one of all families that move the same joints
        elif not copies and (known.inside or is_exact(task.tolerances)):
            return IKSolutions(task.arm, known, (), method, task.complete(method), task.target)
    if known is None:
        found, starts, hits = task.solved(method, values)
    else:
        found, starts, hits = [*roots_in(known)], known.tries, known.hits
    if not found and not is_exact(task.tolerances):
        found = task.within(method)
    if method.there and method.swept and all(task.inside(root) is None for root in found) and not task.deadline.passed:
        members, tried, met = replace(task, progress=None).solved(method, task.values_met(method))
        found, starts, hits = found + members, starts + tried, hits + met
    families = task.families(found)
    missed = False
    more = task.searches(method)
    if more:
        beside, run, met = task.searched(more, found, int(method.there))
        before, families = len(families), task.families(found + beside) if beside else families
        missed = len(families) > before
        if missed or not method.exact or task.rounded:
            starts, hits = starts + run, hits + met
    all_seen = task.brought_inside(families, method.held)
    return task.told(method, families, copies, (starts, hits), all_seen and not missed)


def _at_once(
    arm: Arm, target: TargetLike, theta0: ArrayLike | None, position_tol: float, orientation_tol: float
) -> IKSolutions | None:
    """The answer of the core, where it has the family and everything is plainly right."""
    asked = None if type(target) is np.ndarray else as_given(arm, target)
    like, numbers = (Pose, target) if asked is None else (type(asked), asked.numbers)
    method = known_method(arm, like, asked.axis.tobytes() if isinstance(asked, Approach) else None)
    if method is None or method.compiled is None or method.swept:
        return None
    start = arm.ready if theta0 is None else theta0
    found = method.compiled.solve(numbers, start, None, position_tol, orientation_tol)
    if found is None or found.families:
        return None
    return IKSolutions(arm, found, (), method, is_exact(Tolerances(position_tol, orientation_tol)), asked)


@dataclass(frozen=True, eq=False)
class _Task:
    """What is asked: a target, near which configuration, how exactly, which joints are given, and until when.

    `progress` is told how many values and searches are done, and of how many. `rounded`: the tolerances are those of
    rounded axes, which may miss the target in directions that exact ones need not move in.
    """

    arm: Arm
    target: AnyTarget
    near: Array
    tolerances: Tolerances
    given: tuple[int, ...]
    idle: tuple[int, ...]
    deadline: Deadline
    progress: Progress | None
    rounded: bool = False

    def compiled(self, method: Method, values: Array) -> CoreAllAnswers:
        """What the core has found with the held joints at each of the values (k, h)."""
        assert method.compiled is not None
        held, met = values if len(values) > 1 else None, self.tolerances
        found = method.compiled.solve(self.target.numbers, self.near, held, met.position, met.orientation)
        assert found is not None, "what was checked is plain"
        return found

    def complete(self, method: Method) -> bool:
        """Whether the method finds everything."""
        return method.exact and not method.swept and not self.rounded and is_exact(self.tolerances)

    def searches(self, method: Method) -> int:
        """How many searches are made beside the method, or for want of one."""
        if not method.there:
            return STARTS
        lossy = method.rooted is not None or not method.exact or self.rounded
        return BESIDE if lossy and not method.swept else 0

    def roots(self, candidates: Iterable[Array], held: tuple[int, ...], known: list[Root]) -> list[Root]:
        """The different answers among the candidates that are not known yet, until the time is up."""
        until = self.deadline.until(candidates)
        if not self.rounded:
            return roots(self.arm, self.target, until, self.tolerances, held, known)
        steady = map(self.as_near, until)
        return roots(self.arm, self.target, steady, self.tolerances, held, known, ROUNDED_DIRECTION)

    @property
    def dependent(self) -> float:
        """Singular values below this part of the largest are those of directions that move nothing at first."""
        return ROUNDED_DIRECTION if self.rounded else DEPENDENT

    def as_near(self, theta: Array) -> Array:
        """theta (n,) with theta0's value for joints that move nothing but by the rounding of the axes."""
        size = np.linalg.norm(rows_of(self.arm, self.target, theta)[1], axis=0)
        return np.where(size < ROUNDED_DIRECTION * size.max(initial=0.0), self.stand, theta)

    def solved(self, method: Method, values: Array) -> tuple[list[Root], int, int]:
        """Roots with the held joints at each of the values (k, h); how many values, and how many had roots."""
        found: list[Root] = []
        tries = hits = 0
        for each in self.deadline.until(values if method.there else ()):
            new: list[Root] = []
            exact = method.exact and not self.rounded
            for candidates in self.deadline.until(method.candidates(self.arm, self.target, self.near, each, exact)):
                new += self.roots(candidates, method.held, new)
            held = {*method.idle, *method.swept}
            found += [replace(root, free=tuple(sorted({*root.free, *held}))) for root in new]
            hits += bool(new)
            tries += 1
            self.told_of(tries, len(values) + self.searches(method))
        return (found, tries, hits) if method.swept else (found, 0, 0)

    def values_met(self, method: Method) -> Array:
        """Values (k, h) of the joints held, k ≤ 1, in a configuration that a search has found: samples may miss all."""
        arm, met = holding(self.arm, self.given, self.near), self.tolerances
        left = None if np.isinf(self.deadline.moment) else max(self.deadline.left, 1e-6)
        found = solve_ik(
            arm, self.target, self.near, position_tol=met.position, orientation_tol=met.orientation, max_time=left
        )
        return found.theta[None, list(method.held)][: int(found.converged)]

    def within(self, method: Method) -> list[Root]:
        """The answer of a search, which uses loose tolerances as a closed form, made for exact targets, does not."""
        held = holding(self.arm, self.given, self.near)
        met = self.tolerances
        found = solve_ik(held, self.target, self.near, position_tol=met.position, orientation_tol=met.orientation)
        return [Root(found.theta, method.idle)] if found.converged else []

    def told_of(self, done: int, count: int) -> None:
        """Whoever asked hears how far it is."""
        if self.progress is not None:
            self.progress(done, count)

    def held_values(self, method: Method, count: int) -> Array:
        """Values (k, h) of the joints held: those given, theta0's of idle ones, and a grid of the others."""
        while count ** len(method.swept) > MOST_COMBINATIONS:
            count -= 1
        grid = {i: self._with_near(i, self._spread(i, count)) for i in method.swept}
        choices = [grid.get(i, np.array([self.stand[i]])) for i in method.held]
        combinations = list(itertools.product(*choices))
        return np.array(combinations).reshape(len(combinations), len(method.held))

    def _spread(self, joint: int, count: int) -> Array:
        """Values over the range of a joint, an unbounded one's about theta0; no angle twice."""
        lower, upper = self.arm.limits.lower[joint], self.arm.limits.upper[joint]
        half = 0.5 if self.arm.units[joint] == "m" else np.pi
        lower = lower if np.isfinite(lower) else self.near[joint] - half
        upper = upper if np.isfinite(upper) else self.near[joint] + half
        whole = joint_ranges(self.arm).turns[joint]
        end = lower + 2.0 * np.pi if whole else upper
        return np.linspace(lower, end, count, endpoint=not whole)

    def _with_near(self, joint: int, values: Array) -> Array:
        """Those values of a joint, theta0's first, no two of which are the same angle."""
        apart = values - self.near[joint]
        if joint_ranges(self.arm).periodic[joint]:
            apart = (apart + np.pi) % (2.0 * np.pi) - np.pi
        return np.append(self.near[joint], values[np.abs(apart) > ROUNDED_LIMIT])

    def searched(self, count: int, known: list[Root], before: int) -> tuple[list[Root], int, int]:
        """Roots from many starts that are not known yet, how many searches were run, and how many met the target.

        `before`: how many values of `progress` are done.
        """
        starts = np.vstack([self.near, self.arm.random_theta(0, count - 1)])
        return self.from_starts(starts, known, lambda done, _: self.told_of(before + done, before + count))

    def from_starts(
        self, starts: Array, known: list[Root], progress: Progress | None = None
    ) -> tuple[list[Root], int, int]:
        """The same from these starts (k, n)."""
        if self.deadline.passed:
            return [], 0, 0
        left = None if np.isinf(self.deadline.moment) else max(self.deadline.left, 1e-6)
        targets = [self.target] * len(starts)
        arm = holding(self.arm, self.given, self.near)
        done = searched(arm, targets, starts, max_time=left, progress=progress)
        return self.roots(done.met, self.given, known), done.run, len(done.met)

    @cached_property
    def stand(self) -> Array:
        """theta0's values (n,), or the limits beyond which these are."""
        return np.clip(self.near, self.arm.limits.lower, self.arm.limits.upper)

    @cached_property
    def motions(self) -> SelfMotions:
        """Along which answers may move; what an idle joint does tells none apart."""
        still = (*self.given, *self.idle)
        return SelfMotions(self.arm, self.target, still, self.tolerances, self.deadline, self.dependent)

    def alone(self, root: Root) -> bool:
        """Whether it belongs to no continuous family, but for what idle joints do."""
        return {*self.motions.still}.issuperset(root.free)

    def families(self, found: list[Root]) -> list[list[Root]]:
        """The roots, those together that lie on one self-motion."""
        moving = [root for root in found if not self.alone(root)]
        places = self.motions.families([root.theta for root in moving])
        return [[root] for root in found if self.alone(root)] + [[moving[i] for i in each] for each in places]

    def brought_inside(self, families: list[list[Root]], held: tuple[int, ...]) -> bool:
        """Add a member that keeps a joint at theta0's value to each family, and one inside where none is yet.

        Whether every family was met inside: where searches along it find nothing, there may be something yet.
        """
        all_seen = True
        for members in families:
            if self.alone(members[0]) or self.deadline.passed:
                continue
            if not {*held}.issuperset(members[0].free) and all(self.inside(root) is None for root in members):
                along = [root for root in self.along(members[0], members) if self.inside(root) is not None]
                passed = self.motions.passed(members[0].theta, [root.theta for root in along])
                members += [along[i] for i in passed]
                all_seen = all_seen and self.inside(members[-1]) is not None
            members += self.keeping(members)
        return all_seen

    def keeping(self, members: list[Root]) -> list[Root]:
        """Of a family a member with a free joint at theta0's value, the first that can; none where there is one."""
        free = [i for i in members[0].free if i not in self.motions.still]
        there = [theta for root in members if (theta := self.inside(root)) is not None]
        if any(self.at_start(theta, free) for theta in there):
            return []
        known = np.array(there or [members[0].theta])
        for i in free:
            begin = known[int(np.argmin(np.abs(known[:, i] - self.stand[i])))]
            theta = np.array(begin)
            theta[i] = self.stand[i]
            theta = corrected(self.arm, self.target, theta, (*self.motions.still, i), self.dependent)
            root = Root(theta, members[0].free)
            if (
                met(self.arm, self.target, theta, self.tolerances)
                and self.inside(root) is not None
                and self.motions.together(theta, begin)
            ):
                return [root]
        return []

    def at_start(self, theta: Array, joints: Sequence[int]) -> int:
        """How many of the joints stand at theta0's value."""
        return int((np.abs(theta - self.stand)[list(joints)] <= KEPT).sum())

    def along(self, root: Root, known: list[Root]) -> list[Root]:
        """New roots from starts that differ from this one in the joints that are free."""
        lower, upper = self.arm.sampling_bounds
        starts = np.tile(np.clip(root.theta, lower, upper), (IN_FAMILY, 1))
        free = list(root.free)
        starts[:, free] = self.arm.random_theta(0, IN_FAMILY)[:, free]
        return self.from_starts(starts, known)[0]

    def inside(self, root: Root) -> Array | None:
        """The root inside the limits, if it is there."""
        return inside(self.arm, self.target, root.theta, self.near, self.tolerances)

    def distance(self, theta: Array) -> float:
        """From theta0."""
        return distance(self.arm, theta, self.near)

    def entry(self, members: list[Root], swept: bool) -> Entry:
        """One answer, or one family by the member that keeps most joints at theta0's value, the nearest of these."""
        there = [theta for root in members if (theta := self.inside(root)) is not None]
        free = {i for root in members for i in root.free}
        own = [i for i in free if i not in self.motions.still]
        there.sort(key=lambda theta: (-self.at_start(theta, own), self.distance(theta)))
        first = there[0] if there else members[0].theta
        if swept and not self.deadline.passed:
            free |= {*self_motion(self.arm, self.target, first, self.tolerances, self.motions.still, self.dependent)}
        moving = np.array([i in free for i in range(self.arm.n)])
        return Entry(first, moving, there, self.distance(first))

    def told(
        self, method: Method, families: list[list[Root]], copies: bool, tries: tuple[int, int], all_seen: bool
    ) -> IKSolutions:
        """The answers inside the limits, nearest first, and those outside; twins are one."""
        arm, kept = self.arm, list[Entry]()
        entries = [self.entry(members, bool(method.swept)) for members in families]
        for each in sorted(entries, key=lambda entry: (not entry.inside, entry.distance)):
            i = twin(arm, self.target, each.theta, [other.theta for other in kept], self.tolerances)
            if i is None:
                kept.append(each)
            else:
                kept[i].take(each)
        within = [entry for entry in kept if entry.inside]
        if copies:
            more = [(theta, entry) for entry in within for theta in copied(arm, entry.theta)]
            within = [Entry(theta, entry.moving, [theta], self.distance(theta)) for theta, entry in more]
            within.sort(key=lambda entry: entry.distance)
        every = [*within, *(entry for entry in kept if not entry.inside)]
        theta = np.array([entry.theta for entry in every]).reshape(-1, arm.n)
        moves = np.array([entry.moving for entry in every], dtype=np.bool_).reshape(-1, arm.n)
        numbers = self.target.numbers.ravel()
        found = AllAnswers(theta, moves, len(within), self.near, self.target.kind, numbers, *tries)
        late = self.deadline.passed
        members = tuple(frozen(np.array(entry.inside)) for entry in within)
        return IKSolutions(
            arm, found, members, method,
            all_seen and not late and self.complete(method), self.target, late, self.rounded,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Entry:
    """An answer theta (n,), which joints may move (n,), and the members of its family inside the limits."""

    theta: Array
    moving: NDArray[np.bool_]
    inside: list[Array]
    distance: float

    def take(self, other: Entry) -> None:
        """Make the other one with this."""
        np.logical_or(self.moving, other.moving, out=self.moving)
        self.inside.extend(other.inside)


def distance(arm: Arm, theta: Array, near: Array) -> float:
    """The largest joint difference, in shares of the joint's range, 2π or 1 m where it has none."""
    span = arm.limits.upper - arm.limits.lower
    usual = np.where(np.array(arm.units) == "m", 1.0, 2.0 * np.pi)
    return float((np.abs(theta - near) / np.where(np.isfinite(span) & (span > 0.0), span, usual)).max(initial=0.0))


def given_joints(arm: Arm, given: Mapping[str, float] | None) -> dict[int, float]:
    """{joint's index: value}, base to tip, those among them whose limits are one value."""
    stands = {i: float(arm.limits.lower[i]) for i in standing(arm)}
    if given is None:
        return stands
    if not isinstance(given, Mapping):
        raise InputError(f"given must be a mapping such as {{'elbow': 0.3}}; got {shown(given)}")
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
