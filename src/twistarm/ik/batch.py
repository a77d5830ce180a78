"""`solve_ik_batch`: many targets of one arm, arrays in and out."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, Progress, RealArray, as_given, as_positive, as_whole, require_callback
from ..support.errors import InputError, quote
from .answer import CONVERGED, NOT_FINISHED, STOPS, Record, StopReason, record_type
from .certainty import decided
from .ranges import joint_ranges
from .request import Deadline, Options, Request, checked, in_radians, named
from .solution import IKResult
from .solve import collision_free
from .targets import AnyTarget, Pose, TargetLike, checked_target, shape_hint, target_for, target_of
from .task_space import ORIENTATION_TOL, POSITION_TOL

if TYPE_CHECKING:
    from ..collision import Contact, Scene


MAX_THREADS = 256


@dataclass(frozen=True, eq=False, repr=False)
class IKBatch:
    """The answers to N targets, read-only arrays with a row for each. `batch[i]` is one of them as an `IKResult`.

    A target not finished in time has its start as theta, and infinite errors.
    """

    arm: Arm
    records: Record = field(repr=False)
    """(N,): one answer each, with the fields of `IKResult.record`."""
    given: tuple[AnyTarget, ...] | None = field(default=None, repr=False)
    contacts: Mapping[int, tuple[Contact, ...]] = field(default_factory=dict, repr=False)
    """The pairs that collide, by the row, where every configuration found collides with the scene."""

    def __post_init__(self) -> None:
        self.records.flags.writeable = False

    @property
    def targets(self) -> Array | tuple[AnyTarget, ...]:
        """The targets: poses (N, 4, 4), or targets of any kinds."""
        if self.given is not None:
            return self.given
        return self.records["numbers"][:, :16].reshape(-1, 4, 4)

    @property
    def theta(self) -> Array:
        """(N, n) [rad, m]."""
        return self.records["theta"]

    @property
    def theta0(self) -> Array:
        """(N, n) [rad, m]: the start of each search."""
        return self.records["theta0"]

    @property
    def position_error(self) -> Array:
        """(N,) [m], in what each target constrains."""
        return self.records["position_error"]

    @property
    def orientation_error(self) -> Array:
        """(N,) [rad], in what each target constrains."""
        return self.records["orientation_error"]

    @property
    def iterations(self) -> NDArray[np.int64]:
        """(N,): steps of the search that found theta; of all searches where none did."""
        return self.records["iterations"]

    @property
    def restarts(self) -> NDArray[np.int64]:
        """(N,): number of searches."""
        return self.records["restarts"]

    @cached_property
    def stop(self) -> NDArray[np.object_]:
        """(N,) of `StopReason`."""
        reasons: NDArray[np.object_] = np.array(STOPS, dtype=object)[self.records["stop"]]
        reasons[list(self.contacts)] = StopReason.IN_COLLISION
        return reasons

    @property
    def converged(self) -> NDArray[np.bool_]:
        """(N,): which targets are reached to the tolerances, and free of collisions with the scene."""
        converged: NDArray[np.bool_] = self.records["stop"] == CONVERGED
        converged[list(self.contacts)] = False
        return converged

    def __repr__(self) -> str:
        return f"IKBatch({self.arm.name}, {len(self)} targets, {int(self.converged.sum())} reached)"

    def __len__(self) -> int:
        return len(self.records)

    def __iter__(self) -> Iterator[IKResult]:
        return (self[i] for i in range(len(self)))

    def __getitem__(self, index: int) -> IKResult:
        i = operator.index(index)
        target = None if self.given is None else self.given[i]
        return IKResult(self.arm, self.records[i, ...], target, self.contacts.get(i % len(self), ()))


def solve_ik_batch(
    arm: Arm,
    targets: RealArray | Sequence[TargetLike],
    theta0: ArrayLike | None = None,
    *,
    position_tol: float = POSITION_TOL,
    orientation_tol: float = ORIENTATION_TOL,
    restarts: int = 100,
    max_time: float | None = None,
    rng: int | np.random.Generator = 0,
    posture: ArrayLike | str | None = None,
    scene: Scene | None = None,
    threads: int = 1,
    progress: Progress | None = None,
) -> IKBatch:
    """Inverse kinematics of N targets: poses (N, 4, 4), or a sequence of targets of any kinds.

    Arguments and verdicts are those of `solve_ik`. The answer to a target depends on that target alone. It may be
    another root than that of `solve_ik`, which races its searches. This one takes the first search that converges.
    `threads` share the work, and change no answer. Ctrl-C ends it.

    Args:
        arm: The arm.
        targets: Poses (N, 4, 4), or a sequence of `Pose`, `Position`, `Approach`, `TolerancedPose` and poses (4, 4).
        theta0: Start (n,) or (N, n) [rad, m], or the name of one.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        restarts: Greatest number of searches for each target.
        max_time: Greatest time of the whole batch [s]; None for no limit.
        rng: Seed, or a NumPy Generator.
        posture: Preferred configuration (n,) or (N, n), its name, "theta0", "middle", or None.
        scene: A `Scene` of this arm, or None. An answer that collides is replaced as in `solve_ik`.
        threads: Number of threads.
        progress: Called some twenty times a second with the fraction done, or None.

    Returns:
        The `IKBatch`: theta (N, n), errors (N,) [m, rad], `converged` (N,). batch[i] is an `IKResult`.

    Raises:
        InputError: A target (the message says which), a start, a posture or a number is unusable.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    deadline = Deadline()
    if scene is not None:
        from ..collision import require_scene

        require_scene(scene, arm)
        deadline = Deadline.after(None if max_time is None else as_positive(max_time, "max_time"))
    require_arm(arm).require_core("solve_ik_batch")
    options, batch = (position_tol, orientation_tol, restarts, rng, max_time), None
    if isinstance(targets, np.ndarray) and in_radians(orientation_tol):
        batch = _of_poses(arm, targets, theta0, posture, options, threads, progress)
    if batch is None:
        goals = targets_for(arm, targets)
        request = checked(arm, theta0, posture, *options, count=len(goals))
        workers = as_whole(threads, "threads", 1, MAX_THREADS)
        require_callback(progress, "progress", "(fraction)")
        batch = _of_goals(arm, goals, request, workers, progress)
    return batch if scene is None else _free(batch, scene, deadline, threads)


def _of_poses(
    arm: Arm, poses: RealArray, theta0: Any, posture: Any, options: Options, threads: int, progress: Progress | None
) -> IKBatch | None:
    """The core's answers to poses (N, 4, 4), which it checks much faster. None as in `arm.engine`."""
    start = arm.ready if theta0 is None else named(arm, theta0)
    preferred = None if posture is None else named(arm, posture, start)
    report = partial(_report, progress, 0, None) if callable(progress) else progress
    found = np.zeros(poses.shape[:1], record_type(arm.n))
    arguments = as_given(poses), as_given(start), *options, as_given(preferred), threads, report, found
    if not arm.require_core("solve_ik_batch").solve_batch(Pose.kind, *arguments):
        return None
    return IKBatch(arm, _finished(arm, found, None, options[-1] is None))


def _of_goals(
    arm: Arm, goals: tuple[AnyTarget, ...], request: Request, threads: int, progress: Progress | None
) -> IKBatch:
    """The core's answers to targets of any kinds, those of a kind together."""
    chain = arm.require_core("solve_ik_batch")
    records, done = np.zeros(len(goals), record_type(arm.n)), 0
    kinds = np.array([target.kind for target in goals], dtype=np.int64)
    for kind in np.unique(kinds).tolist():
        places = np.flatnonzero(kinds == kind)
        numbers, part = np.array([goals[i].numbers for i in places]), records[places]
        report = None if progress is None else partial(_report, progress, done, len(goals))
        given = request.theta0, request.posture
        start, posture = (x[places] if x is not None and x.ndim > 1 else x for x in given)
        if not chain.solve_batch(kind, numbers, start, *request.options, posture, threads, report, part):
            # Somebody has written into the arrays of a target.
            return _of_goals(arm, targets_for(arm, goals, checked_target), request, threads, progress)
        records[places] = part
        done += len(places)
    return IKBatch(arm, _finished(arm, records, goals, math.isinf(request.max_time)), goals)


def _free(batch: IKBatch, scene: Scene, deadline: Deadline, threads: int) -> IKBatch:
    """The batch with free answers in place of those that collide, and the contacts where none was found."""
    records = batch.records.copy()
    converged = np.flatnonzero(batch.converged)
    contacts: dict[int, tuple[Contact, ...]] = {}
    for i in converged[scene.collides(batch.theta[converged], threads=threads)].tolist():
        found = collision_free(scene, batch[i], deadline)
        if found.contacts:
            contacts[i] = found.contacts
        else:
            records[i] = found.record
    return replace(batch, records=records, contacts=contacts)


def _finished(arm: Arm, records: Record, targets: tuple[AnyTarget, ...] | None, has_time: bool) -> Record:
    """The answers. Late ones get their start and infinite errors, and the closed form decides about missed ones."""
    late = records["stop"] == NOT_FINISHED
    if late.any():
        records["theta"][late] = joint_ranges(arm).inside(records["theta0"][late])
        records["position_error"][late] = records["orientation_error"][late] = np.inf
        records["stop"][late] = STOPS.index(StopReason.TIMED_OUT)
    # An answer of one search stays: its caller wants the end of that search.
    for i in np.flatnonzero((records["stop"] != CONVERGED) & (records["restarts"] > 1)).tolist():
        target = target_of(Pose.kind, records[i]["numbers"]) if targets is None else targets[i]
        records[i] = decided(arm, target, records[i, ...], has_time)
    return records


def targets_for(arm: Arm, targets: Any, convert: Callable[[Arm, Any], AnyTarget] = target_for) -> tuple[AnyTarget, ...]:
    """The targets of a batch, of any kinds, each as `convert` makes it. InputError names the place of a wrong one."""
    if isinstance(targets, np.ndarray) and (targets.ndim != 3 or targets.shape[1:] != (4, 4)):
        raise InputError(f"targets must be poses of shape (N, 4, 4); got {targets.shape}{shape_hint(targets)}")
    if isinstance(targets, str) or not isinstance(targets, (np.ndarray, Sequence)):
        raise InputError(f"targets must be poses (N, 4, 4) or a sequence of targets; got {quote(targets)}")
    found: list[AnyTarget] = []
    try:
        for target in targets:
            found.append(convert(arm, target))  # noqa: PERF401
    except InputError as error:
        raise InputError(f"targets[{len(found)}]: {error}") from error
    return tuple(found)


def _report(progress: Progress, before: int, count: int | None, done: int, of: int) -> None:
    """Report a part of a batch of `count` targets, after `before` of them. None if it is the only part."""
    progress((before + done) / (of if count is None else count))
