"""Files that a page can download, made in a thread from the current view."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ...collision.scene_file import scene_text
from ...planning.files.c_header import header_text
from ...planning.files.csv_file import csv_text
from ...planning.files.joint_trajectory import json_text
from ...planning.trajectory import Trajectory
from ...support.errors import InputError
from ..files.page_export import stand_alone
from ..files.scene_snapshot import on_show
from ..scene.arm_drawing import Drawing
from ..stage import Stage

SAMPLE_TIME = 0.01
"""Time between two rows of an export [s]."""

MOST_SAMPLES = 20_000
"""Most rows of an exported motion: some megabytes for seven joints."""


@dataclass(frozen=True)
class Download:
    """A file: its content type, and the ending of its name after the arm's name.

    The loop calls `prepare(stage, drawing)`, which copies what it needs from the stage. A thread calls the result,
    which returns the text and must not touch the stage. Both may raise InputError with the reason why there is no file.
    """

    content_type: str
    ending: str
    prepare: Callable[[Stage, Drawing], Callable[[], str]]

    def file_name(self, arm: str) -> str:
        """The file's name, in letters that every system and header takes."""
        return re.sub(r"[^A-Za-z0-9._-]", "_", arm)[:100] + self.ending


def _motion(write: Callable[[Trajectory, float], str], stage: Stage, drawing: Drawing) -> Callable[[], str]:
    at = stage.playback
    if at is None:
        raise InputError("nothing to export: no trajectory is loaded")
    return partial(write, at.trajectory, max(SAMPLE_TIME, at.duration / MOST_SAMPLES))


def _header(motion: Trajectory, dt: float) -> str:
    """Without samples: the polynomials themselves."""
    return header_text(motion)


def _page(stage: Stage, drawing: Drawing) -> Callable[[], str]:
    return partial(stand_alone, on_show(stage, drawing))


def _scene(stage: Stage, drawing: Drawing) -> Callable[[], str]:
    made = stage.collisions.scene
    if made is None:
        raise InputError("there is no scene yet: switch the layer Collision on first")
    return partial(scene_text, made.content(), Path.cwd())


DOWNLOADS: Mapping[str, Download] = {
    "arm.html": Download("text/html; charset=utf-8", ".html", _page),
    "scene.toml": Download("application/toml", "_scene.toml", _scene),
    "motion.csv": Download("text/csv; charset=utf-8", "_motion.csv", partial(_motion, csv_text)),
    "motion.json": Download("application/json", "_motion.json", partial(_motion, json_text)),
    "motion.h": Download("text/plain; charset=utf-8", "_motion.h", partial(_motion, _header)),
}
"""Downloads by their name under the token."""
