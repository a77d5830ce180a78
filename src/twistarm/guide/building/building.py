"""The course built on an arm: every lesson that has changed is run, its page and those around it are written."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import twistarm

from ...loading.load import load_arm
from ...model.arm import Arm
from ...support.errors import InputError
from ...viewer.server.watching import loaded
from ..course import lesson_file, lessons
from .cells import cells_of, title_of
from .errata import slips
from .pages import SCRIPTS, STYLE, before_page, errata_page, index_page, lesson_page, site_text
from .running import TIMEOUT, run_lessons
from .site_folder import SiteFolder

ASSETS = {f"assets/{name}": name for name in (STYLE, *SCRIPTS)}


@dataclass(frozen=True)
class Built:
    """A site: its folder, the arm, the lessons that were run now, and in a sentence each what failed."""

    folder: Path
    arm: Arm
    run: tuple[str, ...]
    failed: tuple[str, ...]

    @property
    def start(self) -> Path:
        """The page to open."""
        return self.folder / "index.html"


def build(
    folder: Path,
    arm: Mapping[str, Any],
    names: Sequence[str] | None = None,
    progress: Callable[[float, str], object] = lambda done, lesson: None,
    timeout: float = TIMEOUT,
) -> Built:
    """Build the course, or the lessons `names` of it, on the arm that `load_arm(**arm)` loads, into `folder`.

    What was built before of the same lesson, the same files of the arm and the same twistarm is kept. A lesson that
    fails has a page that says so, and the others are built.

    Args:
        folder: A new or empty folder, or one that was built before.
        arm: The keywords of `load_arm`, as JSON can hold them.
        names: Lessons; all where not given.
        progress: Called with the share that is done and the lesson that was.
        timeout: Seconds that a lesson may take.

    Returns:
        What was built.

    Raises:
        InputError: The folder is not ours or cannot be written.
        TwistarmError: The arm cannot be loaded.
    """
    wanted = lessons() if names is None else tuple(names)
    the_arm, read = loaded(partial(load_arm, **arm))
    site = SiteFolder(folder)
    made_of = _digest(_package(), json.dumps(arm, sort_keys=True), *map(_content, sorted(read)))
    keys = {name: _digest(made_of, lesson_file(name).read_text("utf-8")) for name in wanted}
    entries = {name: entry for name in wanted if (entry := site.kept(name, keys[name]))}
    titles = {name: title_of(cells_of(lesson_file(name))) for name in wanted}
    stale = [name for name in wanted if name not in entries]
    failed = []
    for done, (name, outcome) in enumerate(run_lessons(stale, arm, site.path / "scenes", timeout), start=1):
        outcome["title"] = titles[name]
        site.write(f"{name}.html", lesson_page(name, outcome, titles, the_arm))
        site.write(f"{name}.py", lesson_file(name).read_text("utf-8"))
        entries[name] = {"key": "" if outcome["failed"] else keys[name], "scenes": outcome["scenes"]}
        site.keep(name, entries[name])
        if outcome["failed"]:
            failed.append(outcome["failed"])
        progress(done / len(stale), name)
    _around(site, titles, the_arm, failed)
    scenes = {scene for entry in entries.values() for scene in entry["scenes"]}
    site.sweep(
        {
            *ASSETS,
            "index.html",
            "errata.html",
            "before.html",
            *(f"{name}{ending}" for name in wanted for ending in (".html", ".py")),
            *scenes,
        }
    )
    return Built(site.path, the_arm, tuple(stale), tuple(sorted(failed)))


def _around(site: SiteFolder, titles: Mapping[str, str], arm: Arm, failed: Sequence[str]) -> None:
    """The contents, the errata and what pages share."""
    for name, source in ASSETS.items():
        site.write(name, site_text(source))
    site.write("index.html", index_page(titles, arm, failed))
    site.write("before.html", before_page(arm))
    site.write("errata.html", errata_page([slip._asdict() for slip in slips()], arm))


def as_keywords(source: str, keywords: Mapping[str, Any]) -> dict[str, Any]:
    """What `load_arm` takes as JSON can hold it, with paths that mean the same from anywhere."""

    def plain(value: Any) -> Any:
        if isinstance(value, Path):
            return str(value.absolute())
        if isinstance(value, (list, tuple)):
            return [plain(each) for each in value]
        return value

    place = Path(source).expanduser()
    try:
        source = str(place.absolute()) if place.exists() else source
        made = {"source": source, **{name: plain(value) for name, value in keywords.items() if value}}
        json.dumps(made, allow_nan=False)
    except (OSError, TypeError, ValueError) as error:
        raise InputError(f"the arm {source!r} cannot be handed to the lessons: {error}") from error
    return made


def _package() -> str:
    """What tells one twistarm from another, and with it the style of its pages."""
    names = (".py", ".js", ".css", ".html", ".json")
    root = Path(twistarm.__file__).parent
    held = sorted(path for path in root.rglob("*") if path.suffix in names and path.parent.name != "lessons")
    return _digest(*(f"{path.relative_to(root)}\0{path.read_text('utf-8')}" for path in held))


def _content(path: Path) -> str:
    try:
        return f"{path}\0{hashlib.sha256(path.read_bytes()).hexdigest()}"
    except (OSError, ValueError):
        return f"{path}\0missing"


def _digest(*parts: str) -> str:
    return hashlib.sha256("\0\0".join(parts).encode()).hexdigest()[:24]
