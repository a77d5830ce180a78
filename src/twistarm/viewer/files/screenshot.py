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
    """The picture that `write_picture` writes."""
    wanted = checked_size(size)
    with browser_at_work("draw") as (browser, folder):
        shown = replace(show(), playback=None)
        return draw(browser, write_whole(folder / "arm.html", sized_page(shown, wanted)), wanted)


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """`size`, or InputError if a picture cannot have it."""
    try:
        width, height = map(operator.index, size)
    except (TypeError, ValueError):
        width = height = 0
    if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
        wanted = f"width and height in whole pixels, {SMALLEST} to {LARGEST} each, as (1280, 720)"
        raise InputError(f"size must be {wanted}; got {shown(size)}")
    return width, height


def sized_page(shown: SceneSnapshot, size: tuple[int, int]) -> str:
    """The saved page at exactly this size, because windows have a minimal width and frames.

    Findings are hidden, so the doctor does not run.
    """
    page = stand_alone(replace(shown, findings=loaded(shown.arm)))
    style = "<style>body {{ width: {}px; height: {}px; }}</style>\n</head>".format(*size)
    return page.replace("</head>", style, 1)
