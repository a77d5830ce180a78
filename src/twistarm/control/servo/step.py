"""`servo_step`: one pure step from a state and a command to the next state and joint rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...arm.arm import Arm, require_arm
from ...arm.engine import answered
from ...support.checks import Array, as_pose, as_theta, frozen, require, require_one
from ...support.display import Brief
from ...support.errors import InputError, quote
from .command import AnyCommand, CommandLike, JogCommand, PoseCommand, TwistCommand
from .output import REASON_OF_CAUSE, CoreStep, ServoOutput, ServoReason, StepRequest, output_of
from .settings import ServoBounds, ServoSettings, bounds_of

if TYPE_CHECKING:
    from ...collision import Contact, Scene
    from ...collision.near_pairs import Near, NearPairs

COMMANDS = (TwistCommand, JogCommand, PoseCommand)
_DEFAULT = ServoSettings()

MAX_VALUE = 1e6  # Greatest position and rate [rad, m, per s].


@dataclass(frozen=True, eq=False, repr=False)
class ServoState(Brief):
    """The commanded arm: theta (n,) [rad, m], its rates theta_dot (n,), and the held pose.

    theta integrates the commands and never the measurements, so noise cannot make it drift. `held_pose` (4, 4) is the
    pose with held components, or None. `held_flags` are those of the command that holds them. `period` [s] is a slow
    mean of the steps, 0 before the first.
    """

    theta: Array
    theta_dot: Array
    held_pose: Array | None = None
    held_flags: int | None = None
    period: float = 0.0

    @classmethod
    def at(cls, arm: Arm, theta: ArrayLike) -> ServoState:
        """At rest at the measured theta (n,). Raises InputError for anything but n finite numbers.

        Args:
            arm: The arm.
            theta: The measured configuration (n,) [rad, m].
        """
        return cls.moving(arm, require_arm(arm).theta_from(theta), np.zeros(arm.n))

    @classmethod
    def moving(cls, arm: Arm, theta: ArrayLike, theta_dot: ArrayLike) -> ServoState:
        """At the measured theta (n,), moving at theta_dot (n,). Raises InputError for anything but finite numbers.

        Args:
            arm: The arm.
            theta: The measured configuration (n,) [rad, m].
            theta_dot: The measured rates (n,) [rad/s, m/s].
        """
        require_arm(arm)
        values = {"theta": theta, "theta_dot": theta_dot}
        checked = {name: as_theta(value, arm.n, name, arm.joint_names) for name, value in values.items()}
        for name, value in checked.items():
            if value.ndim != 1:
                raise InputError(f"{name} must be one configuration, shape ({arm.n},); got {value.shape}")
            if np.abs(value).max(initial=0.0) > MAX_VALUE:
                raise InputError(f"{name} must be at most {MAX_VALUE:g} in size; got {np.abs(value).max():g}")
        return cls(frozen(checked["theta"]), frozen(checked["theta_dot"]))


def servo_step(
    arm: Arm,
    state: ServoState,
    command: CommandLike,
    dt: float,
    *,
    settings: ServoSettings = _DEFAULT,
    scene: Scene | None = None,
) -> tuple[ServoState, ServoOutput]:
    """One step of the servo: the state after `dt` [s] of `command`, and its joint rates.

    An unusable command raises no error, because a loop that raises loses the arm. The arm stops within its acceleration
    limits. The reason is STALE and `explain` says why. A state that is not finite, or a dt outside (0,
    settings.max_dt], gives STALE and zero rates.

    The rates minimise a strictly convex function, continuous in configuration and command (docs/servo.md). Away from
    singularities a twist is exact. If the arm lacks directions (below six joints, at a limit), held components come
    first. The linear part is next, the angular part last. The rest is lost and reported. Near a singularity the law
    damps fast directions only on the way in. Velocity and acceleration limits of joints and motors slow the motion as a
    whole. A joint slows down toward its position limit. The others continue, or all stop on the course
    (settings.on_unreachable).

    A missing limit is no limit. Without acceleration limits rates jump; without velocity limits they follow the
    command. `stream.run` assumes limits there.

    Args:
        arm: The arm.
        state: The state before the step; `ServoState.at(arm, theta)` makes the first one.
        command: A `TwistCommand`, `JogCommand`, `PoseCommand` or None. Six numbers are a twist (v, w) [m/s, rad/s] in
            tool axes.
        dt: The length of the step [s], in (0, settings.max_dt].
        settings: Margins, thresholds and the length that compares metres with radians.
        scene: Keeps the pairs of bodies of a scene apart (docs/servo.md); None to check nothing.

    Returns:
        The state after the step and the `ServoOutput`: rates (n,) [rad/s, m/s], status, reason and loss.

    Raises:
        InputError: The arm, state, settings or scene is of another type, or the scene is of another arm.
        TwistarmError: There is no compiled core, or the arm has more than 64 joints or motors.
    """
    require(state, ServoState, "state", "as ServoState.at(arm, theta) makes it")
    bounds = bounds_of(require_arm(arm), require(settings, ServoSettings, "settings", "as ServoSettings() is"))
    if scene is not None:
        from ...collision import require_scene  # late, because it imports much

        require_scene(scene, arm)
    step = _seconds(dt)
    if not 0.0 < step <= settings.max_dt:
        return _refused(arm, state, f"dt must be more than 0 and at most {settings.max_dt:g} s; got {quote(dt)}")
    checked, reason = _usable(arm, command)

    def solve(command: AnyCommand | None, near: Array | None = None) -> CoreStep:
        return _core_step(arm, bounds, state, command, step, near)

    contact = None
    try:
        if scene is None or checked is None:
            answer = solve(checked)
        else:
            answer, contact = avoid_collisions(
                lambda near: solve(checked, near), lambda: solve(None), state.theta, step, bounds, scene
            )
    except InputError as error:
        return _refused(arm, state, f"the state cannot be used: {error}")
    after = ServoState(answer.theta, answer.theta_dot, answer.held_pose, _held_flags(checked), answer.period)
    if checked is None:
        return after, ServoOutput.stale(after.theta_dot, reason)
    return after, output_of(answer, bounds, StepRequest(arm, state.theta, checked, bounds.stops), contact)


def _seconds(dt: Any) -> float:
    try:
        return float(dt)
    except Exception:  # an object's own __float__ may raise anything
        return np.nan


def _usable(arm: Arm, command: Any) -> tuple[AnyCommand | None, str]:
    if command is None:
        return None, "no command"
    try:
        if not isinstance(command, COMMANDS):
            command = TwistCommand(command)
        if command.kind == JogCommand.kind and command.numbers.shape != (arm.n,):
            raise InputError(f"a jog of {arm.name} has {arm.n} rates; got {command.numbers.size}")
    except InputError as error:
        return None, str(error)
    return command, ""


def _core_step(
    arm: Arm, bounds: ServoBounds, state: ServoState, command: AnyCommand | None, dt: float, near: Array | None
) -> CoreStep:
    step, held = bounds.compiled.step, _held_flags(command)
    holds_on = held is not None and type(state.held_flags) is int and state.held_flags == held
    pose = state.held_pose if holds_on else None
    kind, flags, numbers = (0, 0, None) if command is None else (command.kind, command.flags, command.numbers)
    found = None
    if type(state.period) is float:  # the core's binding raises TypeError for what is no number
        found = step(state.theta, state.theta_dot, pose, kind, flags, numbers, dt, state.period, near)
    if found is None:  # see `arm.engine`
        clean = _clean(arm, state)
        pose = None if pose is None else clean.held_pose
        found = answered(step(clean.theta, clean.theta_dot, pose, kind, flags, numbers, dt, clean.period, near))
    return CoreStep(*found)


def _clean(arm: Arm, state: ServoState) -> ServoState:
    """The state as plain arrays; InputError for one that cannot be used."""
    plain = ServoState.moving(arm, state.theta, state.theta_dot)
    held = state.held_pose
    pose = None if held is None else frozen(require_one(as_pose(held, "held_pose"), "held_pose", 2))
    period = _seconds(state.period)
    if not 0.0 <= period <= MAX_VALUE:
        raise InputError(f"period must be a time from 0 to {MAX_VALUE:g} s; got {quote(state.period)}")
    return ServoState(plain.theta, plain.theta_dot, pose, state.held_flags, period)


def _held_flags(command: AnyCommand | None) -> int | None:
    """The flags of the held components; None without any."""
    return command.flags if command is not None and command.flags > 1 else None


def _refused(arm: Arm, state: ServoState, reason: str) -> tuple[ServoState, ServoOutput]:
    still = frozen(np.zeros(arm.n))
    return ServoState(state.theta, still, period=state.period), ServoOutput.stale(still, reason)


Solve = Callable[[Array | None], CoreStep]

COLLISION = REASON_OF_CAUSE.index(ServoReason.COLLISION)

SPARE = 3e-4  # The servo aims at so much more than the margin [m], for what a linear step cannot see.
ROUNDING = 1e-6  # How far [m] below its margin a pair may come by rounding.
UNSEEN = 5e-5  # Pairs that come nearer than their aim by more [m] were not seen by the rows before.
# The first rows, how often others are added, and the share of the push of the first that others take.
FIRST_ROWS, MOST_ROUNDS, OTHERS_SHARE = 8, 4, 0.1


def avoid_collisions(
    solve: Solve, rest: Callable[[], CoreStep], start: ArrayLike, dt: float, bounds: ServoBounds, scene: Scene
) -> tuple[CoreStep, Contact | None]:
    """The answer of a step from `start` (n,) that brings no pair nearer than its margin, and the pair in the way.

    `solve` steps with rows (k, n + 2) of near pairs or None, `rest` steps toward rest. A pair that is nearer than its
    margin already comes no nearer. Near pairs are measured after the step, and after a straight stop from there. A pair
    that would come too near becomes another row, and the step is made anew. If that does not suffice, the arm comes to
    rest.
    """
    pairs, answer = scene.near_pairs, solve(None)  # which raises an error for a state that cannot be used
    theta = np.asarray(start, dtype=np.float64)
    # The law slows a pair that has less room than a stop in twice its time takes.
    time = 3.0 * answer.period + 2.0 * bounds.stopping_time(answer.theta_dot)
    near = pairs.near(theta, np.abs(time * answer.theta_dot), FIRST_ROWS)
    owner = near.closest
    if not len(owner):
        return answer, None
    margins, speeds = pairs.least.take(near.pairs), pairs.speeds.take(near.pairs, axis=0)
    watch = _Watch(pairs, near, margins, speeds, theta, dt, dt / time)
    rows = _rows(near.approach, _unpushed(near.distances[owner] - margins[owner] - SPARE), 0.0)
    for rounds in range(MOST_ROUNDS + 1):
        answer = solve(rows)
        found = watch.too_near(answer.theta_dot, bounds.stopping_time(answer.theta_dot), unpushed=rounds > 1)
        if found is None:
            break
        if rounds == MOST_ROUNDS:
            below = found.there.min(axis=0) - np.minimum(near.distances, margins)[found.risky] + ROUNDING
            if below.min() < 0.0:
                still = rest()
                halted, owner = not still.theta_dot.any(), found.risky[[below.argmin()]]
                answer = still._replace(cause=COLLISION, row=0, scale=0.0, halted=halted, held_pose=answer.held_pose)
            break
        for at, unseen in zip(found.times, found.there < found.aim - ROUNDING, strict=True):
            if unseen.any():
                new = found.risky[unseen]
                distances, approach = pairs.measured(theta + at * answer.theta_dot, near.pairs[new])
                left = distances - found.aim[unseen] + at * approach @ answer.theta_dot
                rows, owner = np.concatenate([_rows(approach, left, at), rows]), np.concatenate([new, owner])
        if rounds:  # what pushes against each other is no longer pushed
            rows[:, -2] = np.maximum(rows[:, -2], 0.0)
    if answer.cause != COLLISION:
        return answer, None
    from ...collision import Contact  # late, because it imports much

    k = owner[answer.row]
    first, second = (pairs.bodies[body].name for body in pairs.body_pairs[near.pairs[k]])
    return answer, Contact((first, second), float(near.distances[k]), float(margins[k]))


class _TooNear(NamedTuple):
    """Pairs `risky` (k,), their distances `there` (times, k), and their `aim` (k,), which some come below."""

    risky: NDArray[np.intp]
    aim: Array
    times: tuple[float, ...]
    there: Array


class _Watch(NamedTuple):
    """The near pairs of a step from `theta` (n,), their margins (k,), and speeds (k, n). `share` is as in `_aim`."""

    pairs: NearPairs
    near: Near
    margins: Array
    speeds: Array
    theta: Array
    dt: float
    share: float

    def too_near(self, theta_dot: Array, stopping_time: float, *, unpushed: bool) -> _TooNear | None:
        """The pairs that come too near in a step with these rates (n,) and a stop after it; None without any."""
        near, time_to_rest = self.near, self.dt + 0.5 * stopping_time
        lost = self.speeds @ np.abs(time_to_rest * theta_dot)
        if (near.distances - lost >= self.margins + SPARE).all():  # an aim is less
            return None
        while True:
            aim = _aim(near.distances, self.margins, self.share, unpushed)
            risky = np.flatnonzero(near.distances - lost < aim - ROUNDING)
            if not near.measure(risky):
                break
        if not len(risky):
            return None
        # Where it is after the step, on its way to a stop and after it.
        times = self.dt, 0.5 * (self.dt + time_to_rest), time_to_rest
        enough = aim[risky] - ROUNDING
        there = near.distances[risky] - np.array(times)[:, None] * (lost[risky] / time_to_rest)
        maybe = there < enough
        for row in np.flatnonzero(maybe.any(axis=1)).tolist():
            where = near.pairs[risky[maybe[row]]]
            there[row, maybe[row]] = self.pairs.distances_of(self.theta + times[row] * theta_dot, where)
        return _TooNear(risky, aim[risky], times, there) if (there < enough).any() else None


def _aim(distances: Array, margins: Array, share: float, unpushed: bool) -> Array:
    """How near [m] each pair may come in a step. `share`: its part of the law's time."""
    room = _unpushed(distances - margins - SPARE)
    aim: Array = np.minimum(distances - OTHERS_SHARE * share * np.minimum(room, 0.0), margins + SPARE - UNSEEN)
    return np.minimum(aim, distances) if unpushed else aim


def _unpushed(room: Array) -> Array:
    """The room (k,) of pairs without a push, because the rounds leave them there.

    Another corner of flat bodies leaves with the first.
    """
    return np.maximum(room, np.minimum(np.maximum(room + UNSEEN, -SPARE), 0.0))


def _rows(approach: Array, room: Array, time: float) -> Array:
    """Rows (k, n + 2) for the law: a pair takes its room within `time` [s]. One without room moves apart slowly."""
    rows = np.empty((len(room), approach.shape[1] + 2))
    rows[:, :-2], rows[:, -2], rows[:, -1] = approach, np.maximum(room, -SPARE), time
    return rows
