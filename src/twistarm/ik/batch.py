"""`solve_ik_batch`: many targets of one arm, arrays in and out."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import engine
from ..arm import Arm, require_arm
from ..checks import Array, RealArray, as_pose, as_whole, frozen, require_callback
from ..errors import InputError, shown
from . import textbook
from .answer import PlainAnswer
from .deadline import Deadline
from .ranges import joint_ranges
from .request import Request, checked
from .solution import STOPS, IKSolution, StopReason
from .targets import FARTHEST, KINDS, AnyTarget, Pose, TargetLike, target_for

Progress = Callable[[int, int], object]
"""Called with how many targets are done, and how many there are."""

MAX_THREADS = 256

NEAREST, HAS_UNLIMITED, OTHER_BRANCH, START_MOVED = 1, 2, 4, 8
"""Flags of a row."""

NOT_FINISHED = -1
"""In place of a reason: the time was up before the target was finished."""


@dataclass(frozen=True, eq=False, repr=False)
class IKBatch:
    """The answers to N targets, read-only arrays with a row for each; `batch[i]` is one of them as an `IKSolution`.

    A target that was not finished when the time was up has its start as theta, and infinite errors.
    """

    arm: Arm
    targets: Array | Sequence[AnyTarget] = field(repr=False)
    request: Request = field(repr=False)
    rows: Array = field(repr=False)

    @property
    def theta(self) -> Array:
        """(N, n) [rad, m]."""
        return self.rows[:, : self.arm.n]

    @property
    def position_error(self) -> Array:
        """(N,) [m], of what each target constrains."""
        return self.rows[:, -6]

    @property
    def orientation_error(self) -> Array:
        """(N,) [rad], of what each target constrains."""
        return self.rows[:, -5]

    @property
    def iterations(self) -> NDArray[np.int64]:
        """(N,): steps of the search that found theta; of all of them where none did."""
        return self.rows[:, -4].astype(np.int64)

    @property
    def restarts(self) -> NDArray[np.int64]:
        """(N,): searches that were run."""
        return self.rows[:, -3].astype(np.int64)

    @cached_property
    def stop(self) -> NDArray[np.object_]:
        """(N,) of `StopReason`."""
        reasons: NDArray[np.object_] = np.array(STOPS, dtype=object)[self.rows[:, -2].astype(np.int64)]
        return reasons

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(N,): which targets are met to the tolerances."""
        met: NDArray[np.bool_] = self.rows[:, -2] == STOPS.index(StopReason.CONVERGED)
        return met

    def __repr__(self) -> str:
        return f"IKBatch({self.arm.name}, {len(self)} targets, {int(self.converged.sum())} met)"

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[IKSolution]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> IKSolution:
        i = operator.index(index)
        n, row, target = self.arm.n, self.rows[i], target_for(self.arm, self.targets[i])
        flags, start = int(row[-1]), self.request.theta0
        answer = PlainAnswer(
            kind=target.kind,
            numbers=target.numbers.tobytes(),
            theta0=(start if start.ndim == 1 else start[i]).tobytes(),
            position_tol=self.request.tolerances.position,
            orientation_tol=self.request.tolerances.orientation,
            theta=row[:n].tobytes(),
            unlimited=row[n : 2 * n].tobytes() if flags & HAS_UNLIMITED else None,
            position_error=float(row[-6]),
            orientation_error=float(row[-5]),
            iterations=int(row[-4]),
            restarts=int(row[-3]),
            stop=int(row[-2]),
            nearest=bool(flags & NEAREST),
            other_branch=bool(flags & OTHER_BRANCH),
            start_moved=bool(flags & START_MOVED),
        )
        return IKSolution(self.arm, answer, target)


def solve_ik_batch(
    arm: Arm,
    targets: RealArray | Sequence[TargetLike],
    theta0: ArrayLike | None = None,
    *,
    position_tol: float = 1e-6,
    orientation_tol: float = 1e-6,
    restarts: int = 100,
    max_time: float | None = None,
    rng: int | np.random.Generator = 0,
    posture: ArrayLike | str | None = None,
    threads: int = 1,
    progress: Progress | None = None,
) -> IKBatch:
    """Inverse kinematics of N targets: poses (N, 4, 4), or a sequence of targets of any kinds.

    `theta0` is one start for all (n,) or one for each (N, n), `posture` likewise; the other arguments are those of
    `solve_ik`, and so is every verdict. The answer to a target depends on nothing but that target; it may be another
    root than that of `solve_ik`, which races its searches to be done sooner, where this one takes the first search
    that converges. `max_time` [s] is that of the whole batch. `threads` share the work, and change no answer;
    `progress(done, count)` is called some twenty times a second. Ctrl-C ends it.

    Raises InputError for what cannot be a target (which one), a start, a tolerance or a number of threads.
    """
    asked = _targets(targets, require_arm(arm))
    request = checked(arm, theta0, posture, (position_tol, orientation_tol), restarts, max_time, rng, count=len(asked))
    workers = as_whole(threads, "threads", 1, MAX_THREADS)
    require_callback(progress, "progress", "(done, count)")
    if arm.compiled is None:
        rows = _one_by_one(arm, asked, request, progress)
    else:
        rows = _by_core(arm.compiled, asked, request, Errand(workers, progress))
    return IKBatch(arm, asked, request, _begun(arm, request, rows))


def _targets(targets: Any, arm: Arm) -> Array | tuple[AnyTarget, ...]:
    """Poses as one array (N, 4, 4), anything else as targets."""
    if isinstance(targets, np.ndarray):
        return _poses(targets, arm)
    if isinstance(targets, str) or not isinstance(targets, Sequence):
        raise InputError(f"targets must be poses (N, 4, 4) or a sequence of targets; got {shown(targets)}")
    return tuple(_one(i, target, arm) for i, target in enumerate(targets))


def _poses(targets: NDArray[Any], arm: Arm) -> Array:
    if targets.ndim != 3 or targets.shape[1:] != (4, 4):
        raise InputError(f"targets must be poses of shape (N, 4, 4); got {targets.shape}")
    if targets.dtype == np.float64 and arm.compiled is not None:
        poses = frozen(np.ascontiguousarray(targets))
        # The core looks at every pose anyway, and much faster.
        if arm.compiled.are_targets(Pose.kind, poses):
            return poses
    try:
        poses = frozen(as_pose(targets, "targets"))
    except InputError:
        poses = frozen([_one(i, g, arm).numbers for i, g in enumerate(targets)])
    if np.abs(poses[:, :3, 3]).max(initial=0.0) > FARTHEST:
        poses = frozen([_one(i, g, arm).numbers for i, g in enumerate(targets)])
    return poses


def _one(i: int, target: Any, arm: Arm) -> AnyTarget:
    try:
        return target_for(arm, target)
    except InputError as error:
        raise InputError(f"targets[{i}]: {error}") from error


class Errand(NamedTuple):
    """How the core is to go about a batch."""

    threads: int
    progress: Progress | None

    def after(self, before: int, count: int) -> Errand:
        """The same for a part of the batch that follows `before` targets of `count`."""
        progress = self.progress
        return self if progress is None else Errand(self.threads, lambda done, _: progress(before + done, count))


def _by_core(chain: engine.Chain, targets: Array | tuple[AnyTarget, ...], request: Request, errand: Errand) -> Array:
    """The rows of every target: those of a kind together."""
    if isinstance(targets, np.ndarray):
        return _of_one_kind(chain, Pose.kind, targets, request, errand)
    rows = np.empty((len(targets), 2 * chain.n + 6))
    kinds = np.array([target.kind for target in targets], dtype=np.int64)
    for kind in range(len(KINDS)):
        of_kind = np.flatnonzero(kinds == kind)
        if len(of_kind):
            numbers = np.ascontiguousarray([targets[i].numbers for i in of_kind])
            errand_of_kind = errand.after(int((kinds < kind).sum()), len(targets))
            rows[of_kind] = _of_one_kind(chain, kind, numbers, _part(request, of_kind), errand_of_kind)
    return rows


def _of_one_kind(chain: engine.Chain, kind: int, numbers: Array, request: Request, errand: Errand) -> Array:
    rows = chain.solve_batch(
        kind,
        numbers,
        request.theta0,
        request.tolerances.position,
        request.tolerances.orientation,
        request.restarts,
        request.seed,
        request.max_time,
        request.posture,
        *errand,
    )
    assert rows is not None
    return rows


def _begun(arm: Arm, request: Request, rows: Array) -> Array:
    """The rows, read-only; those that were not finished have their start, and no error is known."""
    late = rows[:, -2] == NOT_FINISHED
    if late.any():
        start = joint_ranges(arm).inside(request.theta0)
        rows[late, : arm.n] = start if start.ndim == 1 else start[late]
        rows[late, arm.n :] = [*np.zeros(arm.n), np.inf, np.inf, 0.0, 0.0, STOPS.index(StopReason.TIMED_OUT), 0.0]
    rows.flags.writeable = False
    return rows


def _one_by_one(arm: Arm, targets: Array | tuple[AnyTarget, ...], request: Request, progress: Progress | None) -> Array:
    """Without the core: one after the other, in one thread."""
    deadline = Deadline.after(request.max_time)
    rows = np.full((len(targets), 2 * arm.n + 6), float(NOT_FINISHED))
    for i, target in enumerate(targets):
        if deadline.passed:
            break
        one = _part(request, np.array(i))
        answer = textbook.solve(arm, target_for(arm, target), replace(one, max_time=deadline.left))
        rows[i] = _row(arm, answer)
        if progress is not None:
            progress(i + 1, len(targets))
    return rows


def _row(arm: Arm, answer: PlainAnswer) -> Array:
    flags = NEAREST * answer.nearest + OTHER_BRANCH * answer.other_branch + START_MOVED * answer.start_moved
    unlimited = np.zeros(arm.n)
    if answer.unlimited is not None:
        unlimited, flags = np.frombuffer(answer.unlimited), flags + HAS_UNLIMITED
    errors = [answer.position_error, answer.orientation_error]
    counts = [answer.iterations, answer.restarts, answer.stop, flags]
    return np.concatenate([np.frombuffer(answer.theta), unlimited, errors, counts])


def _part(request: Request, indices: NDArray[np.int64]) -> Request:
    """The request for some targets of the batch."""

    def part(values: Array | None) -> Array | None:
        return values if values is None or values.ndim == 1 else frozen(values[indices])

    start = part(request.theta0)
    assert start is not None
    return replace(request, theta0=start, posture=part(request.posture))
