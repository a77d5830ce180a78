"""How often the links of a robot collide with each other, and what has changed in it, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import Any

from ..arm.arm import Arm
from ..arm.bodies import Pair, adjacent_pairs, sorted_pair
from ..collision import Scene
from ..collision.allowed_pairs import collision_counts
from ..support.checks import Array

SAMPLES = 2000
"""Random configurations at which every pair is checked."""

SAME_SHARE = 0.001
"""Shares that differ by less are the same: rounding moves few configurations into or out of a collision."""


def collisions_entry(scene: Scene) -> dict[str, Any]:
    """What a golden file keeps: the allowed pairs with their reasons, and the share in which each pair collides."""
    shares = collision_shares(scene, scene.arm.random_theta(0, SAMPLES))
    return {
        "exact": scene.exact,
        "allowed": [[*pair, reason] for pair, reason in sorted(scene.allowed.items())],
        "shares": [[*pair, share] for pair, share in sorted(shares.items())],
    }


def collision_changes(entry: Mapping[str, Any], then: Arm, arm: Arm) -> Iterator[str]:
    """The pairs of links that collide more or less often than at the time of `entry`, at the same configurations."""
    reasons = {(a, b): reason for a, b, reason in entry["allowed"]}
    before = {(a, b): share for a, b, share in entry["shares"]}
    now = collision_shares(Scene(arm, exact=entry["exact"]), then.random_theta(0, SAMPLES))
    for pair in sorted({*before, *now}):
        was, share = before.get(pair, 0.0), now.get(pair, 0.0)
        if abs(share - was) > SAME_SHARE:
            exempt = f"; this pair is not checked ({reasons[pair]})" if pair in reasons else ""
            words = f"collide in {_percent(share)} of random configurations" if share else "collide no more"
            yield f"{pair[0]} and {pair[1]} {words}; it was {_percent(was)}{exempt}"


def collision_shares(scene: Scene, thetas: Sequence[Array] | Array) -> dict[Pair, float]:
    """The share of configurations (N, n) at which each pair of links collides, without neighbours and shares of 0."""
    arm, bodies = scene.arm, scene.links
    assert arm.description is not None, "a scene has one"
    names = (sorted_pair(one.name, other.name) for one, other in combinations(bodies, 2))
    apart = {(a, b) for a, b in names if a != b} - adjacent_pairs(arm.description, bodies)
    counts = collision_counts(arm.pinocchio, bodies, apart, map(arm.pinocchio.q, thetas))
    return {pair: count / len(thetas) for pair, count in counts.items()}


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"
