"""Exercises on the workspace."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import tool
from .instances import chain, own_chain
from .words import DEGREES, NO_HOME


def reachable(l1: float, l2: float, x: float, y: float) -> bool:
    """Whether the tip of the two-link arm with links `l1` and `l2` reaches (x, y) [m].

    The edges are reachable.

    Allow 1e-9 m of rounding at the edges.
    """
    r = np.hypot(x, y)
    return bool(abs(l1 - l2) - 1e-9 <= r <= l1 + l2 + 1e-9)


def dextrous(l1: float, l2: float, l3: float) -> Array:
    """The least and the greatest distance (2,) [m] from the base with *every* direction of a planar hand.

    The arm has three links. The third link is the hand, and it ends at the tip. Here l1 ≥ l2 + l3 and l2 ≥ l3.
    """
    return np.array([l1 - l2 + l3, l1 + l2 - l3])


def cloud(twists: Array, home: Array, configurations: Array) -> Array:
    """Positions of the tool's origin (N, 3) [m] at N configurations (N, m) [rad, m].

    `twists` (6, m) are the joints' twists seen from the base, `home` (4, 4) is the tool's pose at zero. Use
    `screws.exp` after `from twistarm import screws`.
    """
    from twistarm import screws

    points = []
    for x in configurations:
        g = np.eye(4)
        for xi, value in zip(twists.T, x, strict=True):
            g = g @ screws.exp(xi, value)
        points.append((g @ home)[:3, 3])
    return np.array(points)


def _targets(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for l1, l2 in ((0.5, 0.3), (0.3, 0.5), (0.4, 0.4)):
        for r in (0.05, 0.15, 0.25, 0.35, 0.7, 0.79, 0.85):
            turn = rng.uniform(-np.pi, np.pi)
            yield l1, l2, float(r * np.cos(turn)), float(r * np.sin(turn))
        for edge, outwards in ((l1 + l2, 1.0), (abs(l1 - l2), -1.0)):
            if edge > 0:
                yield l1, l2, edge + outwards * 1e-10, 0.0  # as far as rounding
                yield l1, l2, 0.0, edge + outwards * 1e-6  # and farther
    yield 2.0, 3.0, 3.0, 4.0
    yield 3.0, 8.0, -3.0, 4.0
    yield 0.4, 0.4, 0.0, 0.0


def _links(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(6):
        l3 = rng.uniform(0.1, 0.3)
        l2 = l3 + rng.uniform(0.05, 0.3)
        yield float(l2 + l3 + rng.uniform(0.05, 0.4)), float(l2), float(l3)


def _configurations(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(3):
        screws, home, x = chain(rng)
        yield screws, home, x * rng.uniform(-1.0, 1.0, (4, 1))
    screws, home, _ = own_chain(rng, arm)
    yield screws, home, arm.random_theta(rng, 4) @ arm.coupling.A.T


def _triangle(l1: float, l2: float, x: float, y: float) -> bool:
    """Three lengths make a triangle: none is longer than the other two together."""
    r = np.sqrt(x * x + y * y)
    return bool(all(2 * side <= l1 + l2 + r + 2e-9 for side in (l1, l2, r)))


def _by_the_wrist(l1: float, l2: float, l3: float) -> Array:
    """The wrist moves in an annulus. It must contain a whole circle of radius l3 about the tip."""
    inner, outer = l1 - l2, l1 + l2
    distances = np.linspace(0.0, l1 + l2 + l3, 100_001)
    inside = (np.abs(distances - l3) >= inner) & (distances + l3 <= outer)
    inside &= distances >= l3
    return np.array([distances[inside][0], distances[inside][-1]])


EXERCISES = (
    Exercise(
        reachable,
        _triangle,
        _targets,
        (
            Slip(
                "hole forgotten",
                "Points near the base are called reachable: with links of different lengths there is a hole of radius "
                "|l1 − l2|.",
                {"abs(l1 - l2) - 1e-9 <= r": "0.0 <= r"},
            ),
            Slip(
                "no absolute value",
                "The hole has the radius |l1 − l2|: without the absolute value it vanishes where the "
                "second link is longer.",
                {"abs(l1 - l2)": "(l1 - l2)"},
            ),
            Slip(
                "edges excluded",
                "The edges are reachable too: there the arm is stretched out or folded. Use <= and allow for rounding.",
                {"- 1e-9 <= r <= l1 + l2 + 1e-9": "+ 1e-9 < r < l1 + l2 - 1e-9"},
            ),
            Slip(
                "no room for rounding",
                "At an edge rounding may bring r slightly outside, and your answer is False: allow 1e-9 m.",
                {"- 1e-9 <= r <= l1 + l2 + 1e-9": "<= r <= l1 + l2"},
            ),
            Slip(
                "too much room",
                "Points that lie a thousandth of a millimetre outside are called reachable: 1e-9 m are enough for "
                "rounding.",
                {"1e-9": "1e-3"},
            ),
            Slip(
                "outer edge forgotten", "Points farther than l1 + l2 are called reachable.", {" <= l1 + l2 + 1e-9": ""}
            ),
            Slip(
                "square for length",
                "You compare x² + y², which is r², with lengths: take the root (np.hypot).",
                {"r = np.hypot(x, y)": "r = x * x + y * y"},
            ),
        ),
    ),
    Exercise(
        dextrous,
        _by_the_wrist,
        _links,
        (
            Slip(
                "reachable for dextrous",
                "These are the edges of the reachable workspace, which the tip reaches in one direction "
                "alone. For every direction the third link must fit inside: it narrows the annulus on "
                "both sides.",
                {"[l1 - l2 + l3, l1 + l2 - l3]": "[l1 - l2 - l3, l1 + l2 + l3]"},
            ),
            Slip(
                "third link forgotten",
                "This is where the wrist can be. Around it the third link needs room: it narrows the annulus on both "
                "sides.",
                {"[l1 - l2 + l3, l1 + l2 - l3]": "[l1 - l2, l1 + l2]"},
            ),
            Slip(
                "outer alone",
                "The outer edge is right; the inner one goes outwards by l3: where the hand points away from the "
                "base, the wrist is nearest to the base, and must not be in the hole.",
                {"[l1 - l2 + l3,": "[l1 - l2 - l3,"},
            ),
            Slip(
                "inner alone",
                "The inner edge is right; the outer one comes inwards by l3: where the hand points towards the base, "
                "the wrist is farthest from the base, and must still be in reach.",
                {"l1 + l2 - l3]": "l1 + l2 + l3]"},
            ),
            Slip(
                "hole of the wrist",
                "The outer edge is right; the inner one is that of the hole for the wrist, l1 − l2. Where the hand "
                "points away from the base, the wrist is nearer to it than the tip by l3.",
                {"[l1 - l2 + l3,": "[l1 - l2,"},
            ),
            Slip(
                "reach of the wrist",
                "The inner edge is right; the outer one is the reach of the wrist, l1 + l2. Where the hand points "
                "towards the base, the wrist is farther from it than the tip by l3.",
                {"l1 + l2 - l3]": "l1 + l2]"},
            ),
        ),
        tolerance=5e-5,
    ),
    Exercise(
        cloud,
        lambda screws, home, configurations: np.array([tool(screws, home, x)[:3, 3] for x in configurations]),
        _configurations,
        (
            Slip("home forgotten", NO_HOME, {"(g @ home)": "g"}),
            Slip(
                "a column each",
                "Your points are columns, (3, N). The task asks for rows, (N, 3).",
                {"return np.array(points)": "return np.array(points).T"},
            ),
            Slip("degrees", DEGREES, {"exp(xi, value)": "exp(xi, np.radians(value))"}),
            Slip(
                "goes on from the last",
                "Each configuration goes on from the one before: begin each with the identity, inside the loop.",
                {"    points = []\n": "    points = []\n    g = np.eye(4)\n", "        g = np.eye(4)\n": ""},
            ),
            Slip(
                "row for column",
                "You read the last row of the pose; the origin is its last column, g[:3, 3].",
                {"[:3, 3]": "[3, :3]"},
            ),
        ),
    ),
)
