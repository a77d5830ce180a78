"""Scenes of the lessons: stand-alone pages of the view, alone in a notebook, beside shared scripts in a site."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ...support.files import write_whole
from ...viewer.files.page_export import beside, stand_alone
from ...viewer.files.scene_snapshot import SceneSnapshot, of_arm
from ...viewer.parts.findings import loaded

if TYPE_CHECKING:
    from .shown import Scene


def whole(scene: Scene) -> str:
    """The page with everything in it."""
    return stand_alone(_snapshot(scene))


def saved(scene: Scene, folder: Path) -> list[str]:
    """Write the page and the scripts that it shares with others into `folder`; their names, the page's first."""
    page, files = beside(_snapshot(scene))
    name = f"scene_{hashlib.sha256(page.encode()).hexdigest()[:12]}.html"
    for each, text in {name: page, **files}.items():
        path = folder / each
        if not path.is_file() or path.read_text("utf-8", errors="replace") != text:
            write_whole(path, text)
    return [name, *files]


def _snapshot(scene: Scene) -> SceneSnapshot:
    shown = of_arm(scene.arm, scene.trajectory, scene.theta)
    if shown.playback is not None and scene.trajectory is not None:
        # Nobody looks yet: the reader plays it, from its beginning.
        shown = replace(shown, playback=replace(shown.playback, running=False), theta=scene.trajectory(0.0))
    # No doctor is going to look, so nothing is said of one; where loading noted nothing, the page shows no findings.
    findings = {**loaded(scene.arm), "note": ""}
    return replace(shown, visible={**shown.visible, "screws": scene.screws}, findings=findings)
