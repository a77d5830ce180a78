"""An eased motion to another configuration in half a second, straight in joint space."""

from __future__ import annotations

from dataclasses import dataclass

from ...support.checks import Array

TIME = 0.5
"""[s]; as in page/glide.js."""


@dataclass(frozen=True, eq=False)
class Glide:
    """From `start` (n,) to `goal` (n,), begun at `begun` [s] on the caller's clock."""

    start: Array
    goal: Array
    begun: float

    def at(self, now: float) -> Array:
        """start + (3s² − 2s³)(goal − start) with s = (now − begun)/TIME: at rest at both ends."""
        s = max(0.0, (now - self.begun) / TIME)
        if s >= 1.0:
            return self.goal
        way: Array = self.start + s * s * (3.0 - 2.0 * s) * (self.goal - self.start)
        return way
