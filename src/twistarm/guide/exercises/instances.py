"""Random rotations, poses, twists and chains of joints, and the joints of the reader's arm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array

TIMES = 8
"""Random instances of an exercise."""


def unit(rng: np.random.Generator) -> Array:
    """A random unit vector (3,)."""
    vector = rng.normal(size=3)
    made: Array = vector / np.linalg.norm(vector)
    return made


def rotation(rng: np.random.Generator) -> Array:
    """A random rotation (3, 3): cross products make the second and third column orthogonal to the first."""
    x = unit(rng)
    z = np.cross(x, unit(rng))
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def pose(rng: np.random.Generator) -> Array:
    """A random pose (4, 4), up to a metre away along each axis."""
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = rotation(rng), rng.uniform(-1.0, 1.0, 3)
    return g


def angle(rng: np.random.Generator) -> float:
    """An angle from 0.2 to 2.9 rad with either sign. Small angles and half turns would hide mistakes."""
    return float(rng.uniform(0.2, 2.9) * rng.choice([-1.0, 1.0]))


def column(rng: np.random.Generator, kind: str) -> Array:
    """The twist (6,) of a joint at a random place: "turn", "slide", or "thread"."""
    w, q = unit(rng), rng.uniform(-0.8, 0.8, 3)
    if kind == "slide":
        return np.concatenate([w, np.zeros(3)])
    h = rng.uniform(0.05, 0.3) if kind == "thread" else 0.0
    return np.concatenate([np.cross(q, w) + h * w, w])


def chain(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """Screws (6, m), home (4, 4) and joint values (m,) of a random chain of three to seven joints.

    The first joint turns and is not at 0, so it moves the axes after it.
    """
    kinds = ["turn", *rng.choice(["turn", "turn", "slide", "thread"], int(rng.integers(2, 7)))]
    return np.column_stack([column(rng, kind) for kind in kinds]), pose(rng), np.array([angle(rng) for _ in kinds])


def own_chain(rng: np.random.Generator, arm: Arm) -> tuple[Array, Array, Array]:
    """Screws, home and joint values of the reader's arm at random, mimic joints included."""
    return np.array(arm.screws), np.array(arm.home), arm.coupling.A @ arm.random_theta(rng)


def chains(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Instances (screws, home, x): random chains, and the reader's arm at three configurations."""
    yield from (chain(rng) for _ in range(TIMES))
    yield from (own_chain(rng, arm) for _ in range(3))
