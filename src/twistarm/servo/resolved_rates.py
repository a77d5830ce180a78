"""Joint rates for a twist (resolved motion rate control), damped where the arm is nearly singular."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..checks import Array
from ..inability import BESIDE, NO_MOTION
from .priorities import prior_shares

ALL = (0, 1, 2, 3, 4, 5)

FIVE = 5
"""Joints from which on singularities are those of the whole twist, not of its levels."""

RISE, LEAST_RISE = 0.1, 0.02
"""dσ per scaled radian along its own direction: from LEAST_RISE on, a motion counts as leaving a singularity, from RISE
on entirely. In between both answers are mixed, so that nothing switches."""

DIFFERENCE = 1e-4
"""Step of a finite difference [scaled rad]."""


@dataclass(frozen=True, eq=False)
class Task:
    """Tool rates `asked` (6,), scaled to rad/s, and which components of them go before which others.

    jacobian(displacement) (6, n): their rows, scaled, at a posture that is a scaled joint displacement (n,) away.
    toward (n,): the scaled way to a good posture. below: singular values less than this are damped. dt: the step [s].
    stopping_time(rates): how long a straight stop from scaled rates (n,) takes [s].
    """

    asked: Array
    levels: tuple[tuple[int, ...], ...]
    jacobian: Callable[[Array], Array]
    toward: Array
    below: float
    dt: float
    stopping_time: Callable[[Array], float]


class Rates(NamedTuple):
    """Scaled joint rates (n,).

    Of a part a of the twist along a damped direction a share f is done. bent: Σ 4 f (1 − f) a² / |asked|², how much
    that bends the twist; taken: Σ (1 − f) a² / |asked|², what it takes away. joint: the one that moves most along the
    direction of which most is taken, −1 for none.
    """

    rates: Array
    bent: float
    taken: float
    joint: int


class Direction(NamedTuple):
    """A singular direction of some rows of the Jacobian: joints v (n,) move the tool by σ u, u (6,) in those rows.

    aside: it was found beside the posture, and σ here is 0.
    """

    u: Array
    sigma: float
    v: Array
    aside: bool


Part = tuple[Direction, float, list[Direction]]
"""A direction, the share of the twist along it, and the directions that go before it."""


def resolved_rates(task: Task, asked: Array, free: Array, fixed_rates: Array) -> Rates:
    """The joint rates for `asked` (6,): Σ gain(σ) a v over J = Σ σ u vᵀ, a = uᵀ(asked − J · fixed_rates).

    Joints that are not `free` keep their `fixed_rates`. D. E. Whitney, Resolved motion rate control of manipulators and
    human prostheses, IEEE T-MMS 10(2), 1969.

    Where that are fewer than six directions, a is that of the twist which meets the task's levels as well as can be,
    one after the other (`prior_shares`). An arm of fewer than five joints solves the levels themselves one after the
    other, each with its own rows of J in the null space of those before: there the position alone can be singular.
    """
    J = task.jacobian(np.zeros(len(free)))
    beside = task.jacobian(BESIDE * task.toward)
    fixed = np.where(free, 0.0, fixed_rates)
    if len(free) < FIVE:
        return _level_by_level(task, J, beside, asked, free, fixed)
    whole = _directions(J, beside, ALL, free, [])
    U, left = np.array([each.u for each in whole]).reshape(-1, len(ALL)).T, asked - J @ fixed
    shares = U.T @ left if len(whole) == len(ALL) else prior_shares(U, left, task.levels)
    parts: list[Part] = [(each, float(a), []) for each, a in zip(whole, shares, strict=True)]
    return _summed(task, J, fixed, parts, float(asked @ asked))


def _level_by_level(task: Task, J: Array, beside: Array, asked: Array, free: Array, fixed: Array) -> Rates:
    found = Rates(fixed, 0.0, 0.0, -1)
    used: list[Direction] = []
    for level in task.levels:
        left = asked - J @ found.rates
        directions = _directions(J, beside, level, free, used)
        parts: list[Part] = [(each, float(each.u @ left), list(used)) for each in directions]
        # A lower level also has to make up for what the upper ones do to it, which may be more than is asked.
        met = _summed(task, J, found.rates, parts, max(float(asked @ asked), float(left @ left)))
        joint = met.joint if met.taken > found.taken else found.joint
        found = Rates(met.rates, found.bent + met.bent, found.taken + met.taken, joint)
        used = used + directions
    return found


def _summed(task: Task, J: Array, rates: Array, parts: list[Part], total: float) -> Rates:
    """`rates`, and those for a share of each direction, of `total` = |asked|² in all."""
    bent, taken, joint, gravest = 0.0, 0.0, -1, 0.0
    for each, share, before in parts:
        gain, done = _gain(task, J, each, share, before)
        rates = rates + gain * share * each.v
        part = share * share / max(total, np.finfo(float).tiny)
        bent, taken = bent + 4.0 * done * (1.0 - done) * part, taken + (1.0 - done) * part
        if (1.0 - done) * part > gravest:
            gravest, joint = (1.0 - done) * part, int(np.argmax(np.abs(each.v)))
    return Rates(rates, bent, taken, joint)


def _directions(J: Array, beside: Array, level: tuple[int, ...], free: Array, used: list[Direction]) -> list[Direction]:
    """The directions of a level's rows of J, without the fixed joints and the used directions.

    Those that this very posture lacks are read off one a little `beside`, on the way to a good one: no rates move the
    tool along them here, but some bend the arm so that they will.
    """
    found = _decomposed(J, level, free, used, False)
    if len(found) < min(len(level), int(free.sum()) - len(used)):
        rest = beside
        for each in found:
            rest = rest - np.outer(each.u, each.u @ rest)
        found += _decomposed(rest, level, free, used + found, True)
    return found


def _decomposed(J: Array, level: tuple[int, ...], free: Array, used: list[Direction], aside: bool) -> list[Direction]:
    rows = np.where(free, J[list(level)], 0.0)
    for each in used:
        rows = rows - np.outer(rows @ each.v, each.v)
    U, sigma, Vt = np.linalg.svd(rows, full_matrices=False)
    whole = np.zeros((6, len(sigma)))
    whole[list(level)] = U
    return [Direction(u, float(s), v, aside) for u, s, v in zip(whole.T, sigma, Vt, strict=True) if s > NO_MOTION]


def _gain(task: Task, J: Array, along: Direction, share: float, before: list[Direction]) -> tuple[float, float]:
    """What a share a is multiplied by to get rates along v, and how much of it is then done, 0 … 1.

    1/σ from ε = `below` on. Under it, where the motion approaches the singularity, 4s / (ε² + 3s²): damped least
    squares with λ² = (ε² − s²)/4 (numerical filtering, A. A. Maciejewski & C. A. Klein, J. Robotic Systems 5(6), 1988);
    s runs from 0 to ε while σ does from NO_MOTION. Where the motion leaves it, 1/ε: an arm must be able to move away.
    An approach must be able to stop halfway to the singularity: a motion that goes through it would be taken back.
    """
    below = task.below
    if along.sigma >= below and not along.aside:
        return 1.0 / along.sigma, 1.0
    rise = _rise(task, J, along, before) * np.sign(share)
    leaving = float(np.clip((rise - LEAST_RISE) / (RISE - LEAST_RISE), 0.0, 1.0))
    s = 0.0 if along.aside else below * (along.sigma - NO_MOTION) / (below - NO_MOTION)
    damped = 4.0 * s / (below * below + 3.0 * s * s)
    if rise < 0.0 and share != 0.0:
        way = 0.5 * s / -rise
        stop = task.stopping_time(along.v)
        fastest = 2.0 * way / (task.dt + np.sqrt(task.dt * task.dt + 2.0 * stop * way))
        damped = min(damped, fastest / abs(share))
    # A motion that leaves does not do its share yet, but it is on its way to: nothing is taken from it.
    return damped + leaving * (1.0 / below - damped), s * damped + leaving * (1.0 - s * damped)


def _rise(task: Task, J: Array, along: Direction, before: list[Direction]) -> float:
    """dσ per scaled radian along v: uᵀ (∂J/∂v) v, less what the levels before make up of their share of (∂J/∂v) v."""
    bend = (task.jacobian(DIFFERENCE * along.v) - J) @ along.v / DIFFERENCE
    rise = float(along.u @ bend)
    for each in before:
        rise -= float(along.u @ (J @ each.v)) * float(each.u @ bend) / max(each.sigma, task.below)
    return rise
