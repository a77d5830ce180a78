"""Self-motions: motions of the arm that keep a target reached. Answers that one of them connects are one family."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..support.checks import Array
from .closed_form.roots import DEPENDENT, Task, joint_difference
from .ranges import TURN, joint_ranges
from .request import Deadline

STEP = 0.2  # Along a self-motion, the norm over the joints [rad, m].
# Most steps along a curve, in either sense, and straight toward another answer.
CURVE_STEPS, STRAIGHT_STEPS = 200, 50
NEIGHBOUR = 0.5  # Two answers nearer than this [rad, m] are together if halfway the target is reached, ...
BENT = 0.1  # ... after a correction of at most this share of their distance.
ACCURACY = 1e-10  # Greatest errors [m, rad] on the way.
MOST_COMPARED = 300  # Answers of a family, evenly chosen, that may be the nearest to another.


@dataclass(frozen=True, eq=False)
class SelfMotions(Task):
    """Motions of the arm that keep the target reached, with the joints `still` at rest.

    Their tangents are the null space of the Jacobian. Where that is a line, the answers are a curve, and one walk along
    it passes them all. Where it has more dimensions, straight walks connect neighbours.
    """

    still: tuple[int, ...]
    deadline: Deadline

    def families(self, thetas: Sequence[Array]) -> Iterator[tuple[list[int], Array]]:
        """The places of the answers of one family, and the curve (k, n) that connects them.

        Two families without a way between them stay separate. Answers not compared before the deadline count with
        the last family: no family is then listed many times.
        """
        every = np.array(thetas).reshape(-1, self.arm.n)
        left = np.arange(len(every))
        while left.size:
            first, left = int(left[0]), left[1:]
            curve, rows = self.curve(every[first]), every[left]
            found = self._on_curve(curve, rows) if len(curve) > 1 else self._beside(every[first], rows)
            of_it = np.isin(np.arange(len(left)), list(found)) | self.deadline.passed
            yield [first, *left[of_it].tolist()], curve
            left = left[~of_it]

    def curve(self, start: Array) -> Array:
        """The whole curve (k, n) through an answer. An answer that lies on no curve comes alone."""
        tangents = self._tangents(start)
        if len(tangents) != 1:
            return start[None]
        ways: list[list[Array]] = []
        for sense in (1.0, -1.0):
            way, along = [start], sense * tangents[0]
            for _ in self.deadline.until(range(CURVE_STEPS)):
                T = self._tangents(way[-1])
                on = self._step(way[-1], T.T @ (T @ along), STEP)
                if on is None:
                    break
                along = on - way[-1]
                way.append(np.where(joint_ranges(self.arm).periodic, on % TURN, on))
                left = joint_difference(self.arm, start, on)
                closes = left @ along > 0.0 and (sense * tangents[0]) @ along > 0.0  # from behind, and not in a bend
                if closes and np.linalg.norm(left) < STEP:
                    return np.array([*way, start])
            ways.append(way)
        return np.array([*ways[1][:0:-1], *ways[0]])

    def _on_curve(self, curve: Array, thetas: Array) -> set[int]:
        """The places of the answers (m, n) that lie on the curve."""
        found = set()
        for i, theta in self.deadline.until(enumerate(thetas)):
            away = np.linalg.norm(joint_difference(self.arm, curve, theta), axis=1)
            nearest = int(np.argmin(away))
            if away[nearest] < STEP and self._connected(theta, curve[nearest]):
                found.add(i)
        return found

    def _beside(self, first: Array, thetas: Array) -> set[int]:
        """The places of the answers (m, n) that straight walks connect with the first, the nearest first."""
        order = np.argsort(np.linalg.norm(joint_difference(self.arm, thetas, first), axis=1))
        family, found = [first], set[int]()
        for i in self.deadline.until(order.tolist()):
            known = np.array(family[:: 1 + len(family) // MOST_COMPARED])
            nearest = known[int(np.argmin(np.linalg.norm(joint_difference(self.arm, known, thetas[i]), axis=1)))]
            if self._connected(thetas[i], nearest):
                family.append(thetas[i])
                found.add(i)
        return found

    def passing(self, curve: Array, joint: int, value: float) -> Iterator[Array]:
        """The members (n,) where the curve (k, n) passes a value of a joint."""
        goal = np.array(curve[0])
        goal[joint] = value
        away = joint_difference(self.arm, curve, goal)[:, joint]
        for k in np.flatnonzero((away[:-1] * away[1:] <= 0.0) & (np.abs(np.diff(away)) < 2.0 * STEP)):
            share = away[k] / ((away[k] - away[k + 1]) or 1.0)  # 1.0: the joint stands at the value all the way
            theta = curve[k] + share * joint_difference(self.arm, curve[k + 1], curve[k])
            theta[joint] = curve[k, joint] - away[k]
            theta = self._corrected(theta, joint)
            if self.converged(theta):
                yield theta

    def toward(self, start: Array, goal: Array) -> Iterator[Array]:
        """Members (n,) from the start on, each nearer to the goal, until none is."""
        x, left = start, joint_difference(self.arm, goal, start)
        for _ in self.deadline.until(range(STRAIGHT_STEPS)):
            T = self._tangents(x)
            along = T.T @ (T @ left)
            on = self._step(x, along, min(STEP, float(np.linalg.norm(along))))
            if on is None or np.linalg.norm(joint_difference(self.arm, goal, on)) >= np.linalg.norm(left):
                return
            x, left = on, joint_difference(self.arm, goal, on)
            yield x

    def _connected(self, a: Array, b: Array) -> bool:
        """Whether a straight walk leads from a to b (n,)."""
        return self._together(a, b) or any(self._together(x, b) for x in self.toward(a, b))

    def _together(self, a: Array, b: Array) -> bool:
        """Whether two answers (n,) are near, and halfway between them is one too."""
        left = joint_difference(self.arm, b, a)
        if np.abs(left).max(initial=0.0) >= NEIGHBOUR:
            return False
        halfway = a + 0.5 * left
        between = self._corrected(halfway)
        return bool(np.linalg.norm(between - halfway) <= BENT * np.linalg.norm(left)) and self.converged(between)

    def _step(self, x: Array, along: Array, length: float) -> Array | None:
        """The member (n,) one step on in the direction `along` (n,). None where the motion ends."""
        size = float(np.linalg.norm(along))
        # The shorter step is for bends in which Newton's method would leave the curve.
        for step in (length, 0.25 * length) if size > 1e-9 else ():
            on = self._corrected(x + step / size * along)
            if 0.5 * step <= np.linalg.norm(on - x) <= 1.5 * step and self.converged(on):
                return on
        return None

    def _corrected(self, theta: Array, *held: int) -> Array:
        return self.corrected(theta, (*self.still, *held), DEPENDENT, ACCURACY)

    def _tangents(self, theta: Array) -> Array:
        """The directions (d, n) that move nothing at first, orthonormal."""
        moving = [i for i in range(self.arm.n) if i not in self.still]
        _, size, Vt = np.linalg.svd(self.rows(theta)[1][:, moving])
        rank = int((size > DEPENDENT * size.max(initial=1e-300)).sum())
        tangents = np.zeros((len(Vt) - rank, self.arm.n))
        tangents[:, moving] = Vt[rank:]
        return tangents
