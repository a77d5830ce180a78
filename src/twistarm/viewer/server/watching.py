"""Watching of an arm's files: the view loads the arm again when a file changes."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from ...arm.arm import Arm
from ...description.document import noted_files
from ...support.errors import one_line, without_places
from ...support.files import as_paths, stamp
from ...support.interrupts import Closeable

if TYPE_CHECKING:  # without the extra `view` there is no tornado, and `load_with_files` needs none
    from .server import Server

# Time between two looks at the files [s]. A look costs a microsecond or two for each file and needs no library. It
# also sees what the system does not notify: files on network shares, in containers, and files that do not exist yet.
PERIOD = 0.25
CHANGES_TIMEOUT = 2.0  # Seconds until files that keep changing are loaded anyway.

Stamps = dict[Path, tuple[int, ...] | None]


def load_with_files(load: Callable[[], Arm]) -> tuple[Arm, set[Path]]:
    """The arm that `load` returns, and all files read or looked for, meshes included."""
    with noted_files() as files:
        arm = load()
    return arm, files | meshes_of(arm)


def meshes_of(arm: Arm) -> set[Path]:
    """The mesh files of the drawn shapes."""
    links = () if arm.description is None else arm.description.links.values()
    return {shape.mesh for link in links for shape in link.visuals if shape.mesh is not None}


class Watch(Closeable):
    """Shows the result of `load` on `server` whenever `files` change, until `close`. A context manager.

    The pages show each loading and its error. The last good arm stays on show. Nothing is loaded while a servo drives.
    `say` gets the same text, from another thread.
    """

    def __init__(
        self, server: Server, load: Callable[[], Arm], files: Iterable[Path], say: Callable[[str], None]
    ) -> None:
        self._server, self._load, self._say = server, load, say
        self._stamps = stamps(files)
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name="twistarm watch", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop watching. A loading that runs is not shown. The call waits for it, one second at most."""
        self._closed.set()
        self._thread.join(1.0)

    def _run(self) -> None:
        waiting = False
        while not self._closed.wait(PERIOD):
            if stamps(self._stamps) == self._stamps:
                continue
            if not self._server.stage.driven:
                waiting = False
                self._load_again(self._stable_stamps())
            elif not waiting:
                waiting = True
                self._tell("the files have changed, and will be loaded once no servo drives", wrong=False)

    def _stable_stamps(self) -> Stamps:
        """The stamps once they no longer change: an editor may still be writing."""
        end = time.monotonic() + CHANGES_TIMEOUT
        before, now = None, stamps(self._stamps)
        while before != now and time.monotonic() < end and not self._closed.wait(PERIOD):
            before, now = now, stamps(self._stamps)
        return now

    def _load_again(self, now: Stamps) -> None:
        files: set[Path] = set()
        try:
            with noted_files() as files:
                arm = self._load()
            files |= meshes_of(arm)
            if not self._closed.is_set():
                self._tell("; ".join(["loaded again", *self._server.exchange(arm)]), wrong=False)
        except Exception as error:
            if self._server.stage.driven:  # a servo has begun meanwhile: the next look comes in a moment
                return
            self._tell(f"not loaded again: {one_line(str(error) or type(error).__name__)}", wrong=True)
            files |= set(self._stamps)  # what the arm on show is made of may be what has to be mended
        self._stamps = {path: now[path] if path in now else stamp(path) for path in files}

    def _tell(self, words: str, wrong: bool) -> None:
        if not self._closed.is_set():
            self._server.notify(f"{time.strftime('%H:%M:%S')} {without_places(words, *self._stamps)}", wrong)
            self._say(words)


def stamps(files: Iterable[Path]) -> Stamps:
    """The stamp of each file."""
    return {path: stamp(path) for path in as_paths(files, "files")}
