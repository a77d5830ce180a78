"""The directions of the tool that a posture lacks or nearly lacks, and how an arm leaves it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from twistarm.support.checks import Array
from twistarm.support.directions import leading

from .rates import PRECEDENCE, RateTask

BESIDE = 0.02
"""How far beside a posture one looks for directions that it lacks [scaled rad]."""

NOTHING = 1e-12
"""Slower scaled rates are rounding."""

NO_MOTION = 1e-9
"""Singular values below this are none at all."""

NO_WAY = 1e-5
"""Of the rows beside a posture: singular values below this show no way out."""

RISE = 0.05
"""dσ per scaled radian, times the share of the twist: from here on a motion leaves a singularity entirely."""

DIFFERENCE = 1e-4
"""Step of a finite difference [scaled rad]."""

MISSED = 0.1
"""Of the twist: where a smaller part is lost, nothing is looked at."""

LEFT_BEHIND = 0.055
"""What a singular value on its way up counts as: √(τ V) for a twist of V = 0.1 rad/s, from where on V/σ is worth it."""

CALM_BELOW = 0.1
"""What turns a held direction is damped by τ times the square of this over σ."""

TAKEN = 0.02
"""dσ per scaled radian of the whole motion, which the levels bend: less takes back what was seen of the way out."""

ON_COURSE = 2e-3
"""What singular values count as at least, where the arm keeps to its course."""

JOINTS_TO_POINT = 5
"""Joints that position and point a tool; below, the position alone can be singular, and is looked at first."""


AS_GOOD_AS_NONE = 2e-4
"""A smaller singular value may be left to either side."""

MORE_ROOM = 0.1
"""A way out is taken for its room where it ends so much farther off [scaled rad]. With less the arm would turn back."""


class Place(NamedTuple):
    """A posture as singularities are looked for: functions of scaled joint displacements (n,).

    rows: the Jacobian's (6, n) so far away. toward (n,): the unit way to a good posture. way_left: how far the joints
    may move along a unit motion before one is at its limit.
    """

    rows: Callable[[Array], Array]
    toward: Array
    way_left: Callable[[Array], float]


class Singular(NamedTuple):
    """The motions of a tool at a posture that is singular, J (6, n) the rows there.

    sigma (k,): singular values, descending; U (6, k), V (n, k): what the tool and the joints do along each; leaving
    (k,), 0 … 1: how far what is asked for leaves the singularity, and edge (k,): what σ counts as then. of_position:
    whether they are those of the position alone.
    """

    J: Array
    sigma: Array
    U: Array
    V: Array
    leaving: Array
    edge: Array
    of_position: bool

    def lead(self, task: RateTask, stops: bool) -> RateTask:
        """The task as it will be where the motion leaves the singularity; on its course at any rates."""
        led = (self.U * (self.leaving * (self.edge - self.sigma))) @ self.V.T
        led[list(task.held)] = 0.0
        led += task.rows
        if not stops:
            return replace(task, rows=led)
        turning = float(self.leaving.max()) if self.of_position else 0.0
        return replace(task, rows=led, undamped=(self.V * self.leaving) @ self.V.T, turning=turning)

    def taken(self, place: Place, x: Array) -> Singular:
        """Of the ways out what the arm really takes at the scaled rates x (n,), which the other levels bend."""
        size = float(np.linalg.norm(x))
        if size <= NOTHING:
            return self
        along = (place.rows(DIFFERENCE / size * x) - self.J) / DIFFERENCE
        rises = np.einsum("id,ij,jd->d", self.U, along, self.V)
        return self._replace(leaving=self.leaving * np.clip(rises / TAKEN, 0.0, 1.0))

    def without_ways_out(self, lost: Array) -> Array:
        """Of what is lost (6,) all but what the arm is about to have again, because it leaves a singularity."""
        rest: Array = lost - self.U @ (self.leaving * (self.U.T @ lost))
        return rest

    def part(self, lost: Array, below: float) -> tuple[float, int]:
        """Of what is lost (6,) the square of the part along singular directions, and the joint that moves most there.

        Of joints that move alike the first counts. The joint is −1 where nothing is lost along them, or none moves.
        """
        parts = np.where(self.sigma < below, ((1.0 - self.leaving) * (self.U.T @ lost)) ** 2, 0.0)
        gravest = int(np.argmax(parts))
        moved = np.abs(self.V[:, gravest])
        joint = leading(moved) if parts[gravest] > 0.0 and moved.any() else -1
        return float(parts.sum()), joint


def singular(place: Place, task: RateTask, lost: Array, below: float, stops: bool, steady: bool) -> Singular | None:
    """Where the arm is singular and of a task so much is lost (6,); None where it is not, or too little is.

    An arm must be able to move away: a singular value that rises as the arm moves counts as LEFT_BEHIND. (An arm that
    is exactly stretched has no rates at all that pull its tool back to first order.) Where the arm keeps to its course,
    it counts as itself and is not damped. dσ per scaled radian along v is uᵀ (∂J/∂v) v. A direction that this very
    posture lacks is read off one a little beside, on the way `toward` a good one. Where the arm is as good as exactly
    singular, v and −v both lead out, and it takes the one that does not end at a limit soon.
    """
    size, n = float(np.linalg.norm(task.asked)), len(place.toward)
    much = float(np.linalg.norm(lost)) / max(size, np.finfo(float).tiny) / MISSED - 1.0
    if much <= 0.0:
        return None
    J, enough = task.J, max(below, LEFT_BEHIND)
    of_position = n < JOINTS_TO_POINT and smallest_about(J[:3]) < max(below, 2.0 / PRECEDENCE)
    if not of_position and smallest_about(J) >= enough:
        return None
    sigma, U, V = _decomposed(place, J, range(3 if of_position else 6))
    leaving, edges = np.zeros(len(sigma)), np.zeros(len(sigma))
    for d in range(len(sigma)):
        u, v = U[:, d], V[:, d].copy()
        # The way out of a position may turn the tool, which a lower level resists.
        edge = max(below, 2.0 * float(np.linalg.norm(J[3:] @ v)) / PRECEDENCE) if of_position else enough
        edges[d] = max(ON_COURSE, sigma[d]) if stops else edge
        if sigma[d] >= edge:
            continue
        share = float(u @ lost)
        way = -v if share < 0.0 else v
        if sigma[d] < AS_GOOD_AS_NONE and place.way_left(way) + MORE_ROOM < place.way_left(-way):
            sigma[d], V[:, d] = -sigma[d], -v
        rise = float(u @ (place.rows(DIFFERENCE * v) - J) @ v) / DIFFERENCE
        leaving[d] = min(much, 1.0) * min(max(rise * share / size / RISE, 0.0), 1.0)
        if of_position and steady and not stops and leaving[d] < min(much, 1.0):
            turns = 2.0 / PRECEDENCE * np.linalg.norm(J[3:] @ V, axis=0)
            bent, motion = _bent(place, J, u * np.sign(share), V[:, sigma >= np.maximum(below, turns)][:, :2])
            out = min(much, 1.0) * min(bent * abs(share) / size / RISE, 1.0)
            if out <= leaving[d]:
                continue
            leaving[d] = out
            side = np.sign(share) * (-1.0 if task.asked[:3] @ J[:3] @ motion < 0.0 else 1.0)
            sigma[d], V[:, d] = 0.0, side * motion
            edges[d] = max(below, 2.0 * float(np.linalg.norm(J[3:] @ motion)) / PRECEDENCE)
    return Singular(J, sigma, U, V, leaving, edges, of_position)


def _bent(place: Place, J: Array, u: Array, V: Array) -> tuple[float, Array]:
    """Of the motions V (n, k) the unit one along which the tool's path bends most to u, and how much; 0: none does.

    At a rest that is held up by the turn that the way out takes, the tool stands where its path is farthest from there:
    any of these motions brings it back, but none to first order.
    """
    if V.shape[1] == 0:
        return 0.0, u
    C = np.array([u @ (place.rows(DIFFERENCE * v) - J) @ V / DIFFERENCE for v in V.T])
    bent, motions = np.linalg.eigh(0.5 * (C + C.T))
    return float(bent[-1]), V @ motions[:, -1]


def fixed(place: Place, held: Sequence[int], damping: float) -> tuple[Array, Array, Array]:
    """J (6, n), its rows as they count where components are held, and what is damped beside τ, (n, n).

    A held direction with a singular value below LEFT_BEHIND counts as that, so that its joint motion v is as good as
    fixed: it would take the tool away by σ, and to second order. v itself turns by (∂J/∂x)ᵀ u / σ as the arm moves at
    x. What turns it is damped by 1/σ², so that no step turns it by much, however small σ is.
    """
    J, n = place.rows(np.zeros(len(place.toward))), len(place.toward)
    rows, calm = J.copy(), np.zeros((n, n))
    if not held or smallest_about(J[list(held)]) >= LEFT_BEHIND:
        return J, rows, calm
    for sigma, u, v in zip(*(of.T for of in _decomposed(place, J, held)), strict=True):
        if sigma >= LEFT_BEHIND or not v.any():
            continue
        rows += (LEFT_BEHIND - sigma) * np.outer(u, v)
        turns = np.array([u @ (place.rows(DIFFERENCE * unit) - J) / DIFFERENCE for unit in np.eye(n)])
        calm += damping * CALM_BELOW**2 * (max(sigma, DIFFERENCE) ** -2 - LEFT_BEHIND**-2) * turns @ turns.T
    return J, rows, calm


def _decomposed(place: Place, J: Array, chosen: Sequence[int]) -> tuple[Array, Array, Array]:
    """σ (k,), U (6, k), V (n, k) of the chosen rows; k as many as random postures have, V 0 where those have none."""
    of = np.isin(np.arange(6), chosen)
    rows, rank = np.where(of[:, None], J, 0.0), min(len(chosen), J.shape[1])
    U, sigma, Vt = np.linalg.svd(rows)
    strong = int((sigma[:rank] > NO_MOTION).sum())
    sigma = np.where(np.arange(rank) < strong, sigma[:rank], 0.0)
    weak, U, V = U[:, strong:], U[:, :rank].copy(), Vt[:rank].T.copy()
    if strong < rank:
        free = np.eye(J.shape[1]) - V[:, :strong] @ V[:, :strong].T
        Y, sizes, Zt = np.linalg.svd(weak[of].T @ place.rows(BESIDE * place.toward)[of] @ free)
        U[:, strong:] = (weak @ Y)[:, : rank - strong]
        V[:, strong:] = np.where(sizes > NO_WAY, Zt[: len(sizes)].T, 0.0)[:, : rank - strong]
    return sigma, U, V


def smallest_about(rows: Array) -> float:
    """At most the smallest of the k singular values of rows (m, n), k = min(m, n), and at least 1/√k of it.

    1/√tr((A Aᵀ)⁻¹): what the core finds by L D Lᵀ.
    """
    sigma = np.linalg.svd(rows, compute_uv=False)
    return 0.0 if sigma[-1] == 0.0 else float(1.0 / np.sqrt((1.0 / sigma**2).sum()))
