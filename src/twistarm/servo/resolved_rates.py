"""Joint rates for a twist (resolved motion rate control), damped where the arm is nearly singular."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..checks import Array

ALL = (0, 1, 2, 3, 4, 5)

NO_MOTION = 1e-3
"""A singular value below this counts as none: descriptions write 1.57 for a right angle, and mean planes by it."""

RISE, LEAST_RISE = 0.1, 0.02
"""dσ per scaled radian along its own direction: from LEAST_RISE on, a motion counts as leaving a singularity, from RISE
on entirely. In between both answers are mixed, so that nothing switches."""

BESIDE = 0.05
"""How far beside a singular posture one looks for the directions that it lacks [scaled rad]."""

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


def resolved_rates(task: Task, asked: Array, free: Array, fixed_rates: Array) -> Rates:
    """The joint rates for `asked` (6,): Σ gain(σ) a v over J = Σ σ u vᵀ, a = uᵀ(asked − J · fixed_rates).

    Joints that are not `free` keep their `fixed_rates`. D. E. Whitney, Resolved motion rate control of manipulators and
    human prostheses, IEEE T-MMS 10(2), 1969.

    Where the free joints move the tool in fewer than six directions, the task's levels are met one after the other,
    each as well as those before leave it free to: J is then the level's rows without the directions that those have
    used. Y. Nakamura, H. Hanafusa & T. Yoshikawa, Task-priority based redundancy control of robot manipulators, IJRR
    6(2), 1987.
    """
    J = task.jacobian(np.zeros(len(free)))
    beside = task.jacobian(BESIDE * task.toward)
    fixed = np.where(free, 0.0, fixed_rates)
    if free.sum() >= 6:
        whole = _directions(J, beside, ALL, free, [])
        if len(whole) == 6:
            return _followed(task, J, asked, fixed, [whole])
    used: list[Direction] = []
    levels = []
    for level in task.levels:
        levels.append(_directions(J, beside, level, free, used))
        used = used + levels[-1]
    return _followed(task, J, asked, fixed, levels)


def _followed(task: Task, J: Array, asked: Array, fixed: Array, levels: list[list[Direction]]) -> Rates:
    rates, bent, taken, joint, gravest = fixed, 0.0, 0.0, -1, 0.0
    before: list[Direction] = []
    for level in levels:
        left = asked - J @ rates
        # A lower level also has to make up for what the upper ones do to it, which may be more than is asked.
        total = max(float(asked @ asked), float(left @ left), np.finfo(float).tiny)
        for each in level:
            share = float(each.u @ left)
            gain, done = _gain(task, J, each, share, before)
            rates = rates + gain * share * each.v
            part = share * share / total
            bent, taken = bent + 4.0 * done * (1.0 - done) * part, taken + (1.0 - done) * part
            if (1.0 - done) * part > gravest:
                gravest, joint = (1.0 - done) * part, int(np.argmax(np.abs(each.v)))
        before = before + level
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
