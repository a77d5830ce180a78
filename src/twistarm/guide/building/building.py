"""The course built on an arm: every lesson run, its page and the pages around it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import twistarm

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...support.errors import InputError
from ...support.files import as_path, stamp, write_whole
from ...viewer.server.watching import load_with_files
from ..course import ERRATA, lesson_file, lessons
from .cells import cells_of, title_of
from .pages import SCRIPTS, STYLE, before_page, index_page, lesson_page, site_file
from .running import run_lessons

RECORD = "twistarm-guide.json"
"""The file that says that a folder is the guide's, and of what its pages were made."""


@dataclass(frozen=True)
class Built:
    """A site: its folder, the arm, the lessons just run, and a sentence for each failure."""

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
    progress: Callable[[float], object] = lambda done: None,
) -> Built:
    """Build the course, or its lessons `names`, into `folder`. The arm is `load_arm(**arm)`.

    An earlier build stays if the arm's files and twistarm are unchanged and nothing failed. A failed lesson gets a page
    that says so, and the others are built.

    Args:
        folder: A new or empty folder, or one that was built before.
        arm: The keywords of `load_arm`, as JSON can hold them.
        names: Lessons; all where not given.
        progress: Called with the share that is done.

    Returns:
        What was built.

    Raises:
        InputError: The folder holds something else or cannot be written.
        TwistarmError: The arm cannot be loaded.
    """
    wanted = lessons() if names is None else tuple(names)
    the_arm, read = load_with_files(partial(load_arm, **arm))
    site = _made(as_path(folder).absolute())
    made_of = _stamps(arm, wanted, read)
    if all((site / f"{name}.html").is_file() for name in ("index", *wanted)) and _recorded(site) == made_of:
        return Built(site, the_arm, (), ())
    write_whole(site / RECORD, "{}\n")
    for old in (path for pattern in ("scene_*.html", "meshes_*.js") for path in (site / "scenes").glob(pattern)):
        old.unlink(missing_ok=True)
    pages = (*wanted, ERRATA)
    titles = {name: title_of(cells_of(lesson_file(name))) for name in pages}
    failed = []
    for done, (name, outcome) in enumerate(run_lessons(pages, arm, site / "scenes"), start=1):
        write_whole(site / f"{name}.html", lesson_page(name, outcome, titles, the_arm))
        write_whole(site / f"{name}.py", lesson_file(name).read_text("utf-8"))
        failed += [outcome["failed"]] if outcome["failed"] else []
        progress(done / len(pages))
    for name in (*STYLE, *SCRIPTS):
        write_whole(site / "assets" / name, site_file(name))
    write_whole(site / "index.html", index_page(titles, the_arm, failed))
    write_whole(site / "before.html", before_page(the_arm))
    if not failed:
        write_whole(site / RECORD, json.dumps({"made of": made_of}))
    return Built(site, the_arm, wanted, tuple(sorted(failed)))


def _made(site: Path) -> Path:
    """The folder with its parents. Raises InputError if it holds something else or cannot be made."""
    try:
        if site.exists() and not site.is_dir():
            raise InputError(f"{site} is a file; -o takes a folder")
        if site.is_dir() and any(site.iterdir()) and not (site / RECORD).is_file():
            raise InputError(
                f"{site} holds something that the guide did not write (there is no {RECORD}); "
                "give a new folder, or an empty one"
            )
        for each in ("assets/fonts", "assets/scripts", "scenes"):
            (site / each).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write into {site}: {error.strerror or error}") from error
    return site


def _stamps(arm: Mapping[str, Any], wanted: Sequence[str], read: set[Path]) -> str:
    """The identity of a site: the arm, its files, the lessons, and twistarm's files."""
    own = (path for path in Path(twistarm.__file__).parent.rglob("*.*") if path.suffix != ".pyc")
    files = [(str(path), stamp(path)) for path in sorted({*read, *own})]
    return hashlib.sha256(repr((twistarm.__version__, arm, wanted, files)).encode()).hexdigest()


def _recorded(site: Path) -> str:
    """The identity of the existing pages; empty if unknown or after a failure."""
    with suppress(OSError, ValueError, TypeError, KeyError):
        return str(json.loads((site / RECORD).read_text("utf-8"))["made of"])
    return ""


def as_keywords(source: str, keywords: Mapping[str, Any]) -> dict[str, Any]:
    """The keywords of `load_arm` for JSON, with absolute paths."""

    def plain(value: Any) -> Any:
        if isinstance(value, (list, tuple)):
            return [plain(each) for each in value]
        return str(value.absolute()) if isinstance(value, Path) else value

    place = Path(source).expanduser()
    try:
        source = str(place.absolute()) if place.exists() else source
        made = {"source": source, **{name: plain(value) for name, value in keywords.items() if value}}
        json.dumps(made, allow_nan=False)
    except (OSError, TypeError, ValueError) as error:
        raise InputError(f"the arm {source!r} cannot be handed to the lessons: {error}") from error
    return made
