"""`solve_ik_all_batch`: every configuration of many targets, arrays in and out."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..arm.engine import answered
from ..support.checks import Array, RealArray, as_flag, as_given, as_whole
from .all_solutions import AllSolutions
from .answer import ConfigurationsBatch
from .batch import MAX_THREADS, targets_for
from .closed_form.methods import Method, method_for
from .reached import reachable
from .request import checked, in_radians
from .solve_all import DEFAULT_SAMPLES, ROOT_TOL, checked_fixed_joints, solve_ik_all
from .targets import AnyTarget, Approach, Pose, TargetLike
from .task_space import ORIENTATION_TOL, POSITION_TOL, Tolerances


@dataclass(frozen=True, eq=False, repr=False)
class AllSolutionsBatch:
    """Every configuration of N targets, read-only arrays with a row for each. `batch[i]` is one as an `AllSolutions`.

    count (N,): configurations inside the limits; outside_count (N,): beyond them.
    """

    arm: Arm
    count: NDArray[np.int64]
    outside_count: NDArray[np.int64]
    targets: Array | tuple[AnyTarget, ...] = field(repr=False)
    """What was asked: poses (N, 4, 4), or targets of any kinds."""
    theta0: Array = field(repr=False)
    """(n,) or (N, n) [rad, m]."""
    rows: Array = field(repr=False)
    """(r, 2, n): theta, and 1 for joints that may move while the target stays reached, else 0.

    The rows of one target follow those of another; those inside the limits come first.
    """
    known: tuple[tuple[Method, bool], ...] = field(repr=False)
    """How, and whether these are all there are: of all targets, or for each."""
    tolerances: Tolerances
    """What was to count as reached."""
    answers: tuple[AllSolutions, ...] = field(default=(), repr=False)
    """The answers where they were found one by one."""

    def __post_init__(self) -> None:
        poses = [self.targets] if isinstance(self.targets, np.ndarray) else []
        for array in (self.count, self.outside_count, self.theta0, self.rows, *poses):
            array.flags.writeable = False

    @property
    def complete(self) -> NDArray[np.bool_]:
        """(N,): whether each target's configurations are all there are."""
        return np.resize([complete for _, complete in self.known], len(self))

    @cached_property
    def theta(self) -> Array:
        """(N, most, n) [rad, m], nearest to theta0 first, then NaN."""
        return self._padded(self.rows[:, 0], np.nan)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """(N, most, n): which joints may go on moving while the target stays reached."""
        return self._padded(self.rows[:, 1] > 0.5, False)

    def _padded(self, rows: NDArray[Any], nothing: float) -> NDArray[Any]:
        """(N, most, n) from rows (r, n)."""
        place = np.arange(self.count.max(initial=0))
        within = place < self.count[:, None]
        padded = np.full((len(self), len(place), self.arm.n), nothing, dtype=rows.dtype)
        padded[within] = rows[(self._first[:, None] + place)[within]]
        padded.flags.writeable = False
        return padded

    @cached_property
    def _first(self) -> NDArray[np.int64]:
        """(N,): where each target's rows begin."""
        both = self.count + self.outside_count
        return np.cumsum(both) - both

    def __repr__(self) -> str:
        return f"AllSolutionsBatch({self.arm.name}, {len(self)} targets, {int((self.count > 0).sum())} reached)"

    def __len__(self) -> int:
        return len(self.count)

    def __iter__(self) -> Iterator[AllSolutions]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> AllSolutions:
        i = range(len(self))[operator.index(index)]
        if self.answers:
            return self.answers[i]
        first, count = self._first[i], int(self.count[i])
        own = slice(first, first + count + self.outside_count[i])
        start = self.theta0 if self.theta0.ndim == 1 else self.theta0[i]
        target = Pose(self.targets[i]) if isinstance(self.targets, np.ndarray) else self.targets[i]
        method, complete = self.known[i % len(self.known)]
        return AllSolutions(self.arm, self.rows[own], count, start, method, complete, target, self.tolerances)


def solve_ik_all_batch(
    arm: Arm,
    targets: RealArray | Sequence[TargetLike],
    theta0: ArrayLike | None = None,
    *,
    fixed_joints: Mapping[str, float] | None = None,
    redundancy_samples: int = DEFAULT_SAMPLES,
    include_turns: bool = False,
    position_tol: float = POSITION_TOL,
    orientation_tol: float = ORIENTATION_TOL,
    threads: int = 1,
) -> AllSolutionsBatch:
    """Every configuration of N targets: `solve_ik_all` of each, at the core's speed for families.

    The core needs targets of one kind (and one tool axis), without sampled joints or `include_turns`. Then `threads`
    share the work. The answer to a target depends on that target alone. Ctrl-C ends it.

    Args:
        arm: The arm.
        targets: Poses (N, 4, 4), or a sequence of `Pose`, `Position`, `Approach`, `TolerancedPose` and poses (4, 4).
        theta0: Origin of distances (n,) or (N, n) [rad, m], by default `arm.ready`.
        fixed_joints: {joint: value} [rad, m] of joints to hold there.
        redundancy_samples: Number of values of each other joint that is held, in (0, 1000].
        include_turns: Whether configurations that differ by whole turns count as different, inside the limits.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        threads: Number of threads.

    Returns:
        The `AllSolutionsBatch`: theta (N, most, n) with NaN after each target's last, count (N,). batch[i] is an
        `AllSolutions`.

    Raises:
        InputError: A target (the message says which), theta0, a fixed joint's value or a number is unusable.
        UnknownNameError: `fixed_joints` names no joint of the arm.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    require_arm(arm).require_core("solve_ik_all_batch")
    as_flag(include_turns, "include_turns")
    count = as_whole(redundancy_samples, "redundancy_samples", 1, 1000)

    solve_single = partial(
        solve_ik_all, arm, fixed_joints=fixed_joints, redundancy_samples=count, include_turns=include_turns,
        position_tol=position_tol, orientation_tol=orientation_tol,
    )  # fmt: skip
    if isinstance(targets, np.ndarray) and fixed_joints is None and not include_turns:
        # Poses that are plainly right go straight to the core, which looks at each of them much faster.
        method = method_for(arm, Pose(np.eye(4)))
        plain = (
            method.core is not None
            and not method.sampled
            and type(position_tol) is float
            and in_radians(orientation_tol)
        )
        start = arm.ready if theta0 is None else theta0
        tolerances = Tolerances(position_tol, orientation_tol)
        found = _by_core(arm, method, targets, start, tolerances, threads, solve_single) if plain else None
        if found is not None:
            return found
    goals = targets_for(arm, targets)
    request = checked(arm, theta0, None, position_tol, orientation_tol, 1, 0, None, count=len(goals))
    workers = as_whole(threads, "threads", 1, MAX_THREADS)
    fixed = checked_fixed_joints(arm, fixed_joints)
    near = np.array(request.theta0)
    near[..., list(fixed)] = list(fixed.values())
    kinds = {(type(target), target.axis.tobytes() if isinstance(target, Approach) else b"") for target in goals}
    method = method_for(arm, goals[0] if goals else Pose(np.eye(4)), tuple(fixed))
    if len(kinds) <= 1 and not include_turns and method.core is not None and not method.sampled:
        return answered(_by_core(arm, method, goals, near, request.tolerances, workers, solve_single))
    starts = np.broadcast_to(near, (len(goals), arm.n))
    return _gathered(arm, goals, near, request.tolerances, list(map(solve_single, goals, starts)))


def _by_core(
    arm: Arm,
    method: Method,
    targets: RealArray | tuple[AnyTarget, ...],
    near: ArrayLike,
    tolerances: Tolerances,
    threads: int,
    solve_single: Callable[[TargetLike, Array], AllSolutions],
) -> AllSolutionsBatch | None:
    """The core's answer. None as in `arm.engine`.

    `solve_single` solves a target if the core cannot separate families, or if only the tolerances reach it.
    """
    assert method.core is not None
    numbers = targets
    if isinstance(targets, tuple):
        numbers = np.array([target.numbers for target in targets]) if targets else np.zeros((0, 4, 4))
    exact = tolerances.at_most(ROOT_TOL)
    how = exact.position, exact.orientation, threads
    answer = method.core.solve_batch(as_given(numbers), as_given(near), *how)
    if answer is None:
        return None
    found = ConfigurationsBatch(*answer)
    kept = targets if isinstance(targets, tuple) else np.array(targets, dtype=np.float64)
    start = np.array(near, dtype=np.float64)
    known = ((method, method.exact),)
    left = found.families > 0
    missed = np.flatnonzero((found.inside == 0) & ~left)
    if len(missed) and exact != tolerances:
        beyond_exact = kept[missed] if isinstance(kept, np.ndarray) else [kept[i] for i in missed]
        left[missed] = reachable(arm, beyond_exact, **tolerances.keywords, threads=threads).converged
    beyond = found.counts - found.inside
    batch = AllSolutionsBatch(arm, found.inside, beyond, kept, start, found.rows, known, tolerances)
    if not left.any():
        return batch
    answers = [
        solve_single(answer.target, answer.theta0) if more else answer for answer, more in zip(batch, left, strict=True)
    ]
    return _gathered(arm, kept, start, tolerances, answers)


def _gathered(
    arm: Arm, targets: Array | tuple[AnyTarget, ...], theta0: Array, tolerances: Tolerances, answers: list[AllSolutions]
) -> AllSolutionsBatch:
    """A batch of answers that were found one by one."""
    count = np.array([len(found) for found in answers], dtype=np.int64)
    beyond = np.array([len(found.outside) for found in answers], dtype=np.int64)
    rows = np.concatenate([np.zeros((0, 2, arm.n)), *(found._rows for found in answers)])
    known = tuple((found._method, found.complete) for found in answers)
    return AllSolutionsBatch(arm, count, beyond, targets, theta0, rows, known, tolerances, tuple(answers))
