"""Nodes of a ladder: configurations at the rungs of a curve, and paths through them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...ik.task_space import Tolerances
from ...support.checks import Array
from .moving_target import MovingTarget

FIRST_STEP, FIRST_TURN = 0.01, np.radians(1.0)
"""From rung to rung [m, rad] solve_ik stays on its branch where it can."""

MOST_RUNGS = 2048

EXACT = 1e-9
"""Configurations meet the curve to this [m, rad], so that the spline through them is smooth."""

ALL_BUT_EXACT = Tolerances(EXACT, EXACT)

LONGEST_JUMP = 0.5
"""A joint that moves farther [rad, m] from rung to rung leaps."""


@dataclass(frozen=True, eq=False)
class Node:
    """A configuration at s of a curve, reached from `parent`. `cost` [s] is the joint motion since the beginning."""

    moving: MovingTarget
    s: float
    theta: Array
    cost: float
    parent: Node | None = None


def way(last: Node | None) -> list[Node]:
    """Return the nodes on the way to the last one, in order."""
    nodes = []
    while last is not None:
        nodes.append(last)
        last = last.parent
    return nodes[::-1]


def cheapest_first(nodes: list[Node]) -> list[Node]:
    """Sort nodes by joint motion, ignoring rounding."""
    return sorted(nodes, key=lambda node: float(f"{node.cost:.6g}"))


@dataclass(frozen=True, eq=False)
class Blocked:
    """A curve that can be followed to `node`, but not to s = `ahead`. `leap`: only a leap would meet it there."""

    node: Node
    ahead: float
    leap: bool

    @property
    def start(self) -> Array:
        """The configuration (n,) at the beginning of the curve."""
        return next(node.theta for node in way(self.node) if node.moving is self.node.moving)


class Rungs:
    """Places s (k + 1,) close enough for the curves of all nodes, and the poses there."""

    def __init__(self, nodes: Sequence[Node], fewest: int) -> None:
        movings = {id(node.moving): node.moving for node in nodes}
        steps = max(max(each.curve.length / FIRST_STEP, each.angle / FIRST_TURN) for each in movings.values())
        self.s = np.linspace(0.0, 1.0, int(np.clip(np.ceil(steps), fewest, MOST_RUNGS)) + 1)
        self._poses = {key: each.curve(self.s) for key, each in movings.items()}

    def poses(self, nodes: Sequence[Node], k: int) -> Array:
        """The ideal poses (b, 4, 4) of each node's curve at rung k."""
        return np.array([self._poses[id(node.moving)][k] for node in nodes])


def efforts(start: Array, end: Array, velocity: Array) -> Array:
    """Return the least times (...) between configurations (..., n) at full velocity [s]."""
    return (np.abs(end - start) / velocity).max(axis=-1)
