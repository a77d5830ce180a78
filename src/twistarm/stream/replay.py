"""A recorded motion as commands: jogs that follow it on the clock."""

from __future__ import annotations

from math import inf
from typing import NoReturn

import numpy as np

from ..model.arm import Arm
from ..servo import JogCommand, ServoState
from ..support.checks import Array
from ..support.errors import InputError, TwistarmError
from .protocols import Reading
from .recording import Recording

GAIN = 5.0
"""Of the correction [1/s]: what limits or late cycles cost is made up for in some half a second."""

PATIENCE = 2.0
"""Seconds that the arm may stand elsewhere before it is given up."""

AT_START = 0.01
"""How far from the recording's start the arm may stand [rad, m]."""

BEHIND = 0.1
"""How far from the recording the arm may be on the way [rad, m]: more is a motion that it cannot follow."""

SETTLING = 0.5
"""Seconds after the recording's end in which what is left of a deviation is made up for."""

SHORTEST_STEP = 1e-4
"""Seconds between two readings below which their distance says nothing about the rate."""


class Replay:
    """A source that plays `recording` once, from the first reading at which the arm is known.

    The jog between two readings is the recording's mean rate over a time as long as the last one, and 5 1/s times the
    deviation of the commanded arm: the recorded positions are passed, not an integral that drifts.

    It does not begin where the arm stands elsewhere, and gives up after 2 s of that, or where the arm falls behind:
    `read` then raises TwistarmError with the reason, which ends a stream.
    """

    def __init__(self, arm: Arm, recording: Recording) -> None:
        if recording.theta.shape[1] != arm.n:
            raise InputError(
                f"a recording of {recording.theta.shape[1]} joints is not for {arm.name}, which has {arm.n}"
            )
        self._arm = arm
        self._recording = recording
        self._ready = False
        self._began = self._before = self._waits = inf
        self._over = self._failed = ""

    @property
    def done(self) -> bool:
        """Whether it has ended: at the recording's end, or because it gave up."""
        return bool(self._over or self._failed)

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The jog for the time until the next reading.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a jog, or None and the reason.

        Raises:
            TwistarmError: The replay has given up.
        """
        if self._failed:
            raise TwistarmError(self._failed)
        if self._over or state is None:
            return Reading(None, 0.0, self._over or "the replay waits for the joint state")
        step, self._before = now - self._before, now
        if not self._ready:
            return self._begin(now, state.theta)
        if self._began == inf:
            self._began = now
        return self._follow(now - self._began, step, state.theta)

    def _begin(self, now: float, theta: Array) -> Reading:
        """Stand still until the next reading, by when it is known how long a step is."""
        start = self._recording.theta[0]
        if np.abs(theta - start).max() > AT_START:
            reason = self._away(theta, start, "begins", "bring the arm there first")
            self._waits = min(self._waits, now)
            return self._give_up(reason) if now - self._waits >= PATIENCE else Reading(None, 0.0, reason)
        self._ready = True
        return Reading(JogCommand(np.zeros(self._arm.n)), 0.0)

    def _follow(self, time: float, step: float, theta: Array) -> Reading:
        wanted = self._recording(time)
        if time >= self._recording.duration + SETTLING:
            self._over = "the recording has ended"
            return Reading(None, 0.0, self._over)
        if not np.abs(theta - wanted).max() <= BEHIND:
            return self._give_up(self._away(theta, wanted, "is by now", "the arm cannot follow it"))
        ahead = (self._recording(time + step) - wanted) / step if step > SHORTEST_STEP else np.zeros(self._arm.n)
        return Reading(JogCommand(ahead + GAIN * (wanted - theta)), 0.0)

    def _give_up(self, reason: str) -> NoReturn:
        self._failed = reason
        raise TwistarmError(reason)

    def _away(self, theta: Array, wanted: Array, verb: str, remedy: str) -> str:
        away = np.abs(theta - wanted)
        j = int(np.argmax(away))
        name, unit = self._arm.joint_names[j], self._arm.units[j]
        return f"the recording {verb} {away[j]:.3g} {unit} from where joint {name} is; {remedy}"
