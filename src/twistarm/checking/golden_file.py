"""Golden files: an arm frozen as numbers."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import Kind, content_of, sealed
from ..collision import Scene, require_scene
from ..collision.survey import collision_shares
from ..description.inertial import Body, bodies
from ..support.files import write_whole

GOLDEN = Kind("twistarm golden", "golden file", "twistarm freeze ARM -o FILE")

COLLISION_SAMPLES = 2000
"""Random configurations at which every pair of links is checked."""

NOT_COVERED = (
    "shapes and meshes",
    "named poses and the SRDF",
    "limits of joints beside the chain",
    "damping and friction",
)
"""What is not compared with a golden file."""


def freeze(arm: Arm, path: str | os.PathLike[str], *, scene: Scene | None = None) -> None:
    """Write the arm as numbers (JSON, SI): what `bake` keeps, and each link's mass, centre and inertia.

    `compare` tells what has changed since. Shapes and meshes, named poses, the SRDF, limits of joints beside the chain,
    damping and friction are not covered, and the file lists them. With a scene the file keeps its allowed pairs, and
    how often each pair of links collides. A changed shape or mesh that makes a pair collide is then a change. A digest
    covers every number, so an edited file is refused. The file is written whole or not at all.

    Args:
        arm: The arm.
        path: The file to write; an existing golden file is replaced.
        scene: A `Scene` of this arm, or None. Its obstacles are not kept.

    Raises:
        InputError: The file cannot be written, or the scene is one of another arm.
    """
    write_whole(path, golden_text(arm, scene))


def golden_text(arm: Arm, scene: Scene | None = None) -> str:
    """What `freeze` writes."""
    collisions = None
    if scene is not None:
        shares = collision_shares(require_scene(scene, arm), arm.random_theta(0, COLLISION_SAMPLES))
        collisions = {
            "exact": scene.exact,
            "allowed": [[*pair, reason] for pair, reason in sorted(scene.allowed.items())],
            "shares": [[*pair, share] for pair, share in sorted(shares.items())],
        }
    masses = {
        link: {"mass": body.mass, "centre": body.centre.tolist(), "inertia": body.inertia.tolist()}
        for link, body in (bodies_of(require_arm(arm)) or {}).items()
    }
    kept = {"bodies": masses if arm.description else None, "collisions": collisions, "not_covered": list(NOT_COVERED)}
    return sealed(GOLDEN, content_of(arm) | kept)


def bodies_of(arm: Arm) -> Mapping[str, Body] | None:
    """The mass of each link; None for an arm without a description."""
    return None if arm.description is None else bodies(arm.description)


def read_bodies(content: Mapping[str, Any]) -> Mapping[str, Body] | None:
    """The masses in a golden file's content; None for a baked arm, and for an arm without a description."""
    entry = content.get("bodies")
    if entry is None:
        return None
    return {
        link: Body(body["mass"], np.array(body["centre"]), np.array(body["inertia"])) for link, body in entry.items()
    }
