"""Self-motions: which answers lie on one connected family. A walk along the null space leads from one to the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array
from .closed_form.roots import DEPENDENT, Asked, apart
from .deadline import Deadline
from .ranges import TURN, joint_ranges

STEP = 0.2
"""[rad, m] along a self-motion, the norm over the joints."""

SHORT, LONG = 10, 200
"""Steps toward an answer nearby, and along a whole curve."""

NEIGHBOURS = 3
"""Number of families whose nearest member is compared before an answer starts a new family."""

MOST_PAIRS = 300
"""Most families to connect, and most members of each, evenly chosen."""

REACHED = 1e-3
"""[rad, m]: nearer than this, two members are together."""

NEARBY = 0.5
"""Two members nearer than this [rad, m] are together if the midpoint corrects to about itself, up to this share:"""

BENT = 0.1

ACROSS = 0.1
"""A path leads past its goal if less than this share of the remaining distance is along it."""

ACCURACY = 1e-10
"""Greatest errors [m, rad] on the way."""


@dataclass(frozen=True, eq=False)
class SelfMotions(Asked):
    """Motions of the arm that keep the target met, with the joints `still` at rest.

    Singular values below the part `dependent` of the largest are directions without first-order motion.
    """

    still: tuple[int, ...]
    deadline: Deadline
    dependent: float = DEPENDENT

    @cached_property
    def _moving(self) -> list[int]:
        return [i for i in range(self.arm.n) if i not in self.still]

    def families(self, members: Sequence[Array]) -> list[list[int]]:
        """The places of those that lie on one connected self-motion. Two without a way between them stay apart."""
        thetas = np.array(members).reshape(-1, self.arm.n)
        thetas = np.where(joint_ranges(self.arm).periodic, thetas % TURN, thetas)
        family = np.arange(len(thetas))
        for i in self.deadline.until(range(1, len(thetas))):
            away = self._away(thetas[:i], thetas[i])
            for _ in range(NEIGHBOURS):
                j = int(np.argmin(away))
                if away[j] > SHORT * STEP:
                    break
                if self.together(thetas[i], thetas[j], SHORT):
                    family[i] = family[j]
                    break
                away[family[:i] == family[j]] = np.inf
        for first in self.deadline.until(np.unique(family)):
            if family[first] == first:  # not joined to another meanwhile
                self._join_along(thetas, family, int(first))
        return [np.flatnonzero(family == first).tolist() for first in np.unique(family)]

    def _join_along(self, thetas: Array, family: NDArray[np.intp], first: int) -> None:
        """Join all members on one self-motion to the family of this one."""
        others = np.flatnonzero(family > first)
        if not len(others):
            return
        if len(self._tangents(thetas[first])) == 1:
            for place in self.passed(thetas[first], [*thetas[others]]):
                family[family == family[others[place]]] = first
            return
        for other in np.unique(family[others])[:MOST_PAIRS]:
            a, b = (each[:: 1 + len(each) // MOST_PAIRS] for each in (thetas[family == first], thetas[family == other]))
            away = np.array([self._away(b, each) for each in a])
            i, j = np.unravel_index(int(np.argmin(away)), away.shape)
            if self.together(a[i], b[j], LONG // 4):
                family[family == other] = first

    def together(self, a: Array, b: Array, steps: int = LONG) -> bool:
        """Whether the self-motion connects a and b (n,) in at most so many steps."""
        left = apart(self.arm, b, a)
        if np.abs(left).max(initial=0.0) < NEARBY:
            halfway = a + 0.5 * left
            between = self.corrected(halfway, self.still, self.dependent, ACCURACY)
            if np.linalg.norm(between - halfway) <= BENT * np.linalg.norm(left) and self.met(between):
                return True
        x, along = a, left
        for _ in range(steps):
            left = apart(self.arm, b, x)
            if np.abs(left).max(initial=0.0) < REACHED:
                return True
            tangents = self._tangents(x)
            # On a curve the way goes on as it began; else it leads straight to b.
            along = tangents.T @ (tangents @ (along if len(tangents) == 1 else left))
            size, far = float(np.linalg.norm(along)), float(np.linalg.norm(left))
            toward = float(along @ left) / max(size, 1e-300)
            if abs(toward) < ACROSS * far and (len(tangents) != 1 or far < STEP):
                return False
            on = self._step_on(x, along, toward if far < 2.0 * STEP and toward > 0.0 else STEP)
            if on is None:
                return False
            along, x = on - x, on
        return False

    def passed(self, start: Array, goals: Sequence[Array]) -> set[int]:
        """The places of the goals, (n,) each, on the closed curve through the start (n,).

        For a start with several ways to move: the indices of the goals that a way reaches.
        """
        if len(self._tangents(start)) != 1:
            return {i for i in self.deadline.until(range(len(goals))) if self.together(start, goals[i], LONG // 4)}
        found: set[int] = set()
        there = np.array(goals).reshape(-1, self.arm.n)
        for sense in (1.0, -1.0):
            x, along = start, sense * self._tangents(start)[0]
            for count in self.deadline.until(range(LONG)):
                tangents = self._tangents(x)
                on = self._step_on(x, tangents.T @ (tangents @ along), STEP)
                if on is None:
                    break
                along, x = on - x, on
                near = np.linalg.norm(apart(self.arm, there, x), axis=1) < 1.5 * STEP
                new = {*np.flatnonzero(near).tolist()} - found
                found |= {i for i in new if self.together(x, goals[i], SHORT)}
                if len(found) == len(goals) or (count > 1 and np.linalg.norm(apart(self.arm, x, start)) < 0.75 * STEP):
                    return found
        return found

    def _step_on(self, x: Array, along: Array, length: float) -> Array | None:
        """The member (n,) one step on in the direction `along`. None where the motion ends."""
        size = float(np.linalg.norm(along))
        if size < 1e-9:
            return None
        for share in (1.0, 0.25):
            step = share * min(length, STEP)
            on = self.corrected(x + step / size * along, self.still, self.dependent, ACCURACY)
            if 0.5 * step <= np.linalg.norm(on - x) <= 1.5 * step and self.met(on):
                return on
        return None

    def _away(self, thetas: Array, theta: Array) -> Array:
        """The largest joint differences (k,) of thetas (k, n) from theta (n,), without whole turns."""
        left = np.abs(thetas - theta)
        turns = joint_ranges(self.arm).periodic
        left[:, turns] = np.minimum(left[:, turns], np.abs(TURN - left[:, turns]))
        return left.max(axis=1, initial=0.0)

    def _tangents(self, theta: Array) -> Array:
        """The directions (d, n) that move nothing at first, orthonormal."""
        J = self.rows(theta)[1][:, self._moving]
        _, size, Vt = np.linalg.svd(J)
        rank = int((size > self.dependent * size.max(initial=1e-300)).sum())
        tangents = np.zeros((len(Vt) - rank, self.arm.n))
        tangents[:, self._moving] = Vt[rank:]
        return tangents
