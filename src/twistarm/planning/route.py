"""Route: the joint paths of a motion's segments, without time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..arm.arm import Arm
from ..ik.targets import KINDS, AnyTarget, Position, target_for
from ..ik.task_space import Tolerances
from ..support.checks import Array
from ..support.errors import NotConvergedError, TwistarmError
from ..support.messages import Argument, Remedies, Text
from .configurations import branches
from .curves import MovingTarget
from .following import Blocked, Node, climb, efforts, follow, way
from .goals import CURVED, Goals
from .keep import Constraint, Keep
from .piecewise import JointPath
from .refusal import PathError, refusal
from .segments import CONSTRAINED, Dwell, FreeMove, JointMove, Move, Segment, place
from .waypoints import UNWRAP, solved, unwrapped

if TYPE_CHECKING:
    from ..collision import Scene

# Waypoints (k, n) of a path that collides with nothing, from a start to a goal (n,) or to one of the others (k, n).
FreePath = Callable[[Array, Array, Callable[[], Array]], Array]
# A path that keeps something too, from a start (n,) to one of some goals (k, n), with a share of the time.
KeepingPath = Callable[[Constraint, Array, Array, float], JointPath]
GOAL_SHARE = 0.6  # Share of the kept angle that a goal may use up: the way to it needs the rest.
MOST_GOALS = 5  # Configurations that meet the target of a free move that keeps something, the nearest twice.
NEAREST = 8  # How many of the nearest start configurations of a run of curves are tried before all others.
FOLLOWED = 4  # How many ways through a ladder, least joint motion first, are tried.
# Radius of a corner on a free way: greatest share of the way to the nearer neighbour, and of the arm's reach.
CORNER_SHARE, LARGEST_CORNER = 0.45, 0.1


@dataclass(frozen=True, eq=False)
class PathPart:
    """A joint path of segment `index`, or all of it. For a dwell, and if the arm does not move, there is no path.

    `blend` is the radius [m] of the ball at its end in which the corner may be rounded. A free move round obstacles
    has several parts; `last` is false for all but the last of them.
    """

    index: int
    segment: Segment
    end: Array
    path: JointPath | None
    blend: float = 0.0
    last: bool = True

    @property
    def move(self) -> Move:
        """The segment, a move if there is a path."""
        assert isinstance(self.segment, Move)
        return self.segment


# The end of a run so far: theta (n,), cost [s], and the last node of the curve before (None at the beginning).
_End = tuple[Array, float, Node | None]


class _BlockedError(Exception):
    """Curve `index` is blocked. `more`: a smaller part of its pose may still be followed."""

    def __init__(self, index: int, blocked: Blocked, more: bool) -> None:
        super().__init__(index)
        self.index, self.blocked, self.more = index, blocked, more

    @property
    def reached(self) -> float:
        """How far the run comes: segments done, plus the share of the blocked one."""
        return self.index + self.blocked.node.s


@dataclass(frozen=True, eq=False)
class Router:
    """Finds the parts of a motion's path. It calls `report(k)` when k segments have theirs.

    A `FreeMove` goes along `free_path`, and to a target to the configuration that `scene` leaves free. One that keeps
    something goes along `keeping_path`. `constraints` then has what is kept, by the index of the segment.
    """

    arm: Arm
    segments: Sequence[Segment]
    goals: Goals
    report: Callable[[int], object]
    scene: Scene | None = None
    free_path: FreePath | None = None
    keeping_path: KeepingPath | None = None
    notes: list[str] = field(default_factory=list)
    constraints: dict[int, Constraint] = field(default_factory=dict)

    def parts(self, origin: Array) -> list[PathPart]:
        """Return the parts from `origin` (n,) on. Raises PathError, LimitError or NotConvergedError if none exist."""
        parts: list[PathPart] = []
        theta, i = origin, 0
        while i < len(self.segments):
            parts += self._next(i, theta)
            theta, i = parts[-1].end, parts[-1].index + 1
            self.report(i)
        still = (part for part in parts if part.path is None and isinstance(part.segment, CURVED))
        self.notes.extend([f"{self._place(part.index)}: it ends where it begins, and the arm stays" for part in still])
        return parts

    def _next(self, i: int, theta: Array) -> list[PathPart]:
        """The parts of segment i. After a joint move to a target, also those of its curves and dwells."""
        segment = self.segments[i]
        after = i + 1
        while after < len(self.segments) and not isinstance(self.segments[after], JointMove):
            after += 1
        if isinstance(segment, Dwell):
            return [self._part(i, theta, None)]
        if isinstance(segment, FreeMove) and segment.keep is not None:
            return [self._keeping(i, segment, segment.keep, theta)]
        if isinstance(segment, FreeMove):
            return self._around(i, segment, theta)
        if not isinstance(segment, JointMove):
            return self._run(range(i, after), theta[None], theta)[1]
        end = self._unwrapped_goal(i, segment, theta)  # says why, where nothing meets the target
        if isinstance(segment.to, KINDS):
            starts = self._meeting(segment.to, theta, self.goals.tolerances(segment))
            if len(starts):
                start, parts = self._run(range(i + 1, after), starts, theta)
                return [self._straight(i, theta, start), *parts]
        return [self._straight(i, theta, end)]

    def _unwrapped_goal(self, i: int, segment: JointMove, theta: Array) -> Array:
        end = self.goals.configuration(segment, theta, self._place(i))
        end, notes = unwrapped(self.arm, end, theta, self._place(i), self.goals.unwrap)
        self.notes.extend(note for note in notes if note not in self.notes)  # a goal may be asked for again
        return end

    def _around(self, i: int, segment: FreeMove, theta: Array) -> list[PathPart]:
        """The straight parts of a free move, with corners that may be rounded."""
        assert self.free_path is not None
        if isinstance(segment.to, KINDS):
            tolerances = self.goals.tolerances(segment)
            goal = solved(self.arm, segment.to, theta, self._place(i), scene=self.scene, **tolerances.keywords)
            others = partial(self._meeting, segment.to, theta, tolerances)
        else:
            goal = self._unwrapped_goal(i, segment, theta)
            others = partial(np.empty, (0, self.arm.n))
        try:
            corners = self.free_path(theta, goal, others)
        except PathError as error:
            nearer = unwrapped(self.arm, goal, theta, "", asked=True)[0]
            hint = Remedies((Text("; {unwrap} takes a nearer turn of the goal", unwrap=UNWRAP),))
            what = error.message if (nearer == goal).all() else Text("{why}{hint}", why=error.message, hint=hint)
            at = theta if error.theta is None else error.theta
            raise PathError(what, theta=at, reason="collision", segment=i, place=self._place(i)) from error
        steps = np.linalg.norm(np.diff(self.arm.fk(corners)[:, :3, 3], axis=0), axis=1)
        radii = np.minimum(CORNER_SHARE * np.minimum(steps[:-1], steps[1:]), LARGEST_CORNER * self.arm.reach)
        parts = [self._straight(i, *ends) for ends in pairwise(corners)]
        inner = [replace(part, blend=r, last=False) for part, r in zip(parts, radii.tolist(), strict=False)]
        return [*inner, parts[-1]]

    def _keeping(self, i: int, segment: FreeMove, keep: Keep, theta: Array) -> PathPart:
        """The part of a free move that keeps something. An arm of fewer than six joints keeps what it can of it."""
        whole = keep.at(self.arm, self.arm.fk(theta))
        wanted, errors = [whole, *(whole.weaker(self.arm) if self.arm.n < 6 else ())], list[TwistarmError]()
        for candidate in wanted:
            constraint = Constraint(self.arm, candidate)
            try:
                path = self._kept_path(i, segment, constraint, theta, 1.0 / len(wanted))
            except (PathError, NotConvergedError) as error:  # the whole may have no configuration at the goal
                errors.append(error)
                continue
            if errors:
                template, what = "{place}: an arm of {n} joints cannot keep {what}; it keeps {less}", whole.describe()
                self.notes.append(
                    Text(template, place=self._place(i), n=self.arm.n, what=what, less=candidate.describe())
                )
            self.constraints[i] = constraint
            return self._part(i, theta if path is None else path.end, path)
        raise errors[0]

    def _kept_path(
        self, i: int, segment: FreeMove, constraint: Constraint, theta: Array, share: float
    ) -> JointPath | None:
        """The path from theta (n,) to the goal, with a share of the time; None if it stays. PathError without one."""
        assert self.keeping_path is not None
        self._require_kept(i, segment, constraint, theta, "start")
        goals = self._kept_goals(i, segment, constraint, theta)
        self._require_kept(i, segment, constraint, goals[0], "goal")
        if (goals[0] == theta).all():
            return None
        try:
            return self.keeping_path(constraint, theta, goals, share)
        except PathError as error:
            at = theta if error.theta is None else error.theta
            raise PathError(error.message, theta=at, reason="collision", segment=i, place=self._place(i)) from error

    def _require_kept(self, i: int, segment: FreeMove, constraint: Constraint, theta: Array, name: str) -> None:
        """Raise PathError where the start or goal of a move, theta (n,), does not keep all."""
        if not (fault := constraint.fault(theta)):
            return
        larger = Text("a larger {tol}", tol=Argument("tol"))
        box = () if constraint.keep.box is None else ("a larger box",)
        remedies = Remedies((f"another {name}", larger, *box))
        turned = name == "goal" and isinstance(segment.to, KINDS) and not isinstance(segment.to, Position)
        own = ", because the target itself turns the tool" if turned else ""
        template = "at its {name} {fault}{own}: give {remedies}"
        what = Text(template, name=name, fault=fault, own=own, remedies=remedies)
        raise PathError(what, theta=theta, reason="not kept", segment=i, place=self._place(i))

    def _kept_goals(self, i: int, segment: FreeMove, constraint: Constraint, theta: Array) -> Array:
        """Configurations (k, n) at the end of a move that keeps something, nearest first.

        At least one, even if none keeps it.
        """
        if not isinstance(segment.to, KINDS):
            return self._unwrapped_goal(i, segment, theta)[None]
        tolerances, target = self.goals.tolerances(segment), constraint.keep.constrain(segment.to)
        solve = partial(solved, self.arm, target, theta, self._place(i), scene=self.scene)
        try:
            nearest = solve(**tolerances.keywords)
        except NotConvergedError:
            if target is segment.to:
                raise
            # The rotation comes from what is kept, within its tol.
            tolerances = replace(tolerances, orientation=GOAL_SHARE * constraint.keep.tol)
            nearest = solve(**tolerances.keywords)
        found = [nearest, *self._meeting(target, theta, tolerances)]
        good = [end for end in found if not constraint.fault(end)][:MOST_GOALS]
        return np.array(good or [nearest])

    def _meeting(self, target: AnyTarget, theta: Array, tolerances: Tolerances) -> Array:
        """Configurations (k, n) that meet a target, nearest to theta (n,) first. In a scene those that are free."""
        found = branches(self.arm, target_for(self.arm, target), theta, tolerances)
        return found if self.scene is None else found[~self.scene.collides(found)]

    def _straight(self, i: int, start: Array, end: Array) -> PathPart:
        return self._part(i, end, JointPath.straight(start, end) if np.abs(end - start).any() else None)

    def _run(self, run: range, starts: Array, theta: Array) -> tuple[Array, list[PathPart]]:
        """The first of `starts` (b, n), nearest first, of a run of curves and dwells, and its parts.

        A curve may follow several parts of a pose. Each is tried when the one before fails.
        """
        options = dict.fromkeys(run, 0)
        errors: list[_BlockedError] = []
        while True:
            try:
                near, far = (partial(self._laddered, run, some, theta, options) for some in np.split(starts, [NEAREST]))
                found = _first_followed([near] if len(starts) <= NEAREST else [near, far])
                less = {k: Argument("constrain", CONSTRAINED[option]) for k, option in options.items() if option}
                what = "{place}: the arm cannot follow whole poses there; it keeps {part}"
                self.notes.extend(Text(what, place=self._place(k), part=part) for k, part in less.items())
                return found
            except _BlockedError as error:
                errors.append(error)
                if error.more:
                    options[error.index] += 1
                    continue
            farthest = max(errors, key=lambda error: error.reached)
            tried = len(starts) > 1 and farthest.index == run[0]
            where = farthest.index, self._place(farthest.index)
            raise refusal(self.arm, self.goals.limits, farthest.blocked, *where, others=not tried)

    def _laddered(
        self, run: range, starts: Array, theta: Array, options: dict[int, int]
    ) -> tuple[Array, list[PathPart]]:
        """Do the same for the chosen options by stacked ladders, with the least joint motion."""
        moved = efforts(theta, starts, self.goals.limits.velocity)
        ends: list[_End] = [(start, float(effort), None) for start, effort in zip(starts, moved, strict=True)]
        more: dict[int, bool] = {}
        for k in run:
            if isinstance(self.segments[k], Dwell):
                continue
            roots, has_more = self._roots(k, ends, options[k])
            if not roots:
                continue
            more[k] = has_more
            nodes = climb(self.arm, self.goals.limits, roots)
            if isinstance(nodes, Blocked):
                raise _BlockedError(k, nodes, more[k])
            ends = [(node.theta, node.cost, node) for node in nodes]
        return _first_followed([partial(self._followed, run, end, node, more) for end, _, node in ends[:FOLLOWED]])

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
            same = next((other for other in known if other.same(moving)), None)
            known += [moving] if same is None else []
            roots.append(Node(moving if same is None else same, 0.0, theta, cost, parent))
        return roots, bool(roots) and option + 1 < len(movings)

    def _followed(
        self, run: range, end: Array, last: Node | None, more: dict[int, bool]
    ) -> tuple[Array, list[PathPart]]:
        """Start and parts of a run that ends at theta (n,) and node `last`. A curve not in `more` does not move."""
        curves = [list(nodes) for _, nodes in groupby(way(last), key=lambda node: id(node.moving))]
        start = theta = curves[0][0].theta if curves else end
        parts: list[PathPart] = []
        for k in run:
            path = follow(self.arm, curves.pop(0)) if k in more else None
            if isinstance(path, Blocked):
                raise _BlockedError(k, path, more[k])
            theta = theta if path is None else path.end
            parts.append(self._part(k, theta, path))
        return start, parts

    def _part(self, i: int, end: Array, path: JointPath | None) -> PathPart:
        segment, following = self.segments[i], self.segments[i + 1 : i + 2]
        # A free way begins at the very end of the move before, so nothing is rounded there.
        sharp = isinstance(segment, FreeMove) < any(isinstance(move, FreeMove) for move in following)
        return PathPart(i, segment, end, path, 0.0 if sharp or not isinstance(segment, Move) else segment.blend)

    def _place(self, i: int) -> str:
        return place(i, self.segments[i])


def _first_followed(attempts: Sequence[Callable[[], tuple[Array, list[PathPart]]]]) -> tuple[Array, list[PathPart]]:
    """The first attempt that is not blocked. Otherwise raise the error of the one that came farthest."""
    errors = []
    for attempt in attempts:
        try:
            return attempt()
        except _BlockedError as error:  # noqa: PERF203
            errors.append(error)
    raise max(errors, key=lambda error: error.reached)
