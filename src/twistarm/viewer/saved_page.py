"""The saved page: a snapshot of the view, an HTML file that plays it offline, a frame in a notebook."""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..arm.usual_limits import defaults_line
from ..planning.trajectory import Trajectory
from ..support.checks import as_positive
from ..support.files import writable, write_whole
from ..support.strict_json import encode
from .messages import SCHEMA, Message
from .parts.arm_data import PENDING, check_trajectory, doctor_findings, tool_path
from .scene.arm_drawing import Drawing
from .stage import Stage

SAMPLE_TIME = 1.0 / 30.0  # Time between samples [s]. The page interpolates between them.
MOST_SAMPLES = 2000  # Most samples of a motion, which keep the file within two megabytes.
DECIMALS = 9  # Decimals of values in rad and m.
LIVE = ("collision", "colliding", "controls")  # Messages that hold only while a process checks and listens.


@dataclass(frozen=True)
class SceneSnapshot:
    """The state of the pages of `arm`: `hello`, messages by type and node, drawing, motion."""

    arm: Arm
    drawing: Drawing
    hello: Message
    messages: Mapping[str, Message]
    motion: Trajectory | None

    def with_messages(self, *messages: Message) -> SceneSnapshot:
        """A copy with these messages in place of those of the same type."""
        return replace(self, messages={**self.messages, **{message["type"]: message for message in messages}})

    def playing(self, trajectory: Trajectory) -> SceneSnapshot:
        """A copy with `trajectory` and its path, which plays from the start when the page opens.

        Raises InputError for another arm's trajectory.
        """
        check_trajectory(self.arm, trajectory)
        stage = Stage(self.arm)
        stage.load(trajectory).play(0.0)
        stage.draw_path(tool_path(self.arm, trajectory))
        messages = {message["type"]: message for message in stage.messages()}
        messages["program"] = {**messages["program"], "poses": self.messages["program"]["poses"]}
        messages["frame"] = {**self.messages["frame"], "time": 0.0, "running": True}
        moved = (messages[kind] for kind in ("player", "plots", "path", "program", "frame"))
        return replace(self.with_messages(*moved), motion=trajectory)

    def data(self, zipped: bool = True) -> dict[str, Any]:
        """The data for process.js: messages, samples of the motion, and a note about the servo's limits.

        It may run in any thread, because it does not touch the stage. It reads remaining meshes and runs the doctor if
        needed.
        """
        drawing, messages = (
            self.drawing.whole(),
            {kind: message for kind, message in self.messages.items() if message["type"] not in LIVE},
        )
        if PENDING in messages["findings"]["note"] and not messages["servo"]["driven"]:
            messages["findings"] = doctor_findings(self.arm)
        snapshot = {
            "hello": {**self.hello, "number": 0},
            "messages": [drawing.message(), *messages.values()],
            "motion": None if self.motion is None else _samples(self.motion),
            "note": f"{defaults_line(self.arm)}; no collisions are checked".removeprefix("; "),
        }
        digest = hashlib.sha256(encode(snapshot).encode()).hexdigest()[:24]
        return {**snapshot, "digest": digest, "objects": _packed(_joined(drawing.objects), zipped)}


def of_arm(arm: Arm, trajectory: Trajectory | None = None, theta: ArrayLike | None = None) -> SceneSnapshot:
    """`arm` at theta (n,), by default ready, with all layers and `trajectory` playing."""
    snapshot = on_show(Stage(arm, theta), Drawing(arm))
    return snapshot if trajectory is None else snapshot.playing(trajectory)


def on_show(stage: Stage, drawing: Drawing) -> SceneSnapshot:
    """The present state of a live view's pages, and the loaded motion.

    Call it in the stage's thread.
    """
    messages = {message["type"] + message.get("node", ""): message for message in stage.messages()}
    if not (stage.visible["reach"][0] or "reach" in stage.needed):
        messages.pop("reach", None)
    if not messages["shapes"]["bodies"]:
        del messages["shapes"]
    motion = None if stage.playback is None else stage.playback.trajectory
    return SceneSnapshot(stage.arm, drawing, stage.hello(drawing.links), messages, motion)


def _samples(motion: Trajectory) -> dict[str, Any]:
    """times (k,) [s], theta and rates (k, n): `motion` from its start to its end."""
    duration = float(motion.duration)
    count = min(MOST_SAMPLES, max(2, 1 + int(np.ceil(duration / SAMPLE_TIME))))
    times = np.linspace(0.0, duration, count if duration > 0.0 else 1)
    theta, rates = (np.round(motion(times, order), DECIMALS).tolist() for order in (0, 1))
    return {"times": times.tolist(), "theta": theta, "rates": rates}


def _joined(objects: Sequence[bytes]) -> bytes:
    """The drawing's objects, each after its length. Meshcat's random names become numbers.

    So an arm's meshes always have the same text.
    """
    numbers: dict[bytes, bytes] = {}

    def numbered(found: re.Match[bytes]) -> bytes:
        return numbers.setdefault(found[0], b"00000000-0000-0000-0000-%012x" % len(numbers))

    plain = [re.sub(RANDOM_NAME, numbered, drawn) for drawn in objects if drawn]
    return b"".join(len(part).to_bytes(4, "big") + part for part in plain)


def _packed(data: bytes, zipped: bool = True) -> str:
    # Without its time stamp gzip gives the same text for the same arm.
    return base64.b64encode(gzip.compress(data, mtime=0) if zipped else data).decode("ascii")


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


STYLESHEET = r'<link rel="stylesheet" href="(.*)">'
# How the page's modules export: a definition at the start of a line.
EXPORT = r"^export ((?:async )?function|class|const) ([\w$]+)"
# State of the page that saved it: camera and choices. share.js writes it in place of the braces.
STATE = '<script type="application/json" id="state">{}</script>'

RANDOM_NAME = rb"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}"

POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:"
)


def save_html(
    arm: Arm, path: str | os.PathLike[str], theta: ArrayLike | None = None, *, trajectory: Trajectory | None = None
) -> Path:
    """Write one HTML file that shows `arm` and plays `trajectory`, or shows theta (n,).

    The page draws the tool's path. It contains Meshcat's code and the meshes, and its policy lets it load nothing.
    Writing it needs no server and no browser. The file is written whole or not at all.

    Returns the path. Raises InputError for a trajectory of another arm, a theta that does not fit, or an unwritable
    file. Raises MissingExtraError without Meshcat.

    Args:
        arm: The arm.
        path: The file to write.
        theta: The configuration to show (n,) [rad, m]. By default `arm.ready`.
        trajectory: A motion that the page plays, or None.
    """
    target = writable(path)
    return write_whole(target, page_html(arm, theta, trajectory=trajectory))


def page_html(arm: Arm, theta: ArrayLike | None = None, *, trajectory: Trajectory | None = None) -> str:
    """The page of `save_html` as text: for a notebook (`twistarm.viewer.Inline.page`) or a web server."""
    return stand_alone(of_arm(arm, trajectory, theta))


def stand_alone(snapshot: SceneSnapshot, zipped: bool = True) -> str:
    """index.html with its style, its scripts, the core and what is shown inlined.

    Without `zipped` the page is complete at once. A headless browser that draws it waits for no other thread.
    """
    meshcat = f"<script>{_inline(meshcat_bundle())}</script>"
    core = f'<script type="text/plain" id="core">{packed_core(zipped)}</script>'
    program = f'<script type="module">\n{_inline(_program())}</script>'
    return _page(snapshot.arm.name, snapshot.data(zipped), POLICY, meshcat, f"{core}\n{program}")


def beside(snapshot: SceneSnapshot) -> tuple[str, dict[str, str]]:
    """The page for a folder with many pages, and the scripts beside it by name.

    All pages share Meshcat's code, ours and the core. All pages of an arm share its meshes. The page's policy runs only
    the scripts that it names, also when opened from disk.
    """
    data = snapshot.data()
    objects = f"globalThis.twistarmObjects = {json.dumps(data.pop('objects'))};"
    digest = hashlib.sha256(objects.encode()).hexdigest()[:12]
    scripts = {
        "meshcat.js": meshcat_bundle(),
        "view.js": f'"use strict";\n{_program()}',
        "core.js": f"globalThis.twistarmCore = {json.dumps(packed_core())};",
        f"meshes_{digest}.js": objects,
    }
    nonce = data["digest"]
    policy = POLICY.replace("script-src 'unsafe-inline'", f"script-src 'nonce-{nonce}'")
    first, *rest = (
        f'<script defer src="{name}" nonce="{nonce}"></script>' for name in ("meshcat.js", *list(scripts)[:0:-1])
    )
    return _page(snapshot.arm.name, data, policy, first, "\n".join(rest)), scripts


def _page(name: str, data: Mapping[str, Any], policy: str, meshcat: str, program: str) -> str:
    """index.html with inlined style and data, and the scripts as elements."""
    page = re.sub(STYLESHEET, lambda link: f"<style>\n{page_text(link[1])}</style>", page_text("index.html"))
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


def _program() -> str:
    """The modules in one script, because a file from disk cannot import any. Each has a separate scope; main waits."""
    *parts, main = modules("main.js")
    schema = f"globalThis.twistarmSchema = {json.dumps(SCHEMA)};"
    return "\n".join([schema, *map(scoped, parts), f"(async () => {{\n{_local(main)}\n}})();"])


def scoped(name: str) -> str:
    """A module as a constant that holds what it exports."""
    exported = ", ".join(found[1] for found in re.findall(EXPORT, page_text(name), flags=re.MULTILINE))
    return f"const of_{name.removesuffix('.js')} = (() => {{\n{_local(name)}\nreturn {{ {exported} }};\n}})();"


def _local(name: str) -> str:
    """A module's text where other modules are constants, without indentation and lines of comments."""
    text = re.sub(r"^\s*(//.*\n)?", "", page_text(name), flags=re.MULTILINE)
    text = re.sub(r'^import (.*) from "\./(.*)\.js";$', r"const \1 = of_\2;", text, flags=re.MULTILINE)
    return re.sub(EXPORT, r"\1 \2", text, flags=re.MULTILINE)


def modules(name: str) -> list[str]:
    """The modules that `name` of the page runs, each after its imports, itself last."""
    ordered: list[str] = []
    for imported in re.findall(r'^import .* from "\./(.*)";$', page_text(name), flags=re.MULTILINE):
        ordered += modules(imported)
    return list(dict.fromkeys([*ordered, name]))


def page_text(name: str) -> str:
    """One of our own files as text."""
    return files(__package__).joinpath("page").joinpath(name).read_text(encoding="utf-8")


@cache
def packed_core(zipped: bool = True) -> str:
    """The core for WebAssembly, packed for core.js."""
    return _packed(files(__package__).joinpath("page").joinpath("arm.wasm").read_bytes(), zipped)


def meshcat_bundle() -> str:
    """Meshcat's page code, three.js included, as its wheel carries it."""
    return files("meshcat").joinpath("viewer").joinpath("dist").joinpath("main.min.js").read_text(encoding="utf-8")


def _inline(script: str) -> str:
    """JavaScript for a script element. `</script` and `<!--` occur in its strings only."""
    return re.sub(r"</(script)", r"<\\/\1", script, flags=re.IGNORECASE).replace("<!--", "<\\!--")
