"""Motions without gaps: intervals that are free because no body can move farther than its clearance."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import comb

import numpy as np

from ..arm.bodies import Body
from ..arm.checker import Checker
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array

FINE = 2.5e-4
"""Half the way [m] between two checks where something is near: nothing thicker than 0.5 mm fits between them."""

LEVELS = tuple(FINE * 2.0**k for k in range(2, 9))
"""Clearances [m] that are checked: 1, 2, 4, … 64 mm."""

FARTHEST = 100.0
"""How far [m] a slide without limits is taken to go."""

LEAST_SHARE = 0.02
"""The least share of a clearance that a pair is given."""

Around = Callable[[float, float], tuple[Array, float]]


class Sweep:
    """Finds the first collision of a motion theta(t).

    An interval about its middle t is free if at theta(t) every pair has the clearance that its bodies can lose within
    the interval. Otherwise the interval is halved (conservative advancement by bisection; Schwarzer, Saha & Latombe,
    Adaptive Dynamic Collision Checking, IEEE T-RO 21(3), 2005).
    """

    def __init__(self, checker: Checker, model: PinocchioModel) -> None:
        self._model, self._base = model, checker
        self._checkers = {0.0: checker}
        speeds = pair_speeds(model, checker)
        total = speeds.sum(axis=1)
        # A pair that hardly moves needs little clearance: each gets its share.
        self._shares = np.maximum(total / max(total.max(initial=0.0), 1e-12), LEAST_SHARE)
        self._speeds = np.unique(np.round(speeds / self._shares[:, None], 9), axis=0)

    def first(self, around: Around, end: float) -> float | None:
        """The first time in [0, end] at which something collides; None if nothing does.

        `around(t, h)` gives theta(t) (n,), and a bound [m] of how much nearer a pair comes within [t − h, t + h].
        """
        waiting = [(0.0, end)]
        while waiting:
            begin, stop = waiting.pop()
            middle, half = 0.5 * (begin + stop), 0.5 * (stop - begin)
            theta, way = around(middle, half)
            q = self._model.q(theta)
            if way <= FINE:
                if self.checker(0.0).collides(q):
                    return middle
                continue
            clearance = next((level for level in LEVELS if level >= way), None)
            if clearance is None or self.checker(clearance).collides(q):
                waiting += [(middle, stop), (begin, middle)]
        return None

    def along(self, piece: Array, duration: float) -> float | None:
        """`first` of a polynomial (degree + 1, n), highest power first."""
        piece = piece[np.argmax(piece.any(axis=1)) :]  # without leading zeros
        orders = np.arange(len(piece) - 1, 0, -1)

        def around(t: float, half: float) -> tuple[Array, float]:
            about = taylor(piece, t)
            return about[-1], self._nearer(np.float_power(half, orders) @ np.abs(about[:-1]))

        return self.first(around, duration)

    def straight(self, one: Array, other: Array) -> bool:
        """Whether the straight way in joint space from one configuration (n,) to another is free."""
        way = other - one
        nearer = self._nearer(np.abs(way))
        return self.first(lambda t, half: (one + t * way, half * nearer), 1.0) is None

    def _nearer(self, moved: Array) -> float:
        """How much nearer [m] a pair may come while each joint moves by at most `moved` (n,), by its share."""
        return float((self._speeds @ moved).max(initial=0.0))

    def checker(self, clearance: float) -> Checker:
        """The checker whose margins are larger by `clearance` [m] for the fastest pairs, and less for others."""
        if clearance not in self._checkers:
            margins = np.array(self._base.margins) + clearance * self._shares
            self._checkers[clearance] = self._base.with_margins(margins.tolist())
        return self._checkers[clearance]


def taylor(piece: Array, at: float) -> Array:
    """The coefficients (degree + 1, n) of a polynomial about `at`, highest power first: the last row is its value."""
    binomials, powers = _shifts(len(piece))
    shifted: Array = (binomials * at**powers) @ piece
    return shifted


@cache
def _shifts(count: int) -> tuple[Array, Array]:
    """Binomial coefficients (count, count) and powers of `at` that shift a polynomial of `count` coefficients."""
    order = np.arange(count - 1, -1, -1)
    binomials = np.array([[float(comb(j, i)) for j in order] for i in order])
    return binomials, np.maximum(order[None] - order[:, None], 0)


def pair_speeds(model: PinocchioModel, checker: Checker) -> Array:
    """Bounds (pairs, n) of how fast any two points of a pair approach, by each coordinate alone at rate 1."""
    count = model.model.njoints
    speeds = np.array([_speeds(model, body) for body in checker.bodies]).reshape(-1, count)
    carried = np.array([[j in ancestors(model, body) for j in range(count)] for body in checker.bodies])
    first, second = np.array(checker.pairs, dtype=int).reshape(-1, 2).T
    # A joint that carries both moves neither against the other.
    by_joint = np.where(carried[second], 0.0, speeds[first]) + np.where(carried[first], 0.0, speeds[second])
    by_q = np.zeros((len(by_joint), model.model.nq))
    for j in range(1, count):
        by_q[:, model.model.idx_qs[j]] = by_joint[:, j]
    driven = model.dq_dtheta.any(axis=1)
    rows: Array = by_q[:, driven] @ np.abs(model.dq_dtheta[driven])
    return rows


def ancestors(model: PinocchioModel, body: Body) -> set[int]:
    """The joints that carry a body, by Pinocchio's numbers."""
    joint, carrying = model.model.frames[model.frame_id(body.carrier)].parentJoint, set()
    while joint > 0:
        carrying.add(int(joint))
        joint = model.model.parents[joint]
    return carrying


def _speeds(model: PinocchioModel, body: Body) -> Array:
    """Bounds (njoints,) of the speed of any point of a body by each joint alone at rate 1.

    A joint turns a point on a radius of at most the lengths between them. A slide between adds its farthest position.
    """
    frame = model.model.frames[model.frame_id(body.carrier)]
    if not frame.parentJoint:
        return np.zeros(model.model.njoints)
    centre = frame.placement.act(body.pose[:3, :3] @ body.shape.aabb_center + body.pose[:3, 3])
    radius = float(np.linalg.norm(centre)) + float(body.shape.aabb_radius)
    speeds = np.zeros(model.model.njoints)
    joint = int(frame.parentJoint)
    while joint > 0:
        slides = "P" in model.model.joints[joint].shortname().removeprefix("JointModel")[:1]
        speeds[joint] = 1.0 if slides else radius
        if slides:
            k = model.model.idx_qs[joint]
            lower, upper = model.model.lowerPositionLimit[k], model.model.upperPositionLimit[k]
            radius += float(min(max(abs(lower), abs(upper)), FARTHEST)) if lower < upper else FARTHEST
        radius += float(np.linalg.norm(model.model.jointPlacements[joint].translation))
        joint = int(model.model.parents[joint])
    return speeds
