"""How fast bodies approach at most, and motions without gaps."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

import numpy as np

from ..arm.bodies import Body
from ..arm.checker import Checker
from ..arm.pinocchio_model import PinocchioModel
from ..support.checks import Array
from ..support.errors import InputError

# Half the way [m] between two checks where something is near: nothing thicker than 0.5 mm fits between them.
FINE = 2.5e-4
LEVELS = (0.0, *(FINE * 2.0**k for k in range(2, 9)))  # Clearances [m] that are checked: 0, 1, 2, 4, … 64 mm.
FIRST = 3  # The level that is checked first.
# A straight way is checked at places so far apart [rad, m] before it is proven, at most twice so many.
COARSE, MOST_COARSE = 0.1, 128
PATIENCE = 8  # After so many intervals that pass, a longer one is tried at the latest.
PARTS = 256  # How many parts a motion has at least, each with its own bound of the speeds.
LONGEST = 1e4  # The longest way [m] of a point in a motion: some 3 s of checks in free space.
LEAST_SHARE = 0.02  # The least share of a clearance that a pair is given.


class Sweep:
    """Finds the first collision of a motion theta(t).

    An interval about its middle t is free if every pair has enough clearance at theta(t). Enough is what its bodies can
    lose within the interval. The next interval is as long as a level of clearance allows. It is shorter where a check
    fails, and longer after some that pass. Source: Schwarzer, Saha & Latombe, Adaptive Dynamic Collision Checking, IEEE
    T-RO 21(3), 2005.
    """

    def __init__(self, checker: Checker, model: PinocchioModel, most: Array) -> None:
        self._model, self._base, self._most = model, checker, most
        self._wider: Sweep | None = None
        self._checkers = {0.0: checker}
        speeds = pair_speeds(model, checker.bodies, checker.pairs, most)
        total = speeds.sum(axis=1)
        # A pair that hardly moves needs little clearance: each gets its share.
        self._shares = np.maximum(total / max(total.max(initial=0.0), 1e-12), LEAST_SHARE)
        self._speeds = np.unique(np.round(speeds / self._shares[:, None], 9), axis=0)

    def first(self, times: Array, pieces: Array) -> tuple[float, Array] | None:
        """The first time at which something collides, and theta (n,) there. None if nothing does.

        `times` are breakpoints (s + 1,), `pieces` coefficients (degree + 1, s, n), highest power first.
        """
        if len(times) < 2:
            return None
        parts = max(1, PARTS // pieces.shape[1]) if len(pieces) > 2 else 1
        width = np.repeat(np.diff(times) / parts, parts)
        begin = np.tile(np.arange(parts), len(times) - 1) * width
        about = shifted(np.repeat(pieces, parts, axis=1), begin + 0.5 * width)
        powers = np.arange(len(pieces) - 1, -1, -1)
        terms = np.abs(about) * ((0.5 * width) ** powers[:, None])[:, :, None]
        bounded = self._reaching(terms.sum(axis=0).max(axis=0))
        moved = 2.0 * np.einsum("k,ksn->sn", powers, terms)
        # How much nearer [m] a pair may come, by its share, up to the end of each part.
        ends = np.concatenate([[0.0], np.cumsum((bounded._speeds @ moved.T).max(axis=0, initial=0.0))])
        if not ends[-1] <= LONGEST:
            raise InputError(f"a point may move {ends[-1]:.3g} m in this motion; at most {LONGEST:g} m are checked")
        known, values = ends.tolist(), about.transpose(1, 0, 2).copy()
        s, level, passed, needed = 0.0, FIRST, 0, 1
        while True:
            half = LEVELS[level] or FINE  # without a clearance nothing is proven, so the step is fixed
            middle = min(s + half, known[-1])
            k = min(bisect_right(known, middle), len(width)) - 1
            tau = ((middle - known[k]) / (known[k + 1] - known[k] or 1.0) - 0.5) * width[k]
            theta = tau**powers @ values[k]
            if bounded.checker(LEVELS[level]).collides(self._model.q(theta)):
                if not level:
                    return float(times[k // parts] + begin[k] + 0.5 * width[k] + tau), theta
                # One that fails at once is tried again after twice as many shorter ones.
                level, passed, needed = level - 1, 0, min(2 * needed, PATIENCE) if not passed else 1
                continue
            s = middle + half
            if s >= known[-1]:
                return None
            passed += 1
            if passed > needed and level < len(LEVELS) - 1:
                level, passed = level + 1, 0

    def straight(self, start: Array, end: Array) -> bool:
        """Whether the straight way in joint space from one configuration (n,) to another is free."""
        way = end - start
        halvings = int(np.log2(np.clip(np.linalg.norm(way) / COARSE, 1.0, MOST_COARSE)))
        # Most ways that are not free are found so, without a clearance: halves first.
        places = ((k + 0.5) / 2**halved for halved in range(halvings + 1) for k in range(2**halved))
        if any(self.checker(0.0).collides(self._model.q(start + t * way)) for t in places):
            return False
        return self.first(np.array([0.0, 1.0]), np.array([[way], [start]])) is None

    def _reaching(self, most: Array) -> Sweep:
        """A sweep whose bounds hold while |theta| is at most `most` (n,): this one, or a wider one."""
        if (most <= self._most).all():
            return self
        wider = self._wider
        if wider is None:
            wider = self._wider = Sweep(self._base, self._model, np.maximum(2.0 * most, self._most))
        return wider._reaching(most)

    def checker(self, clearance: float) -> Checker:
        """The checker with margins larger by `clearance` [m] for the fastest pairs, and by less for others."""
        if clearance not in self._checkers:
            margins = np.array(self._base.margins) + clearance * self._shares
            self._checkers[clearance] = self._base.with_margins(margins)
        return self._checkers[clearance]


def shifted(pieces: Array, at: Array) -> Array:
    """The coefficients (degree + 1, s, n) of polynomials about `at` (s,), highest power first."""
    about = pieces.copy()
    for last in range(len(about), 1, -1):
        for row in range(1, last):
            about[row] += about[row - 1] * at[:, None]
    return about


def pair_speeds(model: PinocchioModel, bodies: Sequence[Body], pairs: Sequence[tuple[int, int]], most: Array) -> Array:
    """Bounds (pairs, n) of the speed at which two points of a pair approach, per coordinate at rate 1.

    They hold while |theta| is at most `most` (n,), which counts for slides only.
    """
    count, far = model.model.njoints, _farthest(model, most)
    speeds = np.array([_speeds(model, body, far) for body in bodies]).reshape(-1, count)
    carried = np.array([[j in ancestors(model, body) for j in range(count)] for body in bodies]).reshape(-1, count)
    first, second = np.array(pairs, dtype=int).reshape(-1, 2).T
    # A joint that carries both moves neither against the other.
    by_joint = np.where(carried[second], 0.0, speeds[first]) + np.where(carried[first], 0.0, speeds[second])
    by_q = np.zeros((len(by_joint), model.model.nq))
    for j in range(1, count):
        by_q[:, model.model.idx_qs[j]] = by_joint[:, j]
    driven = model.dq_dtheta.any(axis=1)
    return by_q[:, driven] @ np.abs(model.dq_dtheta[driven])


def ancestors(model: PinocchioModel, body: Body) -> set[int]:
    """The joints that carry a body, by Pinocchio's numbers."""
    joint, carrying = model.model.frames[model.frame_id(body.carrier)].parentJoint, set()
    while joint > 0:
        carrying.add(int(joint))
        joint = model.model.parents[joint]
    return carrying


def _farthest(model: PinocchioModel, most: Array) -> Array:
    """How far each joint (njoints,) that slides may be from 0 [m] while |theta| is at most `most` (n,); else 0."""
    far = np.abs(model.dq_dtheta) @ most + np.abs(model.q(np.zeros(len(most))))
    joints = range(1, model.model.njoints)
    return np.array([0.0, *(far[model.model.idx_qs[j]] if _slides(model, j) else 0.0 for j in joints)])


def _slides(model: PinocchioModel, joint: int) -> bool:
    return "P" in model.model.joints[joint].shortname().removeprefix("JointModel")[:1]


def _speeds(model: PinocchioModel, body: Body, far: Array) -> Array:
    """Bounds (njoints,) of the speed of any point of a body by each joint alone at rate 1.

    A joint turns a point on a radius of at most the lengths between them. A slide between adds how far it may go.
    """
    frame = model.model.frames[model.frame_id(body.carrier)]
    if not frame.parentJoint:
        return np.zeros(model.model.njoints)
    centre = frame.placement.act(body.pose[:3, :3] @ body.shape.aabb_center + body.pose[:3, 3])
    radius = float(np.linalg.norm(centre)) + float(body.shape.aabb_radius)
    speeds = np.zeros(model.model.njoints)
    joint = int(frame.parentJoint)
    while joint > 0:
        speeds[joint] = 1.0 if _slides(model, joint) else radius
        radius += float(far[joint]) + float(np.linalg.norm(model.model.jointPlacements[joint].translation))
        joint = int(model.model.parents[joint])
    return speeds
