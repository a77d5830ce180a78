"""`MeshReader` reads the meshes of one arm, one after the other, in another process."""

from __future__ import annotations

import threading
from contextlib import suppress
from importlib.util import find_spec
from math import inf
from pathlib import Path
from typing import Any

from ...support.closeable import Closeable
from ...support.errors import InputError, TwistarmError, missing_extra, one_line
from .mesh_file import (
    ARM_SECONDS,
    ARM_SECONDS_AT_MOST,
    LIGHTER,
    MEMORY,
    PATIENCE,
    SECONDS_PER_MEGABYTE,
    Part,
    UnreadableMeshError,
    format_of,
    seconds_for,
    size_of,
)
from .process import Process, shared

LONGEST_REASON = 300
"""Characters."""


class MeshReader(Closeable):
    """Reads the meshes of one arm, within limits of memory and time for each mesh and for all, until `close`.

    A context manager. Any thread may use it. All readers of a program read one mesh at a time. `close` ends the current
    reading.
    `parts` and `length` raise UnreadableMeshError for a file that is not a mesh or exceeds a limit. They raise
    MissingExtraError without trimesh, and TwistarmError if no process can start.
    """

    def __init__(self) -> None:
        self._spent, self._allowed = 0.0, ARM_SECONDS
        self._asked: Process | None = None
        self._unavailable: TwistarmError | None = None
        self._lock, self._closed = threading.Lock(), False
        self._lengths: dict[Path, float | TwistarmError] = {}

    def begin(self) -> None:
        """Start the process if possible, and return at once. Its imports take some tenths of a second."""
        if find_spec("trimesh") is not None:
            with suppress(TwistarmError):
                shared.process()

    def parts(self, path: Path, most: float = inf) -> list[Part]:
        """The parts of the mesh file at `path` in its frame, simplified to about `most` triangles.

        They are in metres if the file names its unit.
        """
        with shared.turn:
            return self._read(path, most)

    def length(self, path: Path) -> float:
        """The longest side of the mesh's box, in metres if the file names its unit. Cached after a reading."""
        if path not in self._lengths:
            with shared.turn:
                self._read(path, 0)
        length = self._lengths[path]
        if isinstance(length, TwistarmError):
            raise length
        return length

    def close(self) -> None:
        """Stop the current reading, and refuse further ones."""
        with self._lock:
            self._closed = True
            if self._asked is not None:
                self._asked.kill()

    def _read(self, path: Path, most: float) -> list[Part]:
        try:
            format_of(path)
            answer = self._answer(path, most)
            if answer["reason"] is not None:
                raise UnreadableMeshError(path, one_line(answer["reason"], LONGEST_REASON))
        except TwistarmError as error:
            self._lengths[path] = error
            raise
        self._lengths[path] = answer["length"]
        return answer["parts"]

    def _answer(self, path: Path, most: float) -> dict[str, Any]:
        seconds = seconds_for(size_of(path))
        try:
            process = self._process_to_ask()
            if self._spent >= self._allowed:
                spent = f"the meshes before it took all of the {self._allowed:.0f} s that an arm has"
                raise UnreadableMeshError(path, spent, LIGHTER)
            answer = process.ask(path.absolute(), most, PATIENCE * seconds)
        except TwistarmError as error:
            self._unavailable = None if isinstance(error, UnreadableMeshError) else error
            raise
        except (TimeoutError, EOFError) as error:
            self._spent += seconds
            if isinstance(error, EOFError):
                raise UnreadableMeshError(path, "its reader broke down on it") from error
            raise UnreadableMeshError(path, f"reading it takes more than {seconds:.0f} s", LIGHTER) from error
        finally:
            with self._lock:
                self._asked = None
        self._spent += answer["seconds"]
        self._allowed = min(self._allowed + SECONDS_PER_MEGABYTE * answer["bytes"] / 1e6, ARM_SECONDS_AT_MOST)
        if answer["memory"]:
            process.kill()
            raise UnreadableMeshError(path, f"reading it takes more than {MEMORY / 1e6:.0f} MB of memory", LIGHTER)
        return answer

    def _process_to_ask(self) -> Process:
        with self._lock:
            if self._closed:
                raise InputError("the reader of meshes was closed")
            if self._unavailable is not None:
                raise self._unavailable
            if find_spec("trimesh") is None:
                raise missing_extra("drawing a mesh", "trimesh", "view")
            self._asked = shared.process()
            return self._asked
