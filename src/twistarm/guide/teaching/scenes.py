"""Scenes of the lessons: saved pages, alone in a notebook, with shared scripts in a site."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import Array
from ...support.files import write_whole
from ...viewer.files.page_export import beside
from ...viewer.files.scene_snapshot import SceneSnapshot, of_arm
from ...viewer.parts.findings import loaded


def snapshot(arm: Arm, theta: Array, trajectory: Trajectory | None, screws: bool) -> SceneSnapshot:
    """What the page shows."""
    shown = of_arm(arm, trajectory, theta)
    if shown.playback is not None and trajectory is not None:
        # Nobody looks yet: the reader plays it, from its beginning.
        shown = replace(shown, playback=replace(shown.playback, running=False), theta=trajectory(0.0))
    # No doctor is going to look, so nothing is said of one; where loading noted nothing, the page shows no findings.
    findings = {**loaded(arm), "note": ""}
    return replace(shown, visible={**shown.visible, "screws": screws}, findings=findings)


def saved(shown: SceneSnapshot, folder: Path) -> str:
    """Write the page and its shared scripts into `folder`. Returns the page's name."""
    page, files = beside(shown)
    name = f"scene_{hashlib.sha256(page.encode()).hexdigest()[:12]}.html"
    for each, text in {name: page, **files}.items():
        if not (folder / each).is_file() or (folder / each).read_text("utf-8", errors="replace") != text:
            write_whole(folder / each, text)
    return name
