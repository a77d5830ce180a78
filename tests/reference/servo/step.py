"""One step of the servo in NumPy, beside the compiled one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from twistarm.arm.arm import Arm
from twistarm.control.servo.answer import Answer, Cause
from twistarm.control.servo.bounds import Bounds
from twistarm.control.servo.command import BASE, AnyCommand, JogCommand, PoseCommand, TwistCommand
from twistarm.control.servo.state import ServoState
from twistarm.support.checks import Array, frozen
from twistarm.theory import rotations

from .rates import ROUNDS, RateTask, resolved_rates, taken_back
from .singular import Place, Singular, fixed, singular, smallest_about

NOTHING = 1e-12
"""Rates and errors below this are rounding."""

HALTED = 3e-2
"""Rates below this share of the command's are a standstill."""

NO_ROOM = 0.01
"""A joint at its limit may move on at a smaller share of the scaled twist."""

TILT = 0.1
"""[scaled rad]"""

STEPS = 3.0
"""τ is at least so many periods, and a joint comes to its limit in no fewer."""

PERIOD_TIME = 8.0
"""How slowly the period follows what steps take [s]."""

ASTRAY = 2e-4
"""An error of what is held at which half of the rest is done [scaled]."""

LOOK_AHEAD = 0.01
"""How far ahead a course is looked at [scaled rad]."""

ONE_ROUND = 2.0
"""A change of rates is at most so many times what the first round shows."""

SLOWINGS = 4
"""How often it is looked whether joints that take over for others at their limits are too fast."""

NO_SHARE = 1e-3
"""Of a unit motion: a joint that moves less does not count."""

OFF_COURSE, FINEST = 1e-3, 1e-6
"""Of the twist: less beside its course is none; and how finely the share is looked for that keeps it."""

NOTICED = 0.01
"""A slow-down by a smaller share than this is not worth a word."""


def step(arm: Arm, bounds: Bounds, state: ServoState, command: AnyCommand | None, dt: float) -> Answer:
    """The rates for the coming dt, and where they lead.

    1. The command becomes a task: levels of tool rates in the command's frame, the held ones first, then linear, then
       angular ones, at the posture half a step ahead (midpoint rule).
    2. `resolved_rates` gives the joint rates; all of them are slowed to what the velocity limits allow.
    3. Where a joint would pass the rate from which it can still stop at its position limit, they are solved again with
       that rate as a bound, which falls to 0 with the distance: the motion along the limit is kept.
    4. The rates go from the old ones toward these as far as the acceleration limits let all of them together.
    """
    state = replace(state, period=_period_after(state.period, dt))
    if command is None:
        answer = _moved(bounds, state, np.zeros(bounds.n), dt)
    elif isinstance(command, JogCommand):
        answer = _jogged(bounds, state, command, dt)
    else:
        goal = _goal(arm, bounds, state, command, dt)
        answer = _reached(bounds, state, goal, _rates(bounds, state, goal, dt), dt)
    answer.period = state.period
    return answer


def _period_after(period: float, dt: float) -> float:
    """The slow measure of what steps take, after one of dt: a loop that jitters is damped evenly."""
    return period + (dt - period) * min(dt / PERIOD_TIME, 1.0) if period > 0.0 else dt


def stopping_time(bounds: Bounds, rates: Array) -> float:
    """How long [s] a straight stop from joint rates (n,) takes."""
    return float((np.abs(bounds.motion.C @ rates) / bounds.motion.limits.acceleration).max())


def velocity_share(bounds: Bounds, rates: Array) -> tuple[float, int]:
    """The share of the joint rates (n,) that keeps every velocity limit, and the row of `motion` that decides."""
    used = np.abs(bounds.motion.C @ rates) / bounds.motion.limits.velocity
    return 1.0 / max(1.0, float(used.max())), int(used.argmax())


# -- the task ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Where:
    """A posture theta (n,) of an arm and the axes of its rows; astray (6, 6) where `_astray` gives one."""

    arm: Arm
    bounds: Bounds
    theta: Array
    frame: str
    astray: Array | None
    held: tuple[int, ...]

    def rows(self, displacement: Array) -> Array:
        """The scaled rows (6, n) a scaled joint displacement (n,) away."""
        J = _jacobian(self.arm, self.bounds, self.theta + self.bounds.unit * displacement, self.frame)
        if self.astray is not None:
            J[list(self.held)] = (self.astray @ J)[list(self.held)]
        return J

    def place(self) -> Place:
        """As singularities are looked for there."""
        return Place(self.rows, _toward(self.bounds, self.theta), lambda way: _way_left(self.bounds, self.theta, way))

    def displaced(self, displacement: Array) -> Where:
        """A scaled joint displacement (n,) away."""
        return replace(self, theta=self.theta + self.bounds.unit * displacement)


@dataclass(frozen=True, eq=False)
class Goal:
    """The task of a command, where it is, the pose that is held after it, and how far a goal is, [m], [rad].

    steady: what is asked stays the same in base axes while the arm moves.
    """

    task: RateTask
    where: Where
    held: Array | None
    remaining: tuple[float, float]
    steady: bool = False


def _goal(arm: Arm, bounds: Bounds, state: ServoState, command: TwistCommand | PoseCommand, dt: float) -> Goal:
    g, ahead = arm.fk(state.theta), state.theta + 0.5 * dt * state.theta_dot
    if isinstance(command, PoseCommand):
        error = _error(g, command.g, BASE)
        where = Where(arm, bounds, ahead, BASE, None, ())
        task = _task(where, state.period)
        asked = _scaled(bounds, command.velocity) + _approach(bounds, task, error, command, state.period, dt)
        remaining = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
        return Goal(replace(task, asked=asked), where, None, remaining)
    held = tuple(k for k in range(6) if command.held[k])
    asked = _scaled(bounds, command.twist)
    if not held:
        where = Where(arm, bounds, ahead, command.frame, None, ())
        task = replace(_task(where, state.period), asked=asked)
        return Goal(task, where, None, (0.0, 0.0), command.frame == BASE)
    kept = state.held if state.held is not None and state.holding == command.flags else g
    error = _error(g, kept, command.frame)
    where = Where(arm, bounds, ahead, command.frame, _astray(bounds, error, command), held)
    task, error = _task(where, state.period), np.where(command.held, error, 0.0)
    # Where what is held has gone astray, the rest waits until it is back.
    asked = asked / (1.0 + (float(np.linalg.norm(_scaled(bounds, error))) / ASTRAY) ** 2)
    asked = asked + _approach(bounds, task, error, None, state.period, dt)
    return Goal(replace(task, asked=asked), where, kept, (0.0, 0.0))


def _task(where: Where, period: float) -> RateTask:
    """Held components first, then linear, then angular ones; nothing asked yet."""
    held = where.held
    others = (tuple(k for k in half if k not in held) for half in (range(3), range(3, 6)))
    levels = tuple(level for level in (held, *others) if level)
    damping = max(where.bounds.damping, STEPS * period)
    J, rows, calm = fixed(where.place(), held, damping)
    return RateTask(np.zeros(6), levels, J, damping, held, rows, calm)


def _astray(bounds: Bounds, error: Array, command: TwistCommand) -> Array | None:
    """−d(error)/dt (6, 6) for scaled twists, where only some of the position or of the orientation are held.

    v + ω × e in the tool's axes, v in the base's; ω by the inverse of the exponential's Jacobian at φ, I ∓ ½ [φ] +
    c [φ]², c = (1 − ½ |φ| cot ½ |φ|) / |φ|². J. Solà et al., arXiv:1812.01537, eq. 144.
    """
    if all(len(set(half)) == 1 for half in (command.held[:3], command.held[3:])):
        return None
    rows, phi, base = np.eye(6), error[3:], command.frame == BASE
    angle, turn = float(np.linalg.norm(phi)), rotations.skew(phi)
    c = (1.0 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2 if angle > 0.01 else 1.0 / 12.0
    rows[:3, 3:] = 0.0 if base else -rotations.skew(error[:3]) / bounds.length
    rows[3:, 3:] += (0.5 if base else -0.5) * turn + c * turn @ turn
    return rows


def _way_left(bounds: Bounds, theta: Array, way: Array) -> float:
    """How far the joints may move along a unit scaled way (n,) before one is at its limit [scaled rad], 1 at most."""
    limits, n = bounds.motion.limits, bounds.n
    room = np.where(way > 0.0, limits.upper[-n:] - theta, theta - limits.lower[-n:])
    counts = np.abs(way) > NO_SHARE
    lengths = np.maximum(room[counts], 0.0) / np.abs(way[counts] * bounds.unit[counts])
    return float(lengths.min(initial=1.0))


def _jacobian(arm: Arm, bounds: Bounds, theta: Array, frame: str) -> Array:
    """The scaled rows (6, n) for scaled rates, in axes of the frame."""
    g, J = arm.fk_and_body_jacobian(theta)
    turned = _in_axes(g[:3, :3], J) if frame == BASE else J
    rows: Array = _scaled(bounds, turned.T).T * bounds.unit
    return rows


def _scaled(bounds: Bounds, twists: ArrayLike) -> Array:
    """Twists (..., 6) with metres measured in `length`."""
    scaled: Array = np.asarray(twists) * np.repeat([1.0 / bounds.length, 1.0], 3)
    return scaled


def _toward(bounds: Bounds, theta: Array) -> Array:
    """The unit scaled way (n,) to the ready pose, tilted a little so that it leads off any singularity."""
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


def _approach(
    bounds: Bounds, task: RateTask, error: Array, command: PoseCommand | None, period: float, dt: float
) -> Array:
    """What to ask for an error (6,): as much of error / dt as lets the arm stop at the goal, straight on.

    At a share s: s p + s² T/2 ≤ p dt, T the time that a stop from the full rates takes, p the period. A command's
    speeds are kept. What is held is taken back in two periods at least, at any dt: a pull that varied with dt would
    shake an arm at rest.
    """
    if np.abs(error).max() <= NOTHING:
        return np.zeros(6)
    asked = _scaled(bounds, error)
    back = replace(task, asked=asked)
    stop = stopping_time(bounds, (taken_back(back) if command is None else resolved_rates(back)[0]) * bounds.unit)
    share = min(1.0, 2.0 * dt / (period + np.sqrt(period * period + 2.0 * stop)))
    if command is None:
        share = min(share, dt / (2.0 * period))
    if command is not None:
        for part, speed in ((error[:3], command.linear_speed), (error[3:], command.angular_speed)):
            share = min(share, speed * dt / max(float(np.linalg.norm(part)), NOTHING))
    approach: Array = share * asked / dt
    return approach


# -- the rates ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Wanted:
    """Joint rates (n,) before acceleration limits, the share of the task that they are for, and what holds them back.

    row: of the bounds' motion, or the joint for Cause.SINGULARITY; −1 for none. beside: what `singular` found.
    """

    rates: Array
    share: float
    cause: Cause
    row: int
    beside: Singular | None = None


def _rates(bounds: Bounds, state: ServoState, goal: Goal, dt: float) -> Wanted:
    task, where, cause, row = goal.task, goal.where, Cause.NONE, -1
    x = resolved_rates(task)[0]
    size = max(float(np.linalg.norm(task.asked)), NOTHING)
    lost = task.asked - task.J @ x
    place = where.place()
    beside = singular(place, task, lost, bounds.singularity_threshold, bounds.stops, goal.steady)
    if beside is not None:
        part, joint = beside.part(lost, bounds.singularity_threshold)
        if part > NOTICED * size * size:
            cause, row = Cause.SINGULARITY, joint
        led = beside.lead(task, bounds.stops)
        beside = beside.taken(place, resolved_rates(led)[0])
        task = beside.lead(task, bounds.stops)
        x = resolved_rates(task)[0]
    share, fastest = velocity_share(bounds, x * bounds.unit)
    calm = _followed(bounds, task, where, None, x) if task.held and _may_bend(bounds, task, x) else 1.0
    if calm < share:
        share = calm
        cause = Cause.SINGULARITY if cause is Cause.NONE and share < 1.0 - NOTICED else cause
    elif share < 1.0:
        cause, row = Cause.VELOCITY, fastest
    wanted = Wanted(share * x * bounds.unit, share, cause, row, beside)
    room = _position_bounds(bounds, state, wanted.rates, dt, gently=bool(task.held))
    inside = (wanted.rates <= room[1] + NOTHING).all() and (wanted.rates >= room[0] - NOTHING).all()
    if share == 1.0 and not bounds.stops and inside:
        return wanted
    velocity = bounds.motion.limits.velocity[-bounds.n :]
    for last in (False,) * (SLOWINGS - 1) + (True,):
        wanted = _within(bounds, task, where, wanted, room, velocity if last else np.full(bounds.n, np.inf))
        slower, fastest = velocity_share(bounds, wanted.rates)
        if slower == 1.0 or last:
            break
        # Others have taken over for the joints at their limits.
        if wanted.cause not in (Cause.LOWER, Cause.UPPER):
            wanted = replace(wanted, cause=Cause.VELOCITY, row=fastest)
        wanted = replace(wanted, share=slower * wanted.share)
    return wanted


def _within(
    bounds: Bounds, task: RateTask, where: Where, wanted: Wanted, room: tuple[Array, Array], velocity: Array
) -> Wanted:
    """The rates for the share of a task within the bounds of each joint, of position (`room`) and of velocity."""
    fastest = bounds.motion.limits.velocity[-bounds.n :]
    task = replace(task, asked=wanted.share * task.asked)
    lower, upper = np.maximum(room[0], -velocity) / bounds.unit, np.minimum(room[1], velocity) / bounds.unit
    x, at = resolved_rates(task, lower, upper)
    end = np.where(at < 0, room[0], room[1])
    size, bounded = float(np.linalg.norm(task.asked)), (at != 0) & (np.abs(end) < fastest)
    left = np.where(bounded, np.abs(end) / bounds.unit, 0.0)
    beyond = np.where(bounded, np.abs(wanted.rates - end) / bounds.unit, 0.0)
    counts = beyond > NOTICED * size
    # Where all stop, it is for the one that has the least way left.
    weight = np.where(counts, beyond / (left + NO_ROOM * size) if bounds.stops else beyond, -1.0)
    worst = int(np.argmax(weight))
    if counts[worst]:
        first = len(bounds.motion.names) - bounds.n
        wanted = replace(wanted, cause=Cause.UPPER if at[worst] > 0 else Cause.LOWER, row=first + worst)
    if bounds.stops:
        x, at = _on_course(bounds, task, where, (lower, upper), x, at)
        # Nobody is at a limit: one would have to be too fast for the course.
        if counts[worst] and left[worst] > NO_ROOM * size and np.linalg.norm(x) <= HALTED * size:
            wanted = replace(wanted, cause=Cause.SINGULARITY, row=worst)
        end = np.where(at < 0, room[0], room[1])
    return replace(wanted, rates=np.where((at != 0) & (np.abs(end) < fastest), end, x * bounds.unit))


def _on_course(
    bounds: Bounds, task: RateTask, where: Where, room: tuple[Array, Array], x: Array, at: Array
) -> tuple[Array, Array]:
    """The rates for the largest share of a task that is done without leaving its course; found by halves."""
    kept, first = 0.0, True
    step = _followed(bounds, task, where, room, x)
    while step > FINEST:
        slower = replace(task, asked=(kept + step) * task.asked)
        x, at = resolved_rates(slower, *room)
        if _keeps_course(slower, x):
            if first:
                return x, at
            kept += step
        step, first = step / 2.0, False
    return resolved_rates(replace(task, asked=kept * task.asked), *room)


def _followed(bounds: Bounds, task: RateTask, where: Where, room: tuple[Array, Array] | None, x: Array) -> float:
    """The share of a task at which the joints can keep to its course.

    With x the rates for all of it and x' how they change on the way, s² x' takes at most a quarter of what accelerates;
    a twelfth where something is held. One round of the solver says whether it may matter.
    """
    size = float(np.linalg.norm(x))
    if size <= NOTHING:
        return 1.0
    ahead = fixed(where.displaced(LOOK_AHEAD / size * x).place(), task.held, task.damping)
    task = replace(task, rows=ahead[1], calm=ahead[2])
    for rounds in (1, ROUNDS):
        then = resolved_rates(task, *(room or (None, None)), start=x, rounds=rounds)[0]
        taken = (12.0 if task.held else 4.0) * _time_to_change(bounds, x, then)
        if ONE_ROUND * taken <= 1.0:
            return 1.0
    return float(1.0 / np.sqrt(max(taken, 1.0)))


def _time_to_change(bounds: Bounds, x: Array, then: Array) -> float:
    """The time [s] that the accelerations take for the change x' of rates x, on the way to `then`."""
    size = float(np.linalg.norm(x))
    # Rates that shrink on the way may stay as they are: the tool speeds up then.
    change = then - x - min(float((then - x) @ x) / size**2, 0.0) * x
    return stopping_time(bounds, change * bounds.unit * size / LOOK_AHEAD)


def _may_bend(bounds: Bounds, task: RateTask, x: Array) -> bool:
    """Whether rates that change by up to |x|² / (3 σ) on the way may take a twelfth of the accelerations."""
    most = 4.0 * float(np.linalg.norm(x)) * stopping_time(bounds, x * bounds.unit)
    return most > 0.0 and most > smallest_about(task.J)


def _keeps_course(task: RateTask, x: Array) -> bool:
    """Whether the tool moves along what is asked at the rates x, if slower, but for a thousandth beside it.

    An arm of fewer than six joints may turn its tool on the way, unless turning is all that is asked.
    """
    count = 6 if len(x) >= 6 or not task.asked[:3].any() else 3
    asked, done = task.asked[:count], (task.rows @ x)[:count]
    along = float(np.clip(done @ asked / max(float(asked @ asked), NOTHING * NOTHING), 0.0, 1.0))
    return bool(np.linalg.norm(done - along * asked) <= OFF_COURSE * np.linalg.norm(asked))


def _position_bounds(
    bounds: Bounds, state: ServoState, rates: Array, dt: float, gently: bool = False
) -> tuple[Array, Array]:
    """The rates (n,) between which a stop that takes twice as long as one from `rates` ends inside the limits.

    To keep to a bound that falls so with the distance takes half of the acceleration, and it falls to 0 in no fewer
    than some periods. `gently` takes twice as long. A joint that is outside may stand still or come back.
    """
    limits, n, theta = bounds.motion.limits, bounds.n, state.theta
    time = max(STEPS * state.period, dt) + (2.0 if gently else 1.0) * stopping_time(bounds, rates)
    most: Array = np.maximum(limits.upper[-n:] - theta, 0.0) / time
    least: Array = -np.maximum(theta - limits.lower[-n:], 0.0) / time
    return least, most


# -- the answer --------------------------------------------------------------------------------------------------------


def _reached(bounds: Bounds, state: ServoState, goal: Goal, wanted: Wanted, dt: float) -> Answer:
    J, asked = goal.task.J, goal.task.asked
    reachable = J @ (wanted.rates / bounds.unit) / wanted.share
    answer = _moved(bounds, state, wanted.rates, dt, wanted.cause, wanted.row)
    done = J @ (answer.theta_dot / bounds.unit)
    size = float(np.linalg.norm(asked))
    answer.scale = _scale(done, reachable, size)
    answer.lost = frozen((asked - reachable) * np.repeat([bounds.length, 1.0], 3))
    answer.lost_share = float(np.linalg.norm(asked - reachable)) / max(size, NOTHING)
    # Arms below six joints turn the tool on their way, and lose turns that they have nowhere.
    lost = asked - reachable if wanted.beside is None else wanted.beside.without_ways_out(asked - reachable)
    astray = np.linalg.norm(lost[: 3 if bounds.n < 6 else 6]) > NOTICED * size
    if answer.cause is Cause.NONE and size > 0.0 and (astray or np.linalg.norm(reachable) <= HALTED * size):
        answer.cause = Cause.SINGULARITY
    answer.held, answer.remaining = goal.held, goal.remaining
    answer.halted = _is_halted(answer.cause, answer.theta_dot / bounds.unit, wanted.share * size)
    return answer


def _jogged(bounds: Bounds, state: ServoState, command: JogCommand, dt: float) -> Answer:
    share, fastest = velocity_share(bounds, command.theta_dot)
    rates = share * command.theta_dot
    cause, row = (Cause.VELOCITY, fastest) if share < 1.0 else (Cause.NONE, -1)
    within = np.clip(rates, *_position_bounds(bounds, state, rates, dt))
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
