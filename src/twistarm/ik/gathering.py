"""Gathering: the roots of one target by every method, grouped into families and answers."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.engine import answered
from ..support.checks import Array, Progress
from .all_solutions import AllSolutions
from .answer import Configurations
from .closed_form.methods import Method
from .closed_form.roots import ROUNDED_LIMIT, Root, Task, copies_inside, joint_difference
from .ranges import holding, joint_ranges
from .request import Deadline
from .searches import searched
from .self_motions import SelfMotions
from .solution import IKResult
from .solve import solve_ik
from .task_space import EXACT_TOL, Tolerances

STARTS = 1000  # Searches where no closed form is known.
# Searches besides elimination, or a family that the axes miss. They find what rounding loses.
EXTRA_SEARCHES = 64
# Shares of the way from one configuration to another at which the target must be reached if both are of one branch.
BETWEEN = np.linspace(0.0, 1.0, 9)[1:-1]
SAME_VALUE = 1e-9  # A joint within this [rad, m] of theta0's value has that value.
MOST_COMBINATIONS = 4096  # Values of several sampled joints together.


@dataclass(frozen=True, eq=False)
class Gathering(Task):
    """One task: a target, tolerances, the configuration to be near, the method and the deadline.

    `progress` gets the fraction of values and searches done.
    """

    near: Array
    method: Method
    deadline: Deadline
    progress: Progress | None

    def compiled(self, values: Array) -> Configurations:
        """What the core finds with the held joints at each of the values (k, h)."""
        assert self.method.core is not None
        held, exact = values if len(values) > 1 else None, self.tolerances
        found = self.method.core.solve(self.target.numbers, self.near, held, exact.position, exact.orientation)
        return Configurations(*answered(found))

    def eliminated(self, values: Array) -> Configurations | None:
        """What elimination finds with the held joints at `values` (h,). None where every way leaves a doubt."""
        for candidates in self.method.eliminated(self.arm, self.target, values):
            found = None if candidates.answers is None else self._verified(candidates.x)
            if found is not None and len(found.rows) == candidates.answers and not found.families:
                return found
        return None

    def _verified(self, candidates: Array) -> Configurations:
        """The different answers among the candidates (k, n), verified by the core."""
        assert self.method.verifier is not None
        how = self.near, candidates, self.tolerances.position, self.tolerances.orientation
        return Configurations(*answered(self.method.verifier.verify(self.target.numbers, *how)))

    @property
    def complete(self) -> bool:
        """Whether the method finds everything."""
        return self.method.exact and not self.method.sampled

    @property
    def searches(self) -> int:
        """The number of searches beside the method, or instead of one."""
        if not self.method.algebraic:
            return STARTS
        lossy = self.method.elimination is not None or not self.method.exact
        return EXTRA_SEARCHES if lossy and not self.method.sampled else 0

    def new_roots(self, candidates: Array, held: tuple[int, ...], known: list[Root]) -> list[Root]:
        """New different answers among the candidates (k, n), until the time is up."""
        if self.method.verifier is not None:
            found = self._verified(candidates)
            if not found.families:
                return [Root(theta, ()) for theta in found.theta if not self.known(theta, known)]
        return self.roots(self.deadline.until(candidates), held, known)

    def solved(self, values: Array) -> tuple[list[Root], int, int]:
        """Roots with the held joints at each of the values (k, h), and how many values have any."""
        method, found = self.method, list[Root]()
        tries = hits = 0
        for row in self.deadline.until(values if method.algebraic else ()):
            new = self._roots_with(row)
            held = {*method.idle, *method.sampled}
            found += [replace(root, free=tuple(sorted({*root.free, *held}))) for root in new]
            hits += bool(new)
            tries += 1
            self.report_progress(tries, len(values) + self.searches)
        return (found, tries, hits) if method.sampled else (found, 0, 0)

    def _roots_with(self, values: Array) -> list[Root]:
        """Roots with the held joints at `values` (h,)."""
        method = self.method
        found = self.eliminated(values) if method.verifier is not None and method.sampled else None
        if found is not None:
            return [Root(theta, ()) for theta in found.theta]
        candidates = method.candidates(self.arm, self.target, self.near, values, method.exact)
        return self.new_roots(candidates, method.held, [])

    def values_found(self) -> Array:
        """Values (k, h), k ≤ 1, of the held joints in a configuration found by a search. Samples may miss all."""
        found = self.one_search()
        return found.theta[None, list(self.method.held)][: int(found.converged)]

    def within_tolerances(self, tolerances: Tolerances) -> tuple[list[Root], int, int]:
        """One configuration of each branch that reaches the target within these, where none does exactly.

        Also the number of searches and how many reached the target. Two branches are separate if the straight line
        between them leaves the target.
        """
        task = replace(self, tolerances=tolerances, progress=None)
        first = task.one_search()
        if not first.converged:
            return [], 0, 0
        arm, starts = holding(self.arm, self.method.given, self.near), self.arm.random_theta(0, EXTRA_SEARCHES)
        done = searched(arm, [self.target] * len(starts), starts, tolerances, max_time=self.deadline.left)
        kept = [first.theta]
        for theta in self.deadline.until(sorted(done.solutions, key=self.distance)):
            left = [joint_difference(self.arm, other, theta) for other in kept]
            if not any(all(task.converged(theta + share * way) for share in BETWEEN) for way in left):
                kept.append(theta)
        return [Root(theta, self.method.idle) for theta in kept], done.run, int(done.converged.sum())

    def one_search(self) -> IKResult:
        """The solution of `solve_ik` from theta0, with the given joints held."""
        arm = holding(self.arm, self.method.given, self.near)
        return solve_ik(arm, self.target, self.near, **self.tolerances.keywords, max_time=self.deadline.left)

    def report_progress(self, done: float, count: int) -> None:
        """Report the progress to the caller."""
        if self.progress is not None:
            self.progress(done / count)

    def held_values(self, count: int) -> Array:
        """Values (k, h) of the held joints: given ones, theta0's for idle ones, else a grid."""
        # Fewer values of each joint, evenly, and not the first combinations of many: those would leave parts out.
        while count ** len(self.method.sampled) > MOST_COMBINATIONS:
            count -= 1
        grid = {i: self._theta0_first(i, self._spread(i, count)) for i in self.method.sampled}
        choices = [grid.get(i, np.array([self.theta0_inside[i]])) for i in self.method.held]
        combinations = list(itertools.product(*choices))
        return np.array(combinations).reshape(len(combinations), len(self.method.held))

    def _spread(self, joint: int, count: int) -> Array:
        """Different values over the range of a joint, or about theta0 for an unbounded one."""
        lower, upper = self.arm.limits.lower[joint], self.arm.limits.upper[joint]
        half = 0.5 if self.arm.units[joint] == "m" else np.pi
        lower = lower if np.isfinite(lower) else self.near[joint] - half
        upper = upper if np.isfinite(upper) else self.near[joint] + half
        whole = joint_ranges(self.arm).turns[joint]
        end = lower + 2.0 * np.pi if whole else upper
        return np.linspace(lower, end, count, endpoint=not whole)

    def _theta0_first(self, joint: int, values: Array) -> Array:
        """Theta0's value of a joint, followed by the values that are another angle."""
        offset = values - self.near[joint]
        if joint_ranges(self.arm).periodic[joint]:
            offset = (offset + np.pi) % (2.0 * np.pi) - np.pi
        return np.append(self.near[joint], values[np.abs(offset) > ROUNDED_LIMIT])

    def searched(self, count: int, known: list[Root], before: int) -> tuple[list[Root], int, int]:
        """New roots from `count` starts, the number of searches, and how many reached the target.

        `before`: how many values of `progress` are done.
        """
        if self.deadline.passed:
            return [], 0, 0
        starts = np.vstack([self.near, self.arm.random_theta(0, count - 1)])
        arm = holding(self.arm, self.method.given, self.near)
        done = searched(
            arm, [self.target] * count, starts, Tolerances(EXACT_TOL, EXACT_TOL), max_time=self.deadline.left,
            progress=lambda done: self.report_progress(before + done * count, before + count),
        )  # fmt: skip
        idle = [i in self.method.idle for i in range(self.arm.n)]  # their values distinguish no answers
        candidates = np.where(idle, self.theta0_inside, done.solutions)
        held = (*self.method.given, *self.method.idle)
        return self.new_roots(candidates, held, known), done.run, int(done.converged.sum())

    @cached_property
    def theta0_inside(self) -> Array:
        """theta0's values (n,), clipped to the limits."""
        return np.clip(self.near, self.arm.limits.lower, self.arm.limits.upper)

    @cached_property
    def motions(self) -> SelfMotions:
        """The self-motions of the answers. Idle joints distinguish no answers."""
        still = (*self.method.given, *self.method.idle)
        return SelfMotions(self.arm, self.target, self.tolerances, still, self.deadline)

    def isolated(self, root: Root) -> bool:
        """Whether a root belongs to no continuous family, apart from the motions of idle joints."""
        return {*self.motions.still}.issuperset(root.free)

    def families(self, found: list[Root]) -> list[Members]:
        """The roots, those of one self-motion together."""
        moving = [root for root in found if not self.isolated(root)]
        connected = self.motions.families([root.theta for root in moving])
        alone = [Members([root], root.theta[None]) for root in found if self.isolated(root)]
        return alone + [Members([moving[i] for i in places], curve) for places, curve in connected]

    def at_start(self, theta: Array, joints: Sequence[int]) -> int:
        """How many of the joints are at theta0's value."""
        return int((np.abs(theta - self.theta0_inside)[list(joints)] <= SAME_VALUE).sum())

    def distance(self, theta: Array) -> float:
        """The largest joint difference from theta0, in shares of the joint's range (else 2π or 1 m)."""
        span = self.arm.limits.upper - self.arm.limits.lower
        usual = np.where(np.array(self.arm.units) == "m", 1.0, 2.0 * np.pi)
        shares = np.abs(theta - self.near) / np.where(np.isfinite(span) & (span > 0.0), span, usual)
        return float(shares.max(initial=0.0))

    def entry(self, family: Members) -> Entry:
        """An answer, or the best of a family inside the limits: most free joints at theta0's value, then nearest."""
        free = {i for root in family.roots for i in root.free}
        own = sorted(free - {*self.motions.still})
        inside = self.inside(np.array([root.theta for root in family.roots]))
        if not any(self.at_start(theta, own) for theta in inside):
            inside += self._first_inside(family.curve, [(i, self.theta0_inside[i]) for i in own])
        if own and not inside:  # a part of a curve inside the limits begins at one of them
            limits = [(i, bound[i]) for i in own for bound in (self.arm.limits.lower, self.arm.limits.upper)]
            inside = self._first_inside(family.curve, [(i, value) for i, value in limits if np.isfinite(value)])
            inside = inside or self.inside(self.motions.toward(family.roots[0].theta, self.theta0_inside))
        inside.sort(key=lambda theta: (-self.at_start(theta, own), self.distance(theta)))
        theta = inside[0] if inside else family.roots[0].theta
        if self.method.sampled and not self.deadline.passed:
            free |= {*self.self_motion(theta, self.motions.still)}
        moving = np.array([i in free for i in range(self.arm.n)])
        return Entry(theta, moving, bool(inside), self.distance(theta))

    def _first_inside(self, curve: Array, values: Iterable[tuple[int, float]]) -> list[Array]:
        """Members inside the limits for the first joint and value that have any."""
        found = (self.inside(self.motions.passing(curve, joint, value)) for joint, value in self.deadline.until(values))
        return next(filter(None, found), [])

    def inside(self, thetas: Iterable[Array]) -> list[Array]:
        """Those of the configurations that lie inside the limits, by whole turns near to theta0. When late, the first.

        An array (k, n) is compared with the limits at once. Thousands of roots one by one would break the deadline.
        """
        if isinstance(thetas, np.ndarray):
            thetas = thetas[self.may_be_inside(thetas, self.near)]
        found: list[Array] = []
        for theta in thetas:
            brought = self.inside_limits(theta, self.near)
            found += [] if brought is None else [brought]
            if found and self.deadline.passed:
                break
        return found

    def assembled(self, families: list[Members], copies: bool, tries: tuple[int, int], all_seen: bool) -> AllSolutions:
        """The answers inside the limits, nearest first, then those outside. Twins become one answer."""
        arm, kept, thetas = self.arm, list[Entry](), np.empty((len(families), self.arm.n))
        entries = [self.entry(family) for family in families]
        pairs = zip(entries, families, strict=True)
        all_seen = all_seen and all(entry.inside or self.isolated(family.roots[0]) for entry, family in pairs)
        for entry in sorted(entries, key=lambda entry: (not entry.inside, entry.distance)):
            i = self.twin(entry.theta, thetas[: len(kept)])
            if i is None:
                thetas[len(kept)] = entry.theta
                kept.append(entry)
            else:
                np.logical_or(kept[i].moving, entry.moving, out=kept[i].moving)
        within = [entry for entry in kept if entry.inside]
        if copies:
            more = [
                (theta, entry)
                for entry in within
                for theta in (entry.theta[None] if self.deadline.passed else copies_inside(arm, entry.theta))
            ]
            within = [Entry(theta, entry.moving, True, self.distance(theta)) for theta, entry in more]
            within.sort(key=lambda entry: entry.distance)
        every = [*within, *(entry for entry in kept if not entry.inside)]
        rows = np.array([(entry.theta, entry.moving) for entry in every]).reshape(-1, 2, arm.n)
        late = self.deadline.passed
        return AllSolutions(
            arm, rows, len(within), self.near, self.method,
            all_seen and not late and self.complete, self.target, self.tolerances, tries, late,
        )  # fmt: skip


class Members(NamedTuple):
    """Roots of one family, and the curve (k, n) that connects them."""

    roots: list[Root]
    curve: Array


@dataclass(frozen=True, eq=False)
class Entry:
    """An answer theta (n,), the joints (n,) free to move, and whether it is inside the limits."""

    theta: Array
    moving: NDArray[np.bool_]
    inside: bool
    distance: float
