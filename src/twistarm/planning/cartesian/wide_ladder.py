"""Wide ladder: the path of a redundant arm, with many configurations at each rung."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from .nodes import EXACT, LONGEST_JUMP, Blocked, Node, Rungs, cheapest_first, efforts
from .projection import projected

MIN_RUNGS = 40
"""Rungs of the shortest curve: on each the arm may change its configuration a little."""

WIDTH = 100
"""Configurations at each rung."""

CANDIDATES, KICK = 500, 0.8
"""Candidates for the next rung, and their greatest distance [rad, m] in every joint."""

PULL, LONGEST_PULL = 0.3, 0.3
"""Each candidate is also tried nearer to the joints' middle: by PULL of the way, at most LONGEST_PULL [rad, m]."""

CELL = 0.15
"""Side [rad, m] of a cube of configurations. Each cube keeps the one with the least joint motion."""

HALFWAY = 0.2
"""Greatest distance of the joints at halfway from the middle of both ends, as a share of the ends' distance."""

SEED = 0


def climb_wide(arm: Arm, limits: JointLimits, roots: Sequence[Node]) -> list[Node] | Blocked:
    """Configurations at the ends of the curves, least joint motion first, or how far they come.

    Candidates at each rung are near the last configuration, nearer to the joints' middle, or random. `WIDTH` of them
    that are apart stay, each with its least joint motion.
    """
    rng = np.random.default_rng(SEED)
    rungs, nodes = Rungs(roots, MIN_RUNGS), list(roots)
    for k in range(1, len(rungs.s)):
        theta, parents = _spread(arm, rungs, k, nodes, rng)
        if not len(theta):
            return Blocked(max(nodes, key=lambda node: _distance_to_limits(arm, node.theta)), float(rungs.s[k]), False)
        here = np.array([node.theta for node in nodes])
        costs = np.array([node.cost for node in nodes])[parents] + efforts(here[parents], theta, limits.velocity)
        kept = _cheapest_per_cell(theta, costs, rng)
        kept = kept[_continuous(arm, nodes, parents[kept], float(rungs.s[k]), theta[kept])]
        if not len(kept):
            return Blocked(max(nodes, key=lambda node: _distance_to_limits(arm, node.theta)), float(rungs.s[k]), True)
        nodes = [
            Node(nodes[parents[i]].moving, float(rungs.s[k]), theta[i], float(costs[i]), nodes[parents[i]])
            for i in kept
        ]
    return cheapest_first(nodes)


def _spread(
    arm: Arm, rungs: Rungs, k: int, nodes: list[Node], rng: np.random.Generator
) -> tuple[Array, NDArray[np.intp]]:
    """Return the configurations (c, n) at rung k, and the node that each follows (c,)."""
    here, moving = np.array([node.theta for node in nodes]), nodes[0].moving
    drawn = PULL * (arm.limits.middle() - here)
    drawn *= np.minimum(1.0, LONGEST_PULL / np.maximum(np.abs(drawn).max(axis=1, keepdims=True), LONGEST_PULL))
    each = -(-CANDIDATES // len(nodes))
    kicks = rng.uniform(-1.0, 1.0, (each, *here.shape)) * rng.uniform(0.0, KICK, (each, len(nodes), 1))
    sought = np.concatenate([here, here + drawn, *(here + kicks)])
    parents = np.tile(np.arange(len(nodes)), 2 + each)
    ideal = np.tile(rungs.poses(nodes, k), (2 + each, 1, 1))
    theta, good = projected(arm, moving.like, ideal, sought, EXACT, moving.leeway)
    good &= np.abs(theta - here[parents]).max(axis=1) <= LONGEST_JUMP
    return theta[good], parents[good]


def _continuous(arm: Arm, nodes: list[Node], parents: NDArray[np.intp], s: float, theta: Array) -> NDArray[np.bool_]:
    """Tell which configurations (c, n) at s follow their parents without a leap: halfway, the arm is about halfway."""
    before = np.array([nodes[i].theta for i in parents])
    middle = np.array(0.5 * (nodes[0].s + s))
    poses = {id(node.moving): node.moving.curve(middle) for node in nodes}
    ideal = np.array([poses[id(nodes[i].moving)] for i in parents])
    halfway = 0.5 * (before + theta)
    moving = nodes[0].moving
    found, met = projected(arm, moving.like, ideal, halfway, EXACT, moving.leeway)
    off, step = (np.linalg.norm(each, axis=1) for each in (found - halfway, theta - before))
    return met & (off <= HALFWAY * (step + CELL))


def _cheapest_per_cell(theta: Array, costs: Array, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return which to keep: the cheapest of each cell, at most `WIDTH`."""
    order = np.argsort(costs, kind="stable")
    _, first = np.unique(np.round(theta[order] / CELL), axis=0, return_index=True)
    kept: NDArray[np.intp] = order[np.sort(first)]
    if len(kept) <= WIDTH:
        return kept
    return np.concatenate([kept[:1], rng.choice(kept[1:], WIDTH - 1, replace=False)])


def _distance_to_limits(arm: Arm, theta: Array) -> float:
    """Return the distance to the nearest limit."""
    return float(np.minimum(theta - arm.limits.lower, arm.limits.upper - theta).min())
