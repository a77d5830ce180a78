"""`reachable`: which of many targets an arm meets, for maps of its workspace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, RealArray, as_direction, as_pose, as_vector, as_whole, require_callback
from ..support.errors import InputError
from .batch import MAX_THREADS, Progress, solve_ik_batch, targets_for
from .certainty import is_exact
from .closed_form.methods import family_method
from .request import Request, checked
from .targets import FARTHEST, AnyTarget, Approach, Pose, Position, TargetLike, target_of

CHUNK = 4096
"""Targets that follow one another and learn from each other's answers."""

AT_ONCE = 16 * CHUNK
"""Targets whose closed forms are in memory at once: six configurations of each take 40 MB."""


class Reached(NamedTuple):
    """The verdicts of `reachable`: `met` (N,), and theta (N, n) [rad, m], NaN where a target is not met."""

    met: NDArray[np.bool_]
    theta: Array


class _Group(NamedTuple):
    """Targets of one kind: their places (k,) among all, their numbers (k, …), and one like them."""

    like: AnyTarget
    places: NDArray[np.int64]
    numbers: Array


def reachable(
    arm: Arm,
    targets: RealArray | Sequence[TargetLike],
    theta0: ArrayLike | None = None,
    *,
    direction: ArrayLike | None = None,
    position_tol: float = 1e-6,
    orientation_tol: float = 1e-6,
    restarts: int = 100,
    threads: int = 1,
    progress: Progress | None = None,
) -> Reached:
    """Which of N targets the arm meets inside its limits, without the nearest configuration and the reason.

    Args:
        arm: The arm.
        targets: Poses (N, 4, 4), positions (N, 3) [m], or a sequence of targets of any kinds, as in `solve_ik_batch`.
        theta0: Start (n,) [rad, m], or the name of a pose.
        direction: Direction (3,) or (N, 3) of the arm's tool axis at positions (N, 3), as in an `Approach`.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        restarts: Greatest number of searches for each target.
        threads: Number of threads.
        progress: Called some twenty times a second with the fraction done, or None.

    Returns:
        `Reached`: met (N,), theta (N, n).

    Raises:
        InputError: A target (the message says which), the start or a number is unusable.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    require_arm(arm)._core("reachable")
    groups = [*_groups(arm, targets, direction)]
    request = checked(arm, theta0, None, position_tol, orientation_tol, restarts, 0, None)
    workers = as_whole(threads, "threads", 1, MAX_THREADS)
    require_callback(progress, "progress", "(fraction)")
    count = sum(len(group.places) for group in groups)
    found = Reached(np.zeros(count, dtype=np.bool_), np.full((count, arm.n), np.nan))
    for group in groups:
        left = _by_closed_form(arm, group, request, workers, found)
        some = [target_of(group.like.kind, each) for each in group.numbers[left]]
        batch = solve_ik_batch(
            arm, some, request.theta0, **request.tolerances.keywords, restarts=restarts, threads=workers
        )
        at = group.places[left]
        found.met[at] = batch.converged
        found.theta[at[batch.converged]] = batch.theta[batch.converged]
    return found


def _groups(arm: Arm, targets: Any, direction: ArrayLike | None) -> Iterator[_Group]:
    """The targets, those of a kind and a tool axis together. InputError for unusable ones."""
    if not isinstance(targets, np.ndarray) or targets.ndim != 2 or targets.shape[1] != 3:
        if direction is not None:
            raise InputError("direction goes with positions (N, 3); other targets have their own")
        if isinstance(targets, np.ndarray) and targets.ndim == 3:
            try:
                numbers = as_pose(targets, "targets")
                if len(numbers):
                    yield _Group(Pose(numbers[0]), np.arange(len(numbers)), numbers)
                return
            except InputError:
                pass  # it is raised again, with the place of the wrong one
        asked = targets_for(arm, targets)
        alike: dict[tuple[Any, ...], list[int]] = {}
        for i, target in enumerate(asked):
            axis = target.axis.tobytes() if isinstance(target, Approach) else b""
            alike.setdefault((target.kind, axis), []).append(i)
        for of_kind in alike.values():
            yield _Group(asked[of_kind[0]], np.array(of_kind), np.array([asked[i].numbers for i in of_kind]))
        return
    p = as_vector(targets, "targets")
    if np.abs(p).max(initial=0.0) > FARTHEST:
        raise InputError(f"targets hold {np.abs(p).max():g}, beyond {FARTHEST:g} m: lengths are in metres")
    places = np.arange(len(p))
    if direction is None:
        yield _Group(Position([0.0, 0.0, 0.0]), places, p)
        return
    along = as_direction(direction, "direction")
    if along.shape not in {(3,), p.shape}:
        raise InputError(f"direction must have shape (3,) or {p.shape}; got {along.shape}")
    like = Approach([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]).of(arm)
    each = np.broadcast_to(along, p.shape), np.broadcast_to(like.axis, p.shape)
    yield _Group(like, places, np.hstack([p, *each]))


def _by_closed_form(arm: Arm, group: _Group, request: Request, threads: int, found: Reached) -> NDArray[np.int64]:
    """Write what the arm's closed form decides into `found`. The answer is the targets left, of the group."""
    method = family_method(arm, group.like)
    if method.compiled is None or method.swept:
        return np.arange(len(group.places))
    tolerances, left = request.tolerances, []
    proves = is_exact(tolerances) and not any(arm.rounding)
    for begin in range(0, len(group.places), AT_ONCE):
        some = slice(begin, begin + AT_ONCE)
        all_of = method.compiled.solve_batch(
            group.numbers[some], request.theta0, tolerances.position, tolerances.orientation, threads
        )
        assert all_of is not None, "what was checked is plain"
        met, at = all_of.inside > 0, group.places[some]
        found.met[at] = met
        found.theta[at[met]] = all_of.theta[(np.cumsum(all_of.count) - all_of.count)[met]]
        left.append(begin + np.flatnonzero(~met & ((all_of.families > 0) | (not proves))))
    return np.concatenate(left)
