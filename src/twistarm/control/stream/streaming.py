"""The loop around the servo. Each cycle takes the command, steps the servo and sends the setpoint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from inspect import signature
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array, as_positive, require, require_callback, require_method
from ...support.errors import InputError, quote
from ..servo import AnyCommand, ServoSettings, servo_step
from .cycles import Cycle, Loop, call_device, run_loop
from .protocols import MESSAGE_TIMEOUT, Clock, Feedback, LoopOptions, Reading, Setpoint, Sink, Source
from .report import Ending, StreamReport

if TYPE_CHECKING:
    from ...collision import Scene

RELEASE_FIRST = "release the controls first: they were held when the arm was enabled"


@dataclass(frozen=True, eq=False)
class StreamOptions(LoopOptions):
    """Options of `run` and `Streaming`: those of `LoopOptions`, and these.

    command_timeout [s]: greatest age of a command.

    settings: those of the servo, or a function of nothing that returns them before every cycle. The stream ends where
    it returns anything else. None: the usual ones.

    scene: the bodies that the servo keeps apart, or None.

    Raises InputError for a number that is not positive, or a value of another type.
    """

    command_timeout: float = MESSAGE_TIMEOUT
    settings: ServoSettings | Callable[[], ServoSettings] | None = None
    scene: Scene | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "command_timeout", as_positive(self.command_timeout, "command_timeout"))


USUAL = StreamOptions()


class Streaming(Loop[Cycle]):
    """A stream, cycle by cycle (see `Loop`), for loops with a timer. The arguments are those of `run`."""

    def __init__(
        self, arm: Arm, source: Source, sink: Sink, feedback: Feedback, options: StreamOptions = USUAL
    ) -> None:
        require(options, StreamOptions, "options", "as StreamOptions() is")
        self._current = _current(options.settings)
        super().__init__(arm, sink, feedback, options, self._current())
        self.source = require_method(source, "source", "read")
        self.scene, self.command_timeout = options.scene, options.command_timeout
        if self.scene is not None:
            from ...collision import require_scene

            require_scene(self.scene, self.arm).near_pairs  # noqa: B018  (what takes long is done before the loop)
        self._interlock(self.source)
        # A command from before the arm was enabled moves nothing until the controls were released once.
        self._await_release = not self.interlock.allows_motion

    def _events(self, now: float) -> Cycle:
        self.settings = call_device(Ending.SERVO_FAILED, self._current)
        theta, blind = self._measure(now)
        reading = call_device(Ending.SOURCE_FAILED, self.source.read, now, self.state)
        command, uncommanded = self._command(reading)
        barred = self.interlock.barrier
        self._await_release = (self._await_release or bool(barred)) and _asks_for_motion(command)
        if self._await_release:
            command, uncommanded = None, RELEASE_FIRST
        if self.state is None:
            return self._record(now, blind, reading=reading)
        strayed = "" if theta is None else self._watch.deviation(theta)
        if barred:
            command, uncommanded = None, ""
        self.tally.count(blind=blind, uncommanded=uncommanded, barred=barred)
        reason = strayed or barred or blind or self._time_fault(now) or uncommanded
        command = None if reason else command
        if theta is not None and not strayed and self.at_rest:
            self._while_at_rest(theta, now, command)
        else:
            self._watch.rest(None, now)
        setpoint = self._step(command, now, reason)
        undelivered = self._send(setpoint)
        why = "; ".join(filter(None, (reason, undelivered)))
        ending = Ending.STRAYED if strayed else None
        return Cycle(now, reading, theta, setpoint, why, ending, not undelivered, setpoint.interlock)

    def _record(self, now: float, reason: str, ending: Ending | None = None, reading: Reading | None = None) -> Cycle:
        return Cycle(now, reading, None, None, reason, ending, interlock=self.interlock.word)

    def _starts(self, theta: Array) -> bool:
        # Others may have moved an arm that rested unseen.
        return super()._starts(theta) or (self._watch.returned and self.at_rest)

    def _while_at_rest(self, theta: Array, now: float, command: AnyCommand | None) -> None:
        """Start the next motion where the arm is, if others have moved it at rest. So it does not jump back.

        In velocity mode an arm without a command always restarts: only motion needs corrections.
        """
        assert self.state is not None
        distance = theta - self.state.theta
        if _asks_for_motion(command):
            if self._watch.moved_by_others(distance):
                self._start(theta, now)
            self._watch.rest(None, now)
        elif self._watch.rest(distance, now) and self.velocity_mode and command is None:
            self._start(theta, now)
            self._watch.follow(theta, now)

    def _command(self, reading: Reading) -> tuple[AnyCommand | None, str]:
        if reading.command is None:
            return None, reading.reason or "no command"
        if not abs(reading.age) <= self.command_timeout:  # below 0: it came while the loop waited for its turn
            return None, f"the command is {reading.age:.3g} s old (timeout {self.command_timeout:g} s)"
        return reading.command, ""

    def _step(self, command: AnyCommand | None, now: float, reason: str) -> Setpoint:
        if command is None:
            return self._braked(now, reason)
        assert self.state is not None  # a step needs a state, and its caller has checked that
        dt = self._elapsed(now)
        state, output = servo_step(
            self._commanded_arm, self.state, command, dt, settings=self.settings, scene=self.scene
        )
        return self._moved(state, output, now, follow=True)


def _asks_for_motion(command: Any) -> bool:
    """Whether the controls are held: any command but a twist or a jog of zeros."""
    return command is not None and not np.array_equiv(getattr(command, "numbers", command), 0.0)


def run(
    arm: Arm,
    source: Source,
    sink: Sink,
    feedback: Feedback,
    options: StreamOptions = USUAL,
    *,
    handle_signals: bool = True,
    duration: float | None = None,
    until: Callable[[], bool] | None = None,
    on_cycle: Callable[[Cycle], object] | None = None,
    clock: Clock | None = None,
) -> StreamReport:
    """Stream `source`'s commands through the servo to `sink` until something ends it.

    Missing velocity and acceleration limits are assumed (1 rad/s, 3 rad/s²; 0.25 m/s, 1 m/s²). The report says so.

    The servo waits for the first joint state of `feedback` and starts there. A command is valid for `command_timeout`
    [s]. Commands are ignored while the joint state is older than `feedback_timeout` [s]. They are also ignored after a
    cycle later than the servo's longest step. The arm then stops within its acceleration limits, and continues when all
    is well. If it came to rest without a joint state, it restarts at the measured position.

    A joint may be `tolerance` (one number or (n,)) [rad, m] from all setpoints of the last `feedback_timeout`. One that
    is farther ends the stream. So does a start farther beyond a position limit, as of joint states in degrees. If
    others move the resting arm by more than 0.01 rad or m, the next motion begins there.

    While `interlock` forbids motion, the arm comes to rest and waits. Each cycle, each setpoint and the report have its
    word. After it is enabled, the controls must be released first: a cycle without a motion.

    Robots that accept only rates receive the servo's, plus a correction toward the servo's position. A filter learns
    each drive's gain and delay (`RateObserver`). The servo reserves 15 % of the velocity and 10 % of the acceleration
    limits for it. Without a command nothing is corrected. At rest the servo restarts at the measured position.

    At every end the arm stops within its limits: time, Ctrl-C, a failing device, an exception of `on_cycle`. The last
    setpoint has zero rates. A second Ctrl-C stops at once. The report has the errors of devices (OSError,
    TwistarmError). Other exceptions are raised at the end. An undelivered setpoint (`UndeliveredError`) is counted and
    ends nothing.

    Args:
        arm: The arm.
        source: Where commands come from.
        sink: Where setpoints go.
        feedback: Where the joint state comes from.
        options: Rate, timeouts, tolerance, velocity mode, interlock, the servo's settings and its scene.
        handle_signals: Whether SIGTERM and SIGHUP end the stream as Ctrl-C does. This works in the main thread, and if
            the program has no handler. On return the old effect is back.
        duration: Greatest duration [s]; None for no limit.
        until: A function that returns True to end the stream, or None.
        on_cycle: Called with each `Cycle` between its setpoint and the next, or None. It must be quick.
        clock: The clock, by default the system's monotonic one.

    Returns:
        The `StreamReport`: cycles, jitter, stale inputs, failures, and how the stream ended.

    Raises:
        InputError: A rate, timeout, tolerance or duration is not positive. Or the settings have another type, or a
            period exceeds the servo's longest step.
    """
    require_callback(until, "until", "nothing")
    require_callback(on_cycle, "on_cycle", "a Cycle")
    longest = inf if duration is None else as_positive(duration, "duration")
    streaming = Streaming(arm, source, sink, feedback, options)
    return run_loop(
        streaming, clock=clock, handle_signals=handle_signals, on_cycle=on_cycle, longest=longest, until=until
    )


def _current(settings: ServoSettings | Callable[[], ServoSettings] | None) -> Callable[[], ServoSettings]:
    """A function for the present settings, which raises InputError if they are invalid."""
    how = "as ServoSettings() is, or a function of nothing that returns one"
    if not callable(settings):
        given = ServoSettings() if settings is None else settings
        return lambda: require(given, ServoSettings, "settings", how)
    try:
        signature(settings).bind()
    except (TypeError, ValueError):  # it takes arguments, or nobody can tell
        raise InputError(f"settings must be a ServoSettings, {how}; got {quote(settings)}") from None
    return lambda: require(settings(), ServoSettings, "settings", how)
