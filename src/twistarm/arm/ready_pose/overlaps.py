"""Links of an arm that overlap at a configuration, and links below the base plane."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, islice
from typing import TYPE_CHECKING

import numpy as np

from ...support.checks import Array
from ..bodies import Body, Pair, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import import_pinocchio
from .quick_shapes import QuickShapes

if TYPE_CHECKING:
    from ..arm import Arm

MOST_PAIRS = 2_000
"""The most pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"


def overlapping_links(arm: Arm) -> Callable[[Array], frozenset[Pair]] | None:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the first joint carries is tested against the rest and the base plane, except adjacent links and pairs that an
    SRDF exempts. None for an arm without a description.
    """
    description = arm.description
    if description is None:
        return None
    model, shapes = arm.pinocchio, QuickShapes(import_pinocchio().coal)
    moved = description.beyond(arm.moving_names[0])
    ground = Body(GROUND, arm.base, shapes.half_space(), np.eye(4), "plane")
    bodies = [ground, *shapes.of_links(description, arm.reach)]
    joints = [model.model.frames[model.frame_id(body.carrier)].parentJoint for body in bodies]
    names = [body.name for body in bodies]
    exempt = arm.disabled_collisions | adjacent_pairs(description, bodies)
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
