"""`servo_step`: one pure step from a command to joint rates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ...arm.arm import Arm, require_arm
from ...support.checks import Array, as_pose, frozen, require
from ...support.errors import InputError, shown
from .bounds import ServoBounds, bounds_of
from .command import AnyCommand, CommandLike, JogCommand, PoseCommand, TwistCommand
from .core_step import OF_CAUSE, CoreStep
from .output import ServoOutput, StepRequest
from .settings import ServoSettings
from .state import MAX_VALUE, ServoState

if TYPE_CHECKING:
    from ...collision import Contact, Scene

COMMANDS = (TwistCommand, JogCommand, PoseCommand)
_DEFAULT = ServoSettings()


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
    limits. The reason is STALE and `explain` says why. A dt outside (0, settings.max_dt], or a state that is not
    finite, gives STALE and zero rates at once.

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
        InputError: The arm, the state, the settings or the scene are of another type, or the scene is of another arm.
        TwistarmError: There is no compiled core, or the arm has more than 32 joints or motors.
    """
    require(state, ServoState, "state", "as ServoState.at(arm, theta) makes it")
    bounds = bounds_of(require_arm(arm), require(settings, ServoSettings, "settings", "as ServoSettings() is"))
    if scene is not None:
        from ...collision import require_scene  # late, because it imports much

        require_scene(scene, arm)
    step = _seconds(dt)
    if not 0.0 < step <= settings.max_dt:
        return _refused(arm, state, f"dt must be more than 0 and at most {settings.max_dt:g} s; got {shown(dt)}")
    checked, reason = _usable(arm, command)
    contact = None
    try:
        if scene is None or checked is None:
            answer = _answer(arm, bounds, state, checked, step)
        else:
            answer, contact = _apart(arm, bounds, state, checked, step, scene)
    except InputError as error:
        return _refused(arm, state, f"the state cannot be used: {error}")
    after = ServoState(answer.theta, answer.theta_dot, answer.held, _holding(checked), answer.period)
    if checked is None:
        return after, ServoOutput.stale(after.theta_dot, reason)
    return after, ServoOutput.of(answer, bounds, StepRequest(arm, state.theta, checked, bounds.stops), contact)


def _apart(
    arm: Arm, bounds: ServoBounds, state: ServoState, command: AnyCommand, dt: float, scene: Scene
) -> tuple[CoreStep, Contact | None]:
    """The answer that keeps the bodies of a scene apart, and the pair that holds the arm."""
    from .apart import apart

    def ask(near: Array | None) -> CoreStep:
        return _answer(arm, bounds, state, command, dt, near)

    return apart(ask, lambda: _answer(arm, bounds, state, None, dt), state.theta, dt, bounds, scene)


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


def _answer(
    arm: Arm, bounds: ServoBounds, state: ServoState, command: AnyCommand | None, dt: float, near: Array | None = None
) -> CoreStep:
    holding = _holding(command)
    held = state.held if holding is not None and type(state.holding) is int and state.holding == holding else None
    kind, flags, numbers = (0, 0, None) if command is None else (command.kind, command.flags, command.numbers)
    found = None
    if type(state.period) is float:
        found = bounds.compiled.step(state.theta, state.theta_dot, held, kind, flags, numbers, dt, state.period, near)
    if found is None:  # not plain float64: converted, or refused
        clean = _clean(arm, state)
        held = None if held is None else clean.held
        found = bounds.compiled.step(clean.theta, clean.theta_dot, held, kind, flags, numbers, dt, clean.period, near)
        assert found is not None, "what was refused has been cleaned"
    theta, theta_dot, kept, cause, row, scale, lost, lost_share, halted, position, angle, period = found
    remaining = position, angle
    return CoreStep(theta, theta_dot, OF_CAUSE[cause], row, scale, lost, lost_share, kept, halted, remaining, period)


def _clean(arm: Arm, state: ServoState) -> ServoState:
    """The state as plain arrays; InputError for one that cannot be used."""
    plain = ServoState.moving(arm, state.theta, state.theta_dot)
    held = None if state.held is None else frozen(as_pose(state.held, "held"))
    if held is not None and held.shape != (4, 4):
        raise InputError(f"held must be one pose, shape (4, 4); got {held.shape}")
    period = _seconds(state.period)
    if not 0.0 <= period <= MAX_VALUE:
        raise InputError(f"period must be a time from 0 to {MAX_VALUE:g} s; got {shown(state.period)}")
    return ServoState(plain.theta, plain.theta_dot, held, state.holding, period)


def _holding(command: AnyCommand | None) -> int | None:
    """The flags of the held components; None without any."""
    return command.flags if command is not None and command.flags > 1 else None


def _refused(arm: Arm, state: ServoState, reason: str) -> tuple[ServoState, ServoOutput]:
    still = frozen(np.zeros(arm.n))
    return ServoState(state.theta, still, period=state.period), ServoOutput.stale(still, reason)
