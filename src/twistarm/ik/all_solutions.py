"""The answer of `solve_ik_all`: every configuration that meets a target, and what is known of the whole set."""

from __future__ import annotations

import operator
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..model.arm import Arm
from ..support.checks import Array, frozen
from ..support.errors import printable
from .explain import reached, why_not
from .solve import solve_ik
from .targets import AnyTarget


@dataclass(frozen=True, eq=False, repr=False)
class IKSolutions:
    """Configurations inside the limits that meet the target, each verified by forward kinematics.

    theta (k, n) [rad, m], read-only: nearest to theta0 first, by the largest joint difference in shares of the joint's
    range (2π or 1 m where it has none). `solutions[i]` is theta[i].
    free: for each of them, the joints that may go on moving while the target stays met, () where it stands alone. Where
    a wrist is singular, or an arm redundant, theta is one of a continuous family, the one nearest to theta0 that was
    found; `given` chooses another.
    outside (m, n): configurations that meet the target beyond the position limits.
    complete: whether these are all there are, but for others of the same families. False where joints were sampled,
    where the axes miss the family that was solved, and for a search.
    method: "closed form", "elimination" or "search from many starts"; `family`: which, in words.
    starts, hits: searches that were run, and how many of them met the target; values of sampled joints, and how many
    gave a configuration. 0 where there was nothing to sample.
    """

    arm: Arm
    target: AnyTarget
    theta0: Array
    theta: Array
    free: tuple[tuple[str, ...], ...]
    outside: Array
    complete: bool
    method: str
    family: str
    starts: int = 0
    hits: int = 0

    def __post_init__(self) -> None:
        for name in ("theta0", "theta", "outside"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def position_error(self) -> Array:
        """(k,) [m], of what the target constrains."""
        return np.array([self.target.position_error(g) for g in self.arm.fk(self.theta)])

    @property
    def orientation_error(self) -> Array:
        """(k,) [rad], of what the target constrains."""
        return np.array([self.target.orientation_error(g) for g in self.arm.fk(self.theta)])

    def explain(self) -> str:
        """What was asked, how many configurations meet it, and where none does, how far off the nearest is."""
        lines = [
            f"asked of {self.arm.name}: {self.target.describe()}",
            self._counted(),
            f"{'found' if len(self) else 'looked for'} by {self.method}: {self.family}",
        ]
        families = sorted({joints for joints in self.free if joints})
        lines += [
            f"one of a continuous family: {', '.join(joints)} may move while the target stays met"
            for joints in families
        ]
        if not len(self):
            nearest = solve_ik(self.arm, self.target, self.theta0)
            lines.append(f"the nearest configuration: {reached(nearest)}")
            lines += [] if nearest.converged else why_not(nearest)
        return "\n".join(map(printable, lines))

    def _counted(self) -> str:
        count, beyond = len(self), len(self.outside)
        all_ = "all there are" if self.complete else "there may be more"
        outside = f", {beyond}{' more' * (count > 0)} outside" if beyond else ""
        sampled = f", {self.hits} of {self.starts} tries met it" if self.starts else ""
        if not count and self.complete:
            return f"no configuration inside the limits{outside}: that is certain"
        return f"{count} configuration{'s' * (count != 1)} inside the limits{outside}; {all_}{sampled}"

    def __len__(self) -> int:
        return len(self.theta)

    def __iter__(self) -> Iterator[Array]:
        return iter(self.theta)

    def __getitem__(self, index: int) -> Array:
        theta: Array = self.theta[operator.index(index)]
        return theta

    def __repr__(self) -> str:
        return f"IKSolutions({self.arm.name}, {self._counted()}; {self.method})"
