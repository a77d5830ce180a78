"""A recorded motion as commands: jogs that follow it on the clock."""

from __future__ import annotations

from math import inf

import numpy as np

from ..arm import Arm
from ..checks import Array
from ..errors import InputError
from ..servo import JogCommand, ServoState
from .protocols import Reading
from .recording import Recording

GAIN = 5.0
"""Of the correction [1/s]: what limits or late cycles cost is made up for in some half a second."""

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
    deviation of the commanded arm: the recorded positions are passed, not an integral that drifts. It refuses to begin
    where the arm stands elsewhere, and ends for good where the arm falls behind.
    """

    def __init__(self, arm: Arm, recording: Recording) -> None:
        if recording.theta.shape[1] != arm.n:
            raise InputError(
                f"a recording of {recording.theta.shape[1]} joints is not for {arm.name}, which has {arm.n}"
            )
        self._arm = arm
        self._recording = recording
        self._ready = False
        self._began = self._before = inf
        self._over = ""

    @property
    def done(self) -> bool:
        """Whether it has ended, at the recording's end or because the arm fell behind."""
        return bool(self._over)

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The jog for the time until the next reading."""
        if self._over or state is None:
            return Reading(None, 0.0, self._over or "the replay waits for the joint state")
        step, self._before = now - self._before, now
        if not self._ready:
            return self._begin(state.theta)
        if self._began == inf:
            self._began = now
        return self._follow(now - self._began, step, state.theta)

    def _begin(self, theta: Array) -> Reading:
        """Stand still until the next reading, by when it is known how long a step is."""
        start = self._recording.theta[0]
        if np.abs(theta - start).max() > AT_START:
            return Reading(None, 0.0, self._away(theta, start, "begins", "bring the arm there first"))
        self._ready = True
        return Reading(JogCommand(np.zeros(self._arm.n)), 0.0)

    def _follow(self, time: float, step: float, theta: Array) -> Reading:
        wanted = self._recording(time)
        if time >= self._recording.duration + SETTLING:
            self._over = "the recording has ended"
        elif not np.abs(theta - wanted).max() <= BEHIND:
            self._over = self._away(theta, wanted, "is by now", "the arm cannot follow it")
        if self._over:
            return Reading(None, 0.0, self._over)
        ahead = (self._recording(time + step) - wanted) / step if step > SHORTEST_STEP else np.zeros(self._arm.n)
        return Reading(JogCommand(ahead + GAIN * (wanted - theta)), 0.0)

    def _away(self, theta: Array, wanted: Array, verb: str, remedy: str) -> str:
        away = np.abs(theta - wanted)
        j = int(np.argmax(away))
        name, unit = self._arm.joint_names[j], self._arm.units[j]
        return f"the recording {verb} {away[j]:.3g} {unit} from where joint {name} is; {remedy}"
