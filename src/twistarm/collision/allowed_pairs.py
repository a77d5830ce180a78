"""Pairs of links that need no check: neighbours, and pairs that always or never collide.

The rules and their names are those of MoveIt's setup assistant (compute_default_collisions.cpp), in its order.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from ..arm.arm import Arm
from ..arm.bodies import Body, adjacent_pairs
from ..arm.checker import Checker
from ..arm.pinocchio_model import PinocchioModel
from ..description.chain import coupling_matrix
from ..description.tree import Description, Pair, sorted_pair
from ..limits.joint_limits import slides
from ..support.checks import Array, Progress

SAMPLES = 10_000  # Random configurations of the whole robot.
TRIALS, ALWAYS = 200, 0.95  # Samples that look for pairs in constant collision, and the share of them that is constant.
UNLIMITED = {True: 1.0, False: np.pi}  # Half the range of a joint without limits: a slide [m], a turn [rad].


def allowed_pairs(
    arm: Arm,
    model: PinocchioModel,
    description: Description,
    bodies: Sequence[Body],
    samples: int = SAMPLES,
    progress: Progress | None = None,
) -> dict[Pair, str]:
    """Sorted pairs of links that need no check, each with its reason.

    "Adjacent": one joint connects them, or only links without shapes are between them. "Default": they collide with
    all joints at zero, or at the ready configuration. "Always": they collide in at least 95 % of 200 random
    configurations. "Never": they collide in none of `samples` random configurations of the whole robot.
    """
    links = list(dict.fromkeys(body.name for body in bodies))
    reasons = dict.fromkeys(sorted(adjacent_pairs(description, bodies)), "Adjacent")
    left = {sorted_pair(a, b) for a, b in combinations(links, 2)} - set(reasons)
    draw = _Sampler(arm, model, description)
    for reason, least, Q in (
        ("Default", 1.0, [draw.zero, model.q(arm.ready)]),
        ("Always", ALWAYS * TRIALS, draw(TRIALS)),
    ):
        counts = collision_counts(model, bodies, left, Q)
        reasons |= {pair: reason for pair, count in sorted(counts.items()) if count >= least}
        left -= set(reasons)
    left -= set(counts)
    for done in range(0, samples, TRIALS):
        if progress is not None:
            progress(done / samples)
        left -= set(collision_counts(model, bodies, left, draw(min(TRIALS, samples - done)), once=True))
    return reasons | dict.fromkeys(sorted(left), "Never")


class _Sampler:
    """Random configurations q (count, nq) of the whole robot, every independent joint inside its limits."""

    def __init__(self, arm: Arm, model: PinocchioModel, description: Description) -> None:
        names = [str(name) for name in list(model.model.names)[1:]]
        free = list(dict.fromkeys(m for name in names if (m := arm.couplings[name].master) is not None))
        self._A, self._b = coupling_matrix(arm.couplings, names, free)
        lower, upper = [], []
        for name in free:
            joint = description.joints[name]
            half = UNLIMITED[slides(joint.type)]
            lower.append(joint.lower if np.isfinite(joint.lower) else -half)
            upper.append(joint.upper if np.isfinite(joint.upper) else half)
        self._lower, self._upper = np.array(lower), np.array(upper)
        self._rng = np.random.default_rng(0)
        inside = (self._lower <= 0.0) & (self._upper >= 0.0)
        self.zero = self._q(np.where(inside, 0.0, 0.5 * (self._lower + self._upper)))

    def __call__(self, count: int) -> list[Array]:
        values = self._rng.uniform(self._lower, self._upper, (count, len(self._lower)))
        return [self._q(value) for value in values]

    def _q(self, values: Array) -> Array:
        return self._A @ values + self._b


def collision_counts(
    model: PinocchioModel, bodies: Sequence[Body], pairs: Iterable[Pair], Q: Iterable[Array], once: bool = False
) -> Mapping[Pair, int]:
    """In how many of the configurations q (nq,) each pair collides. With `once`, a pair is dropped when it has."""
    wanted, counts, checker = set(pairs), dict[Pair, int](), None
    for q in Q:
        if checker is None:
            named = [(i, j) for i, j in combinations(range(len(bodies)), 2) if _pair(bodies, i, j) in wanted]
            checker = Checker(model, bodies, named, [0.0] * len(named))
        if checker.collides(q):
            hit = {_pair(bodies, *checker.pairs[k]) for k in checker.overlapping(q)}
            counts |= {pair: counts.get(pair, 0) + 1 for pair in hit}
            if once:
                wanted, checker = wanted - hit, None
    return counts


def _pair(bodies: Sequence[Body], i: int, j: int) -> Pair:
    return sorted_pair(bodies[i].name, bodies[j].name)
