"""Links of an arm that overlap at a configuration, and links below the base plane."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, islice

import numpy as np

from ...description.tree import Description
from ...support.checks import Array
from ..bodies import Body, Pair, Shapes, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import PinocchioModel, import_pinocchio

MOST_SHAPES, MOST_PAIRS = 500, 2_000
"""The most shapes and pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"


def overlapping_links(
    model: PinocchioModel, description: Description, base: str, first: str, reach: float, exempt: frozenset[Pair]
) -> Callable[[Array], frozenset[Pair]] | None:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the `first` joint carries is tested against the rest and the base plane, except adjacent links and pairs that
    are `exempt`. None with more than `MOST_SHAPES` or `MOST_PAIRS`.
    """
    shapes = Shapes(import_pinocchio().coal, rough=True)
    moved = description.beyond(first)
    ground = Body(GROUND, base, shapes.half_space(), np.eye(4), "plane")
    bodies = [ground, *islice(shapes.of_links(description, reach), MOST_SHAPES)]
    joints = [model.model.frames[model.frame_id(body.carrier)].parentJoint for body in bodies]
    names = [body.name for body in bodies]
    exempt = exempt | adjacent_pairs(description, bodies)
    pairs = [
        (i, j)
        for i, j in combinations(range(len(bodies)), 2)
        if (names[i] in moved or names[j] in moved)
        and joints[i] != joints[j]
        and sorted_pair(names[i], names[j]) not in exempt
    ]
    if len(bodies) > MOST_SHAPES or len(pairs) > MOST_PAIRS:
        return None
    checker = Checker(model, bodies, pairs, [0.0] * len(pairs))

    def overlapping(theta: Array) -> frozenset[Pair]:
        hit = (checker.pairs[k] for k in checker.overlapping(model.q(theta)))
        return frozenset((names[i], names[j]) for i, j in hit)

    return overlapping
