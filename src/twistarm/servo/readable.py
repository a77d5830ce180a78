"""One step of the servo in NumPy: the specification of the compiled one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from .. import rotations
from ..arm import Arm
from ..checks import Array, frozen
from .answer import Answer, Cause
from .bounds import Bounds
from .command import BASE, AnyCommand, JogCommand, PoseCommand, TwistCommand
from .resolved_rates import Task, resolved_rates
from .state import ServoState

NOTHING = 1e-12
"""Rates and errors below this are rounding."""

HALTED = 1e-4
"""Rates below this share of the command's are a standstill."""

TILT = 0.1
"""[scaled rad]"""

NOTICED = 0.01
"""A slow-down by a smaller share than this is not worth a word."""


def step(arm: Arm, bounds: Bounds, state: ServoState, command: AnyCommand | None, dt: float) -> Answer:
    """The rates for the coming dt, and where they lead.

    1. The command becomes a task: levels of tool rates in the command's frame, the held ones first, then linear, then
       angular ones, at the posture half a step ahead (midpoint rule).
    2. `resolved_rates` gives the joint rates; all of them are scaled for singularities and velocity limits.
    3. A joint that would pass the rate from which it can still stop at its position limit is fixed at that rate, and
       the others are solved again: the motion along the limit is kept. After F. Flacco, A. De Luca & O. Khatib, Control
       of redundant robots under hard joint constraints: saturation in the null space, IEEE T-RO 31(3), 2015, §III.
    4. The rates go from the old ones toward these as far as the acceleration limits let all of them together.
    """
    if command is None:
        return _moved(bounds, state, np.zeros(bounds.n), dt)
    if isinstance(command, JogCommand):
        return _jogged(bounds, state, command, dt)
    goal = _goal(arm, bounds, state, command, dt)
    return _reached(bounds, state, goal, _rates(bounds, state, goal.task, dt), dt)


# -- the task ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Goal:
    """The task of a command, the pose that is held after it, and how far a pose to reach is, [m] and [rad]."""

    task: Task
    held: Array | None
    remaining: tuple[float, float]


def _goal(arm: Arm, bounds: Bounds, state: ServoState, command: TwistCommand | PoseCommand, dt: float) -> Goal:
    g = arm.fk(state.theta)
    if isinstance(command, PoseCommand):
        error = _error(g, command.g, BASE)
        task = _task(arm, bounds, state, BASE, (), dt)
        asked = _scaled(bounds, command.velocity) + _approach(bounds, task, error, command)
        remaining = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
        return Goal(replace(task, asked=asked), None, remaining)
    held = [k for k in range(6) if command.held[k]]
    task = _task(arm, bounds, state, command.frame, held, dt)
    if not held:
        return Goal(replace(task, asked=_scaled(bounds, command.twist)), None, (0.0, 0.0))
    kept = state.held if state.held is not None and state.holding == command.flags else g
    error = np.where(command.held, _error(g, kept, command.frame), 0.0)
    asked = _scaled(bounds, command.twist) + _approach(bounds, task, error, None)
    return Goal(replace(task, asked=asked), kept, (0.0, 0.0))


def _task(arm: Arm, bounds: Bounds, state: ServoState, frame: str, held: Sequence[int], dt: float) -> Task:
    """Held components first, then linear, then angular ones, at the posture half a step ahead; nothing asked yet."""
    ahead = state.theta + 0.5 * dt * state.theta_dot

    def jacobian(displacement: Array) -> Array:
        g, J = arm.fk_and_body_jacobian(ahead + bounds.unit * displacement)
        turned = _in_axes(g[:3, :3], J) if frame == BASE else J
        return _scaled(bounds, turned.T).T * bounds.unit

    others = (tuple(k for k in half if k not in held) for half in (range(3), range(3, 6)))
    levels = tuple(level for level in (tuple(held), *others) if level)
    toward, below = _toward(bounds, ahead), bounds.singular_below
    return Task(
        np.zeros(6), levels, jacobian, toward, below, dt, lambda rates: bounds.stopping_time(rates * bounds.unit)
    )


def _scaled(bounds: Bounds, twists: ArrayLike) -> Array:
    """Twists (..., 6) with metres measured in `length`."""
    scaled: Array = np.asarray(twists) * np.repeat([1.0 / bounds.length, 1.0], 3)
    return scaled


def _toward(bounds: Bounds, theta: Array) -> Array:
    """The unit scaled way to the ready pose, tilted a little so that it leads off any singularity."""
    way = (bounds.ready - theta) / bounds.unit + TILT * (-1.0) ** np.arange(bounds.n)
    unit: Array = way / max(float(np.linalg.norm(way)), NOTHING)
    return unit


def _error(g: Array, target: Array, frame: str) -> Array:
    """(p_target − p, log(R_target Rᵀ)) (6,) in base axes, or turned into the tool's."""
    R = g[:3, :3]
    error = np.concatenate([target[:3, 3] - g[:3, 3], rotations.log(target[:3, :3] @ R.T)])
    return error if frame == BASE else _in_axes(R.T, error)


def _in_axes(R: Array, columns: Array) -> Array:
    turned: Array = np.concatenate([R @ columns[:3], R @ columns[3:]])
    return turned


def _approach(bounds: Bounds, task: Task, error: Array, command: PoseCommand | None) -> Array:
    """What to ask for an error (6,): as much of error / dt as lets the arm stop at the goal, straight on.

    At a share s: s dt + s² T/2 ≤ dt, T the time that a stop from the full rates takes. A command's speeds are kept.
    """
    asked = _scaled(bounds, error) / task.dt
    if np.abs(error).max() <= NOTHING:
        return np.zeros(6)
    found = resolved_rates(task, asked, np.ones(bounds.n, bool), np.zeros(bounds.n))
    stop = bounds.stopping_time(found.rates * bounds.unit)
    share = 2.0 * task.dt / (task.dt + np.sqrt(task.dt * task.dt + 2.0 * stop * task.dt))
    if command is not None:
        for part, speed in ((error[:3], command.linear_speed), (error[3:], command.angular_speed)):
            share = min(share, speed * task.dt / max(float(np.linalg.norm(part)), NOTHING))
    approach: Array = share * asked
    return approach


# -- the rates ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Wanted:
    """Joint rates (n,) before acceleration limits, the share of the task that they are for, and what holds them back.

    row: of the bounds' motion, or the joint for Cause.SINGULARITY; −1 for none.
    """

    rates: Array
    share: float
    cause: Cause
    row: int


def _rates(bounds: Bounds, state: ServoState, task: Task, dt: float) -> Wanted:
    free, fixed = np.ones(bounds.n, bool), np.zeros(bounds.n)
    found = resolved_rates(task, task.asked, free, fixed)
    share, cause, row = 1.0 / (1.0 + found.bent), Cause.NONE, -1
    if found.taken > NOTICED:
        cause, row = Cause.SINGULARITY, found.joint
    rates = share * found.rates * bounds.unit
    first = len(bounds.motion.names) - bounds.n
    for _ in range(2 * bounds.n):
        slower, fastest = bounds.velocity_share(rates)
        if slower < 1.0:
            rates, share = slower * rates, slower * share
            if cause in (Cause.NONE, Cause.SINGULARITY):
                cause, row = Cause.VELOCITY, fastest
        least, most = _position_bounds(bounds, state.theta, rates, dt)
        over = np.maximum(rates - most, least - rates)
        worst = int(np.argmax(over))
        if over[worst] <= NOTHING:
            break
        if cause not in (Cause.LOWER, Cause.UPPER):
            cause, row = (Cause.UPPER if rates[worst] > 0 else Cause.LOWER), first + worst
        free[worst] = False
        rates[worst] = min(max(rates[worst], least[worst]), most[worst])
        found = resolved_rates(task, share * task.asked, free, np.where(free, 0.0, rates / bounds.unit))
        rates = found.rates * bounds.unit
    return Wanted(rates, share, cause, row)


def _position_bounds(bounds: Bounds, theta: Array, rates: Array, dt: float) -> tuple[Array, Array]:
    """The least and largest rates (n,) at which a stop that takes as long as one from `rates` ends inside the limits.

    A joint that is outside may stand still or come back.
    """
    limits, n = bounds.motion.limits, bounds.n
    time = dt + 0.5 * bounds.stopping_time(rates)
    most: Array = np.maximum(limits.upper[-n:] - theta, 0.0) / time
    least: Array = -np.maximum(theta - limits.lower[-n:], 0.0) / time
    return least, most


# -- the answer --------------------------------------------------------------------------------------------------------


def _reached(bounds: Bounds, state: ServoState, goal: Goal, wanted: Wanted, dt: float) -> Answer:
    J, asked = goal.task.jacobian(np.zeros(bounds.n)), goal.task.asked
    reachable = J @ (wanted.rates / bounds.unit) / wanted.share
    answer = _moved(bounds, state, wanted.rates, dt, wanted.cause, wanted.row)
    done = J @ (answer.theta_dot / bounds.unit)
    size = float(np.linalg.norm(asked))
    answer.scale = _scale(done, reachable, size)
    answer.lost = frozen((asked - reachable) * np.repeat([bounds.length, 1.0], 3))
    answer.lost_share = float(np.linalg.norm(asked - reachable)) / max(size, NOTHING)
    if answer.cause is Cause.NONE and size > 0.0 and np.linalg.norm(reachable) <= HALTED * size:
        answer.cause = Cause.SINGULARITY
    answer.held, answer.remaining = goal.held, goal.remaining
    answer.halted = _is_halted(answer.cause, answer.theta_dot / bounds.unit, wanted.share * size)
    return answer


def _jogged(bounds: Bounds, state: ServoState, command: JogCommand, dt: float) -> Answer:
    share, fastest = bounds.velocity_share(command.theta_dot)
    rates = share * command.theta_dot
    cause, row = (Cause.VELOCITY, fastest) if share < 1.0 else (Cause.NONE, -1)
    within = np.clip(rates, *_position_bounds(bounds, state.theta, rates, dt))
    over = np.abs(within - rates)
    if over.max() > NOTHING:
        joint = int(np.argmax(over))
        cause, row = (Cause.UPPER if rates[joint] > 0 else Cause.LOWER), joint - bounds.n + len(bounds.motion.names)
    answer = _moved(bounds, state, within, dt, cause, row)
    size = float(np.linalg.norm(command.theta_dot))
    answer.scale = _scale(answer.theta_dot, command.theta_dot, size)
    answer.halted = _is_halted(answer.cause, answer.theta_dot, share * size)
    return answer


def _scale(done: Array, reachable: Array, asked: float) -> float:
    """1 − |done − reachable| over the longer of the two, at least 0: 1 where it is done and nothing beside it."""
    length = float(np.linalg.norm(reachable))
    if length <= HALTED * asked:
        return float(asked == 0.0)
    longer = max(length, float(np.linalg.norm(done)))
    return max(0.0, 1.0 - float(np.linalg.norm(done - reachable)) / longer)


def _is_halted(cause: Cause, rates: Array, asked: float) -> bool:
    return cause in (Cause.LOWER, Cause.UPPER) and bool(np.linalg.norm(rates) <= HALTED * asked)


def _moved(
    bounds: Bounds, state: ServoState, target: Array, dt: float, cause: Cause = Cause.NONE, row: int = -1
) -> Answer:
    motion = bounds.motion
    allowed = motion.within(state.theta, target, state.theta_dot, dt)
    if allowed.by is not None and allowed.limit == "position" and cause not in (Cause.LOWER, Cause.UPPER):
        row = motion.names.index(allowed.by)
        cause = Cause.UPPER if motion.C[row] @ target > 0 else Cause.LOWER
    theta = state.theta + dt * allowed.theta_dot
    # Rounding may not carry a joint beyond its limit; one that was outside stays no farther out than it was.
    lower = np.minimum(motion.limits.lower[-bounds.n :], state.theta)
    upper = np.maximum(motion.limits.upper[-bounds.n :], state.theta)
    return Answer(frozen(np.clip(theta, lower, upper)), frozen(allowed.theta_dot), cause, row)
