"""Simulated joints: late, with limits of velocity and acceleration, and hard stops."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...arm.usual_limits import defaults_line, with_defaults
from ...support.checks import Array, as_number, frozen, require, require_clock
from ...support.errors import InputError
from .protocols import Measured, Setpoint
from .watch import one_or_each

SUBSTEP = 0.002
"""Longest step of the simulation [s]."""

GAIN = 40.0
"""Gain of the drives' position loop [1/s]: an error falls to a third in 25 ms, as with small servo drives."""

HOLD_AFTER = 0.1
"""Seconds without a new setpoint after which the drives hold their position."""

VELOCITY_RESERVE, ACCELERATION_RESERVE = 1.2, 2.0
"""What drives can do beyond the arm's limits. Without a reserve a late joint never catches up with a motion at its
limits, and overshoots when it brakes.
"""

ARRIVED = 1e-9
"""A joint this near its goal [rad, m] is at it."""

LONGEST_QUEUE = 10_000
"""Most setpoints under way. More mean that a latency was given in milliseconds."""


class SimulatedJoints:
    """The joints of `arm`, at rest at `theta` (n,): a sink and a feedback.

    A setpoint takes effect `latency` [s] later. Each joint moves at the setpoint's rate plus 40 1/s times its position
    error. `velocity` and `acceleration` (n,) [rad/s, m/s, and per s²] limit it. By default these are the arm's limits
    or assumed ones, plus the usual reserve of drives. `assumed` lists assumed limits. At a position limit a joint stops
    dead. `step` advances time by hand; `write` and `read` first advance it to now. With your own clock the same calls
    give the same motion.

    Raises InputError for a negative latency, limits that are not positive, or a wrong theta shape.
    """

    def __init__(
        self,
        arm: Arm,
        theta: ArrayLike,
        *,
        latency: float = 0.0,
        velocity: ArrayLike | None = None,
        acceleration: ArrayLike | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if not 0.0 <= as_number(latency, "latency") < inf:
            raise InputError(f"latency must be a number of seconds from 0 on; got {latency:g}")
        self._theta = require_arm(arm).theta_from(theta).copy()
        if self._theta.ndim != 1:
            raise InputError(f"theta must be one configuration ({arm.n},); got {self._theta.shape}")
        self._theta_dot = np.zeros(arm.n)
        self._latency = latency
        usual = with_defaults(arm)
        self._velocity = VELOCITY_RESERVE * usual.velocity
        self._acceleration = ACCELERATION_RESERVE * usual.acceleration
        known = {}
        if velocity is not None:
            self._velocity, known["velocity"] = one_or_each(velocity, arm.n, "velocity"), usual.velocity
        if acceleration is not None:
            self._acceleration = one_or_each(acceleration, arm.n, "acceleration")
            known["acceleration"] = usual.acceleration
        self.assumed = defaults_line(arm, replace(arm.limits, **known))
        self._lower, self._upper = arm.limits.lower, arm.limits.upper
        self._clock = require_clock(clock, "clock")
        self._now = clock()
        self._queue: deque[tuple[float, Array, Array]] = deque()
        self._goal, self._rate, self._heard = self._theta.copy(), np.zeros(arm.n), -inf

    @property
    def theta(self) -> Array:
        """Where the joints are (n,) [rad, m], a copy."""
        return self._theta.copy()

    @property
    def theta_dot(self) -> Array:
        """How fast they move (n,) [rad/s, m/s], a copy."""
        return self._theta_dot.copy()

    def write(self, setpoint: Setpoint) -> None:
        """Send a setpoint to the drives."""
        require(setpoint, Setpoint, "setpoint", "as the loop makes it")
        self._advance()
        if len(self._queue) >= LONGEST_QUEUE:
            raise InputError(f"{LONGEST_QUEUE} setpoints are under way: latency is in seconds; got {self._latency:g}")
        self._queue.append((self._now + self._latency, setpoint.theta, setpoint.theta_dot))

    def read(self, now: float) -> Measured:
        """Where the joints are now."""
        self._advance()
        return Measured(frozen(self._theta), now)

    def step(self, dt: float) -> None:
        """Let `dt` [s] pass."""
        end = self._now + as_number(dt, "dt [s]", 0.0)
        while self._now < end:
            self._receive()
            until = min(end, self._queue[0][0]) if self._queue else end
            if not self._at_rest_at_goal:
                until = min(until, self._now + SUBSTEP)
                self._move(until - self._now)
            self._now = until
        self._receive()

    def _advance(self) -> None:
        self.step(max(0.0, self._clock() - self._now))

    def _receive(self) -> None:
        """Take what has arrived by now; the latest counts."""
        while self._queue and self._queue[0][0] <= self._now:
            self._heard, goal, self._rate = self._queue.popleft()
            self._goal = np.clip(goal, self._lower, self._upper)

    @property
    def _at_rest_at_goal(self) -> bool:
        """Whether nothing will move until another setpoint arrives."""
        return not self._theta_dot.any() and not self._rate.any() and bool((self._goal == self._theta).all())

    def _move(self, h: float) -> None:
        if self._now - self._heard > HOLD_AFTER and self._rate.any():
            self._rate = np.zeros_like(self._rate)
        error = self._goal - self._theta
        # The speed from which the joint can still stop at its goal: v² = 2 a |error|.
        braking = np.sqrt(2.0 * self._acceleration * np.abs(error))
        wanted = self._rate + np.clip(GAIN * error, -braking, braking)
        wanted = np.clip(wanted, -self._velocity, self._velocity)
        most = self._acceleration * h
        self._theta_dot += np.clip(wanted - self._theta_dot, -most, most)
        self._theta += self._theta_dot * h
        there = (np.abs(self._goal - self._theta) < ARRIVED) & (np.abs(self._theta_dot) < ARRIVED / SUBSTEP)
        if there.all() and not self._rate.any():
            self._theta, self._theta_dot = self._goal.copy(), np.zeros_like(self._rate)
        inside = np.clip(self._theta, self._lower, self._upper)
        self._theta_dot[inside != self._theta] = 0.0
        self._theta = inside
