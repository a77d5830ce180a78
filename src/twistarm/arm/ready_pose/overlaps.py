"""Links of an arm that overlap at a configuration, and links below the base plane."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, islice

import numpy as np

from ...description.tree import Description
from ...support.checks import Array
from ..bodies import Body, Pair, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import PinocchioModel, import_pinocchio
from .quick_shapes import QuickShapes

MOST_PAIRS = 2_000
"""The most pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"

Overlapping = Callable[[Array], frozenset[Pair]]


def overlapping_links(
    model: PinocchioModel, description: Description, base: str, reach: float, first: str, exempt: frozenset[Pair]
) -> Overlapping:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the joint `first` carries is tested against the rest and the base plane, except adjacent and `exempt` pairs.
    """
    shapes, moved = QuickShapes(import_pinocchio().coal), description.beyond(first)
    ground = Body(GROUND, base, shapes.half_space(), np.eye(4), "plane")
    bodies = [ground, *shapes.of_links(description, reach)]
    joints = [model.model.frames[model.frame_id(body.carrier)].parentJoint for body in bodies]
    names = [body.name for body in bodies]
    exempt = exempt | adjacent_pairs(description, bodies)
    every = (
        (i, j)
        for i, j in combinations(range(len(bodies)), 2)
        if (names[i] in moved or names[j] in moved)
        and joints[i] != joints[j]
        and sorted_pair(names[i], names[j]) not in exempt
    )
    pairs = list(islice(every, MOST_PAIRS + 1))
    checker = Checker(model, bodies, pairs if len(pairs) <= MOST_PAIRS else [], [0.0] * len(pairs))

    def overlapping(theta: Array) -> frozenset[Pair]:
        hit = (checker.pairs[k] for k in checker.overlapping(model.q(theta)))
        return frozenset((names[i], names[j]) for i, j in hit)

    return overlapping
