"""Following curves: a ladder climbed from all configurations together, without leaps, and the joint path through it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..ik.answer import ConfigurationsBatch
from ..ik.closed_form.methods import method_for
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from .configurations import EXACT, LONGEST_JUMP, Solutions, solve_near, targets_at
from .curves import MovingTarget
from .piecewise import JointPath, bernstein, extremes
from .spline import interpolating
from .within import POSITION_TOL as ROUNDING

Flags = NDArray[np.bool_]

# From rung to rung [m, rad] solve_ik stays on its branch where it can.
FIRST_STEP, FIRST_TURN = 0.01, np.radians(1.0)

MOST_RUNGS = 2048

MIN_RUNGS = 4  # Rungs of the shortest curve.
SMALLEST_STEP = 8  # A rung without an answer is tried again nearer, back to this fraction (1/8) of the step.
LEAST_DISTANCE = 2**-12  # Least distance of rungs in s. A path that needs less does not continue.
MOST_HALVINGS = 4096  # Rungs in between of one climb, at most.
# Greatest distance of the tool from the curve [m, rad]. Wider tolerances replace it.
POSITION_TOL, ANGLE_TOL = 1e-4, np.radians(0.05)
# Share of `POSITION_TOL` and `ANGLE_TOL` that check points may use. The rest is for what lies between them.
RESERVE = 0.95
# Intervals of check points in each piece of a path, and the most on a whole path of many pieces.
FEWEST_CHECKS, CHECKS, MOST_CHECKS = 4, 16, 40_000
# A path within tolerances is only sampled more densely where it uses less than this share of them.
SHARE = 0.95

MOST_SAMPLES = 4096

ROUNDS = 12  # Halvings of intervals in which the tool is too far from the curve.


@dataclass(frozen=True, eq=False)
class Node:
    """A configuration at s of a curve, reached from `parent`. `cost` [s] is the joint motion since the beginning."""

    moving: MovingTarget
    s: float
    theta: Array
    cost: float
    parent: Node | None = None

    def ahead(self, s: float) -> Array:
        """Where the node is heading (n,) at another s, straight on from its parent."""
        before = self.parent
        if before is None or before.moving is not self.moving:
            return self.theta
        return self.theta + (self.theta - before.theta) * ((s - self.s) / (self.s - before.s))


def way(last: Node | None) -> list[Node]:
    """Return the nodes on the way to the last one, in order."""
    nodes = []
    while last is not None:
        nodes.append(last)
        last = last.parent
    return nodes[::-1]


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


def efforts(start: Array, end: Array, velocity: Array) -> Array:
    """Return the least times (...) between configurations (..., n) at full velocity [s]."""
    return (np.abs(end - start) / velocity).max(axis=-1)


def climb(arm: Arm, limits: JointLimits, roots: Sequence[Node]) -> list[Node] | Blocked:
    """Configurations at the ends of the curves, least joint motion first, or the place where all stop.

    Each rung is solved from every configuration at the one before, in one batch. The closed form does it if no joint is
    held. Where a joint would leap or there is no answer, a rung halfway comes first.
    """
    climber = _Climber(arm, limits, roots)
    nodes = list(roots)
    for k in range(1, len(climber.s)):
        nodes = climber.advance(nodes, float(climber.s[k]), k)
    if nodes:
        return sorted(nodes, key=lambda node: float(f"{node.cost:.6g}"))  # by more than rounding
    assert climber.farthest is not None
    return climber.farthest


class _Climber:
    """One climb: places s (k + 1,) and poses of its rungs, the number of rungs left, and the farthest blocked node."""

    def __init__(self, arm: Arm, limits: JointLimits, roots: Sequence[Node]) -> None:
        self.arm, self.limits = arm, limits
        movings = {id(node.moving): node.moving for node in roots}
        steps = max(max(moving.curve.length / FIRST_STEP, moving.angle / FIRST_TURN) for moving in movings.values())
        self.s = np.linspace(0.0, 1.0, int(np.clip(np.ceil(steps), MIN_RUNGS, MOST_RUNGS)) + 1)
        self._poses = {key: moving.curve(self.s) for key, moving in movings.items()}
        self.left = MOST_HALVINGS
        self.farthest: Blocked | None = None

    def advance(self, nodes: list[Node], s: float, k: int | None = None) -> list[Node]:
        """Return what follows the nodes at another s: at rung k, or between two rungs."""
        if not nodes:
            return []
        found, halved = self._step(nodes, s, k)
        if halved:
            middle = self.advance(halved, 0.5 * (halved[0].s + s))
            found += self.advance(middle, s, k)
        return found

    def _step(self, nodes: list[Node], s: float, k: int | None) -> tuple[list[Node], list[Node]]:
        """Return the successors of the nodes, and the nodes that need a rung halfway."""
        here = np.array([node.theta for node in nodes])
        theta, converged = self._solved(nodes, s, k)
        moved, leap = efforts(here, theta, self.limits.velocity), np.abs(theta - here).max(axis=1) > LONGEST_JUMP
        found, halved, step = [], [], s - nodes[0].s
        for i, node in enumerate(nodes):
            if converged[i] and not leap[i]:
                found.append(Node(node.moving, s, theta[i], node.cost + float(moved[i]), node))
            elif self.left > 0 and step > (LEAST_DISTANCE if converged[i] else self.s[1] / SMALLEST_STEP):
                self.left -= 1
                halved.append(node)
            elif self.farthest is None or node.s > self.farthest.node.s:
                self.farthest = Blocked(node, s, bool(converged[i]))
        return found, halved

    def _solved(self, nodes: list[Node], s: float, k: int | None) -> Solutions:
        """Return answers (b, n) at s, near where each node is heading, and which exist."""
        ideal = [node.moving.curve(np.array(s)) if k is None else self._poses[id(node.moving)][k] for node in nodes]
        near = np.clip([node.ahead(s) for node in nodes], self.arm.limits.lower, self.arm.limits.upper)
        return solve_near(self.arm, nodes[0].moving, np.array(ideal), near, self._by_closed_form)

    def _by_closed_form(self, moving: MovingTarget, ideal: Array, near: Array) -> Solutions | None:
        """Return the nearest answer to each target. The arm's family must give all of them and hold no joint."""
        method = method_for(self.arm, moving.like, families_alone=True)
        if method.core is None or method.sampled:
            return None
        targets = targets_at(moving.like, ideal)
        numbers = targets if isinstance(targets, np.ndarray) else np.array([target.numbers for target in targets])
        answer = method.core.solve_batch(numbers, near, EXACT, EXACT, 1)
        if answer is None:
            return None
        found = ConfigurationsBatch(*answer)
        theta, converged = near.copy(), found.inside > 0
        if found.families[~converged].any():
            return None
        theta[converged] = found.rows[found.first[converged], 0]
        return theta, converged


def follow(arm: Arm, samples: Sequence[Node]) -> JointPath | Blocked:
    """Return the joint path through samples of one curve, or the place where it leaps.

    A C² cubic spline goes through the samples. Intervals where the tool is too far from the curve are halved. Too far
    means beyond `POSITION_TOL`, `ANGLE_TOL` or wider tolerances, at check points that lie densely in each interval.
    """
    moving = samples[0].moving
    s, theta = np.array([node.s for node in samples]), np.array([node.theta for node in samples])
    for _ in range(ROUNDS):
        path = JointPath(*interpolating(theta, s, s[2:-2], ())).cut_at(s)  # without a knot next to either end
        outside = outside_limits(arm, path)
        off = _too_far(arm, moving, path) | outside
        if not off.any():
            return path
        if len(s) > MOST_SAMPLES:
            break
        between = 0.5 * (s[:-1] + s[1:])[off]
        found = path(between)
        position, angle = moving.errors(between, arm.fk(found))
        good = (position <= SHARE * moving.tolerances.position) & (angle <= SHARE * moving.tolerances.orientation)
        good &= ~outside[off] & (not moving.exactly)
        found[~good], good[~good] = solve_near(arm, moving, moving.curve(between[~good]), found[~good])
        if not good.all():
            return _blocked(samples[0], s, theta, float(between[int(np.argmin(good))]), leap=False)
        s, theta = np.concatenate([s, between]), np.concatenate([theta, found])
        order = np.argsort(s, kind="stable")
        s, theta = s[order], theta[order]
    return _blocked(samples[0], s, theta, float(s[int(np.argmax(off)) + 1]), leap=True)


def _blocked(root: Node, s: Array, theta: Array, ahead: float, *, leap: bool) -> Blocked:
    last = int(np.searchsorted(s, ahead, side="left")) - 1
    return Blocked(Node(root.moving, float(s[last]), theta[last], root.cost, root), ahead, leap)


def _too_far(arm: Arm, moving: MovingTarget, path: JointPath) -> Flags:
    """Tell in which pieces (m,) the tool is too far from the curve at a check point."""
    starts, h = path.breakpoints[:-1], np.diff(path.breakpoints)
    count = int(np.clip(MOST_CHECKS // len(h), FEWEST_CHECKS, CHECKS))
    inside = np.arange(1, count) / count  # at the ends of pieces are samples, which meet their targets
    s = (starts[:, None] + h[:, None] * inside).ravel()
    allowed = np.maximum(
        [RESERVE * POSITION_TOL, RESERVE * ANGLE_TOL], [moving.tolerances.position, moving.tolerances.orientation]
    )
    far = np.stack(moving.errors(s, arm.fk(path(s))), axis=1) > allowed
    far_in: Flags = np.logical_or.reduce(far.reshape(len(h), -1), axis=1)
    return far_in


def outside_limits(arm: Arm, path: JointPath) -> Flags:
    """Tell in which pieces (m,) a joint passes its limit by more than rounding."""
    h = np.diff(path.breakpoints)
    outside: Flags = _beyond(arm, bernstein(path.coefficients, h)) > ROUNDING
    if outside.any():  # the Bernstein coefficients may lie beyond where the spline does not
        outside[outside] = _beyond(arm, extremes(path.coefficients[:, outside], h[outside])[1]) > ROUNDING
    return outside


def _beyond(arm: Arm, values: Array) -> Array:
    return np.maximum(arm.limits.lower - values, values - arm.limits.upper).max(axis=(0, 2))
