"""The site of the course on an arm, and a lesson as PDF. Each lesson runs in its own process."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import twistarm

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...support.errors import InputError, one_line
from ...support.files import as_path, stamp, write_whole
from ...viewer.screenshot import browser_at_work, printed
from ...viewer.server.watching import load_with_files
from ..course import ERRATA, LESSONS, lesson_file
from ..teaching.reader import VARIABLE
from .lesson import cells_of, title_of
from .pages import SCRIPTS, STYLE, before_page, index_page, lesson_page, site_file

# The file that says that a folder is the guide's, and of what its pages were made.
RECORD = "twistarm-guide.json"
TIMEOUT = 120.0  # Seconds that a lesson may take.
Outcome = dict[str, Any]  # What `lesson` writes.
# The model solution of an exercise in a page.
SOLUTION = r"<details[^>]*><summary>Show a solution</summary>.*?</details>"


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
        arm: The keywords of `load_arm`, numbers, texts, paths and tuples or dictionaries of them.
        names: Lessons; all where not given.
        progress: Called with the share that is done.

    Returns:
        What was built.

    Raises:
        InputError: The folder holds something else or cannot be written.
        TwistarmError: The arm cannot be loaded.
    """
    lessons = LESSONS if names is None else tuple(names)
    the_arm, read = load_with_files(partial(load_arm, **arm))
    site = _made(as_path(folder).absolute())
    made_of = _stamps(arm, lessons, read)
    if all((site / f"{name}.html").is_file() for name in ("index", *lessons)) and _recorded(site) == made_of:
        return Built(site, the_arm, (), ())
    write_whole(site / RECORD, "{}\n")
    for old in (path for pattern in ("scene_*.html", "meshes_*.js") for path in (site / "scenes").glob(pattern)):
        old.unlink(missing_ok=True)
    pages = (*lessons, ERRATA)
    titles = {name: title_of(cells_of(lesson_file(name))) for name in pages}
    failed = []
    for count, (name, outcome) in enumerate(run_lessons(pages, arm, site / "scenes"), start=1):
        write_whole(site / f"{name}.html", lesson_page(name, outcome, titles, the_arm))
        write_whole(site / f"{name}.py", lesson_file(name).read_text("utf-8"))
        failed += [outcome["failed"]] if outcome["failed"] else []
        progress(count / len(pages))
    for name in (*STYLE, *SCRIPTS):
        write_whole(site / "assets" / name, site_file(name))
    write_whole(site / "index.html", index_page(titles, the_arm, failed))
    write_whole(site / "before.html", before_page(the_arm))
    if not failed:
        write_whole(site / RECORD, json.dumps({"made of": made_of}))
    return Built(site, the_arm, lessons, tuple(sorted(failed)))


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
        for part in ("assets/fonts", "assets/scripts", "scenes"):
            (site / part).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write into {site}: {error.strerror or error}") from error
    return site


def _stamps(arm: Mapping[str, Any], lessons: Sequence[str], read: set[Path]) -> str:
    """The identity of a site: the arm, its files, the lessons, and twistarm's files."""
    own = (path for path in Path(twistarm.__file__).parent.rglob("*.*") if path.suffix != ".pyc")
    files = [(str(path), stamp(path)) for path in sorted({*read, *own})]
    return hashlib.sha256(repr((twistarm.__version__, arm, lessons, files)).encode()).hexdigest()


def _recorded(site: Path) -> str:
    """The identity of the existing pages; empty if unknown or after a failure."""
    with suppress(OSError, ValueError, TypeError, KeyError):
        return str(json.loads((site / RECORD).read_text("utf-8"))["made of"])
    return ""


def run_lessons(
    names: Sequence[str], arm: Mapping[str, Any], scenes: Path, timeout: float = TIMEOUT
) -> Iterator[tuple[str, Outcome]]:
    """The outcome of each lesson as it arrives. No process outlives the iteration."""
    with ThreadPoolExecutor(max_workers=2) as pool:
        running = {pool.submit(_outcome, name, arm, scenes, timeout): name for name in names}
        try:
            yield from ((running[future], future.result()) for future in as_completed(running))
        finally:
            pool.shutdown(cancel_futures=True)


def _outcome(name: str, arm: Mapping[str, Any], scenes: Path, timeout: float) -> Outcome:
    # One thread each: two lessons at once fill two cores.
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, VARIABLE: json.dumps(arm, default=str), "PYTHONWARNINGS": "ignore"}
    with TemporaryDirectory(prefix="twistarm-guide-") as folder:
        log, result = Path(folder, "log"), Path(folder, "outcome.json")
        command = (sys.executable, "-m", "twistarm.guide.building.lesson", lesson_file(name), scenes, result)
        try:
            with log.open("wb") as log_file:
                streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": log_file, "stderr": log_file}
                code = subprocess.run(command, **streams, env=environment, timeout=timeout, check=False).returncode
            if code == 0:
                outcome: Outcome = json.loads(result.read_text("utf-8"))
                return outcome
            how = f"ended with code {code}"
        except subprocess.TimeoutExpired:
            how = f"was ended after {timeout:g} s, which a busy computer can need"
        last = log.read_text("utf-8", errors="replace").strip().rpartition("\n")[2]
    words = f"{name}: {how}" + (f": {one_line(last, 300)}" if last else "")
    remedy = f"Run twistarm guide again, or for this lesson alone twistarm guide print {name}."
    body = f'<p class="failed" role="note">{escape(words)}. {remedy}</p>'
    return {"body": body, "sections": [], "failed": words}


def pdf_of(site: Path, lesson: str, solutions: bool = True) -> bytes:
    """The PDF of a lesson of the site in `site`, unfolded. Without `solutions` it is a sheet for a class.

    Raises TwistarmError without a browser, or if it prints nothing.
    """
    with browser_at_work("print") as (browser, folder):
        page = folder / f"{lesson}.html"
        shutil.copytree(site / "assets", folder / "assets")
        text = (site / page.name).read_text("utf-8")
        if not solutions:
            text = re.sub(SOLUTION, "", text, flags=re.DOTALL)
        # On paper nothing can be unfolded, tried or opened.
        text = re.sub(r"<iframe .*?</iframe>", "", text.replace("<details", "<details open"), flags=re.DOTALL)
        page.write_text(re.sub(r"<script .*?</script>", "", text, flags=re.DOTALL), "utf-8")
        return printed(browser, page)
