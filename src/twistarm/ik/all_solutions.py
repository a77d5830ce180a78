"""The answer of `solve_ik_all`: every configuration that reaches a target, and whether these are all."""

from __future__ import annotations

import operator
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..support.checks import Array, frozen
from ..support.errors import printable
from ..support.messages import plural
from .closed_form.methods import Method
from .ranges import holding, joint_ranges
from .solution import errors_in_words, why_not
from .solve import solve_ik
from .targets import AnyTarget, Pose
from .task_space import Tolerances


@dataclass(eq=False, repr=False, slots=True)
class AllSolutions:
    """Configurations inside the limits that reach the target, each verified by forward kinematics. It cannot be
    changed.

    They reach it exactly. Where none does, they miss it by no more than the tolerances, one for each branch.

    Nearest to theta0 first, by the largest joint difference relative to the joint's range (else 2π or 1 m).
    `solutions[i]` is theta[i]. Where a wrist is singular, or an arm redundant, configurations form continuous families.
    A family counts once. Its entry has a free joint at theta0's value, or else is the nearest member. `fixed_joints`
    chooses another.
    """

    _arm: Arm
    _rows: Array
    """(k, 2, n): theta, and 1 for joints that may move while the target stays reached, else 0."""
    _inside: int
    _theta0: Array
    _method: Method
    _complete: bool
    _target: AnyTarget | Array
    _tolerances: Tolerances
    _tries: tuple[int, int] = (0, 0)
    _timed_out: bool = False
    _colliding: NDArray[np.bool_] | None = None

    def __post_init__(self) -> None:
        self._rows.flags.writeable = self._theta0.flags.writeable = False

    @property
    def arm(self) -> Arm:
        """The arm that was solved for."""
        return self._arm

    @property
    def target(self) -> AnyTarget:
        """The target that was solved for."""
        if isinstance(self._target, np.ndarray):
            self._target = Pose(self._target)
        return self._target

    @property
    def theta0(self) -> Array:
        """(n,) [rad, m]: the origin of distances, with given joints at their values."""
        return self._theta0

    @property
    def theta(self) -> Array:
        """(k, n) [rad, m], read-only, nearest to theta0 first."""
        return self._rows[: self._inside, 0]

    @property
    def outside(self) -> Array:
        """(m, n) [rad, m], read-only: configurations outside the limits, turned near to them."""
        return frozen(joint_ranges(self._arm).toward_middle(self._rows[self._inside :, 0]))

    @property
    def free(self) -> tuple[tuple[str, ...], ...]:
        """For each of theta, the joints that can go on moving with the target reached."""
        names = self._arm.joint_names
        moving = self._rows[: self._inside, 1]
        return tuple(tuple(names[i] for i in np.flatnonzero(row)) for row in moving)

    @property
    def colliding(self) -> NDArray[np.bool_]:
        """(k,): which of theta collide with the scene of the call. None without a scene."""
        return np.zeros(len(self), dtype=bool) if self._colliding is None else self._colliding.copy()

    @property
    def complete(self) -> bool:
        """Whether there are no other configurations, except others of the same families.

        False for sampled joints, axes that miss the family, a search, inexact ones, and after a timeout.
        """
        return self._complete

    @property
    def timed_out(self) -> bool:
        """Whether the time was up before everything had been tried."""
        return self._timed_out

    @property
    def method(self) -> str:
        """closed form, elimination or search from many starts."""
        return self._method.name

    @property
    def family(self) -> str:
        """The closed form in words, or why the arm has no closed form."""
        return self._method.in_words(self._arm)

    @property
    def starts(self) -> int:
        """Number of searches, or of values of sampled joints; 0 without either."""
        return self._tries[0]

    @property
    def hits(self) -> int:
        """How many of these reached the target."""
        return self._tries[1]

    @property
    def position_error(self) -> Array:
        """(k,) [m], in what the target constrains."""
        return np.array([self.target.position_error(g) for g in self.arm.fk(self.theta)])

    @property
    def orientation_error(self) -> Array:
        """(k,) [rad], in what the target constrains."""
        return np.array([self.target.orientation_error(g) for g in self.arm.fk(self.theta)])

    def explain(self) -> str:
        """The target and how many configurations reach it, or how far off the nearest is."""
        by_value = f" at each value of {self._sampled}" if self._sampled else ""
        lines = [
            f"target of {self.arm.name}: {self.target.describe()}",
            self._counted(),
            f"{'found' if len(self) else 'looked for'} by {self.method}{by_value}: {self.family}",
        ]
        if not len(self):
            held = holding(self.arm, self._method.given, self.theta0)
            nearest = solve_ik(held, self.target, self.theta0, **self._tolerances.keywords)
            lines.append(f"the nearest configuration: {errors_in_words(nearest)}")
            lines += [] if nearest.converged else why_not(nearest)
        return "\n".join(map(printable, lines))

    @property
    def _sampled(self) -> str:
        """The joints that a closed form or elimination is tried at values of; "" without any."""
        return " and ".join(self.arm.joint_names[i] for i in self._method.sampled) if self._method.algebraic else ""

    def _counted(self) -> str:
        count, beyond = len(self), len(self.outside)
        all_ = "all there are" if self.complete else "there may be more"
        outside = f", {beyond}{' more' * (count > 0)} outside" if beyond else ""
        share = f"{self.hits} of {self.starts}" if self.hits else f"none of {self.starts}"
        tries = f"values of {self._sampled}" if self._sampled else "searches"
        sampled = f", {share} {tries} reached the target" if self.starts else ""
        if not count and self.complete:
            return f"no configuration inside the limits{outside}: that is certain"
        late = "; the time was up before everything had been tried" * self.timed_out
        what = f"{plural(count, 'configuration')} inside the limits"
        hits = int(self.colliding.sum())
        collide = "" if self._colliding is None else f", {hits or 'none'} of them in collision"
        return f"{what}{collide}{self._families(count)}{outside}; {all_}{sampled}{late}"

    def _families(self, count: int) -> str:
        """How many of them are continuous families, and what moves in these."""
        parts = []
        for joints, times in Counter(joints for joints in self.free if joints).items():
            which = f"{times} of them " if times < count else "each " if count > 1 else ""
            what = "every joint" if len(joints) == self.arm.n else " and ".join(joints)
            parts.append(f", {which}of a continuous family in which {what} can move")
        return "".join(parts)

    def __len__(self) -> int:
        return self._inside

    def __iter__(self) -> Iterator[Array]:
        return iter(self.theta)

    def __getitem__(self, index: int) -> Array:
        return self.theta[operator.index(index)]

    def __repr__(self) -> str:
        return f"AllSolutions({self.arm.name}, {self._counted()}; {self.method})"

    def __reduce__(self) -> tuple[Any, ...]:
        return AllSolutions, tuple(getattr(self, name) for name in self.__slots__)  # which makes arrays read-only again
