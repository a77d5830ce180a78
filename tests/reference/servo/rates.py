"""Joint rates for a twist (resolved motion rate control): the least of one strictly convex function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from twistarm.support.checks import Array

from .box import least_in_box

PRECEDENCE, PRECEDENCE_OF_SIX = 10.0, 3.0
"""κ: the weight of a level beside that of the next, below six joints and from six on. An arm that lacks a rotation must
turn its tool on the way; one that lacks nothing turns it little to get a little farther at the edge of its reach."""

TIP = 1e-4
"""Of the twist: how far the tip of a norm is rounded off, so that it has a slope there."""

FIRMNESS = 1e6
"""The weight of what is held, beside 1 for the norms of the other levels [s]."""

SETTLED, ROUNDS = 1e-6, 50
"""Of the rates: a smaller change from one round to the next is none; and the most rounds."""


@dataclass(frozen=True, eq=False)
class RateTask:
    """Tool rates `asked` (6,), scaled to rad/s, which components of them go before which others, and the Jacobian's
    rows J (6, n) for scaled rates. damping: τ [s].

    held: the components of the first level, if they are held. rows (6, n): J as it counts, where held directions are
    fixed and those that the motion leaves are led. calm (n, n): what is damped beside τ.
    undamped (n, n): V L Vᵀ of joint motions V that are damped by 1 − L only. turning: how far rotations that are not
    held are left out, 0 … 1.
    """

    asked: Array
    levels: tuple[tuple[int, ...], ...]
    J: Array
    damping: float
    held: tuple[int, ...]
    rows: Array
    calm: Array
    undamped: Array | None = None
    turning: float = 0.0


def resolved_rates(
    task: RateTask,
    lower: Array | None = None,
    upper: Array | None = None,
    start: Array | None = None,
    rounds: int = ROUNDS,
) -> tuple[Array, Array]:
    """The scaled rates x (n,) for a task, and the bound that each stands at: −1 the lower, 1 the upper, 0 neither.

    With the twist V in levels V_l, the first the most important, and their rows J_l of the Jacobian,

        x = argmin  Σ_l w_l |V_l − J_l x| + (τ/2) |x|²   over   lower ≤ x ≤ upper,   w_l = 1, 1/κ, 1/κ², …

    What is held is no norm, but ½ ρ |V_0 − J_0 x|² with so large a ρ that it is done exactly. The other norms are not
    squared: an exact penalty (J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., §17.2). What the arm can do at
    moderate rates, |J⁻ᵀ τ x| ≤ w, is done exactly; near a singularity, where that would take rates beyond all bounds,
    it gives up as much as it must, and of a lower level first. The function is strictly convex, so that x is one, and
    continuous in posture, twist and bounds.

    Why it cannot cycle: with 0 within the bounds, Σ w_l |V_l − J_l x| + (τ/2) |x|² ≤ Σ w_l |V_l|. For a constant
    velocity V of the tool this means V·J x > 0 unless x = 0: the tool moves on along the command or is at rest, which
    it comes to because its workspace ends. Near that rest ∂x/∂θ is at most the curvature of the tool's path over τ;
    one step dt of delay leaves this stable for τ ≥ 3 dt on average, which `step` sees to.

    Found by least squares with weights w_l / |V_l − J_l x| of the round before (E. Weiszfeld, Tôhoku Math. J. 43,
    1937), each within the bounds. D. E. Whitney, Resolved motion rate control of manipulators and human prostheses,
    IEEE T-MMS 10(2), 1969.
    """
    n = task.rows.shape[1]
    lower = np.full(n, -np.inf) if lower is None else lower
    upper = np.full(n, np.inf) if upper is None else upper
    x, at = np.clip(np.zeros(n), lower, upper) if start is None else start, np.zeros(n, int)
    tip = TIP * float(np.linalg.norm(task.asked))
    if tip * tip == 0.0:
        return x, at
    for _ in range(rounds):
        H, r = _weighed(task, x, tip)
        before = x
        x, at = least_in_box(H, r, lower, upper, before, at)
        if np.abs(x - before).max() <= SETTLED * np.abs(x).max():
            break
    return x, at


def _weighed(task: RateTask, x: Array, tip: float) -> tuple[Array, Array]:
    """Jᵀ Ω J + τ and Jᵀ Ω V, Ω = w / |V − J x| level by level."""
    weights, left = np.zeros(6), task.asked - task.rows @ x
    precedence = PRECEDENCE if len(x) < len(left) else PRECEDENCE_OF_SIX
    for number, level in enumerate(task.levels):
        rows: Sequence[int] = list(level)
        firm = number == 0 and bool(task.held)
        weights[rows] = FIRMNESS if firm else precedence**-number / np.sqrt(tip * tip + left[rows] @ left[rows])
        if number > 0 and level[0] >= 3:
            weights[rows] *= 1.0 - task.turning
    weighed, damped = task.rows.T * weights, np.eye(len(x))
    if task.undamped is not None:
        damped = damped - task.undamped
    return weighed @ task.rows + task.damping * damped + task.calm, weighed @ task.asked


def taken_back(task: RateTask) -> Array:
    """The scaled rates x (n,) that do what is asked of the held components, if nothing else is asked."""
    rows = task.rows[list(task.held)]
    H = FIRMNESS * rows.T @ rows + task.damping * np.eye(rows.shape[1]) + task.calm
    return np.asarray(np.linalg.solve(H, FIRMNESS * rows.T @ task.asked[list(task.held)]), dtype=float)
