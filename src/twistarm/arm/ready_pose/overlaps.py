"""Links of an arm that overlap at a configuration, and links below the base plane."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations, islice
from pathlib import Path
from typing import Any

import numpy as np

from ...description.tree import Description
from ...support.checks import Array
from ...support.errors import InputError
from ...support.files import read_bounded
from ..bodies import Body, Pair, Shapes, adjacent_pairs, sorted_pair
from ..checker import Checker
from ..pinocchio_model import PinocchioModel, import_pinocchio

MOST_SHAPES, MOST_PAIRS = 500, 2_000
"""The most shapes and pairs of shapes. A larger robot is a scene and is not checked."""

GROUND = "the base plane"

LARGEST, HEAD, TRIANGLE = 10_000_000, 84, 50
"""Bytes of the largest file, of an STL's head and of a triangle."""

VERTICES = 3_000
"""The most vertices to look at, evenly spread over the file."""

DIRECTIONS = np.array([d for d in np.ndindex(5, 5, 5) if 0 < np.abs(np.subtract(d, 2)).sum() <= 3]) - 2.0
"""Along the axes, between two or three of them, and between those."""


def overlapping_links(
    model: PinocchioModel, description: Description, base: str, first: str, reach: float, exempt: frozenset[Pair]
) -> Callable[[Array], frozenset[Pair]] | None:
    """A function from theta (n,) to the pairs of links that overlap, and links that reach below the base plane.

    What the `first` joint carries is tested against the rest and the base plane, except adjacent links and pairs that
    are `exempt`. None with more than `MOST_SHAPES` or `MOST_PAIRS`.
    """
    shapes = _QuickShapes(import_pinocchio().coal)
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


class _QuickShapes(Shapes):
    """Shapes that need no other process, so that every installation computes the same ready pose.

    A link whose meshes are no binary STL has visuals or capsules, as one without shapes.
    """

    def mesh(self, path: Path, scale: tuple[float, ...]) -> Any:
        """The hull of the outermost points of a binary STL. InputError for any other file."""
        points = _vertices(path) * scale
        return self._hull(points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))])


def _vertices(path: Path) -> Array:
    """Up to `VERTICES` vertices (N, 3) of a binary STL."""
    try:
        data = read_bounded(path, LARGEST) if path.suffix.lower() == ".stl" else b""
    except OSError as error:
        raise InputError(str(error)) from None
    count = int.from_bytes(data[80:HEAD], "little")
    if count == 0 or len(data) != HEAD + TRIANGLE * count:
        raise InputError("it is no binary STL")
    every = np.ndarray((count, 3, 3), "<f4", data, HEAD + 12, (TRIANGLE, 12, 4))
    points = every[:: 1 + 3 * count // VERTICES].reshape(-1, 3).astype(np.float64)
    if not np.isfinite(points).all():
        raise InputError("a vertex is not finite")
    return points
