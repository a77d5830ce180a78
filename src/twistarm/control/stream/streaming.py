"""One cycle of the servo loop: take the command, step the servo, send the setpoint."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...support.checks import Array, as_positive, require_method
from ..servo import AnyCommand, ServoSettings, servo_step
from .cycles import Cycle, Cycles
from .failures import call_device
from .interlock import Interlock
from .links.inbox import COMMAND_TIMEOUT, FEEDBACK_TIMEOUT
from .protocols import Feedback, Reading, Setpoint, Sink, Source
from .report import Ending

TOLERANCE = 0.2
"""How far a joint may be from where it was commanded to be [rad, m]."""

RELEASE_FIRST = "release the controls first: they were held when the arm was enabled"


class Streaming(Cycles[Cycle]):
    """A stream, cycle by cycle (see `Cycles`), for loops with a timer; the arguments are those of `run`."""

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
        given = ServoSettings() if settings is None else settings
        super().__init__(
            arm, sink, feedback, rate=rate, feedback_timeout=feedback_timeout, tolerance=tolerance, settings=given,
            velocity_mode=velocity_mode, interlock=interlock,
        )  # fmt: skip
        self.source = require_method(source, "source", "read")
        self.command_timeout = as_positive(command_timeout, "command_timeout")
        self._interlock(self.source)
        self._released = inf
        self._held = not self.interlock.allows_motion  # a command since before the arm was enabled, which moves nothing

    def _cycle(self, now: float) -> Cycle:
        measured, theta, blind = self._look(now)
        self._start(theta, now)
        self._hear(None if blind else measured, now)
        reading = call_device(Ending.SOURCE_FAILED, self.source.read, now, self.state)
        command, uncommanded = self._command(reading)
        barred = self.interlock.look().barrier
        self._held = (self._held or bool(barred)) and _asks_for_motion(command)
        if self._held:
            command, uncommanded = None, RELEASE_FIRST
        if self.state is None:
            self.tally.waited += 1
            return Cycle(now, reading, None, None, blind, interlock=self.interlock.word)
        strayed = "" if theta is None else self._watch.deviation(theta)
        if barred:
            command, uncommanded = None, ""
        self.tally.count(blind=blind, uncommanded=uncommanded, barred=barred)
        reason = strayed or barred or blind or self._untimely(now) or uncommanded
        setpoint = self._step(None if reason else command, now, reason)
        undelivered = self._send(setpoint)
        self._restart_at_rest(theta, now, released=command is None)
        why = "; ".join(filter(None, (reason, undelivered)))
        ending = Ending.STRAYED if strayed else None
        return Cycle(now, reading, theta, setpoint, why, ending, not undelivered, setpoint.interlock)

    def _failed(self, now: float, reason: str, ending: Ending) -> Cycle:
        return Cycle(now, None, None, None, reason, ending, interlock=self.interlock.word)

    def _start(self, theta: Array | None, now: float) -> None:
        """Start at the measured theta: the first one, or one that returns while the commanded arm rests.

        The arm may have moved meanwhile, so it is not sent back.
        """
        if theta is not None and (self.state is None or (self._watch.returned and self.at_rest)):
            self._start_at(theta, now)
            self._watch.forget()

    def _command(self, reading: Reading) -> tuple[AnyCommand | None, str]:
        if reading.command is None:
            return None, reading.reason or "no command"
        if not abs(reading.age) <= self.command_timeout:  # below 0: it came while the loop waited for its turn
            return None, f"the command is {reading.age:.3g} s old (timeout {self.command_timeout:g} s)"
        return reading.command, ""

    def _step(self, command: AnyCommand | None, now: float, reason: str) -> Setpoint:
        if command is None:
            return self._braked(now, reason)
        assert self.state is not None  # whoever steps has asked
        dt = self._elapsed(now)
        state, output = servo_step(self._commanded_arm, self.state, command, dt, settings=self.settings)
        return self._moved(state, output, now, follow=True)

    def _restart_at_rest(self, theta: Array | None, now: float, released: bool) -> None:
        """In velocity mode, restart at the measured position after the arm has rested for a while without a command."""
        if not (self.velocity_mode and released and self.at_rest and theta is not None):
            self._released = inf
            return
        self._released = min(self._released, now)
        if now - self._released >= self.feedback_timeout:
            self._start_at(theta, now)
            self._watch.follow(theta, now)


def _asks_for_motion(command: Any) -> bool:
    """Whether the controls are held: any command but a twist or a jog of zeros."""
    return command is not None and not np.array_equiv(getattr(command, "numbers", command), 0.0)
