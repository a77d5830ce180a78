"""Ladder: curves climbed rung by rung from all configurations together, without leaps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...arm.arm import Arm
from ...ik.closed_form.methods import family_method
from ...limits.joint_limits import JointLimits
from ...support.checks import Array
from .meeting import Met, met_near, targets_at
from .moving_target import MovingTarget
from .nodes import EXACT, LONGEST_JUMP, Blocked, Node, Rungs, cheapest_first, efforts

MIN_RUNGS = 4
"""Rungs of the shortest curve."""

SMALLEST_STEP = 8
"""A rung without an answer is tried again nearer, back to this fraction (1/8) of the step."""

LEAST_DISTANCE = 2**-12
"""Least distance of rungs in s. A path that needs less does not continue."""

MOST_HALVINGS = 4096
"""Rungs in between of one climb, at most."""


def climb(arm: Arm, limits: JointLimits, roots: Sequence[Node]) -> list[Node] | Blocked:
    """Configurations at the ends of the curves, least joint motion first, or the place where all stop.

    Each rung is solved from every configuration at the one before, in one batch. The closed form does it if no joint is
    held. Where a joint would leap or there is no answer, a rung halfway comes first.
    """
    climber = _Climber(arm, limits, Rungs(roots, MIN_RUNGS))
    nodes = list(roots)
    for k in range(1, len(climber.rungs.s)):
        nodes = climber.advance(nodes, float(climber.rungs.s[k]), k)
    if nodes:
        return cheapest_first(nodes)
    assert climber.farthest is not None
    return climber.farthest


class _Climber:
    """One climb: the number of rungs left, and the farthest blocked node."""

    def __init__(self, arm: Arm, limits: JointLimits, rungs: Rungs) -> None:
        self.arm, self.limits, self.rungs = arm, limits, rungs
        self.left = MOST_HALVINGS
        self.farthest: Blocked | None = None

    def advance(self, nodes: list[Node], s: float, k: int | None = None) -> list[Node]:
        """Return what follows the nodes at another s: at rung k, or between two rungs."""
        if not nodes:
            return []
        found, halved = self._step(nodes, s, k)
        if halved:
            found += self.advance(self.advance(halved, 0.5 * (halved[0].s + s)), s, k)
        return found

    def _step(self, nodes: list[Node], s: float, k: int | None) -> tuple[list[Node], list[Node]]:
        """Return the successors of the nodes, and the nodes that need a rung halfway."""
        here = np.array([node.theta for node in nodes])
        theta, met = self._solved(nodes, s, k)
        moved, leap = efforts(here, theta, self.limits.velocity), np.abs(theta - here).max(axis=1) > LONGEST_JUMP
        found, halved, step = [], [], s - nodes[0].s
        for i, node in enumerate(nodes):
            if met[i] and not leap[i]:
                found.append(Node(node.moving, s, theta[i], node.cost + float(moved[i]), node))
            elif self.left > 0 and step > (LEAST_DISTANCE if met[i] else self.rungs.s[1] / SMALLEST_STEP):
                self.left -= 1
                halved.append(node)
            elif self.farthest is None or node.s > self.farthest.node.s:
                self.farthest = Blocked(node, s, bool(met[i]))
        return found, halved

    def _solved(self, nodes: list[Node], s: float, k: int | None) -> Met:
        """Return answers (b, n) at s, near where each node is heading, and which exist."""
        g = np.array([node.moving.curve(np.array(s)) for node in nodes]) if k is None else self.rungs.poses(nodes, k)
        near = np.clip([_ahead(node, s) for node in nodes], self.arm.limits.lower, self.arm.limits.upper)
        return met_near(self.arm, nodes[0].moving, g, near, self._by_closed_form)

    def _by_closed_form(self, moving: MovingTarget, ideal: Array, near: Array) -> Met | None:
        """Return the nearest answer to each target. The arm's family must give all of them and hold no joint."""
        method = family_method(self.arm, moving.like)
        if method.compiled is None or method.swept:
            return None
        targets = targets_at(moving.like, ideal)
        numbers = targets if isinstance(targets, np.ndarray) else np.array([each.numbers for each in targets])
        found = method.compiled.solve_batch(numbers, near, EXACT, EXACT, 1)
        if found is None:
            return None
        theta, met = near.copy(), found.inside > 0
        if found.families[~met].any():
            return None
        theta[met] = found.theta[(np.cumsum(found.count) - found.count)[met]]
        return theta, met


def _ahead(node: Node, s: float) -> Array:
    before = node.parent
    if before is None or before.moving is not node.moving:
        return node.theta
    return node.theta + (node.theta - before.theta) * ((s - node.s) / (node.s - before.s))
