"""How often each pair of a scene collides at random configurations, and its SRDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from xml.sax.saxutils import quoteattr

from ..arm.bodies import adjacent_pairs
from ..description.tree import Pair, sorted_pair
from ..support.checks import Array, Progress, as_whole
from .allowed_pairs import collision_counts
from .scene import Scene

REASONS = ("Never", "Default", "Adjacent", "Always", "User")
"""The reasons that MoveIt's setup assistant knows."""


@dataclass(frozen=True, eq=False)
class Colliding:
    """A pair that collides in `share` of the configurations, for example at `theta` (n,)."""

    links: tuple[str, str]
    share: float
    theta: Array


@dataclass(frozen=True, eq=False)
class Survey:
    """The pairs that collide, the most frequent first, and the share of all configurations in which one does."""

    samples: int
    share: float
    pairs: tuple[Colliding, ...]


def survey(scene: Scene, samples: int = 2000, rng: int = 0, progress: Progress | None = None) -> Survey:
    """Check random configurations of the arm inside its limits."""
    count = as_whole(samples, "samples", 1, 10**7)
    seen: dict[tuple[str, str], list[Array]] = {}
    hit = 0
    for k, theta in enumerate(scene.arm.random_theta(rng, count)):
        if progress is not None and k % 100 == 0:
            progress(k / count)
        if scene.collides(theta):
            hit += 1
            for contact in scene.contacts(theta):
                seen.setdefault(contact.links, []).append(theta)
    pairs = [Colliding(links, len(thetas) / count, thetas[0]) for links, thetas in seen.items()]
    return Survey(count, hit / count, tuple(sorted(pairs, key=lambda pair: -pair.share)))


def collision_shares(scene: Scene, thetas: Sequence[Array] | Array) -> dict[Pair, float]:
    """The share of configurations (N, n) at which each pair of links collides, allowed pairs included.

    Neighbours and pairs that never collide are left out.
    """
    arm, bodies = scene.arm, scene.links
    assert arm.description is not None, "a scene has one"
    names = (sorted_pair(first.name, second.name) for first, second in combinations(bodies, 2))
    pairs = {(a, b) for a, b in names if a != b} - adjacent_pairs(arm.description, bodies)
    counts = collision_counts(arm.pinocchio, bodies, pairs, map(arm.pinocchio.q, thetas))
    return {pair: count / len(thetas) for pair, count in counts.items()}


def srdf_text(scene: Scene) -> str:
    """An SRDF with the allowed pairs of the scene's robot, as MoveIt's setup assistant writes them.

    Pairs of an SRDF keep their reasons. Unknown ones are "User", as it reads them. Pairs with an obstacle are left out.
    """
    assert scene.arm.description is not None
    semantics = scene.arm.description.semantics
    reasons = {**scene.allowed, **(semantics.disabled if semantics else {})}
    rows = [
        f"    <disable_collisions link1={quoteattr(a)} link2={quoteattr(b)} "
        f"reason={quoteattr(reasons[a, b] if reasons[a, b] in REASONS else 'User')}/>"
        for a, b in sorted(scene.allowed)
        if not {a, b} & scene.obstacles.keys()
    ]
    name = quoteattr(scene.arm.description.name)
    return "\n".join(['<?xml version="1.0" encoding="UTF-8"?>', f"<robot name={name}>", *rows, "</robot>", ""])
