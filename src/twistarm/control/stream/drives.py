"""Drives: simulated joints, and a filter for robots that take rates alone."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm, require_arm
from ...arm.usual_limits import with_defaults
from ...support.checks import Array, as_number, frozen, require, require_clock
from ...support.errors import InputError
from .protocols import Measured, Setpoint, one_or_each

SUBSTEP = 0.002  # Longest step of the simulation [s].
# Gain of the drives' position loop [1/s]: an error falls to a third in 25 ms, as with small servo drives.
GAIN = 40.0
HOLD_AFTER = 0.1  # Seconds without a new setpoint after which the drives hold their position.
# What drives can do beyond the arm's limits. Without a reserve a late joint never catches up with a motion at its
# limits, and overshoots when it brakes.
VELOCITY_RESERVE, ACCELERATION_RESERVE = 1.2, 2.0
ARRIVED = 1e-9  # A joint this near its goal [rad, m] is at it.
LONGEST_QUEUE = 10_000  # Most setpoints under way. More mean that a latency was given in milliseconds.
GAIN_ERROR = 0.13  # Greatest relative error of a drive's rate, from its motor and gear ratio.
# Shares of the arm's limits for the servo. The rest is for gains below 1 and for corrections.
VELOCITY_SHARE, ACCELERATION_SHARE = 0.85, 0.9
# Gain of the position loop [1/s]: an error falls to a third in 0.2 s. It is stable with a delay error of 0.1 s.
STIFFNESS = 5.0
CORRECTION = 0.15  # Greatest correction, as a share of a joint's velocity limit.
STILL = 1e-3  # A joint slower than this [rad/s, m/s] should rest. A slower correction counts as 0.
NEAR_AT_REST = 2e-3  # A resting joint is corrected to within this [rad, m], and again from twice this error.
# Delay from a setpoint to the joint state with its effect [s]: first guess and maximum.
DELAY, LONGEST_DELAY = 0.07, 0.3
SPACING = 0.004  # Least time between remembered rates [s].
# Half a step of a 12-bit encoder [rad]. A moving joint with a smaller error is not corrected.
HALF_STEP = 0.8e-3
# Initial standard deviations of a position [rad, m], a gain, and the delay [s].
FIRST_DEVIATION = np.array([5e-4, 0.15, 0.05])
# Their random-walk changes in a second of motion; for the position also at rest.
WALK = np.array([1.5e-3, 5e-3, 5e-3])
NOISE, JITTER = 0.7e-3, 0.006  # Standard deviations of a measured position [rad, m] and of its time [s].


class SimulatedJoints:
    """The joints of `arm`, at rest at `theta` (n,): a sink and a feedback.

    A setpoint takes effect `latency` [s] later. Each joint moves at the setpoint's rate plus 40 1/s times its position
    error. `velocity` and `acceleration` (n,) [rad/s, m/s, and per s²] limit it. By default these are the arm's limits
    or assumed ones, plus the usual reserve of drives. At a position limit a joint stops
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
        fastest = VELOCITY_RESERVE * usual.velocity if velocity is None else velocity
        hardest = ACCELERATION_RESERVE * usual.acceleration if acceleration is None else acceleration
        self._velocity = one_or_each(fastest, arm.n, "velocity")
        self._acceleration = one_or_each(hardest, arm.n, "acceleration")
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
        self._theta_dot[inside != self._theta] = 0.0  # a hard stop takes all speed
        self._theta = inside


def with_reserve(arm: Arm) -> Arm:
    """The arm with reduced limits. The servo's rates divided by the gains then stay within those of `arm`."""
    given = arm.limits
    velocity, acceleration = VELOCITY_SHARE * given.velocity, ACCELERATION_SHARE * given.acceleration
    return replace(arm, limits=replace(given, velocity=velocity, acceleration=acceleration))


class RateObserver:
    """A Kalman filter for each joint's position θ and drive gain g, with one loop delay D.

    h(t) is the integral of the sent rates u, and θ' = g u. The state heard at t shows the joint as θ − g (h(now) − h(t
    − D)). The delay is in the prediction (a Smith predictor) and not in the loop. A wrong gain leaves a lasting error;
    that of a wrong delay vanishes at rest.

    `rates` closes a position loop: the servo's rate plus STIFFNESS times the distance to the servo's position. It is
    divided by the gain and kept within the arm's velocity and acceleration limits.
    """

    def __init__(self, arm: Arm) -> None:
        self._velocity = arm.limits.velocity
        self._acceleration = arm.limits.acceleration
        n = arm.n
        self._x = np.column_stack([np.zeros(n), np.ones(n), np.full(n, DELAY)])
        self._covariance = np.tile(np.diag(FIRST_DEVIATION**2), (n, 1, 1))
        self._u = np.zeros(n)
        self._travel = np.zeros(n)
        self._history: deque[tuple[float, Array]] = deque()
        self._heard = -np.inf

    @property
    def at_rest(self) -> bool:
        """Whether the drives have zero rates."""
        return not self._u.any()

    def start(self, theta: Array, now: float) -> None:
        """At rest at the measured theta (n,); what was learned of the drives stays."""
        self._x[:, 0] = theta
        self._covariance[:, 0, :] = self._covariance[:, :, 0] = 0.0
        self._covariance[:, 0, 0] = FIRST_DEVIATION[0] ** 2
        self._u = np.zeros_like(self._u)
        self._history.clear()
        self._history.append((now, self._travel))

    def hear(self, measured: Measured | None, now: float) -> None:
        """Begin the cycle at `now` [s] with a usable joint state `measured`, if any."""
        self._predict(now)
        if measured is not None and measured.theta is not None and measured.time > self._heard:
            self._heard = measured.time
            self._update(measured.theta, min(measured.time, now))

    def rates(self, theta: Array, theta_dot: Array, elapsed: float, follow: bool = True) -> Array:
        """The rates u (n,) for a setpoint theta (n,), theta_dot (n,), `elapsed` [s] after the last.

        Unless `follow`, theta is ignored and the joints come to rest as the servo does.
        """
        error = theta - self._x[:, 0] if follow else np.zeros_like(theta)
        resting = np.abs(theta_dot) < STILL
        at_rest = resting & (np.abs(self._u) < STILL)
        near = np.where(at_rest, 2.0 * NEAR_AT_REST, np.where(resting, NEAR_AT_REST, HALF_STEP))
        correction = STIFFNESS * (error - np.clip(error, -near, near))
        correction[resting & (np.abs(correction) < STILL)] = 0.0
        wanted = theta_dot + np.clip(correction, -CORRECTION * self._velocity, CORRECTION * self._velocity)
        wanted = np.clip(wanted / self._x[:, 1], -self._velocity, self._velocity)
        most = self._acceleration * elapsed
        self._u = frozen(np.clip(wanted, self._u - most, self._u + most))
        return self._u

    def _predict(self, now: float) -> None:
        elapsed = now - self._history[-1][0]
        if elapsed < 0.0:  # the clock went back: what was sent and heard in that future is forgotten
            self._history.clear()
            elapsed, self._heard = 0.0, -np.inf
        step = self._u * elapsed
        self._travel = self._travel + step
        # The last entry moves on with time until SPACING has passed, which bounds the history of a fast loop.
        if len(self._history) > 1 and now - self._history[-2][0] < SPACING:
            self._history.pop()
        self._history.append((now, self._travel))
        while len(self._history) > 2 and self._history[1][0] < now - 2.0 * LONGEST_DELAY:
            self._history.popleft()
        self._x[:, 0] += self._x[:, 1] * step
        p = self._covariance
        p[:, 0, :] += step[:, None] * p[:, 1, :]
        p[:, :, 0] += step[:, None] * p[:, :, 1]
        moving = np.column_stack([np.ones_like(step), step != 0.0, step != 0.0])
        p[:, range(3), range(3)] += WALK**2 * elapsed * moving

    def _update(self, theta: Array, heard: float) -> None:
        position, gain, delay = self._x.T
        unsure = np.sqrt(self._covariance[:, 2, 2]) + JITTER
        left = self._travel - self._travelled(heard - delay)
        # The mean rate over what the delay may be: at a start, the rate at one moment would say nothing of the delay.
        rate = (self._travelled(heard - delay + unsure) - self._travelled(heard - delay - unsure)) / (2.0 * unsure)
        error = theta - (position - gain * left)
        row = np.column_stack([np.ones_like(left), -left, -gain * rate])
        spread = np.einsum("nij,nj->ni", self._covariance, row)
        noise = NOISE**2 + (JITTER * rate) ** 2
        weight = spread / (np.einsum("ni,ni->n", row, spread) + noise)[:, None]
        self._x += weight * error[:, None]
        self._x[:, 1] = np.clip(self._x[:, 1], 1.0 - GAIN_ERROR, 1.0 + GAIN_ERROR)
        self._x[:, 2] = np.clip(self._x[:, 2], 0.0, LONGEST_DELAY)
        self._covariance -= weight[:, :, None] * spread[:, None, :]
        self._share_delay()

    def _share_delay(self) -> None:
        """One delay for all joints, the mean weighted by certainty, and the resulting θ and g.

        Different delays would leave the path; a common error only shifts time.
        """
        variance = self._covariance[:, 2, 2]
        common = (self._x[:, 2] / variance).sum() / (1.0 / variance).sum()
        self._x += self._covariance[:, :, 2] / variance[:, None] * (common - self._x[:, 2:])

    def _travelled(self, moments: Array) -> Array:
        """h at a moment for each joint (n,)."""
        times = [time for time, _ in self._history]
        travels = np.array([travel for _, travel in self._history]).T
        return np.array([np.interp(t, times, h) for t, h in zip(moments, travels, strict=True)])
