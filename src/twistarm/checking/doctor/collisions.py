"""Links that collide at the ready pose or in most configurations, though no SRDF exempts them."""

from __future__ import annotations

from collections.abc import Iterator

from ...arm.arm import Arm
from ...arm.pinocchio_model import why_no_pinocchio
from ...collision import Scene
from ...collision.allowed_pairs import ALWAYS
from ...collision.survey import collision_shares
from ...description.findings import Finding, finding
from ...support.errors import listed
from .wording import place_of

SAMPLES, OFTEN = 100, 0.8
"""Random configurations, and the share of them in which a pair collides by its drawing and not by the motion."""

MOST_BODIES = 100
"""The most bodies to check: their pairs take 1 s. A robot with more is left out."""


def check_collisions(arm: Arm) -> Iterator[Finding]:
    """Pairs of links by the shapes of a `Scene`. Pairs that always collide are exempt without an SRDF."""
    if arm.description is None or len(arm.description.links) > MOST_BODIES or why_no_pinocchio():
        return
    scene, exempt = Scene(arm), arm.disabled_collisions
    if len(scene.links) > MOST_BODIES:
        return
    shares = collision_shares(scene, arm.random_theta(0, SAMPLES))
    often = {pair for pair, share in shares.items() if share >= OFTEN and (exempt or share < ALWAYS)} - exempt
    at_ready = {pair for pair in collision_shares(scene, [arm.ready]) if shares.get(pair, 0.0) < OFTEN} - exempt
    allow = "if they may touch, add disable_collisions to the SRDF (twistarm collisions writes one)"
    for pairs, when, remedy in (
        (at_ready, "at the ready pose", f"look at it with twistarm view; correct the pose or the shapes; {allow}"),
        (often, "in most configurations", f"correct the shapes; {allow}"),
    ):
        if pairs:
            what = f"links collide {when}: {listed(f'{a} – {b}' for a, b in sorted(pairs))}"
            yield finding("links-collide", place_of(arm.description, arm.name), what, remedy)
