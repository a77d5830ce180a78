"""A picture of the arm without a display. A headless browser draws the saved page."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.errors import InputError, shown
from ...support.files import writable, write_whole
from ..parts.findings import loaded
from .headless import browser_at_work, draw
from .page_export import stand_alone
from .scene_snapshot import SceneSnapshot, of_arm

SMALLEST, LARGEST = 200, 4096
"""Sides of a picture [pixels]. In smaller ones the legend hides the arm. Larger ones may be scaled down."""


def save_png(
    arm: Arm,
    path: str | os.PathLike[str],
    theta: ArrayLike | None = None,
    *,
    size: tuple[int, int] = (1280, 720),
    trajectory: Trajectory | None = None,
) -> Path:
    """Write a PNG of `arm` at theta (n,) [rad, m], `size` (width, height) in pixels, without a display.

    Chromium, Chrome or Edge must be installed. It draws the 3D view of the `save_html` page without a GPU, with a
    temporary profile. The file is written whole or not at all.

    Args:
        arm: The arm.
        path: The file to write, which ends in .png.
        theta: The configuration to show (n,) [rad, m]. By default the trajectory's start, else the ready pose.
        size: (width, height) [pixels].
        trajectory: A motion whose tool path is drawn, or None.

    Returns:
        The path written.

    Raises:
        InputError: The size, theta or the path cannot be used.
        MissingExtraError: Meshcat is not installed.
        TwistarmError: There is no browser, or it does not draw.
    """
    start = trajectory(0.0) if trajectory is not None and theta is None else theta
    return write_picture(path, size, lambda: of_arm(arm, trajectory, start))


def write_picture(path: str | os.PathLike[str], size: tuple[int, int], show: Callable[[], SceneSnapshot]) -> Path:
    """`save_png` of what `show` returns. `show` is called after all checks."""
    target = writable(path)
    if target.suffix.lower() != ".png":
        raise InputError(f"cannot write {target}: a screenshot is a PNG; give a name that ends in .png")
    return write_whole(target, png_of(size, show))


def png_of(size: tuple[int, int], show: Callable[[], SceneSnapshot]) -> bytes:
    """The picture that `write_picture` writes. Findings are hidden, so the doctor does not run."""
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        width = height = 0
    if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
        wanted = f"width and height in whole pixels, {SMALLEST} to {LARGEST} each, as (1280, 720)"
        raise InputError(f"size must be {wanted}; got {shown(size)}")
    with browser_at_work("draw") as (browser, folder):
        snapshot = replace(show(), playback=None)
        page = stand_alone(replace(snapshot, findings=loaded(snapshot.arm)))
        # Windows have a minimal width and frames: the page itself has this size.
        style = f"<style>body {{ width: {width}px; height: {height}px; }}</style>\n</head>"
        return draw(browser, write_whole(folder / "arm.html", page.replace("</head>", style, 1)), (width, height))
