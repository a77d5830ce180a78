"""Velocities from which all joints and motors can still stop inside their limits."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import sqrt
from typing import NamedTuple

import numpy as np

from ..support.checks import Array, frozen
from ..support.display import Brief
from ..support.errors import InputError
from .joint_limits import JointLimits

STILL = 1e-12
"""A slower row [rad/s, m/s] is at rest and meets no limit. Its motion is rounding."""

ROUNDED = 1.0 + 1e-9
"""Excess of a product of two rounded numbers over its bound."""


class Allowed(NamedTuple):
    """The velocities theta_dot (n,) to command, and the row `by` with the `limit` that restricts them.

    `limit` is "position", "velocity" or "acceleration". Both are None where nothing holds the command back.
    """

    theta_dot: Array
    by: str | None = None
    limit: str | None = None


@dataclass(frozen=True, eq=False, repr=False)
class MotionLimits(Brief):
    """Limits of x = C theta + c, one row per motor or joint: C (r, n), c (r,) [rad or m].

    A motion is safe if the arm can stop straight on, all joints slowing in proportion. That takes the time T = max |ẋ|
    / acceleration. No row may meet its position limit, at its present speed, within dt + T/2. Slowing by dt/T in the
    next step keeps this true for any dt. Every row stays below its acceleration. So there is always a way out. (Braking
    each row separately would be shorter, but coupled rows cannot move that way.)

    For inner loops: only construction checks anything.
    """

    names: tuple[str, ...]
    C: Array
    c: Array
    limits: JointLimits
    _per_limit: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        for name in ("C", "c"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        r = len(self.names)
        if not r or self.C.ndim != 2 or {len(self.C), self.c.size, self.limits.lower.size} != {r}:
            raise InputError(f"{r} names, C {self.C.shape}, c {self.c.shape} and limits must have the same rows, not 0")
        per_limit = frozen(1.0 / np.stack([self.limits.velocity, self.limits.acceleration]))
        object.__setattr__(self, "_per_limit", per_limit)

    def within(self, theta: Array, theta_dot: Array, previous_theta_dot: Array, dt: float) -> Allowed:
        """The command for the next dt [s] instead of theta_dot (n,), after previous_theta_dot (n,).

        First theta_dot is slowed as a whole to the velocity and position limits. If the accelerations allow less, it
        takes another speed of that motion. Failing that, it takes a part of the change. If the arm would then be
        unsafe, it mixes in the least sufficient part of the straight stop.
        """
        x = self.C @ theta + self.c
        scale, by, limit = self._slowed(x, self.C @ theta_dot, dt)
        target = scale * theta_dot
        hurry = np.abs(self.C @ (target - previous_theta_dot)) * self._per_limit[1]
        most = float(hurry.max()) / dt
        if most > 1.0:
            speed = self._speed_in_reach(self.C @ target, self.C @ previous_theta_dot, dt)
            turned = previous_theta_dot + (target - previous_theta_dot) / most
            target = turned if speed is None else speed * target
            by, limit = (by, limit) if limit else (int(hurry.argmax()), "acceleration")
            ahead = self.C @ target
            if not self._safe(x, ahead, dt, self._stopping_time(ahead)):
                target, by, limit = self._braked_part(x, previous_theta_dot, target, dt)
        return Allowed(target, self.names[by], limit) if limit else Allowed(target)

    def _slowed(self, x: Array, ahead: Array, dt: float) -> tuple[float, int, str | None]:
        """The scale s of `ahead` (r,) within velocities and positions, and the limiting row.

        By position: s dt + s² T/2 ≤ t, where t is the time to the first limit.
        """
        used = np.abs(ahead) * self._per_limit
        most, stopping = used.max(axis=1).tolist()
        scale, row, limit = (1.0 / most, int(used[0].argmax()), "velocity") if most > 1.0 else (1.0, -1, None)
        if not self._safe(x, scale * ahead, dt, scale * stopping):
            time, met = self._time_to_limit(x, ahead)
            if scale * (dt + 0.5 * scale * stopping) > time:
                return 2.0 * time / (dt + sqrt(dt * dt + 2.0 * stopping * time)), met, "position"
        return scale, row, limit

    def _speed_in_reach(self, ahead: Array, now: Array, dt: float) -> float | None:
        """The s nearest to 1 for which s · ahead (r,) may follow `now` (r,), or None."""
        room = self.limits.acceleration * dt
        moving = np.abs(ahead) > STILL
        if (np.abs(now) > room)[~moving].any():
            return None
        middle, half = now[moving] / ahead[moving], room[moving] / np.abs(ahead[moving])
        fastest = 1.0 / max(float((np.abs(ahead) * self._per_limit[0]).max()), STILL)
        least = float((middle - half).max(initial=0.0))
        most = float((middle + half).min(initial=fastest))
        if least > most:
            return None
        speed = min(max(1.0, least), most)
        # Rows that stand still beside the others may not be carried beyond their accelerations by a large speed.
        return speed if (np.abs(speed * ahead - now) <= room * ROUNDED).all() else None

    def _braked_part(self, x: Array, previous: Array, target: Array, dt: float) -> tuple[Array, int, str]:
        """The largest safe part of `target` (n,), mixed with the straight stop, and the limiting row.

        Between two courses no stop takes longer than the longer of theirs. Where the straight stop would be unsafe at
        that length, nothing is mixed in.
        """
        stopping = self._stopping_time(self.C @ previous)
        stop = previous * (1.0 - min(1.0, dt / stopping)) if stopping > 0.0 else np.zeros_like(previous)
        slow, ahead = self.C @ stop, self.C @ target
        longer = max(self._stopping_time(slow), self._stopping_time(ahead))
        if not self._safe(x, slow, dt, longer):
            return stop, self._time_to_limit(x, slow)[1], "position"
        time = dt + 0.5 * longer
        share, row = self._time_to_limit(x + time * slow, time * (ahead - slow))
        return stop + min(1.0, share) * (target - stop), row, "position"

    def _safe(self, x: Array, x_dot: Array, dt: float, stopping: float) -> bool:
        """Tell whether after dt + T/2 at x_dot no row is beyond a position limit, or farther than now."""
        then = x + (dt + 0.5 * stopping) * np.where(np.abs(x_dot) > STILL, x_dot, 0.0)
        upper, lower = np.maximum(self.limits.upper, x), np.minimum(self.limits.lower, x)
        return bool((then <= upper).all() and (then >= lower).all())

    def _time_to_limit(self, x: Array, x_dot: Array) -> tuple[float, int]:
        """Time [s] until the first row meets a position limit at x_dot, and that row."""
        room = np.maximum(np.where(x_dot > 0.0, self.limits.upper - x, x - self.limits.lower), 0.0)
        speed = np.abs(x_dot)
        time = np.where(speed > STILL, room / np.maximum(speed, STILL), np.inf)
        row = int(time.argmin())
        return float(time[row]), row

    def _stopping_time(self, x_dot: Array) -> float:
        """Return the time [s] of a straight stop from x_dot."""
        return float((np.abs(x_dot) * self._per_limit[1]).max())
