"""The cycle that all loops share, on a grid of times: read the joints, send a setpoint, come to rest."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from math import floor, inf
from typing import Generic, ParamSpec, TypeVar

import numpy as np

from ...arm.arm import Arm, require_arm
from ...arm.usual_limits import defaults_line, usually_limited
from ...support.checks import LARGEST_ARRAY, Array, as_flag, as_positive, as_whole, frozen, require, require_method
from ...support.display import Brief
from ...support.errors import InputError, TwistarmError, quote
from ...support.interrupts import ended_like_ctrl_c
from ..servo import ServoOutput, ServoSettings, ServoState, servo_step
from .drives import RateObserver, with_reserve
from .protocols import (
    ENABLED,
    LATEST,
    Clock,
    Feedback,
    Interlock,
    Interlocked,
    LoopOptions,
    MonotonicClock,
    Reading,
    Setpoint,
    Sink,
    UndeliveredError,
    require_time,
)
from .report import Ending, FeedbackWatch, StreamReport, Tally, with_counts

ROUNDING = 1e-6  # Part of a period that is rounding.
BRAKING_SPARE = 0.5  # Extra seconds for braking, beyond twice velocity over acceleration.


@dataclass(frozen=True, eq=False, repr=False)
class Cycle(Brief):
    """The events of one cycle.

    theta (n,): the usable joint state. setpoint: the computed one, None before the first joint state. reason: why there
    was no command, or why the setpoint was not delivered (`delivered`). ending: why the stream ends, or None.
    interlock: the word of the `Interlock`.
    """

    time: float
    reading: Reading | None
    theta: Array | None
    setpoint: Setpoint | None
    reason: str = ""
    ending: Ending | None = None
    delivered: bool = True
    interlock: str = ENABLED


P = ParamSpec("P")
T = TypeVar("T")
C = TypeVar("C", bound=Cycle)


class StreamError(Exception):
    """The stream ends with `ending`, because of what the text says."""

    def __init__(self, ending: Ending, reason: str) -> None:
        super().__init__(reason)
        self.ending, self.reason = ending, reason


def call_device(ending: Ending, call: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """What a device answers; `StreamError` where it says that it cannot."""
    try:
        return call(*args, **kwargs)
    except (OSError, TwistarmError) as error:
        raise StreamError(ending, _as_reason(error)) from error


def _as_reason(error: Exception) -> str:
    """An error as a reason. Errors of other programs are named with their type."""
    if isinstance(error, StreamError):
        return error.reason
    return error.message if isinstance(error, TwistarmError) else f"{type(error).__name__}: {error}"


class Loop(ABC, Generic[C]):
    """A loop, cycle by cycle, for programs with a timer.

    Call `cycle` at `rate` [Hz] until it returns an ending. Then call `brake` at the same rate until it returns True.
    Finally call `halt` in any case. `arm` has assumed limits where the given one has none; `assumed` lists them.
    """

    def __init__(self, arm: Arm, sink: Sink, feedback: Feedback, options: LoopOptions, settings: ServoSettings) -> None:
        require(options, LoopOptions, "options", "as StreamOptions() is")
        self.assumed = defaults_line(require_arm(arm))
        self.arm = usually_limited(arm)
        self.sink = require_method(sink, "sink", "write")
        self.feedback = require_method(feedback, "feedback", "read")
        self.settings = require(settings, ServoSettings, "settings", "as ServoSettings() is")
        self.rate = checked_rate(options.rate, self.settings)
        self.period = 1.0 / self.rate
        self.feedback_timeout, self.velocity_mode = options.feedback_timeout, options.velocity_mode
        self.interlock = Interlock() if options.interlock is None else options.interlock
        self._interlock(self.feedback)
        self.state: ServoState | None = None
        self.tally = Tally(rate=self.rate, assumed=self.assumed)
        self._watch = FeedbackWatch(arm, self.feedback_timeout, options.tolerance)
        self._commanded_arm = with_reserve(self.arm) if self.velocity_mode else self.arm
        self._observer = RateObserver(self.arm) if self.velocity_mode else None
        self._number = 0
        self._stepped: float | None = None  # when the last step was made [s]

    def cycle(self, now: float, periods: int = 1) -> C:
        """One cycle: read the joints, take the command, step the servo, write the setpoint.

        A failing device, or a setpoint that is not finite, is an ending and raises nothing. Such a setpoint is not
        sent. Other exceptions are errors of a program.

        Args:
            now: The clock's time [s].
            periods: Periods since the last cycle: what is more than 1 counts as missed.
        """
        now, periods = require_time(now), as_whole(periods, "periods", -1, LARGEST_ARRAY)
        self.tally.cycles += 1
        self.tally.missed += max(0, periods - 1)
        try:
            return self._events(now)
        except StreamError as failed:
            return self._record(now, failed.reason, failed.ending)

    def brake(self, now: float) -> bool:
        """One step toward rest at the clock's time `now` [s], without reading commands or joints.

        Returns whether the arm is at rest. A failure of the sink is recorded. If the servo fails, the arm stops at
        once: zero rates at its last position.
        """
        if not self.at_rest:
            try:
                self._write_anyway(self._coming_to_rest(now))
            except Exception as error:  # whatever it is, the arm must not go on moving
                self.tally.failures[f"the servo failed, and the arm was stopped at once: {_as_reason(error)}"] += 1
                assert self.state is not None
                Loop._start(self, self.state.theta, now)  # a motion's own start may fail again
        return self.at_rest

    def change_clock(self, now: float) -> None:
        """Use another clock, with the time `now` [s], from now on. The next step covers the time from this moment."""
        self._stepped = require_time(now)

    def halt(self, now: float) -> None:
        """Send zero rates at the commanded position at once; nothing before the first joint state."""
        if self.state is None:
            return
        still = frozen(np.zeros(self.arm.n))
        output = ServoOutput.stale(still, "the stream has ended")
        self._write_anyway(self._setpoint(now, self.state.theta, still, output))

    def report(self, ending: Ending, reason: str, duration: float, at_rest: bool) -> StreamReport:
        """The report of all cycles until now: the kind of ending, its reason in words, the time since the start [s]."""
        return StreamReport(
            **vars(self.tally), ending=ending, reason=reason, duration=duration, at_rest=at_rest,
            interlock=self.interlock.word,
        )  # fmt: skip

    @property
    def at_rest(self) -> bool:
        """Whether the commanded arm stands."""
        drives_rest = self._observer is None or self._observer.at_rest
        return self.state is None or (drives_rest and not self.state.theta_dot.any())

    @property
    def longest_braking(self) -> float:
        """Seconds within which the commanded arm must have come to rest."""
        if self.state is None:
            return 0.0
        return 2.0 * float((np.abs(self.state.theta_dot) / self.arm.limits.acceleration).max()) + BRAKING_SPARE

    def _coming_to_rest(self, now: float) -> Setpoint:
        """The setpoint of a step of `brake`."""
        return self._braked(now, "coming to rest")

    @abstractmethod
    def _events(self, now: float) -> C:
        """What happens in one cycle; it may raise `StreamError`."""

    @abstractmethod
    def _record(self, now: float, reason: str, ending: Ending | None) -> C:
        """A cycle without a setpoint, because of what `reason` says."""

    def _starts(self, theta: Array) -> bool:
        """Whether the servo or motion starts at the measured theta (n,). `StreamError` where it cannot."""
        return self.state is None

    def _interlock(self, device: object) -> None:
        """Pass the interlock messages of a device to this interlock."""
        if isinstance(device, Interlocked):
            device.interlock = self.interlock

    def _measure(self, now: float) -> tuple[Array | None, str]:
        """The measured theta (n,), or None and why it cannot be used. The first one starts the servo or motion.

        `StreamError` where that is far beyond the position limits.
        """
        measured = call_device(Ending.FEEDBACK_FAILED, self.feedback.read, now)
        theta, blind = self._watch.look(measured, now)
        self.tally.blind_reason = blind or self.tally.blind_reason
        if theta is not None and self._starts(theta):
            if beyond := self._watch.beyond_limits(theta):
                raise StreamError(Ending.BEYOND_LIMITS, beyond)
            self._start(theta, now)
        if self.state is None:
            self.tally.waited += self.period
            return theta, blind
        # Until the next setpoint a drive goes on at the rates that it was sent: farther, where this cycle is late.
        since = 0.0 if self._stepped is None else min(max(now - self._stepped, 0.0), self.settings.max_dt)
        self._watch.follow(self.state.theta + self.state.theta_dot * since, now)
        if self._observer is not None:
            self._observer.hear(None if blind else measured, now)
        return theta, blind

    def _start(self, theta: Array, now: float) -> None:
        """Start at rest at theta (n,). Earlier setpoints do not count."""
        self.state = ServoState.at(self.arm, theta)
        self._watch.forget()
        if self._observer is not None:
            self._observer.start(self.state.theta, now)

    def _time_fault(self, now: float) -> str:
        """Why the time since the last step is not usable, or "". A period may be late by one."""
        elapsed = self.period if self._stepped is None else now - self._stepped
        if elapsed <= 0.0:
            return "time went back"
        if elapsed >= self.settings.max_dt + self.period * (1.0 - ROUNDING):
            return f"{elapsed:.3g} s since the last cycle (longest step {self.settings.max_dt:g} s)"
        return ""

    def _elapsed(self, now: float) -> float:
        """Seconds since the last step, so that a late cycle moves nothing faster.

        It is one period at first, and if that time is unusable.
        """
        if self._stepped is None or self._time_fault(now):
            return self.period
        return min(max(now - self._stepped, ROUNDING * self.period), self.settings.max_dt)

    def _braked(self, now: float, reason: str) -> Setpoint:
        """One step toward rest of each joint alone, as fast as its acceleration limit allows."""
        assert self.state is not None  # a step needs a state, and its caller has checked that
        state, output = servo_step(self.arm, self.state, None, self._elapsed(now), settings=self.settings)
        return self._moved(state, ServoOutput.stale(output.theta_dot, reason), now, follow=False)

    def _moved(self, state: ServoState, output: ServoOutput, now: float, *, follow: bool) -> Setpoint:
        """The setpoint of a step to `state`; StreamError where it is not finite."""
        assert self.state is not None
        before = self.state.theta
        if not np.isfinite([state.theta, state.theta_dot, output.theta_dot]).all():
            raise StreamError(Ending.SERVO_FAILED, f"its setpoint is not finite: rates {output.theta_dot.tolist()}")
        self.state = state
        self._watch.follow(self.state.theta, now)
        rates, elapsed = output.theta_dot, self._elapsed(now)
        self._stepped = now  # after `_elapsed`, which counts from the step before
        if self._observer is not None:
            rates = self._observer.rates(before, rates, elapsed, follow=follow)
        return self._setpoint(now, self.state.theta, rates, output)

    def _setpoint(self, now: float, theta: Array, rates: Array, output: ServoOutput) -> Setpoint:
        setpoint = Setpoint(self._number, now, theta, rates, output, self.interlock.word)
        self._number += 1
        return setpoint

    def _send(self, setpoint: Setpoint) -> str:
        """Send the setpoint and count it. Returns why it was not delivered. Raises StreamError if the sink fails."""
        self.tally.statuses[setpoint.output.status] += 1
        self.tally.reasons[setpoint.output.reason] += 1
        return call_device(Ending.SINK_FAILED, self._write, setpoint)

    def _write(self, setpoint: Setpoint) -> str:
        """Send the setpoint. Returns why it was not delivered, or "" as far as is known."""
        self.tally.delivered = False
        try:
            self.sink.write(setpoint)
        except UndeliveredError as error:
            self.tally.undelivered[str(error)] += 1
            return str(error)
        self.tally.delivered = True
        return ""

    def _write_anyway(self, setpoint: Setpoint) -> None:
        try:
            self._write(setpoint)
        except Exception as error:  # whatever it is, the arm must still be brought to rest
            self.tally.failures[f"the sink failed: {_as_reason(error)}"] += 1


def checked_rate(rate: float, settings: ServoSettings) -> float:
    """`rate` [Hz]. Raises InputError if it is not positive, or a period exceeds the servo's longest step."""
    checked = as_positive(rate, "rate")
    if 1.0 / checked > settings.max_dt:
        raise InputError(
            f"rate must be at least {1.0 / settings.max_dt:g} Hz, because no step is longer than "
            f"{settings.max_dt:g} s (ServoSettings.max_dt); got {checked:g} Hz"
        )
    return checked


class Metronome:
    """The grid t₀ + k · period [s] with t₀ the first tick. `next` is the next time.

    early: the part of a period by which a tick may be early, for timers with jitter.
    """

    def __init__(self, period: float, early: float = ROUNDING) -> None:
        self.period = period
        self._early = early
        self.next = -inf
        self._origin = -inf
        self._index = 0

    def tick(self, now: float) -> int:
        """The number of periods of this cycle: 1 on time, more after a delay, 0 if early.

        −1 if time ran backwards by a period or more; the grid then restarts.

        Raises InputError for a time that is not finite or at least 1e12 s, and keeps the grid.
        """
        if not abs(require_time(now)) < LATEST:
            raise InputError(f"now must be seconds of a clock, below {LATEST:g}; got {quote(now)}")
        first = self._origin == -inf
        index = 0 if first else floor((now - self._origin) / self.period + self._early)
        periods = 1 if first else max(index - self._index, -1)
        if first or periods < 0:
            self._origin, index = now, 0
        self._origin = min(self._origin, now - index * self.period)
        self._index = index
        self.next = self._origin + (index + 1) * self.period
        return periods


def run_loop(
    loop: Loop[C],
    *,
    clock: Clock | None,
    handle_signals: bool,
    on_cycle: Callable[[C], object] | None,
    longest: float = inf,
    until: Callable[[], bool] | None = None,
) -> StreamReport:
    """Run cycles until one returns an ending, `longest` [s] pass, `until` returns True, or an interrupt.

    Then bring the arm to rest.
    """
    time = MonotonicClock() if clock is None else require_method(clock, "clock", "sleep_until")
    metronome = Metronome(loop.period)
    began = time.now()
    with ended_like_ctrl_c() if as_flag(handle_signals, "handle_signals") else nullcontext():
        ending, reason = Ending.INTERRUPTED, ""
        try:
            ending, reason = _run_until_ended(loop, metronome, time, began + longest, until, on_cycle)
        except KeyboardInterrupt as interrupted:
            reason = str(interrupted)
        except BaseException as error:
            come_to_rest(loop, metronome, time)
            if sys.version_info >= (3, 11):
                for failure in with_counts(loop.tally.failures):
                    error.add_note(f"while the arm came to rest, {failure}")
            raise
        at_rest = come_to_rest(loop, metronome, time)
        return loop.report(ending, reason, time.now() - began, at_rest)


def come_to_rest(loop: Loop[C], metronome: Metronome, clock: Clock) -> bool:
    """Brake the loop at the metronome's times, then send zero rates. Returns whether the arm is at rest.

    Ctrl-C shortens the braking, and the zero rates follow at once. A clock that jumps ahead does not shorten the
    braking: the needed cycles run in any case.

    Args:
        loop: The `Streaming` or `Following`.
        metronome: The cycles' times.
        clock: The clock.
    """
    require_method(loop, "loop", "brake")
    require_method(metronome, "metronome", "tick")
    require_method(clock, "clock", "now")
    try:
        latest, left = clock.now() + loop.longest_braking, loop.longest_braking / loop.period
        while not loop.at_rest and (left > 0.0 or clock.now() < latest):
            _wait(clock, metronome, inf)
            now = clock.now()
            if not abs(now) < LATEST:  # a broken clock
                break
            metronome.tick(now)
            loop.brake(now)
            left -= 1.0
    except KeyboardInterrupt:
        pass
    finally:
        at_rest = loop.at_rest
        loop.halt(clock.now())
    return at_rest


def _run_until_ended(
    loop: Loop[C],
    metronome: Metronome,
    clock: Clock,
    end: float,
    until: Callable[[], bool] | None,
    on_cycle: Callable[[C], object] | None,
) -> tuple[Ending, str]:
    """Cycles until one of the reasons to end, and which it was."""
    while True:
        now, due = clock.now(), metronome.next
        if now >= end:
            return Ending.DURATION, ""
        if until is not None and until():
            return Ending.DONE, ""
        periods = metronome.tick(now)
        if periods != 0:  # else the clock woke us a little early
            if due > -inf:
                loop.tally.begin(now - due)
            cycle = loop.cycle(now, periods)
            if on_cycle is not None:
                on_cycle(cycle)
            if cycle.ending is not None:
                return cycle.ending, cycle.reason
        _wait(clock, metronome, end)


def _wait(clock: Clock, metronome: Metronome, end: float) -> None:
    """Sleep until the next cycle or the end, at most a period. A clock may run backwards."""
    clock.sleep_until(min(metronome.next, end, clock.now() + metronome.period))
