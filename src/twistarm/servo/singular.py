"""The directions of the tool that a posture lacks or nearly lacks, and how an arm leaves it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..checks import Array
from .resolved_rates import PRECEDENCE, Task, weights

BESIDE = 0.02
"""How far beside a posture one looks for directions that it lacks [scaled rad]."""

NO_MOTION = 1e-9
"""Singular values below this are none at all."""

RISE = 0.05
"""dσ per scaled radian, times the share of the twist: from here on a motion leaves a singularity entirely."""

DIFFERENCE = 1e-4
"""Step of a finite difference [scaled rad]."""

MISSED = 0.1
"""Of the twist: where a smaller part is lost, nothing is looked at."""

WIDEST, WIDEST_OF_SIX = 0.3, 0.06
"""Singular values above these count as themselves, in arms of fewer than six joints and of more."""

FIVE = 5
"""Joints below which the position alone can be singular, and is looked at first."""


class Singular(NamedTuple):
    """The motions of a tool at a posture that is singular.

    sigma (k,): singular values, descending; U (6, k), V (n, k): what the tool and the joints do along each; leaving
    (k,), 0 … 1: how far what is asked for leaves the singularity. led (6, n): the Jacobian's rows as they will be then.
    """

    sigma: Array
    U: Array
    V: Array
    leaving: Array
    led: Array

    def part(self, lost: Array, below: float) -> tuple[float, int]:
        """Of what is lost (6,) the square of the part along singular directions, and the joint that moves most there.

        The joint is −1 where nothing is lost along them.
        """
        parts = np.where(self.sigma < below, ((1.0 - self.leaving) * (self.U.T @ lost)) ** 2, 0.0)
        gravest = int(np.argmax(parts))
        joint = int(np.argmax(np.abs(self.V[:, gravest]))) if parts[gravest] > 0.0 else -1
        return float(parts.sum()), joint


Displaced = Callable[[Array], Array]
"""The rows (6, n) at a posture that is a scaled joint displacement (n,) away."""


def singular(jacobian: Displaced, toward: Array, task: Task, lost: Array, below: float) -> Singular | None:
    """Where the arm is singular and of a task so much is lost (6,); None where it is not, or too little is.

    An arm must be able to move away: a singular value that rises as the arm moves counts as more, see `_edge`. (An arm
    that is exactly stretched has no rates at all that pull its tool back to first order.) dσ per scaled radian along v
    is uᵀ (∂J/∂v) v. A direction that this very posture lacks is read off one a little beside, on the way `toward` (n,)
    a good one.
    """
    size = float(np.linalg.norm(task.asked))
    much = float(np.linalg.norm(lost)) / max(size, np.finfo(float).tiny) / MISSED - 1.0
    if much <= 0.0:
        return None
    J, widest = jacobian(np.zeros(len(toward))), max(below, _widest(len(toward)))
    if len(toward) < FIVE and smallest_about(J[:3]) < max(below, 2.0 / PRECEDENCE):
        count = 3
    elif smallest_about(J) < widest:
        count = 6
    else:
        return None
    sigma, U, V = _decomposed(J, count, lambda: jacobian(BESIDE * toward))
    led, leaving = J.copy(), np.zeros(len(sigma))
    for d in range(len(sigma)):
        u, v = U[:, d], V[:, d]
        # The way out of a position may turn the tool, which a lower level resists.
        turned = float(np.linalg.norm(J[3:] @ v))
        edge = max(below, 2.0 * turned / PRECEDENCE if count == 3 else _edge(task, u))
        if sigma[d] < edge:
            rise = float(u @ (jacobian(DIFFERENCE * v) - J) @ v) / DIFFERENCE
            leaving[d] = min(much, 1.0) * min(max(rise * float(u @ lost) / size / RISE, 0.0), 1.0)
            led += leaving[d] * (edge - sigma[d]) * np.outer(u, v)
    return Singular(sigma, U, V, leaving, led)


def _edge(task: Task, u: Array) -> float:
    """The least σ at which rates V/σ are worth what they bring for V along u (6,): √(τ V / w), w what V weighs."""
    weight = min(weight / max(float(np.linalg.norm(u[list(level)])), NO_MOTION) for level, weight in weights(task))
    return min(float(np.sqrt(task.damping * np.linalg.norm(task.asked) / weight)), _widest(task.J.shape[1]))


def _widest(n: int) -> float:
    return WIDEST if n < 6 else WIDEST_OF_SIX


def _decomposed(J: Array, count: int, beside: Callable[[], Array]) -> tuple[Array, Array, Array]:
    """σ (k,), U (6, k), V (n, k) of the first `count` rows; k as many as random postures have."""
    rows, rank = np.where(np.arange(6)[:, None] < count, J, 0.0), min(count, J.shape[1])
    U, sigma, Vt = np.linalg.svd(rows)
    strong = int((sigma[:rank] > NO_MOTION).sum())
    sigma = np.where(np.arange(rank) < strong, sigma[:rank], 0.0)
    weak, U, V = U[:, strong:], U[:, :rank].copy(), Vt[:rank].T.copy()
    if strong < rank:
        free = np.eye(J.shape[1]) - V[:, :strong] @ V[:, :strong].T
        Y, _, Zt = np.linalg.svd(weak[:count].T @ beside()[:count] @ free)
        U[:, strong:], V[:, strong:] = (weak @ Y)[:, : rank - strong], Zt[: rank - strong].T
    return sigma, U, V


def smallest_about(rows: Array) -> float:
    """At most the smallest of the k singular values of rows (m, n), k = min(m, n), and at least 1/√k of it.

    1/√tr((A Aᵀ)⁻¹): what the core finds by L D Lᵀ.
    """
    sigma = np.linalg.svd(rows, compute_uv=False)
    return 0.0 if sigma[-1] == 0.0 else float(1.0 / np.sqrt((1.0 / sigma**2).sum()))
