"""Collision avoidance: near pairs of a scene become rows of the servo's law, and each step leaves room to stop."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ...collision import Contact, Scene
from ...support.checks import Array
from .output import REASON_OF_CAUSE, CoreStep, ServoReason
from .settings import ServoBounds

Solve = Callable[[Array | None], CoreStep]

COLLISION = REASON_OF_CAUSE.index(ServoReason.COLLISION)

SPARE = 3e-4
"""The servo aims at so much more than the margin [m], for what a linear step cannot see."""

ROUNDING = 1e-6
"""How far [m] below its margin a pair may come by rounding."""

UNSEEN = 5e-5
"""Pairs that come nearer than their aim by more [m] were not seen by the rows before."""

FIRST_ROWS, MOST_ROUNDS, OTHERS_SHARE = 8, 4, 0.1
"""The first rows, how often others are added, and the share of the push of the first that others take."""


def avoid_collisions(
    solve: Solve, rest: Callable[[], CoreStep], start: ArrayLike, dt: float, bounds: ServoBounds, scene: Scene
) -> tuple[CoreStep, Contact | None]:
    """The answer of a step from `start` (n,) that brings no pair nearer than its margin, and the pair that holds it.

    `solve` steps with rows (k, n + 2) of near pairs or None, `rest` steps toward rest. A pair that is nearer than its
    margin already comes no nearer. Near pairs are measured where the arm will be after the step, and where it would
    stand after a straight stop. A pair that would come too near becomes another row, and the step is made anew. If that
    does not suffice, the arm comes to rest.
    """
    pairs, answer = scene.near_pairs, solve(None)  # which raises an error for a state that cannot be used
    theta = np.asarray(start, dtype=np.float64)
    # The law slows a pair that has less room than a stop in twice its time takes.
    time = 3.0 * answer.period + 2.0 * bounds.stopping_time(answer.theta_dot)
    near = pairs.near(theta, np.abs(time * answer.theta_dot))
    if not len(near.pairs):
        return answer, None
    margins, speeds = pairs.least[near.pairs], pairs.speeds[near.pairs]
    room, floor = near.distances - margins - SPARE, np.minimum(near.distances, margins) - ROUNDING
    # No pair is pushed where the rounds below leave it, and another corner of flat bodies leaves with the first.
    room = np.maximum(room, np.clip(room + UNSEEN, -SPARE, 0.0))
    aim = np.minimum(near.distances - OTHERS_SHARE * dt / time * np.minimum(room, 0.0), margins + SPARE - UNSEEN)
    owner = room.argsort()[:FIRST_ROWS]
    rows = _rows(near.approach[owner], room[owner], 0.0)
    for rounds in range(MOST_ROUNDS + 1):
        answer = solve(rows)
        time = dt + 0.5 * bounds.stopping_time(answer.theta_dot)
        risky = np.flatnonzero(near.distances - speeds @ np.abs(time * answer.theta_dot) < aim - ROUNDING)
        if not len(risky):
            break
        # Where it is after the step, on its way to a stop and after it.
        times = dt, 0.5 * (dt + time), time
        there = np.array([pairs.distances_of(theta + at * answer.theta_dot, near.pairs[risky]) for at in times])
        unseen = there < aim[risky] - ROUNDING
        if not unseen.any():
            break
        if rounds == MOST_ROUNDS:
            below = there.min(axis=0) - floor[risky]
            if below.min() < 0.0:
                still = rest()
                halted, owner = not still.theta_dot.any(), risky[[below.argmin()]]
                answer = still._replace(cause=COLLISION, row=0, scale=0.0, halted=halted, held_pose=answer.held_pose)
            break
        for too_near, at in zip(unseen, times, strict=True):
            new = risky[too_near]
            seen = pairs.measured(theta + at * answer.theta_dot, near.pairs[new])
            left = seen.distances - aim[new] + at * seen.approach @ answer.theta_dot
            rows, owner = np.concatenate([_rows(seen.approach, left, at), rows]), np.concatenate([new, owner])
        if rounds:  # what pushes against each other is no longer pushed
            rows[:, -2], aim = np.maximum(rows[:, -2], 0.0), np.minimum(aim, near.distances)
    if answer.cause != COLLISION:
        return answer, None
    k = owner[answer.row]
    first, second = (pairs.bodies[body].name for body in pairs.pairs[near.pairs[k]])
    return answer, Contact((first, second), float(near.distances[k]), float(margins[k]))


def _rows(approach: Array, room: Array, time: float) -> Array:
    """Rows (k, n + 2) for the law: a pair takes its room within `time` [s]. One without room moves apart slowly."""
    rows = np.full((len(room), approach.shape[1] + 2), time)
    rows[:, :-2], rows[:, -2] = approach, np.maximum(room, -SPARE)
    return rows
