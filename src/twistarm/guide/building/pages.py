"""The pages of the site: a lesson, the contents, the words, in the one template."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

import twistarm

from ...arm.arm import Arm
from ...viewer.saved_page import scoped
from ..course import LESSONS, PARTS, SECTIONS
from ..exercises.files import HERE
from ..teaching.html import table, text
from ..teaching.markup import block, inline

STYLE = ("style.css", "fonts/stix-two-math.woff2", "fonts/OFL.txt")

SCRIPTS = tuple(
    f"scripts/{name}.js"
    for name in ("playback", "numbers", "eye", "player", "space_figures", "bench", "space", "plane", "start", "frames")
)
"""Of pages with figures to turn, sliders or scenes, in the order in which they need one another."""

Titles = Mapping[str, str]  # Titles of the lessons by name.


def site_file(name: str) -> bytes:
    """A file of the site, from the package. The clock of motions is that of the view."""
    if name == SCRIPTS[0]:
        return scoped("playback.js").encode()
    return files("twistarm.guide").joinpath("site").joinpath(name).read_bytes()


def lesson_page(name: str, outcome: Mapping[str, Any], titles: Titles, arm: Arm) -> str:
    """A lesson, or the errata, as a page."""
    items = "".join(f'<li><a href="#{anchor}">{inline(title)}</a></li>' for anchor, title in outcome["sections"])
    file = f'<p><a href="{name}.py" download>This lesson as a program</a></p>'
    contents = f'<nav class="contents" aria-label="In this lesson"><ol>{items}</ol>{file}</nav>'
    return _page(
        kind="lesson" if name in LESSONS else name,
        title=f"{titles[name]} · the guide",
        body=outcome["body"],
        arm=arm,
        contents=contents,
        neighbours=_neighbours(name, titles),
    )


def index_page(titles: Titles, arm: Arm, failed: Iterable[str]) -> str:
    """The contents: the parts with their lessons, and the guide's sections with their lessons."""
    parts = "".join(
        f'<section><h2 id="part-{number}">{escape(part.title)}</h2><ol>{_lessons(part.lessons, titles)}</ol></section>'
        for number, part in enumerate(PARTS, start=1)
        if any(name in titles for name in part.lessons)
    )
    rows = [(section, topic, f"[{titles[name]}]({name}.html)") for section, topic, name in SECTIONS if name in titles]
    failures = "".join(f'<p class="failed" role="note">{escape(words)}</p>' for words in failed)
    joints = f"{arm.n} joint{'s' * (arm.n != 1)}"
    body = (
        f"<h1>The guide</h1>{failures}"
        f"{block(_filled('index.md', arm=arm.name.replace('`', ''), joints=joints))}{parts}"
        f"{block(_filled('exercises.md', here=str(HERE), first=LESSONS[0]))}"
        f"{table(('Section', 'What is in it', 'Lesson'), rows, 'Sections of the guide')}"
    )
    return _page(kind="index", title="The guide", body=body, arm=arm, neighbours=_neighbours("", titles))


def before_page(arm: Arm) -> str:
    """What a reader knows before the first lesson, the letters and the words."""
    body = f"<h1>Before you begin</h1>{text(site_file('before.md').decode())}"
    return _page(kind="before", title="Before you begin", body=body, arm=arm)


def _page(*, kind: str, title: str, body: str, arm: Arm, contents: str = "", neighbours: str = "") -> str:
    scripts = SCRIPTS if re.search("data-(slider|eye|src)=", body) else ()
    here = {name: ' aria-current="page"' if kind == name else "" for name in ("index", "before", "errata")}
    return _filled(
        "page.html",
        **here,
        kind=kind,
        title=escape(title),
        body=body,
        contents=contents,
        neighbours=neighbours,
        arm=escape(arm.name),
        version=twistarm.__version__,
        script="".join(f'<script defer src="assets/{name}"></script>\n' for name in scripts),
    )


def _filled(name: str, **words: str) -> str:
    return Template(site_file(name).decode()).substitute(words)


def _neighbours(name: str, titles: Titles) -> str:
    """Links to the lessons before and after one; the contents are before the first."""
    order = ["", *(lesson for lesson in LESSONS if lesson in titles), ""]
    if name not in order:
        return ""
    at = order.index(name)
    turns = (("prev", "Previous", order[at - 1] if at else ""), ("next", "Next", order[at + 1]))
    links = (
        f'<a rel="{rel}" href="{to}.html"><small>{word}</small> {escape(titles[to])}</a>' if to else "<span></span>"
        for rel, word, to in turns
    )
    return f'<nav class="neighbours" aria-label="Lessons">{"".join(links)}</nav>'


def _lessons(names: Iterable[str], titles: Titles) -> str:
    topics: dict[str, list[str]] = {}
    for _, topic, name in SECTIONS:
        topics.setdefault(name, []).append(topic)
    return "".join(
        f'<li><a href="{name}.html">{escape(titles[name])}</a> <small>{escape("; ".join(topics[name]))}</small></li>'
        for name in names
        if name in titles
    )
