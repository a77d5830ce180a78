"""A site of arms for any web server: an index with pictures, and a page to move each arm."""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..support.errors import InputError, TwistarmError, printable, quote
from ..support.files import writable, write_folder
from .parts.arm_data import doctor_findings
from .saved_page import SceneSnapshot, beside, of_arm, page_text
from .scene.arm_drawing import anchors
from .screenshot import png_of

PICTURE = (640, 400)  # Sides of a picture [pixels].
# What is right and what is down in a drawing, seen from the base.
AXES = np.array([[0.77, 0.64, 0.0], [0.29, -0.35, -0.89]])
INDEX = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
  content="default-src 'none'; style-src 'unsafe-inline'; img-src 'self' file: data:">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light">
<title>{count} · twistarm</title>
<meta name="generator" content="twistarm view">
<link rel="icon" href="data:,">
<style>
{style}</style>
</head>
<body><main><h1>{count}</h1>
<ul>
{arms}
</ul></main></body>
</html>
"""
MARK = '<meta name="generator" content="twistarm view">'
SAMPLES = 20_000  # Random configurations; in the best of them the tool is as far from the base as it comes, to 3 %.


def save_site(arms: Iterable[Arm], folder: str | os.PathLike[str]) -> Path:
    """Write a static site of `arms`: index.html, and a page for each that opens without a server.

    Links are relative, and all pages share their scripts. An installed browser draws the pictures. Without one, the
    index has line drawings. The site is written whole or not at all. It replaces files of the same names, and
    removes the pages of an older site. Other files in the folder stay.

    Returns the path of index.html. Raises InputError for no arms or a folder that cannot be written, and
    MissingExtraError without Meshcat.

    Args:
        arms: The arms, in the order of the index. Several may have the same name.
        folder: The folder, which need not exist.
    """
    return write_site(folder, site_of(arms)[1]) / "index.html"


def write_site(folder: str | os.PathLike[str], files: Mapping[str, str | bytes]) -> Path:
    """Write the files of a site, then remove the pages that only the site before it had."""
    target = writable(folder, folder=True)
    before = _pages(target)
    written = write_folder(target, files)
    for path in before:
        if path.name not in files:
            path.unlink(missing_ok=True)
    return written


def site_of(
    arms: Iterable[Arm], progress: Callable[[str], object] = lambda words: None
) -> tuple[list[dict[str, Any]], dict[str, str | bytes]]:
    """What the index tells of each arm, and the files of the site by name. `progress` takes a line for each arm."""
    try:
        checked = [require_arm(arm) for arm in arms]
    except TypeError as error:
        raise InputError(f"arms must be a list of arms; got {quote(arms)}") from error
    if not checked:
        raise InputError("a site needs one arm at least")
    cards: dict[str, dict[str, Any]] = {}  # by the names of their files, in small letters
    files: dict[str, str | bytes] = {}
    entries, drawn = [], True
    for number, arm in enumerate(checked, start=1):
        plain = re.sub(r"[^A-Za-z0-9_.-]", "_", arm.name).strip("._-")[:50] or "arm"
        names = (plain if k == 1 else f"{plain}_{k}" for k in range(1, len(cards) + 3))
        name = next(free for free in names if free.casefold() not in {"index", *cards})
        snapshot, findings, picture = of_arm(arm), doctor_findings(arm), _drawing(arm)
        try:
            if drawn:
                files[f"{name}.png"] = _picture(snapshot)
                picture = f'<img src="{name}.png" alt="" width="{PICTURE[0]}" height="{PICTURE[1]}" loading="lazy">'
        except TwistarmError as error:  # no browser, or one that does not draw: the next would take as long to fail
            drawn = False
            progress(f"drawings instead of pictures: {error}")
        page, scripts = beside(snapshot.with_messages(findings))
        files |= {f"{name}.html": page, **scripts}
        card = cards[name.casefold()] = {
            "name": printable(arm.name) + _distinction(arm, number, checked),
            "page": f"{name}.html",
            "joints": Counter(arm.joint_types),
            "reach": float(np.linalg.norm(arm.fk(arm.random_theta(0, SAMPLES))[:, :3, 3], axis=-1).max()),
            "findings": findings["counts"],
        }
        title, lines = escape(card["name"]), _lines(card)
        entries.append(f'<li><a href="{name}.html">{picture}<h2>{title}</h2><p>{"<br>".join(lines)}</p></a></li>')
        progress(f"{number} of {len(checked)}: {card['name']}, {', '.join(lines)}")
    count = f"{len(checked)} arm{'s' * (len(checked) != 1)}"
    index = INDEX.format(count=count, style=page_text("site.css"), arms="\n".join(entries))
    return [*cards.values()], files | {"index.html": index}


def _distinction(arm: Arm, number: int, arms: list[Arm]) -> str:
    """A mark for an arm that shares its name with others: its file, or else its number."""

    def name_of(other: Arm) -> str:
        path = other.description and other.description.path
        return path.name if path else ""

    alike, file = [name_of(other) for other in arms if other.name == arm.name], name_of(arm)
    if len(alike) == 1:
        return ""
    return f" ({file})" if file and alike.count(file) == 1 else f" ({number})"


def _pages(folder: Path) -> list[Path]:
    """The pages, pictures and meshes of the site in `folder`, by its index. None if another tool wrote it."""
    index = folder / "index.html"
    text = index.read_text("utf-8", "replace") if index.is_file() else ""
    if MARK not in text:
        return []
    pages = [folder / name for name in re.findall(r'<li><a href="([\w.-]+\.html)">', text)]
    return [*pages, *(page.with_suffix(".png") for page in pages), *folder.glob("meshes_" + "[0-9a-f]" * 12 + ".js")]


def _lines(card: Mapping[str, Any]) -> tuple[str, str]:
    """Joints; reach and findings."""
    joints, found = (", ".join(f"{n} {kind}" for kind, n in card[what].items()) for what in ("joints", "findings"))
    return f"joints: {joints}", f"reach {card['reach']:.2g} m, findings: {found or 'none'}"


def _picture(snapshot: SceneSnapshot) -> bytes:
    """The arm alone, without its axes."""
    layers = {layer: [False, 0] for layer in snapshot.messages["visible"] if layer != "type"}
    plain = snapshot.with_messages({"type": "visible", **layers})
    return png_of(PICTURE, lambda: plain)


def _drawing(arm: Arm) -> str:
    """The arm in its ready configuration as a line through its joints, for an index without pictures."""
    points = np.array([np.zeros(3), *anchors(arm, arm.ready), arm.fk(arm.ready)[:3, 3]]) @ AXES.T
    extent = np.ptp(points, axis=0)
    at = np.array(PICTURE) / 2 + (points - points.min(axis=0) - extent / 2) * 300 / max(extent.max(), 1e-9)
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
    joints = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="9"/>' for x, y in at[1:-1])
    return f'<svg viewBox="0 0 {PICTURE[0]} {PICTURE[1]}" aria-hidden="true"><polyline points="{line}"/>{joints}</svg>'
