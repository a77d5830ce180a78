"""The saved page: a snapshot of what is on show, one HTML file that plays it offline, and its frame in a notebook."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..planning.trajectory import Trajectory
from ..support.checks import Array, as_positive
from ..support.files import writable, write_whole
from ..support.strict_json import encode
from .messages import Message
from .parts.arm_data import PENDING, check_trajectory, describe_arm, doctor_findings, named_poses, tool_path
from .parts.player import plots
from .parts.show import Playback
from .parts.theory import axes
from .scene.arm_drawing import Drawing
from .scene.kinematics import kinematics
from .stage import Stage

PLAYED = ("time", "running", "speed", "loop")  # State of a playback that the page continues.
SAME = 1e-9  # An arm within this [rad, m] of a trajectory's theta is on the trajectory.
SAMPLE_TIME = 1.0 / 30.0  # Time between samples [s]. The page interpolates between them.
MOST_SAMPLES = 2000  # Most samples of a motion, which keep the file within a megabyte.
DECIMALS = 9  # Decimals of values in rad and m.


@dataclass(frozen=True)
class SceneSnapshot:
    """`arm` at theta (n,) [rad, m] with its other joints, drawn as `drawing`, and the visible layers.

    `playback` is the motion that the page plays and its start time, or None. `findings` is their message, or None
    before the doctor has run. `recorded` holds poses by name, `obstacles` and `shapes` what is drawn of a scene, and
    `reach` what is drawn of a map. `drawings` are the messages of a program's drawings.
    """

    arm: Arm
    drawing: Drawing
    theta: Array
    others: Mapping[str, float]
    visible: Mapping[str, bool]
    path: Mapping[str, Any]
    playback: Playback | None
    findings: Message | None
    recorded: Mapping[str, Array] = field(default_factory=dict)
    obstacles: Sequence[Mapping[str, Any]] = ()
    shapes: Sequence[Mapping[str, Any]] = ()
    reach: Message | None = None
    drawings: Sequence[Message] = ()

    def playing(self, trajectory: Trajectory) -> SceneSnapshot:
        """A copy with `trajectory` and its path, playing from the start.

        Raises InputError for another arm's trajectory.
        """
        check_trajectory(self.arm, trajectory)
        playback = Playback(trajectory, running=True)
        return replace(self, playback=playback, path=tool_path(self.arm, trajectory))

    def data(self) -> dict[str, Any]:
        """The data for standalone.js.

        `aside` is the arm's configuration if it is not on the motion.

        It may run in any thread, because it does not touch the stage. It reads remaining meshes and runs the doctor if
        needed.
        """
        at, drawing = self.playback, self.drawing.whole()
        # A user may have moved the arm away from its motion.
        on_motion = at is not None and (at.running or bool(np.abs(at.theta() - self.theta).max() < SAME))
        skipped = drawing.live | {b""}
        still = {"times": [0.0], "theta": [self.theta.tolist()], "rates": [[0.0] * self.arm.n]}
        return {
            "arm": describe_arm(self.arm),
            "links": drawing.links,
            "visible": dict(self.visible),
            "path": dict(self.path),
            "kinematics": kinematics(self.arm, list(self.others)),
            "others": dict(self.others),
            "poses": self._poses(),
            "samples": still if at is None else _moving(at.trajectory),
            "aside": None if at is None or on_motion else self.theta.tolist(),
            "plots": plots(self.arm, None if at is None else at.trajectory),
            "player": None if at is None else {name: getattr(at, name) for name in PLAYED},
            "objects": [base64.b64encode(part).decode("ascii") for part in drawing.objects if part not in skipped],
            "obstacles": self.obstacles,
            "shapes": self.shapes,
            "reach": self.reach,
            "drawings": self.drawings,
            "notes": drawing.notes,
            "axes": axes(self.arm),
            "findings": doctor_findings(self.arm) if self.findings is None else self.findings,
        }

    def _poses(self) -> dict[str, list[float]]:
        """Poses that the page can go to, by name: the arm's and the recorded ones."""
        named = {name: theta.tolist() for name, theta in named_poses(self.arm).items()}
        own = {f"{name} (recorded)" if name in named else name: theta.tolist() for name, theta in self.recorded.items()}
        return named | own


def of_arm(arm: Arm, trajectory: Trajectory | None = None, theta: ArrayLike | None = None) -> SceneSnapshot:
    """`arm` at theta (n,), by default ready, with all layers and `trajectory` playing."""
    shown = on_show(Stage(arm, theta), Drawing(arm))
    return shown if trajectory is None else shown.playing(trajectory)


def on_show(stage: Stage, drawing: Drawing) -> SceneSnapshot:
    """What the pages of a live view show now, and the loaded motion.

    Call it in the stage's thread.

    The findings are those of the pages, unless the doctor has not run yet.
    """
    playback = stage.playback
    unexamined = PENDING in stage.findings["note"] and not stage.driven
    return SceneSnapshot(
        stage.arm,
        drawing,
        stage.theta.copy(),
        stage.others,
        {layer: on for layer, (on, _) in stage.visible.items()},
        stage.path,
        None if playback is None else replace(playback),
        None if unexamined else stage.findings,
        stage.poses.named(),
        stage.collisions.drawn,
        stage.collisions.shapes,
        stage.reach.drawn if stage.visible["reach"][0] or "reach" in stage.needed else None,
        [*stage.drawings.values()],
    )


def _moving(trajectory: Trajectory) -> dict[str, Any]:
    """times (k,) [s], theta (k, n) and its rates: `trajectory` from its start to its end."""
    duration = float(trajectory.duration)
    count = min(MOST_SAMPLES, max(2, 1 + int(np.ceil(duration / SAMPLE_TIME))))
    times = np.linspace(0.0, duration, count if duration > 0.0 else 1)
    theta, rates = (np.round(trajectory(times, order), DECIMALS).tolist() for order in (0, 1))
    return {"times": times.tolist(), "theta": theta, "rates": rates}


# the page --------------------------------------------------------------------------------------------

HEIGHT = 480  # Height of a frame [pixels]. It is as wide as the notebook's output.

STYLE = "width:100%;border:1px solid #8884;border-radius:8px;color-scheme:normal"


@dataclass(frozen=True)
class Inline:
    """HTML that a notebook shows on a cell's last line or by IPython's `display`."""

    html: str

    def _repr_html_(self) -> str:
        return self.html

    @classmethod
    def live(cls, url: str, name: str, height: float = HEIGHT) -> Inline:
        """The page at `url`, which its process serves to notebooks of this machine."""
        return cls(_frame(name, height, f'src="{escape(url)}" allow="clipboard-write; gamepad; fullscreen"'))

    @classmethod
    def page(cls, html: str, name: str, height: float = HEIGHT) -> Inline:
        """A saved page in the notebook. It reaches nothing outside its frame."""
        sandbox = 'sandbox="allow-scripts allow-downloads" allow="clipboard-write; fullscreen"'
        return cls(_frame(name, height, f'{sandbox} srcdoc="{escape(html)}"'))


def _frame(name: str, height: float, content: str) -> str:
    pixels = round(as_positive(height, "height"))
    return f'<iframe title="{escape(name)} · twistarm" height="{pixels}" style="{STYLE}" {content}></iframe>'


# How the page's modules export: a definition at the start of a line.
EXPORT = r"^export ((?:async )?function|class|const) ([\w$]+)"
# State of the page that saved it: camera and choices. share.js writes it in place of the braces.
STATE = '<script type="application/json" id="state">{}</script>'

RANDOM_NAME = rb"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}"

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def save_html(
    arm: Arm, path: str | os.PathLike[str], theta: ArrayLike | None = None, *, trajectory: Trajectory | None = None
) -> Path:
    """Write one HTML file that shows `arm` and plays `trajectory`, or shows theta (n,).

    The page draws the tool's path. It contains Meshcat's code and the meshes, and its policy lets it load nothing.
    Writing it needs no server and no browser. The file is written whole or not at all.

    Returns the path. Raises InputError for a trajectory of another arm, a theta that does not fit or a file that cannot
    be written, and MissingExtraError without Meshcat.

    Args:
        arm: The arm.
        path: The file to write.
        theta: The configuration to show (n,) [rad, m]; by default the ready pose.
        trajectory: A motion that the page plays, or None.
    """
    target = writable(path)
    return write_whole(target, page_html(arm, theta, trajectory=trajectory))


def page_html(arm: Arm, theta: ArrayLike | None = None, *, trajectory: Trajectory | None = None) -> str:
    """The page of `save_html` as text: for a notebook (`twistarm.viewer.Inline.page`) or a web server."""
    return stand_alone(of_arm(arm, trajectory, theta))


def stand_alone(shown: SceneSnapshot) -> str:
    """index.html with its style, its scripts and what is shown inlined."""
    meshcat = f"<script>{_inline(meshcat_bundle())}</script>"
    return _page(
        shown.arm.name, shown.data(), POLICY, meshcat, f'<script type="module">\n{_inline(_program())}</script>'
    )


def beside(shown: SceneSnapshot) -> tuple[str, dict[str, str]]:
    """The page for a folder with many pages, and the scripts beside it by name.

    All pages share Meshcat's code and ours. All pages of an arm share its meshes. The page's policy runs only the
    scripts that it names, also when opened from disk.
    """
    data = shown.data()
    objects = f"globalThis.twistarmObjects = {json.dumps(_numbered(data.pop('objects')))};"
    digest = hashlib.sha256(objects.encode()).hexdigest()[:12]
    scripts = {
        "meshcat.js": meshcat_bundle(),
        "view.js": f'"use strict";\n{_program()}',
        f"meshes_{digest}.js": objects,
    }
    nonce = hashlib.sha256(encode(data).encode()).hexdigest()[:24]
    policy = POLICY.replace("script-src 'unsafe-inline'", f"script-src 'nonce-{nonce}'")
    first, *rest = (
        f'<script defer src="{name}" nonce="{nonce}"></script>' for name in ("meshcat.js", *list(scripts)[:0:-1])
    )
    return _page(shown.arm.name, data, policy, first, "\n".join(rest)), scripts


def _numbered(objects: list[str]) -> list[str]:
    """Replace Meshcat's random names by numbers, so that an arm's meshes always have the same text."""
    numbers: dict[bytes, bytes] = {}

    def numbered(found: re.Match[bytes]) -> bytes:
        return numbers.setdefault(found[0], b"00000000-0000-0000-0000-%012x" % len(numbers))

    plain = (re.sub(RANDOM_NAME, numbered, base64.b64decode(each)) for each in objects)
    return [base64.b64encode(each).decode("ascii") for each in plain]


def _page(name: str, data: Mapping[str, Any], policy: str, meshcat: str, program: str) -> str:
    """index.html with inlined style and data, and the scripts as elements."""
    page = re.sub(r'<link rel="stylesheet" href="(.*)">', _style, page_text("index.html"))
    # A "<" in JSON can only stand in a string; escaped, no name can close the script.
    literal = encode(data).replace("<", "\\u003c")
    for old, new in (
        ("<title>twistarm</title>", f"<title>{escape(name)} · twistarm</title>"),
        (
            '<meta charset="utf-8">',
            f'<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="{policy}">',
        ),
        ('<script src="meshcat.js"></script>', meshcat),
        (
            '<script type="module" src="main.js"></script>',
            f'<script type="application/json" id="data">{literal}</script>\n{STATE}\n{program}',
        ),
    ):
        page = page.replace(old, new, 1)
    return page


def _style(link: re.Match[str]) -> str:
    return f"<style>\n{page_text(link[1])}</style>"


def _program() -> str:
    """The modules in one script, because a file from disk cannot import any. Each module has a separate scope."""
    return "\n".join(scoped(name) for name in modules("standalone.js"))


def scoped(name: str) -> str:
    """A module as a constant that holds what it exports."""
    text = page_text(name)
    text = re.sub(r'^import (.*) from "\./(.*)\.js";$', r"const \1 = of_\2;", text, flags=re.MULTILINE)
    text = re.sub(EXPORT, r"\1 \2", text, flags=re.MULTILINE)
    exported = ", ".join(found[1] for found in re.findall(EXPORT, page_text(name), flags=re.MULTILINE))
    return f"const of_{name.removesuffix('.js')} = (() => {{\n{text}\nreturn {{ {exported} }};\n}})();"


def modules(name: str) -> list[str]:
    """The modules that `name` of the page runs, each after its imports, itself last."""
    ordered: list[str] = []
    for imported in re.findall(r'^import .* from "\./(.*)";$', page_text(name), flags=re.MULTILINE):
        ordered += modules(imported)
    return list(dict.fromkeys([*ordered, name]))


def page_text(name: str) -> str:
    """One of our own files as text."""
    return files(__package__).joinpath("page").joinpath(name).read_text(encoding="utf-8")


def meshcat_bundle() -> str:
    """Meshcat's page code, three.js included, as its wheel carries it."""
    return files("meshcat").joinpath("viewer").joinpath("dist").joinpath("main.min.js").read_text(encoding="utf-8")


def _inline(script: str) -> str:
    """JavaScript for a script element. `</script` and `<!--` occur in its strings only."""
    return re.sub(r"</(script)", r"<\\/\1", script, flags=re.IGNORECASE).replace("<!--", "<\\!--")
