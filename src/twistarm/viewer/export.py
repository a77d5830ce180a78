"""The stand-alone page: one HTML file with everything in it, which opens offline and plays a trajectory."""

from __future__ import annotations

import base64
import os
import re
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import rotations
from ..arm import Arm
from ..checks import Array
from ..errors import InputError
from ..files import write_whole
from ..planning.trajectory import Trajectory
from ..strict_json import encode
from .admission import check_trajectory, checked_theta
from .drawing import require_meshcat
from .findings import examined
from .page_files import meshcat_bundle, page_text
from .path import NO_PATH, tool_path
from .scene import build_scene
from .summary import describe_arm, extra_joints, placement, rest

SAMPLE_TIME = 1.0 / 30.0
"""Between samples [s] the page interpolates, so the eye sees no steps."""

MOST_SAMPLES = 2000
"""A longer motion is sampled more coarsely: the file stays within a few megabytes."""

DECIMALS = 6
"""Positions to a micrometre, quaternions to a microradian."""

EXPORT = r"^export ((?:async )?function|class|const) ([\w$]+)"
"""How the page's modules export: a definition at the start of a line."""

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def save_html(
    arm: Arm,
    path: str | os.PathLike[str],
    trajectory: Trajectory | None = None,
    theta: ArrayLike | None = None,
) -> Path:
    """Write one HTML file that shows `arm`, and plays `trajectory` if one is given; without, it stands at theta (n,).

    The way that the trajectory takes the tool is drawn. The file needs no server and no browser to write, and no
    network to open: Meshcat's code and the meshes are inside, and the page's policy lets it load nothing. `theta`
    defaults to the ready pose. Written whole or not at all.

    Raises InputError for a trajectory of another arm or a path that cannot be written, MissingExtraError without
    Meshcat.
    """
    require_meshcat()
    start = arm.ready if theta is None else checked_theta(arm, theta)
    if trajectory is not None:
        check_trajectory(arm, trajectory)
    scene = build_scene(arm)
    data = {
        "arm": describe_arm(arm),
        "links": scene.links,
        "visible": {"screws": True, "frames": True, "path": True},
        "path": NO_PATH if trajectory is None else tool_path(arm, trajectory),
        "samples": _samples(arm, trajectory, start),
        "objects": [base64.b64encode(part).decode("ascii") for part in scene.objects],
        "notes": scene.notes,
        "findings": examined(arm),
    }
    return write_whole(path, _page(arm.name, data))


def _page(name: str, data: dict[str, Any]) -> str:
    """index.html with its style, scripts and data inlined."""
    page = re.sub(r'<link rel="stylesheet" href="(.*)">', _style, page_text("index.html"))
    # A "<" in JSON can only stand in a string; escaped, no name can close the script.
    literal = encode(data).replace("<", "\\u003c")
    policy = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
    scripts = (
        f'<script type="application/json" id="data">{literal}</script>\n<script type="module">\n{_program()}</script>'
    )
    for old, new in (
        ("<title>twistarm</title>", f"<title>{escape(name)} · twistarm</title>"),
        ('<meta charset="utf-8">', f'<meta charset="utf-8">\n{policy}'),
        ('<script src="meshcat.js"></script>', f"<script>{_inline(meshcat_bundle())}</script>"),
        ('<script type="module" src="main.js"></script>', scripts),
    ):
        head, found, tail = page.partition(old)
        if not found:
            raise InputError(f"the page's index.html lacks {old!r}; reinstall twistarm")
        page = head + new + tail
    return page


def _style(link: re.Match[str]) -> str:
    return f"<style>\n{page_text(link[1])}</style>"


def _program() -> str:
    """The modules in one script, since a file opened from disk may import none; each keeps its names to itself."""
    return _inline("\n".join(_scoped(name) for name in modules("standalone.js")))


def _scoped(name: str) -> str:
    """A module as a constant that holds what it exports."""
    text = page_text(name)
    text = re.sub(r'^import (.*) from "\./(.*)\.js";$', r"const \1 = of_\2;", text, flags=re.MULTILINE)
    text = re.sub(EXPORT, r"\1 \2", text, flags=re.MULTILINE)
    exported = ", ".join(found[1] for found in re.findall(EXPORT, page_text(name), flags=re.MULTILINE))
    return f"const of_{name.removesuffix('.js')} = (() => {{\n{text}\nreturn {{ {exported} }};\n}})();"


def modules(name: str) -> list[str]:
    """What the module `name` of the page runs, each module after those it imports, itself the last."""
    ordered: list[str] = []
    for imported in re.findall(r'^import .* from "\./(.*)";$', page_text(name), flags=re.MULTILINE):
        ordered += modules(imported)
    return list(dict.fromkeys([*ordered, name]))


def _inline(script: str) -> str:
    """JavaScript that may stand inside a script element: `</script` and `<!--` occur in its strings only."""
    return re.sub(r"</(script)", r"<\\/\1", script, flags=re.IGNORECASE).replace("<!--", "<\\!--")


def _samples(arm: Arm, trajectory: Trajectory | None, start: Array) -> dict[str, Any]:
    times = np.zeros(1) if trajectory is None else _times(float(trajectory.duration))
    thetas = [start] if trajectory is None else [checked_theta(arm, trajectory(t)) for t in times]
    others = {name: rest(joint) for name, joint in extra_joints(arm).items()}
    placed = [placement(arm, theta, others) for theta in thetas]
    paths = placed[0]["transforms"]
    return {
        "times": times.tolist(),
        "theta": [_rounded(theta) for theta in thetas],
        "others": others,
        "tool": [frame["tool"] for frame in placed],
        "nodes": {path: [_seven(frame["transforms"][path]) for frame in placed] for path in paths},
    }


def _times(duration: float) -> Array:
    count = min(MOST_SAMPLES, 1 + int(np.ceil(duration / SAMPLE_TIME)))
    return np.asarray(np.linspace(0.0, duration, max(2, count) if duration > 0 else 1), dtype=np.float64)


def _seven(numbers: list[float]) -> list[float]:
    """Position and quaternion (x, y, z, w) of a matrix given by columns."""
    g = np.array(numbers).reshape(4, 4).T
    return _rounded(np.concatenate([g[:3, 3], rotations.to_xyzw(g[:3, :3])]))


def _rounded(values: Array) -> list[float]:
    numbers: list[float] = np.round(values, DECIMALS).tolist()
    return numbers
