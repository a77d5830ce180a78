"""Drives that take rates alone, as an outsider would model them, and figures of what the joints really do."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from stream_stand_ins import PERIOD, FakeClock, Says
from twistarm.control.stream import Ending, Measured, Streaming, StreamOptions

STEP = 2.0 * np.pi / 4096  # Of an encoder with 12 bits [rad]; of a slide's, that many metres.

TICK = 0.001
BEGIN = 100.0


class RateDrives:
    """Joints moved by the rates they last heard, times a `gain`, `delay` [s] late; nothing stops them at a limit.

    The encoders' last digit flickers; a joint state every `every` [s]. A share `loss` of setpoints and of joint states
    gets lost, and all joint states while `mute(now)`. `lag` [s]: the time constant of the rate.
    """

    def __init__(
        self, arm, theta, clock, seed=0, *, gain=None, delay=0.05, every=0.015, loss=0.15, lag=1e-9, step=STEP,
        mute=lambda now: False,
    ):  # fmt: skip
        self.random = np.random.default_rng(seed)
        self.theta = np.array(theta, dtype=float)
        self.gain = 1.0 + self.random.choice([-0.1, 0.1, 0.05], arm.n) if gain is None else np.asarray(gain)
        self.clock, self.delay, self.every, self.loss, self.lag, self.step = clock, delay, every, loss, lag, step
        self.told = self.rate = np.zeros(arm.n)
        self.mute, self.queue, self.now, self.next = mute, deque(), clock.now(), clock.now()
        self.heard = Measured(self._encoded(), self.now)
        self.sent, self.path = [], []

    def write(self, setpoint):
        self.sent.append(setpoint.theta_dot)
        if self.random.random() >= self.loss:
            self.queue.append((self.clock.now() + self.delay, setpoint.theta_dot))

    def read(self, now):
        while self.now < now - TICK / 2:
            self._tick()
        self.path.append(self.theta)
        return self.heard

    def _tick(self):
        while self.queue and self.queue[0][0] <= self.now:
            self.told = self.queue.popleft()[1]
        self.rate = self.rate + (self.gain * self.told - self.rate) * min(1.0, TICK / self.lag)
        self.theta = self.theta + self.rate * TICK
        self.now += TICK
        if self.now >= self.next:
            self.next += self.every
            if self.random.random() >= self.loss and not self.mute(self.now - BEGIN):
                self.heard = Measured(self._encoded(), self.now)

    def _encoded(self):
        flicker = self.random.uniform(-0.25, 0.25, self.theta.size)
        return np.round(self.theta / self.step + flicker) * self.step


@dataclass
class Drive:
    """What was measured: joints and rates sent (N, n), and how the stream ended (None: it went on).

    Rates and their changes as shares of what the limits allow; how far joints were beyond their limits [rad, m].
    """

    path: np.ndarray
    rates: np.ndarray
    ending: Ending | None
    beyond: np.ndarray
    fastest: float
    hardest: float

    @property
    def seconds(self):
        return len(self.path) * PERIOD

    def reversals(self, since):
        """How often a joint's rate changes its sign after `since` [s], of the joint that does it most."""
        signs = np.sign(np.where(np.abs(self.rates) > 1e-4, self.rates, 0.0))[round(since / PERIOD) :]
        return max(int((np.diff(one[one != 0.0]) != 0.0).sum()) for one in signs.T)


def driven(arm, theta, command, seconds, *, velocity_mode=True, push=None, **plant):
    """The arm under `command(time since the start)`, and what its joints did; `push(time, drives)` after each cycle."""
    clock = FakeClock(BEGIN)
    drives = RateDrives(arm, theta, clock, **plant)
    source = Says(lambda now: command(now - BEGIN))
    streaming = Streaming(arm, source, drives, drives, StreamOptions(velocity_mode=velocity_mode))
    limits, ending = streaming.arm.limits, None
    for k in range(round(seconds / PERIOD)):
        clock.time = BEGIN + k * PERIOD
        ending = streaming.cycle(clock.time).ending
        if push is not None:
            push(k * PERIOD, drives)
        if ending is not None:
            break
    path, rates = np.array(drives.path), np.array(drives.sent)
    changes = np.abs(np.diff(rates, axis=0, prepend=0.0 * rates[:1])) / (limits.acceleration * PERIOD)
    beyond = np.maximum(path - limits.upper, limits.lower - path).max(axis=0)
    return Drive(path, rates, ending, beyond, (np.abs(rates) / limits.velocity).max(), changes.max())


def off_line(arm, path, direction):
    """How far the tool was from the straight line that it was told to follow [m], and how far it went along it."""
    origins = np.array([arm.fk(theta)[:3, 3] for theta in path[::5]]) - arm.fk(path[0])[:3, 3]
    along = origins @ direction
    return np.linalg.norm(origins - along[:, None] * direction, axis=1).max(), along.max()
