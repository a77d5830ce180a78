"""Links of an arm that overlap at a configuration, and links below the base plane."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, islice
from typing import TYPE_CHECKING

import numpy as np

from ...support.checks import Array
from ..bodies import Body, Pair, Shapes, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import import_pinocchio, why_no_pinocchio

if TYPE_CHECKING:
    from ..arm import Arm

MOST_SHAPES, MOST_PAIRS = 500, 2_000
"""The most shapes and pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"


def overlapping_links(arm: Arm) -> Callable[[Array], frozenset[Pair]] | None:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the first joint carries is tested against the rest and the base plane, except adjacent links and pairs that an
    SRDF exempts. None without Pinocchio or a description, and with more than `MOST_SHAPES` or `MOST_PAIRS`.
    """
    description = arm.description
    if description is None or why_no_pinocchio():
        return None
    model, shapes = arm.pinocchio, Shapes(import_pinocchio().coal, rough=True)
    moved = description.beyond(arm.moving_names[0])
    ground = Body(GROUND, arm.base, shapes.half_space(), np.eye(4), "plane")
    bodies = [ground, *islice(shapes.of_links(description, arm.reach), MOST_SHAPES)]
    joints = [model.model.frames[model.frame_id(body.carrier)].parentJoint for body in bodies]
    names = [body.name for body in bodies]
    exempt = arm.disabled_collisions | adjacent_pairs(description, bodies)
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
