"""The loop around the servo on a clock: commands in, setpoints out, until it ends."""

from __future__ import annotations

from collections.abc import Callable
from inspect import signature
from math import inf

from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...support.checks import as_positive, require, require_callback
from ...support.errors import InputError, shown
from ..servo import ServoSettings
from .cycles import Cycle
from .driving import drive
from .failures import call_device
from .interlock import Interlock
from .links.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from .protocols import Clock, Feedback, Sink, Source
from .report import Ending, StreamReport
from .streaming import TOLERANCE, Streaming


def run(
    arm: Arm,
    source: Source,
    sink: Sink,
    feedback: Feedback,
    *,
    rate: float = 100.0,
    command_timeout: float = COMMAND_TIMEOUT,
    feedback_timeout: float = FEEDBACK_TIMEOUT,
    tolerance: ArrayLike = TOLERANCE,
    settings: ServoSettings | Callable[[], ServoSettings] | None = None,
    velocity_mode: bool = False,
    interlock: Interlock | None = None,
    handle_signals: bool = True,
    duration: float | None = None,
    until: Callable[[], bool] | None = None,
    on_cycle: Callable[[Cycle], object] | None = None,
    clock: Clock | None = None,
) -> StreamReport:
    """Stream `source`'s commands through the servo to `sink` at `rate` [Hz] until something ends it.

    Missing velocity and acceleration limits are assumed (1 rad/s, 3 rad/s²; 0.25 m/s, 1 m/s²), and the report says so.

    The servo waits for the first joint state of `feedback` and starts there. A command is valid for `command_timeout`
    [s]. No command counts while the joint state is older than `feedback_timeout` [s] or after a cycle later than the
    servo's longest step. The arm then comes to rest within its acceleration limits and continues when all is well. If
    it came to rest without a joint state, it restarts at the measured position.

    A joint farther than `tolerance` (one number or (n,)) [rad, m] from all setpoints within the last `feedback_timeout`
    ends the stream. While `interlock` forbids motion, the arm comes to rest and waits. Each cycle, each setpoint and
    the report have its word. After it is enabled, the controls must be released first: a cycle without a command, or
    with a zero twist or jog.

    Robots that accept only rates receive the servo's rates plus a correction toward the servo's position. A filter
    learns each drive's gain and delay (`RateObserver`). The servo reserves 15 % of the velocity and 10 % of the
    acceleration limits for it. Without a command nothing is corrected, and at rest the servo restarts at the measured
    position.

    At every end (time, Ctrl-C, a failing device, an exception of `on_cycle`) the arm comes to rest within its limits,
    and the last setpoint has zero rates. A second Ctrl-C stops at once. The report has the errors of devices (OSError,
    TwistarmError); other exceptions are raised at the end. An undelivered setpoint (`UndeliveredError`) is counted and
    ends nothing.

    Args:
        arm: The arm.
        source: Where commands come from.
        sink: Where setpoints go.
        feedback: Where the joint state comes from.
        rate: Cycles per second [Hz].
        command_timeout: Greatest age of a command [s].
        feedback_timeout: Greatest age of the joint state [s].
        tolerance: Greatest distance of a joint from what was commanded, one number or (n,) [rad, m].
        settings: Settings of the servo, or a function of nothing that returns them before every cycle, and ends the
            stream where it returns anything else; None for the usual ones.
        velocity_mode: Whether the robot takes rates alone.
        interlock: The switch that allows motion, or None.
        handle_signals: Whether SIGTERM and SIGHUP end the stream as Ctrl-C does, in the main thread and where the
            program has no handler of its own; they have their usual effect again once it has returned.
        duration: Greatest duration [s]; None for no limit.
        until: A function whose true result ends the stream, or None.
        on_cycle: Called with each `Cycle` between its setpoint and the next one, or None; it must be quick.
        clock: The clock, by default the system's monotonic one.

    Returns:
        The `StreamReport`: cycles, jitter, stale inputs, failures, and how the stream ended.

    Raises:
        InputError: A rate, timeout, tolerance or duration is not positive, the settings are of another type, or a
            period is longer than the servo's longest step.
    """
    require_callback(until, "until", "nothing")
    require_callback(on_cycle, "on_cycle", "a Cycle")
    longest = inf if duration is None else as_positive(duration, "duration")
    current = _current(settings)
    streaming = Streaming(
        arm, source, sink, feedback, rate=rate, command_timeout=command_timeout, feedback_timeout=feedback_timeout,
        tolerance=tolerance, settings=current(), velocity_mode=velocity_mode, interlock=interlock,
    )  # fmt: skip

    def take_settings() -> None:
        streaming.settings = call_device(Ending.SERVO_FAILED, current)

    return drive(
        streaming, clock=clock, handle_signals=handle_signals, on_cycle=on_cycle, longest=longest, until=until,
        before=take_settings,
    )  # fmt: skip


def _current(settings: ServoSettings | Callable[[], ServoSettings] | None) -> Callable[[], ServoSettings]:
    """A function for the present settings, which raises InputError if they are invalid."""
    how = "as ServoSettings() is, or a function of nothing that returns one"
    if not callable(settings):
        given = ServoSettings() if settings is None else settings
        return lambda: require(given, ServoSettings, "settings", how)
    try:
        signature(settings).bind()
    except (TypeError, ValueError):  # it takes arguments, or nobody can tell
        raise InputError(f"settings must be a ServoSettings, {how}; got {shown(settings)}") from None
    return lambda: require(settings(), ServoSettings, "settings", how)
