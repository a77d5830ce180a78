"""Route: the joint paths of a motion's segments, without time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from ..arm.arm import Arm
from ..ik.targets import KINDS, target_for
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from .cartesian.branches import branches
from .cartesian.following import follow
from .cartesian.ladder import climb
from .cartesian.moving_target import MovingTarget
from .cartesian.nodes import Blocked, Node, efforts, way
from .cartesian.refusal import refusal
from .cartesian.wide_ladder import climb_wide
from .goals import CURVED, Goals
from .joint_path import JointPath
from .segments import Dwell, JointMove, Move, Segment, place
from .unwrapping import unwrapped

NEAREST = 8
"""How many of the nearest start configurations of a run of curves are tried before all others."""

FOLLOWED = 4
"""How many ways through a ladder, least joint motion first, are tried."""


@dataclass(frozen=True, eq=False)
class Leg:
    """The joint path of segment `index`. The path is None for a dwell, and if the arm does not move."""

    index: int
    segment: Segment
    end: Array
    path: JointPath | None

    @property
    def move(self) -> Move:
        """The segment, a move if there is a path."""
        assert isinstance(self.segment, Move)
        return self.segment


_End = tuple[Array, float, Node | None]
"""The end of a run so far: theta (n,), cost [s], and the last node of the curve before (None at the beginning)."""


class _BlockedError(Exception):
    """Curve `index` is blocked. `more`: a smaller part of its pose may still be followed."""

    def __init__(self, index: int, blocked: Blocked, more: bool) -> None:
        super().__init__(index)
        self.index, self.blocked, self.more = index, blocked, more

    @property
    def reached(self) -> float:
        """How far the run comes: segments done, plus the share of the blocked one."""
        return self.index + self.blocked.node.s


class Router:
    """Finds the legs of a motion. It calls `done(k)` when k segments have theirs.

    `numbers` are the indices of the segments in the caller's motion, where several may belong to one of the caller's.
    """

    def __init__(
        self,
        arm: Arm,
        segments: Sequence[Segment],
        limits: JointLimits,
        done: Callable[[int], object],
        unwrap: bool = False,
        numbers: Sequence[int] | None = None,
        exactly: bool = True,
    ) -> None:
        self.arm, self.segments, self.limits, self.done = arm, segments, limits, done
        self.numbers = range(len(segments)) if numbers is None else numbers
        self.notes: list[str] = []
        self.goals = Goals(arm, limits, unwrap, exactly)

    def legs(self, origin: Array) -> list[Leg]:
        """Return the legs from `origin` (n,) on. Raises PathError, LimitError or NotConvergedError if none exist."""
        legs: list[Leg] = []
        theta = origin
        while len(legs) < len(self.segments):
            legs += self._next(len(legs), theta)
            theta = legs[-1].end
            self.done(len(legs))
        still = (i for i, leg in enumerate(legs) if leg.path is None and isinstance(leg.segment, CURVED))
        self.notes += [f"{self._place(i)}: it ends where it begins, and the arm stays" for i in still]
        return legs

    def _next(self, i: int, theta: Array) -> list[Leg]:
        """The leg of segment i. After a joint move to a target, also those of its curves and dwells."""
        segment = self.segments[i]
        after = i + 1
        while after < len(self.segments) and not isinstance(self.segments[after], JointMove):
            after += 1
        if isinstance(segment, Dwell):
            return [self._leg(i, theta, None)]
        if not isinstance(segment, JointMove):
            return self._run(range(i, after), theta[None], theta)[1]
        if isinstance(segment.to, KINDS) and after > i + 1:
            starts = branches(self.arm, target_for(self.arm, segment.to), theta, self.goals.tolerances(segment))
            if len(starts):
                start, legs = self._run(range(i + 1, after), starts, theta)
                return [self._straight(i, theta, start), *legs]
        end = self.goals.configuration(segment, theta, self._place(i))
        end, said = unwrapped(self.arm, end, theta, self._place(i), self.goals.unwrap)
        self.notes += said
        return [self._straight(i, theta, end)]

    def _straight(self, i: int, start: Array, end: Array) -> Leg:
        if not np.abs(end - start).any():
            return self._leg(i, end, None)
        path = JointPath(np.array([0.0, 1.0]), np.stack([end - start, start])[:, None])
        return self._leg(i, end, path)

    def _run(self, run: range, starts: Array, theta: Array) -> tuple[Array, list[Leg]]:
        """The first of `starts` (b, n), nearest first, of a run of curves and dwells, and its legs.

        A curve may follow several parts of a pose. Each is tried when the one before fails.
        """
        options = dict.fromkeys(run, 0)
        errors: list[_BlockedError] = []
        while True:
            try:
                return self._by_start(run, starts, theta, options)
            except _BlockedError as error:
                errors.append(error)
                if error.more:
                    options[error.index] += 1
                    continue
            farthest = max(errors, key=lambda error: error.reached)
            tried = len(starts) > 1 and farthest.index == run[0]
            where = self.numbers[farthest.index], self._place(farthest.index)
            raise refusal(self.arm, self.limits, farthest.blocked, *where, others=not tried)

    def _by_start(self, run: range, starts: Array, theta: Array, options: dict[int, int]) -> tuple[Array, list[Leg]]:
        """Do the same for the chosen options: nearest starts, then all others, then a wide ladder."""
        farthest: _BlockedError | None = None
        for group, wide in ((starts[:NEAREST], False), (starts[NEAREST:], False), (starts, True)):
            if not len(group) or (wide and farthest and not farthest.blocked.node.moving.freedom(self.arm.n)):
                continue
            try:
                return self._laddered(run, group, theta, options, wide)
            except _BlockedError as error:
                if farthest is None or error.reached > farthest.reached:
                    farthest = error
        assert farthest is not None
        raise farthest

    def _laddered(
        self, run: range, starts: Array, theta: Array, options: dict[int, int], wide: bool
    ) -> tuple[Array, list[Leg]]:
        """Do the same by stacked ladders, with the least joint motion."""
        moved = efforts(theta, starts, self.limits.velocity)
        ends: list[_End] = [(start, float(effort), None) for start, effort in zip(starts, moved, strict=True)]
        more: dict[int, bool] = {}
        for k in run:
            if isinstance(self.segments[k], Dwell):
                continue
            roots, has_more = self._roots(k, ends, options[k])
            if not roots:
                continue
            more[k] = has_more
            nodes = (climb_wide if wide else climb)(self.arm, self.limits, roots)
            if isinstance(nodes, Blocked):
                raise _BlockedError(k, nodes, more[k])
            ends = [(node.theta, node.cost, node) for node in nodes]
        errors = []
        for end, _, node in ends[:FOLLOWED]:
            found = self._followed(run, end, node, wide, more)
            if not isinstance(found, _BlockedError):
                return found
            errors.append(found)
        raise max(errors, key=lambda error: error.reached)

    def _roots(self, k: int, ends: list[_End], option: int) -> tuple[list[Node], bool]:
        """The first nodes of curve k at the `ends` before it, and whether more options follow."""
        segment = self.segments[k]
        assert isinstance(segment, CURVED)
        known: list[MovingTarget] = []
        roots: list[Node] = []
        for theta, cost, parent in ends:
            movings = self.goals.moving(segment, theta, self._place(k))
            if not movings:
                continue
            moving = movings[min(option, len(movings) - 1)]
            same = next((each for each in known if each.same(moving)), None)
            known += [moving] if same is None else []
            roots.append(Node(moving if same is None else same, 0.0, theta, cost, parent))
        return roots, bool(roots) and option + 1 < len(movings)

    def _followed(
        self, run: range, end: Array, last: Node | None, even: bool, more: dict[int, bool]
    ) -> tuple[Array, list[Leg]] | _BlockedError:
        """Start and legs of a run that ends at theta (n,) and node `last`, or its error.

        A curve that is not in `more` does not move.
        """
        curves = [list(nodes) for _, nodes in groupby(way(last), key=lambda node: id(node.moving))]
        start = theta = curves[0][0].theta if curves else end
        legs: list[Leg] = []
        for k in run:
            if k not in more:
                legs.append(self._leg(k, theta, None))
                continue
            result = follow(self.arm, curves.pop(0), even=even)
            if isinstance(result, Blocked):
                return _BlockedError(k, result, more[k])
            theta = result.end
            legs.append(self._leg(k, theta, result))
        return start, legs

    def _leg(self, i: int, end: Array, path: JointPath | None) -> Leg:
        return Leg(self.numbers[i], self.segments[i], end, path)

    def _place(self, i: int) -> str:
        return place(self.numbers[i], self.segments[i])
