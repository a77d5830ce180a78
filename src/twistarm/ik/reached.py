"""`reachable`: which of many targets an arm reaches, for maps of its workspace.

`reach_ball` bounds where a point of the tool may be, at any configuration. It excludes far targets.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..arm.engine import answered
from ..support.checks import Array, Progress, RealArray, as_direction, as_floats, as_pose, as_whole, require_callback
from ..support.errors import InputError
from ..theory.screws import to_screw
from .answer import ConfigurationsBatch
from .batch import MAX_THREADS, targets_for
from .closed_form.chain import NO_PITCH
from .closed_form.methods import family_for
from .request import Request, checked
from .targets import FARTHEST, AnyTarget, Approach, Pose, Position, TargetLike, TolerancedPose, checked_target
from .task_space import EXACT_TOL, ORIENTATION_TOL, POSITION_TOL

STEPS = 50  # Steps toward the smallest radius. Each of them gives a bound.
SHORTEST = 1e-6  # Shorter distances [m] count as this in a step's weights.
RADIUS_ROUNDING = 1e-9  # What the radius has beyond the bound [m].
CHUNK = 4096  # Targets after which a search begins at theta0 again, not at the answer before.
# Searches for a target that the closed form excludes. The nearest configuration may still be within the tolerances.
FEW_SEARCHES = 4
AT_ONCE = 16 * CHUNK  # Targets whose closed forms are in memory at once: six configurations of each take 40 MB.


class Reached(NamedTuple):
    """The verdicts of `reachable`: `converged` (N,), and theta (N, n) [rad, m]. NaN: the target is not reached."""

    converged: NDArray[np.bool_]
    theta: Array


class _Group(NamedTuple):
    """Targets of one kind: one like them, their places (k,) among all, and their numbers (k, …).

    `own`: whether approaches have the arm's tool axis. The ball and the closed form belong to one tool axis.
    """

    like: AnyTarget
    own: bool
    places: NDArray[np.int64]
    numbers: Array


def reachable(
    arm: Arm,
    targets: RealArray | Sequence[TargetLike],
    theta0: ArrayLike | None = None,
    *,
    direction: ArrayLike | None = None,
    position_tol: float = POSITION_TOL,
    orientation_tol: float = ORIENTATION_TOL,
    restarts: int = 32,
    threads: int = 1,
    progress: Progress | None = None,
) -> Reached:
    """Which of N targets the arm reaches inside its limits, without the nearest configuration and the reason.

    A target outside the tool's ball (`reach_ball`) is not reached. If the arm has a closed form for these targets, it
    decides which others are reached exactly. A few searches decide which of the rest are reached within the tolerances.
    Without a closed form, `restarts` searches decide. They may miss a configuration: on a grid of voxels one in 10,000.
    The first search begins at the answer before, so put neighbours one after the other. It begins at theta0 again after
    each 4096 targets. So the parts of a call that is divided there give the same bits, as do any `threads`.

    Args:
        arm: The arm.
        targets: Poses (N, 4, 4), positions (N, 3) [m], or a sequence of targets of any kinds, as in `solve_ik_batch`.
        theta0: Start (n,) [rad, m], or the name of one.
        direction: Direction (3,) or (N, 3) of `arm.tool_axis` at positions (N, 3), as in `Approach`. None for any.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        restarts: Greatest number of searches for each target.
        threads: Number of threads.
        progress: Called now and then with the fraction done, or None.

    Returns:
        The `Reached`: converged (N,) and theta (N, n).

    Raises:
        InputError: A target (the message says which), the start or a number is unusable.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    chain = require_arm(arm).require_core("reachable")
    request = checked(arm, theta0, None, position_tol, orientation_tol, restarts, 0, None)
    workers = as_whole(threads, "threads", 1, MAX_THREADS)
    require_callback(progress, "progress", "(fraction)")
    groups = [group for group in _groups(arm, targets, direction) if len(group.places)]
    count = sum(len(group.places) for group in groups)
    found, decided = Reached(np.zeros(count, dtype=np.bool_), np.full((count, arm.n), np.nan)), 0

    def report(searched: int, _: int = 0) -> None:
        if progress is not None:
            progress((decided + searched) / count)

    for group in groups:
        searches = np.where(_in_ball(arm, group, request), request.restarts, 0)
        _decide_by_closed_form(arm, group, searches, request, workers, found)
        decided += int((searches == 0).sum())
        report(0)
        for most in np.unique(searches[searches > 0])[::-1].tolist():
            left = np.flatnonzero(searches == most)
            at = group.places[left]
            chunks = np.searchsorted(at, np.arange(0, count + CHUNK, CHUNK)).astype(np.float64)
            how = request.tolerances.position, request.tolerances.orientation, most, request.seed, chunks
            numbers, callback = group.numbers[left], progress and report
            answers = chain.reachable(group.like.kind, numbers, request.theta0, *how, workers, callback)
            found.converged[at], found.theta[at] = answered(answers)
            decided += len(left)
    return found


def _groups(arm: Arm, targets: Any, direction: ArrayLike | None) -> Iterator[_Group]:
    """The targets, those of a kind together. InputError for unusable ones."""
    shape = targets.shape if isinstance(targets, np.ndarray) else ()
    if shape[1:] in {(3,), (4, 4)}:
        given = as_floats(targets, "targets")
        if np.abs(given).max(initial=0.0) > FARTHEST:
            raise InputError(f"targets hold {np.abs(given).max():g}, beyond {FARTHEST:g} m: lengths are in metres")
        if shape[1:] == (3,):
            like: AnyTarget = Position([0.0] * 3)
            numbers = [given]
            if direction is not None:
                like, along = Approach([0.0] * 3, [0.0, 0.0, 1.0]).of(arm), as_direction(direction, "direction")
                if along.shape not in {(3,), shape}:
                    raise InputError(f"direction must have shape (3,) or {shape}; got {along.shape}")
                numbers += [np.broadcast_to(along, shape), np.broadcast_to(like.axis, shape)]
            yield _Group(like, True, np.arange(len(given)), np.hstack(numbers))
            return
    if direction is not None:
        raise InputError("direction goes with targets that are positions (N, 3); others have their own")
    if shape[1:] == (4, 4):
        with suppress(InputError):  # raised below, with the place of the wrong pose
            yield _Group(Pose(np.eye(4)), True, np.arange(len(given)), as_pose(given, "targets"))
            return
    goals = targets_for(arm, targets, checked_target)
    alike: dict[tuple[int, bool], list[int]] = {}
    for i, target in enumerate(goals):
        own = not isinstance(target, Approach) or np.array_equal(target.axis, arm.tool_axis)
        alike.setdefault((target.kind, own), []).append(i)
    for (_, own), places in alike.items():
        yield _Group(goals[places[0]], own, np.asarray(places), np.array([goals[i].numbers for i in places]))


def _in_ball(arm: Arm, group: _Group, request: Request) -> NDArray[np.bool_]:
    """Which of the group's targets are in its ball, with the tolerances."""
    if isinstance(group.like, TolerancedPose) or not group.own:
        return np.ones(len(group.places), dtype=np.bool_)
    ball, numbers = reach_ball(arm, group.like), group.numbers
    if isinstance(group.like, Pose):
        x = numbers[:, :3, :3] @ ball.x + numbers[:, :3, 3]
    else:
        x = numbers[:, :3] + (ball.x @ group.like.axis * numbers[:, 3:6] if isinstance(group.like, Approach) else 0.0)
    slack = request.tolerances.position + request.tolerances.orientation * float(np.linalg.norm(ball.x))
    inside: NDArray[np.bool_] = np.linalg.norm(x - ball.centre, axis=1) <= ball.radius + slack
    return inside


def _decide_by_closed_form(
    arm: Arm, group: _Group, searches: NDArray[np.int64], request: Request, threads: int, found: Reached
) -> None:
    """Write what the closed form reaches into `found`, and how many `searches` (k,) decide each of the others.

    A target that no configuration reaches exactly may still be reached within tolerances that are not tight.
    """
    method, exact = family_for(arm, group.like) if group.own else None, request.tolerances.at_most(EXACT_TOL)
    if method is None or method.core is None or method.sampled or not method.exact:
        return
    few = 0 if exact == request.tolerances else min(request.restarts, FEW_SEARCHES)
    asked = np.flatnonzero(searches)
    for begin in range(0, len(asked), AT_ONCE):
        part = asked[begin : begin + AT_ONCE]
        how = request.theta0, exact.position, exact.orientation, threads
        every = ConfigurationsBatch(*answered(method.core.solve_batch(group.numbers[part], *how)))
        inside = every.inside > 0
        at = group.places[part[inside]]
        found.converged[at] = True
        found.theta[at] = every.rows[every.first[inside], 0]
        searches[part[inside]] = 0
        searches[part[~inside & (every.families == 0)]] = few


class ReachBall(NamedTuple):
    """The point x (3,) of the tool, in tool axes, stays within `radius` [m] of `centre` (3,)."""

    x: Array
    centre: Array
    radius: float


def reach_ball(arm: Arm, like: Position | Approach | Pose, bounds: tuple[Array, Array] | None = None) -> ReachBall:
    """A small ball for targets like this one, where theta is inside `bounds` or the limits.

    A turn about an axis keeps the distance from its point q_i to the next one, q_{i+1}. So the tool's point x stays
    within Σ ‖q_{i+1} − q_i‖ of q_1. A slide or helical joint adds half of its range. That holds for any q_i on the axes
    and any x that the target fixes. A `Position` fixes the origin, an `Approach` the tool axis, a `Pose` every point.
    The q_i and x are those of the least sum, by iteratively reweighted least squares (E. Weiszfeld, Tôhoku Math. J. 43,
    1937). Coupled joints count as if they moved alone. If one that slides has no limits, the radius is inf.
    """
    kept = {Position: np.zeros((3, 0)), Approach: getattr(like, "axis", np.zeros(3))[:, None], Pose: np.eye(3)}
    lower, upper = bounds or (arm.limits.lower, arm.limits.upper)
    screws = to_screw(arm.screws.T)
    turns = np.isfinite(screws.pitch)
    pitch = np.where(turns, np.where(np.abs(screws.pitch) > NO_PITCH, screws.pitch, 0.0), 1.0)
    advance = (pitch * screws.magnitude)[:, None] * arm.coupling.A
    half = np.where(advance, np.maximum(upper - arm.middle, arm.middle - lower), 0.0)  # no 0 times inf
    shift = (advance @ arm.middle)[:, None] * screws.axis
    axes, behind = screws.axis[turns], (np.cumsum(shift, axis=0) + screws.point)[turns]
    count, fixed = len(axes), kept[type(like)]
    at = np.vstack([behind, arm.home[:3, 3] + shift.sum(axis=0)])
    along = np.zeros((count + 1, 3, count + fixed.shape[1]))
    along[range(count), :, range(count)] = axes
    along[count, :, count:] = arm.home[:3, :3] @ fixed
    offset, rows, length, z = np.diff(at, axis=0), np.diff(along, axis=0), np.ones(count), np.zeros(along.shape[-1])
    for _ in range(STEPS):
        weight = np.maximum(length, SHORTEST) ** -0.5
        z = np.linalg.lstsq((rows * weight[:, None, None]).reshape(3 * count, len(z)),
                            -(offset * weight[:, None]).ravel(), rcond=None)[0]  # fmt: skip
        length = np.linalg.norm(offset + rows @ z, axis=1)
    radius = float(length.sum() + (np.abs(advance) * half).sum()) + RADIUS_ROUNDING
    return ReachBall(fixed @ z[count:], at[0] + along[0] @ z, radius)
