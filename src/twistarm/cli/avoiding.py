"""The option `--avoid`: the scene with which an arm must not collide."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..arm.arm import Arm
from .output import progress_bar

if TYPE_CHECKING:
    from ..collision import Scene

SELF = "self"

Avoid = Annotated[
    str | None,
    typer.Option(
        "--avoid",
        "--scene",
        metavar="SCENE",
        help=f"Collide with nothing: a scene.toml or MoveIt's scene, or {SELF} for the robot alone.",
    ),
]


def avoided(arm: Arm, typed: str | None) -> Scene | None:
    """The scene of `--avoid`, None if it was not typed."""
    if typed is None:
        return None
    from ..collision import Scene

    with progress_bar("allowed pairs") as progress:
        scene = Scene(arm, progress=progress) if typed == SELF else Scene.load(arm, typed, progress=progress)
        scene.find_allowed_pairs()
    return scene
