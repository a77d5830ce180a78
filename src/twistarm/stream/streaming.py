"""One cycle of the loop: look at the joints, take the command, step the servo, hand the setpoint on."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..model.arm import Arm, require_arm
from ..model.usual_limits import defaults_line, usually_limited
from ..servo import AnyCommand, ServoOutput, ServoSettings, ServoState, servo_step
from ..support.checks import Array, as_positive, frozen, require, require_method
from ..support.display import Brief
from ..support.errors import InputError
from .failures import StreamError, call_device, worded
from .interlock import ENABLED, Interlock, Interlocked
from .links.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from .observer import RateObserver, with_reserve
from .protocols import Feedback, Reading, Setpoint, Sink, Source, UndeliveredError
from .report import Ending, StreamReport, Tally
from .watch import FeedbackWatch

TOLERANCE = 0.2
"""How far a joint may be from where it was commanded to be [rad, m]."""

RELEASE_FIRST = "release the controls first: they were held when the arm was enabled"

BRAKING_SPARE = 0.5
"""Seconds that coming to rest may take beyond twice what velocity over acceleration says."""


@dataclass(frozen=True, eq=False, repr=False)
class Cycle(Brief):
    """What happened in one cycle.

    theta (n,): the joint state where it can be used. setpoint: what was computed, None before the first joint state.
    reason: why there was no command, or the setpoint did not get through, which `delivered` says. ending: why the
    stream cannot go on, None where it can. interlock: the `Interlock`'s word, by which the arm may move or not.
    """

    time: float
    reading: Reading | None
    theta: Array | None
    setpoint: Setpoint | None
    reason: str = ""
    ending: Ending | None = None
    delivered: bool = True
    interlock: str = ENABLED


class Streaming:
    """A stream, cycle by cycle, for loops that have a timer of their own; `run` is the loop with ours.

    Call `cycle` at `rate` [Hz] until it says an ending, then `brake` at the same rate until it answers True, then
    `halt`, whatever went wrong before. The arguments are those of `run`; `arm` has the usual limits where the one given
    has none, and `assumed` says which.
    """

    def __init__(
        self,
        arm: Arm,
        source: Source,
        sink: Sink,
        feedback: Feedback,
        *,
        rate: float = 100.0,
        command_timeout: float = COMMAND_TIMEOUT,
        feedback_timeout: float = FEEDBACK_TIMEOUT,
        tolerance: ArrayLike = TOLERANCE,
        settings: ServoSettings | None = None,
        velocity_mode: bool = False,
        interlock: Interlock | None = None,
    ) -> None:
        self.assumed = defaults_line(require_arm(arm))
        self.arm = usually_limited(arm)
        self.source = require_method(source, "source", "read")
        self.sink = require_method(sink, "sink", "write")
        self.feedback = require_method(feedback, "feedback", "read")
        given = ServoSettings() if settings is None else settings
        self.settings = require(given, ServoSettings, "settings", "as ServoSettings() is")
        self.rate = checked_rate(rate, self.settings)
        self.period = 1.0 / self.rate
        self.command_timeout = as_positive(command_timeout, "command_timeout")
        self.feedback_timeout = as_positive(feedback_timeout, "feedback_timeout")
        self.velocity_mode = velocity_mode
        self.interlock = require(
            Interlock() if interlock is None else interlock, Interlock, "interlock", "as Interlock() is"
        )
        for device in (self.source, self.feedback):
            if isinstance(device, Interlocked):
                device.interlock = self.interlock
        self.state: ServoState | None = None
        self.tally = Tally(self.rate, self.assumed)
        self._watch = FeedbackWatch(arm, self.feedback_timeout, tolerance)
        self._commanded_arm = with_reserve(self.arm) if velocity_mode else self.arm
        self._observer = RateObserver(self.arm, self.period) if velocity_mode else None
        self._number = 0
        self._released = inf
        self._held = not self.interlock.allows_motion  # a command since before the arm was enabled, which moves nothing

    def cycle(self, now: float, periods: int = 1) -> Cycle:
        """One cycle: look at the joints, take the command, step the servo, write the setpoint.

        A device that fails is an ending, nothing is raised for it, and so is a setpoint that is not finite, which is
        not sent; whatever else is raised is an error in a program.

        Args:
            now: The clock's time [s].
            periods: Periods since the last cycle; 0 or less where time went back.

        Returns:
            The `Cycle`.
        """
        self.tally.cycles += 1
        self.tally.missed += max(0, periods - 1)
        try:
            return self._cycle(now, periods)
        except StreamError as failed:
            return Cycle(now, None, None, None, str(failed), failed.ending, interlock=self.interlock.word)

    def brake(self, now: float, periods: int = 1) -> bool:
        """One step toward rest, which reads neither commands nor joints. A sink's failure is noted.

        Where the servo itself fails, the arm stands at once: rates of 0 where it was last.

        Args:
            now: The clock's time [s].
            periods: Periods since the last cycle.

        Returns:
            Whether the arm is at rest.
        """
        if not self.at_rest:
            try:
                self._write_anyway(self._step(None, now, periods, "coming to rest"))
            except Exception as error:  # whatever it is, the arm must not go on moving
                self.tally.failures[f"the servo failed, and the arm was stopped at once: {worded(error)}"] += 1
                assert self.state is not None
                self._start_at(self.state.theta, now)
        return self.at_rest

    def halt(self, now: float) -> None:
        """Rates of 0 where the commanded arm is, at once; nothing where no joint state ever arrived."""
        if self.state is None:
            return
        still = frozen(np.zeros(self.arm.n))
        self._write_anyway(
            self._setpoint(now, self.state.theta, still, ServoOutput.stale(still, "the stream has ended"))
        )

    def report(self, ending: Ending, reason: str, duration: float, at_rest: bool) -> StreamReport:
        """The report of all cycles until now.

        Args:
            ending: The kind of ending.
            reason: The reason, in words.
            duration: The time since the start [s].
            at_rest: Whether the arm is at rest.

        Returns:
            The `StreamReport`.
        """
        return self.tally.report(ending, reason, duration, at_rest, self.interlock.word)

    @property
    def at_rest(self) -> bool:
        """Whether the commanded arm stands."""
        told = self._observer is None or self._observer.at_rest
        return self.state is None or (told and not self.state.theta_dot.any())

    @property
    def longest_braking(self) -> float:
        """Seconds within which the commanded arm must have come to rest."""
        if self.state is None:
            return 0.0
        return 2.0 * float((np.abs(self.state.theta_dot) / self.arm.limits.acceleration).max()) + BRAKING_SPARE

    def _cycle(self, now: float, periods: int) -> Cycle:
        measured = call_device(Ending.FEEDBACK_FAILED, self.feedback.read, now)
        theta, blind = self._watch.look(measured, now)
        self._start(theta, now)
        if self._observer is not None and self.state is not None:
            self._observer.hear(None if blind else measured, now)
        reading = call_device(Ending.SOURCE_FAILED, self.source.read, now, self.state)
        command, uncommanded = self._command(reading)
        barred = self.interlock.look().barrier
        self._held = (self._held or bool(barred)) and _asks_for_motion(command)
        if self._held:
            command, uncommanded = None, RELEASE_FIRST
        self.tally.blind_reason = blind or self.tally.blind_reason
        if self.state is None:
            self.tally.waited += 1
            return Cycle(now, reading, None, None, blind, interlock=self.interlock.word)
        strayed = "" if theta is None else self._watch.deviation(theta)
        if barred:
            command, uncommanded = None, ""
        self.tally.blind += bool(blind)
        self.tally.uncommanded += bool(uncommanded)
        self.tally.uncommanded_reason = uncommanded or self.tally.uncommanded_reason
        self.tally.barred += bool(barred)
        self.tally.barred_reason = barred or self.tally.barred_reason
        reason = strayed or barred or blind or self._untimely(periods) or uncommanded
        setpoint = self._step(None if reason else command, now, periods, reason)
        self.tally.statuses[setpoint.output.status] += 1
        undelivered = call_device(Ending.SINK_FAILED, self._write, setpoint)
        self._restart_at_rest(theta, now, released=command is None)
        why = "; ".join(filter(None, (reason, undelivered)))
        ending = Ending.STRAYED if strayed else None
        return Cycle(now, reading, theta, setpoint, why, ending, not undelivered, setpoint.interlock)

    def _start(self, theta: Array | None, now: float) -> None:
        """From the measured theta: the first one, and one that comes back while the commanded arm stands.

        Nobody knows where the arm went meanwhile: it is not held to where it was, nor told to jump back there.
        """
        if theta is not None and (self.state is None or (self._watch.returned and self.at_rest)):
            self._start_at(theta, now)
            self._watch.forget()

    def _start_at(self, theta: Array, now: float) -> None:
        self.state = ServoState.at(self.arm, theta)
        if self._observer is not None:
            self._observer.start(self.state.theta, now)

    def _command(self, reading: Reading) -> tuple[AnyCommand | None, str]:
        if reading.command is None:
            return None, reading.reason or "no command"
        if not abs(reading.age) <= self.command_timeout:  # below 0: it came while the loop waited for its turn
            return None, f"the command is {reading.age:.3g} s old (timeout {self.command_timeout:g} s)"
        return reading.command, ""

    def _untimely(self, periods: int) -> str:
        if periods < 1:
            return "time went back"
        elapsed = periods * self.period
        if elapsed > self.settings.longest_dt:
            return f"{elapsed:.3g} s since the last cycle (longest step {self.settings.longest_dt:g} s)"
        return ""

    def _step(self, command: AnyCommand | None, now: float, periods: int, reason: str) -> Setpoint:
        """A step over the time since the last one, over one period where that cannot be."""
        assert self.state is not None  # whoever steps has asked
        before = self.state.theta
        dt = self.period if self._untimely(periods) else periods * self.period
        arm = self.arm if command is None else self._commanded_arm
        state, output = servo_step(arm, self.state, command, dt, settings=self.settings)
        if not np.isfinite([state.theta, state.theta_dot, output.theta_dot]).all():
            raise StreamError(Ending.SERVO_FAILED, f"its setpoint is not finite: rates {output.theta_dot.tolist()}")
        self.state = state
        if reason:
            output = ServoOutput.stale(output.theta_dot, reason)
        self._watch.follow(self.state.theta, now)
        rates = output.theta_dot
        if self._observer is not None:
            rates = self._observer.rates(before, rates, follow=command is not None)
        return self._setpoint(now, self.state.theta, rates, output)

    def _setpoint(self, now: float, theta: Array, rates: Array, output: ServoOutput) -> Setpoint:
        setpoint = Setpoint(self._number, now, theta, rates, output, self.interlock.word)
        self._number += 1
        return setpoint

    def _restart_at_rest(self, theta: Array | None, now: float, released: bool) -> None:
        """In velocity mode, measured positions count again once the arm was left alone and stood for a while."""
        if not (self.velocity_mode and released and self.at_rest and theta is not None):
            self._released = inf
            return
        self._released = min(self._released, now)
        if now - self._released >= self.feedback_timeout:
            self._start_at(theta, now)
            self._watch.follow(theta, now)

    def _write(self, setpoint: Setpoint) -> str:
        """Hand the setpoint on; why nobody took it, "" where somebody did as far as is known."""
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
            self.tally.failures[f"the sink failed: {worded(error)}"] += 1


def _asks_for_motion(command: Any) -> bool:
    """Whether the controls are held: any command but a twist or a jog of zeros."""
    return command is not None and not np.array_equiv(getattr(command, "numbers", command), 0.0)


def checked_rate(rate: float, settings: ServoSettings) -> float:
    """`rate` [Hz]; InputError where it is not positive, or so low that the servo's longest step is under a period."""
    checked = as_positive(rate, "rate")
    if 1.0 / checked > settings.longest_dt:
        raise InputError(
            f"rate must be at least {1.0 / settings.longest_dt:g} Hz, because no step is longer than "
            f"{settings.longest_dt:g} s (ServoSettings.longest_dt); got {checked:g} Hz"
        )
    return checked
