"""Free paths that keep a part of the tool's pose: two trees of projected states, then a spline.

Source: Berenson, Srinivasa, Ferguson & Kuffner, Manipulation Planning on Constraint Manifolds (CBiRRT), ICRA 2009.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from itertools import count

import numpy as np

from ..collision import Scene
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.messages import Text
from .following import outside_limits
from .free_moves import UNLIMITED, no_path, require_clear, roomy
from .keep import Constraint, Flags
from .piecewise import JointPath
from .segments import CLEARANCE
from .spline import interpolating

# For one attempt after the other: the distance [rad, m] of states, the share of the tolerances that they use, and that
# of the clearance.
ATTEMPTS = ((0.1, 0.7, 1.0), (0.05, 0.6, 1.0), (0.025, 0.5, 0.5), (0.0125, 0.5, 0.2), (0.0125, 0.5, 0.05))
REACH = 1.5  # The longest way [rad, m] that a tree grows at once.
GAP = 2.0  # Projected states may be so many times farther from each other than the states were before.
NEW = 0.3  # A state nearer to a known one than this share of the distance of states is none.
STALLED = 300  # After so many samples in a row without a new state, the trees have filled what they can reach.
MOST_STATES = 20_000
AT_ONCE = 32  # Samples that are projected together.
SHORTCUTS = 40  # Random shortcuts that are tried on a path.
SMOOTHINGS = 8  # How often each state moves towards its neighbours.
ROUNDS = 7  # How often pieces of the spline that do not keep all are halved.
ROUNDING = 1e-9  # Beyond a limit by less [rad, m] is rounding.


def keeping_path(
    scene: Scene, constraint: Constraint, start: Array, goals: Array, part: float = 1.0, *, limits: JointLimits,
    max_time: float, clearance: float = CLEARANCE, seed: int = 0,
) -> JointPath:  # fmt: skip
    """A free path that keeps all, from `start` (n,) to one of `goals` (k, n), best first.

    Both ends keep all and are free. The straight way is chosen if it keeps all and is free. The same with its states
    projected comes next. Otherwise a tree grows from the start and one from all goals, with projected steps (Kuffner &
    LaValle, RRT-Connect, ICRA 2000). Shortcuts and averages of neighbours make the path short and smooth. A C² cubic
    spline leads through its states. Its pieces are halved until all of it is proven to keep. If that fails, or the path
    collides, the search begins anew with smaller steps and distances.

    Raises:
        PathError: Start or goal collides, or no path is found in this part of `max_time` [s].
    """
    require_clear(scene, start, goals[0])
    ends, began = time.monotonic() + part * max_time, time.process_time()
    for goal in goals:
        straight = JointPath.straight(start, goal)
        if not constraint.unproven(straight.coefficients, np.ones(1)).any() and scene.is_free(start, goal):
            return straight
    filled = False
    for k in count():
        step, share, room = ATTEMPTS[min(k, len(ATTEMPTS) - 1)]
        is_free = roomy(scene, room * clearance, np.array([start, *goals]))
        search = Search(is_free, constraint, limits, step, share, ends, np.random.default_rng(seed + k))
        states = search.found(start, goals)
        if states is not None:
            path = search.spline(search.smoothed(states))
            if path is not None and scene.first_collision(path) is None:
                return path
        filled = states is None and not search.late
        if search.late or (filled and k + 1 >= len(ATTEMPTS)):
            break
    what = Text("path that keeps {what}", what=constraint.keep.describe())
    more = ", the search came to its end" if filled else ""
    raise no_path(what, max_time, time.process_time() - began, more, {"tol": "larger", "max_time": "longer"})


class Tree:
    """States (count, n) and the state before each; -1 for a root."""

    def __init__(self, roots: Array) -> None:
        self.states, self.before, self.count = np.array(roots), [-1] * len(roots), len(roots)

    def nearest(self, theta: Array) -> int:
        """The state nearest to theta (n,)."""
        away = self.states[: self.count] - theta
        return int(np.einsum("ij,ij->i", away, away).argmin())

    def add(self, states: Array, after: int) -> int:
        """Add states in a row after one. Return the last."""
        while self.count + len(states) > len(self.states):
            self.states = np.concatenate([self.states, np.empty_like(self.states)])
        for state in states:
            self.states[self.count] = state
            self.before.append(after)
            after, self.count = self.count, self.count + 1
        return after

    def way(self, i: int) -> Array:
        """The states from state i to its root."""
        way = []
        while i >= 0:
            way.append(self.states[i])
            i = self.before[i]
        return np.array(way)


class Search:
    """One search with states `step` [rad, m] from each other, within `share` of the tolerances."""

    def __init__(
        self, is_free: Callable[[Array], bool], constraint: Constraint, limits: JointLimits, step: float, share: float,
        ends: float, rng: np.random.Generator,
    ) -> None:  # fmt: skip
        self.is_free, self.constraint, self.limits, self.step, self.share = is_free, constraint, limits, step, share
        self.ends, self.rng = ends, rng

    @property
    def late(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() > self.ends

    def found(self, start: Array, goals: Array) -> Array | None:
        """States (k, n) from the start to a goal. None when the time is over or the trees are full."""
        for goal in goals:
            straight = self.between(start, goal)
            if straight is not None:
                return straight
        samples = self._samples(np.array([start, *goals]))
        growing, joining, stalled = Tree(start[None]), Tree(goals), 0
        while stalled < STALLED and growing.count + joining.count < MOST_STATES and not self.late:
            sample = next(samples)
            i = self._grown(growing, sample)
            stalled = stalled + 1 if i is None else 0
            if i is not None and (j := self._joined(joining, growing.states[i])) is not None:
                whole = np.concatenate([growing.way(i)[::-1], joining.way(j)[1:]])
                return whole if (whole[0] == start).all() else whole[::-1]
            growing, joining = joining, growing
        return None

    def _samples(self, ends: Array) -> Iterator[Array]:
        """Random states, projected where that succeeds, at most half a turn or so beyond the ends (k, n)."""
        lower = np.maximum(ends.min(axis=0) - UNLIMITED, self.limits.lower)
        upper = np.minimum(ends.max(axis=0) + UNLIMITED, self.limits.upper)
        while True:
            random = self.rng.uniform(lower, upper, (AT_ONCE, len(lower)))
            yield from self.constraint.projected(random, self.share, lower, upper)[0]

    def _projected(self, states: Array) -> tuple[Array, Flags]:
        return self.constraint.projected(states, self.share, self.limits.lower, self.limits.upper)

    def _grown(self, tree: Tree, target: Array) -> int | None:
        """Grow a tree from its nearest state towards a target, by one reach at most. Return the new state."""
        i = tree.nearest(target)
        states, _ = self._towards(tree.states[i], target)
        if not len(states):
            return None
        away = _lengths(tree.states[: tree.count] - states[-1])
        return None if away.min() < NEW * self.step else tree.add(states, i)

    def _joined(self, tree: Tree, target: Array) -> int | None:
        """Grow a tree from its nearest state to the target, as far as it goes. Return the last state if that is it."""
        i = tree.nearest(target)
        while not self.late:
            states, arrived = self._towards(tree.states[i], target)
            if len(states):
                i = tree.add(states, i)
            if arrived or not len(states):
                return i if arrived else None
        return None

    def _towards(self, state: Array, target: Array) -> tuple[Array, bool]:
        """The states of a way from a state towards a target, by one reach at most, and whether they arrive.

        A way that does not arrive begins along the tangent of what is kept. So its projections stay small.
        """
        way = target - state
        length = float(np.linalg.norm(way))
        if length <= REACH:
            straight = self.between(state, target)
            if straight is not None:
                return straight[1:], True
        way = self.constraint.tangent(state + way * (self.step / length), way, self.share)
        far = float(np.linalg.norm(way))
        steps = int(min(far, REACH) / self.step)
        if not steps:
            return np.empty((0, len(state))), False
        shares = np.arange(1, steps + 1)[:, None] * (self.step / far)
        found, converged = self._projected(state + shares * way)
        gaps = _lengths(found - np.vstack([state, found[:-1]]))
        left = np.append(length, _lengths(target - found))
        good = np.append(converged & (gaps <= GAP * self.step) & (left[1:] < left[:-1]), False)
        some = int(np.argmin(good))
        return found[: next((k for k in range(some) if not self.is_free(found[k])), some)], False

    def between(self, start: Array, end: Array) -> Array | None:
        """States (k, n) from one state to another: those of the straight way, projected; None if that fails."""
        steps = int(np.ceil(np.linalg.norm(end - start) / self.step))
        if steps < 2:
            return np.array([start, end])
        inner = start + np.linspace(0.0, 1.0, steps + 1)[1:-1, None] * (end - start)
        states, converged = self._projected(inner)
        states = np.vstack([start, states, end])
        gaps = _lengths(np.diff(states, axis=0))
        if not converged.all() or (gaps > GAP * self.step).any() or not all(map(self.is_free, states[1:-1])):
            return None
        return states

    def smoothed(self, states: Array) -> Array:
        """The states (k, n) with random shortcuts, each then moved towards its neighbours where that is free."""
        for _ in range(SHORTCUTS):
            if len(states) < 4 or self.late:
                break
            i, j = sorted(self.rng.choice(len(states), 2, replace=False).tolist())
            if j - i < 2:
                continue
            shorter = self.between(states[i], states[j])
            before = _lengths(np.diff(states[i : j + 1], axis=0)).sum()
            if shorter is not None and _lengths(np.diff(shorter, axis=0)).sum() < before - ROUNDING:
                states = np.concatenate([states[:i], shorter, states[j + 1 :]])
        for _ in range(SMOOTHINGS):
            if len(states) < 3 or self.late:
                break
            mean = 0.5 * states[1:-1] + 0.25 * (states[:-2] + states[2:])
            inner, converged = self._projected(mean)
            good = converged & np.array([self.is_free(state) for state in inner])
            states = np.vstack([states[0], np.where(good[:, None], inner, states[1:-1]), states[-1]])
        return states

    def spline(self, states: Array) -> JointPath | None:
        """A C² cubic spline through states (k, n) that keeps all inside the limits, or None."""
        for _ in range(ROUNDS):
            steps = _lengths(np.diff(states, axis=0))
            states = states[np.append(True, steps > ROUNDING)]
            while len(states) < 4:
                states = self._halved(states, np.ones(len(states) - 1, dtype=bool))
            s = np.append(0.0, np.cumsum(_lengths(np.diff(states, axis=0))))
            path = JointPath(*interpolating(states, s, s[2:-2], ())).cut_at(s)
            bad = self.constraint.unproven(path.coefficients, np.diff(s)) | outside_limits(self.constraint.arm, path)
            if not bad.any():
                return path
            if self.late:
                break
            states = self._halved(states, bad)
        return None

    def _halved(self, states: Array, bad: Flags) -> Array:
        """The states with one more in the middle of each marked interval."""
        at = np.flatnonzero(bad)
        middle = 0.5 * (states[at] + states[at + 1])
        found, _ = self._projected(middle)
        return np.insert(states, at + 1, found, axis=0)


def _lengths(ways: Array) -> Array:
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", ways, ways)))
