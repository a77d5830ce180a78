"""The process that reads meshes, as whoever asks it has it: started, asked, and ended with all that it started."""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from ...support.errors import TwistarmError, missing_extra, one_line
from .answers import unpacked

PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from twistarm.description.meshes.worker import main; main()"
)

ALONE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Threads that are not needed take addresses and time."""

START = 30.0
"""Seconds on the clock until it must be ready: some tenths, and more where nothing is in memory yet."""

LAST = 0.2
"""Seconds that a killed one is waited for."""

CHUNK = 1 << 20
"""Bytes."""

LARGEST = 500_000_000
"""Bytes of an answer: a million triangles take 170 MB."""


class Process:
    """A process in a session of its own, which a Ctrl-C in the terminal does not reach; it ends when this one does.

    TwistarmError where none can be started, MissingExtraError where it lacks trimesh.
    """

    def __init__(self) -> None:
        try:
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-c", PROGRAM, json.dumps(_module_path())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd="/",
                env=os.environ | ALONE,
                bufsize=0,
                start_new_session=True,
            )
        except (OSError, ValueError, TypeError) as error:  # TypeError: a program that embeds Python names none
            raise _unavailable(str(getattr(error, "strerror", None) or error)) from error
        self._ready = False

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return self._popen.poll() is None

    def ask(self, request: dict[str, Any], seconds: float) -> dict[str, Any]:
        """The answer.

        Raises TimeoutError after `seconds` on the clock or all of its processor time, EOFError where it ends
        otherwise, and ValueError for nonsense. Then, and at every interruption, it has been ended.
        """
        assert self._popen.stdin is not None
        try:
            if not self._ready:
                self._begin()
            with suppress(BrokenPipeError):  # its end is told below
                self._popen.stdin.write(json.dumps(request).encode("ascii") + b"\n")
            return self._answer(seconds)
        except BaseException:
            self.kill()
            raise

    def kill(self) -> None:
        """End it, and whatever it has started, at once. From any thread, and harmless when repeated."""
        with suppress(ProcessLookupError, PermissionError):  # it has ended, and nobody has been told yet
            if self._popen.poll() is None:
                os.killpg(self._popen.pid, signal.SIGKILL)
        with suppress(subprocess.TimeoutExpired):  # a disk that does not answer holds it up, and nobody else
            self._popen.wait(LAST)

    def _begin(self) -> None:
        try:
            lacking = self._answer(START)["lacking"]
        except (EOFError, TimeoutError, ValueError) as error:
            raise _unavailable(f"it did not begin: {type(error).__name__}") from error
        if lacking:
            raise missing_extra("drawing a mesh", "trimesh", "view")
        self._ready = True

    def _answer(self, seconds: float) -> dict[str, Any]:
        end = time.monotonic() + seconds
        size = int.from_bytes(self._exactly(8, end), "little")
        if size > LARGEST:
            raise ValueError("an answer without end")
        return unpacked(self._exactly(size, end))

    def _exactly(self, size: int, end: float) -> bytes:
        assert self._popen.stdout is not None
        poll, came = select.poll(), bytearray()
        poll.register(self._popen.stdout, select.POLLIN)
        while len(came) < size:
            if not poll.poll(max(0.0, end - time.monotonic()) * 1e3):
                raise TimeoutError
            data = os.read(self._popen.stdout.fileno(), min(CHUNK, size - len(came)))
            if not data:
                raise self._ended()
            came += data
        return bytes(came)

    def _ended(self) -> EOFError | TimeoutError:
        """Why nothing comes any more: its end, or that it goes on without a word."""
        try:
            return TimeoutError() if self._popen.wait(LAST) == -signal.SIGXCPU else EOFError()
        except subprocess.TimeoutExpired:
            return TimeoutError()


def _module_path() -> list[str]:
    """Where modules are found, but for the current folder: what lies beside a description is never imported."""
    own, here = (os.path.realpath(folder) for folder in (Path(__file__).parents[3], "."))
    places = ((folder, os.path.realpath(folder)) for folder in sys.path if os.path.isabs(folder))
    return [folder for folder, place in places if place != here or place == own]


def _unavailable(why: str) -> TwistarmError:
    return TwistarmError(one_line(f"no mesh is drawn: the process that reads them could not be started here ({why})"))


_idle: list[Process] = []
_lock = threading.Lock()


def taken() -> Process:
    """One that waits to be asked, or a new one: what it imported, the next arm's meshes need too."""
    with _lock:
        while _idle:
            if (process := _idle.pop()).alive:
                return process
    return Process()


def given_back(process: Process) -> None:
    """Let it wait for the next arm, or for the end of the program."""
    if process.alive:
        with _lock:
            _idle.append(process)


@atexit.register
def _end() -> None:
    with _lock:
        for process in _idle:
            process.kill()
        _idle.clear()


os.register_at_fork(after_in_child=_idle.clear)  # they are the parent's
