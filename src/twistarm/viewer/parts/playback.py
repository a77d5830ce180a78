"""Motions on show: a trajectory with its clock, and an eased move to a configuration."""

from __future__ import annotations

from dataclasses import dataclass

from ...planning.trajectory import Trajectory
from ...support.checks import Array, as_theta

GLIDE_TIME = 0.5
"""Duration of a glide [s], as in page/glide.js."""


@dataclass
class Playback:
    """The clock of one trajectory."""

    trajectory: Trajectory
    speed: float = 1.0
    loop: bool = False
    time: float = 0.0
    running: bool = False
    _last: float = 0.0

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.trajectory.duration)

    def play(self, now: float) -> None:
        """Run from the moment shown; at the end, run from the start."""
        if self.time >= self.duration:
            self.time = 0.0
        self.running, self._last = True, now

    def seek(self, time: float) -> None:
        """Stop at `time`, or at the nearer end."""
        self.running = False
        self.time = min(max(time, 0.0), self.duration)

    def advance(self, now: float) -> None:
        """Advance the clock to `now`. At the end, start again with `loop`; otherwise stop there."""
        if not self.running:
            return
        self.time += self.speed * (now - self._last)
        self._last = now
        if self.time >= self.duration:
            again = self.loop and self.duration > 0.0
            self.time = self.time % self.duration if again else self.duration
            self.running = again

    def theta(self) -> Array:
        """The configuration (n,) at the moment shown."""
        return as_theta(self.trajectory(self.time), len(self.trajectory.joint_names), "the trajectory's theta")


@dataclass(frozen=True, eq=False)
class Glide:
    """From `start` (n,) to `goal` (n,), begun at `begun` [s] on the caller's clock."""

    start: Array
    goal: Array
    begun: float

    def at(self, now: float) -> Array:
        """start + (3s² − 2s³)(goal − start) with s = (now − begun)/GLIDE_TIME: at rest at both ends."""
        s = max(0.0, (now - self.begun) / GLIDE_TIME)
        if s >= 1.0:
            return self.goal
        way: Array = self.start + s * s * (3.0 - 2.0 * s) * (self.goal - self.start)
        return way
