"""Pairs of links that need no check: neighbours, and pairs that always or never collide.

The rules and their names are those of MoveIt's setup assistant (compute_default_collisions.cpp), in its order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from ..arm.arm import Arm
from ..arm.bodies import Body, Pair, adjacent_pairs, sorted_pair
from ..arm.checker import Checker
from ..arm.pinocchio_model import PinocchioModel
from ..description.coupling import coupling_matrix
from ..description.tree import Description
from ..limits.joint_limits import slides
from ..support.checks import Array

SAMPLES = 10_000
"""Random configurations of the whole robot."""

TRIALS, ALWAYS = 200, 0.95
"""Samples that look for pairs in constant collision, and the share of them that is constant."""

UNLIMITED = {True: 1.0, False: np.pi}
"""Half the range of a joint without limits: a slide [m], a turn [rad]."""


def allowed_pairs(
    arm: Arm,
    model: PinocchioModel,
    description: Description,
    bodies: Sequence[Body],
    samples: int = SAMPLES,
    progress: Callable[[float], object] | None = None,
) -> dict[Pair, str]:
    """Sorted pairs of links that need no check, each with its reason.

    "Adjacent": one joint connects them, or only links without shapes are between them. "Default": they collide with
    all joints at zero, or at the ready configuration. "Always": they collide in at least 95 % of 200 random
    configurations. "Never": they collide in none of `samples` random configurations of the whole robot.
    """
    links = list(dict.fromkeys(body.name for body in bodies))
    every = [sorted_pair(a, b) for a, b in combinations(links, 2)]
    reasons = dict.fromkeys(sorted(adjacent_pairs(description, bodies)), "Adjacent")
    draw = _Sampler(arm, model, description)

    def left() -> list[Pair]:
        return [pair for pair in every if pair not in reasons]

    rest = [draw.zero, model.q(arm.ready)]
    reasons |= dict.fromkeys(sorted(collision_counts(model, bodies, left(), rest)), "Default")
    counts = collision_counts(model, bodies, left(), draw(TRIALS))
    reasons |= {pair: "Always" for pair, count in sorted(counts.items()) if count >= ALWAYS * TRIALS}
    unseen = set(left()) - set(counts)
    for done in range(0, samples, TRIALS):
        if progress is not None:
            progress(done / samples)
        unseen -= set(collision_counts(model, bodies, unseen, draw(min(TRIALS, samples - done)), once=True))
    return reasons | dict.fromkeys(sorted(unseen), "Never")


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
    """In how many of the configurations q (nq,) each pair collides; with `once`, a pair is dropped when it has."""
    wanted, counts = set(pairs), dict[Pair, int]()
    checker = _checker(model, bodies, wanted)
    for q in Q:
        if not checker.collides(q):
            continue
        hit = {_names(checker, k) for k in checker.overlapping(q)}
        for pair in hit:
            counts[pair] = counts.get(pair, 0) + 1
        if once:
            wanted -= hit
            checker = _checker(model, bodies, wanted)
    return counts


def _checker(model: PinocchioModel, bodies: Sequence[Body], wanted: set[Pair]) -> Checker:
    indices = [
        (i, j) for i, j in combinations(range(len(bodies)), 2) if sorted_pair(bodies[i].name, bodies[j].name) in wanted
    ]
    return Checker(model, bodies, indices, [0.0] * len(indices))


def _names(checker: Checker, k: int) -> Pair:
    i, j = checker.pairs[k]
    return sorted_pair(checker.bodies[i].name, checker.bodies[j].name)
