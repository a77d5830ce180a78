"""The saved page: one HTML file that opens offline and plays a trajectory, and its frame in a notebook."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.trajectory import Trajectory
from ...support.checks import as_positive
from ...support.files import writable, write_whole
from ...support.strict_json import encode
from ..page_files import meshcat_bundle, page_text
from .scene_snapshot import SceneSnapshot, of_arm

HEIGHT = 480
"""Height of a frame [pixels]. It is as wide as the notebook's output."""

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


EXPORT = r"^export ((?:async )?function|class|const) ([\w$]+)"
"""How the page's modules export: a definition at the start of a line."""

STATE = '<script type="application/json" id="state">{}</script>'
"""State of the page that saved it: camera and choices. share.js writes it in place of the braces."""

RANDOM_NAME = rb"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}"

POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"


def save_html(
    arm: Arm, path: str | os.PathLike[str], theta: ArrayLike | None = None, *, trajectory: Trajectory | None = None
) -> Path:
    """Write one HTML file that shows `arm` and plays `trajectory`, or shows theta (n,).

    The page draws the tool's path. It contains Meshcat's code and the meshes, and its policy lets it load nothing.
    Writing it needs no server and no browser. The file is written whole or not at all.

    Args:
        arm: The arm.
        path: The file to write.
        theta: The configuration to show (n,) [rad, m]; by default the ready pose.
        trajectory: A motion that the page plays, or None.

    Returns:
        The path written.

    Raises:
        InputError: The trajectory has another arm, theta does not fit, or the file cannot be written.
        MissingExtraError: Meshcat is not installed.
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


def _inline(script: str) -> str:
    """JavaScript for a script element. `</script` and `<!--` occur in its strings only."""
    return re.sub(r"</(script)", r"<\\/\1", script, flags=re.IGNORECASE).replace("<!--", "<\\!--")
