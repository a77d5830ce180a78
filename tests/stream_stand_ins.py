"""Stand-ins around the loop: a clock that tests move, sources that say one thing, sinks and feedback that fail."""

from dataclasses import fields, replace

import numpy as np
import pytest

from twistarm.control.servo import JogCommand, ServoOutput, ServoReason
from twistarm.control.stream import Measured, Reading, Setpoint, StreamOptions, run

RATE = 100.0
PERIOD = 1.0 / RATE
SHARED = [field.name for field in fields(StreamOptions)]


class FakeClock:
    """Time that passes only while somebody sleeps; `late` maps a sleep's number to how much it oversleeps [s]."""

    def __init__(self, start=100.0, late=None):
        self.time = start
        self.late = late or {}
        self.sleeps = 0

    def __call__(self):
        return self.time

    now = __call__

    def sleep_until(self, moment):
        self.sleeps += 1
        self.time = max(self.time, moment) + self.late.get(self.sleeps, 0.0)


class Says:
    """A source whose command is `command(now)`, or always `command`."""

    def __init__(self, command):
        self.command = command

    def read(self, now, state):
        command = self.command(now) if callable(self.command) else self.command
        return Reading(command, 0.0, "" if command is not None else "nobody commands")


class Robot:
    """Joints that are where they are told to be, at once: a sink that remembers and a feedback.

    `deaf(now)`, `mute(now)`: while true, it does not move, its joint state grows old. `broken`: what to raise.
    """

    def __init__(self, theta, clock):
        self.theta = np.array(theta, dtype=float)
        self.clock = clock
        self.setpoints: list[Setpoint] = []
        self.heard = clock.now()
        self.deaf = self.mute = lambda now: False
        self.broken = lambda now: None

    def write(self, setpoint):
        error = self.broken(self.clock.now())
        if error is not None:
            raise error
        self.setpoints.append(setpoint)
        if not self.deaf(self.clock.now()):
            self.theta = setpoint.theta

    def read(self, now):
        if not self.mute(now):
            self.heard = now
        return Measured(self.theta, self.heard)

    @property
    def rates(self):
        return np.array([setpoint.theta_dot for setpoint in self.setpoints])

    @property
    def times(self):
        return np.array([setpoint.time for setpoint in self.setpoints])

    def hardest(self, arm):
        """The largest change of a rate since the setpoint before, as a share of what the acceleration limits allow."""
        steps = np.abs(np.diff(self.rates, axis=0, prepend=np.zeros((1, arm.n))))
        spans = np.diff(self.times, prepend=self.times[0] - PERIOD)
        return (steps / (arm.limits.acceleration * np.maximum(spans, 1e-9)[:, None])).max()

    def moving(self, after):
        """The latest moment at which a setpoint had a rate, counted from `after` [s]."""
        return max((s.time for s in self.setpoints if s.theta_dot.any()), default=after) - after


def answer(rates, reason=ServoReason.MOVING, scale=1.0, joint=None, why=""):
    """What a step of the servo answers."""
    return replace(ServoOutput.stale(np.asarray(rates, dtype=float), why), reason=reason, scale=scale, joint=joint)


def jog(arm, **rates):
    return JogCommand.of(arm, rates)


@pytest.fixture
def clock():
    return FakeClock()


@pytest.fixture
def robot(rover, clock):
    return Robot(rover.ready, clock)


@pytest.fixture
def stream(rover, clock, robot):
    """`run` of the rover arm on the fake clock: an elbow jog where no source is given, and `sink` measures itself."""

    def streamed(source=None, sink=None, feedback=None, **options):
        source = source or Says(jog(rover, elbow=-0.4))
        options = {"rate": RATE, "duration": 2.0, "clock": clock} | options
        shared = StreamOptions(**{name: options.pop(name) for name in SHARED if name in options})
        return run(rover, source, sink or robot, feedback or sink or robot, shared, **options)

    return streamed
