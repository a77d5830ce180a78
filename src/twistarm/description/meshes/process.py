"""The process that reads meshes, from its parent's side: start, ask, end."""

from __future__ import annotations

import atexit
import json
import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from multiprocessing import Pipe
from pathlib import Path
from typing import Any

from ...support.errors import TwistarmError, missing_extra, one_line

PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from twistarm.description.meshes.worker import main; main(int(sys.argv[2]))"
)

ALONE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Threads that are not needed take addresses and time."""

START = 30.0
"""Seconds on the clock until it must be ready: some tenths, and more where nothing is in memory yet."""

LAST = 0.2
"""Seconds that a killed one is waited for."""


class Process:
    """A process in a separate session, so Ctrl-C does not reach it.

    It ends with its parent.

    Raises TwistarmError if it cannot start, MissingExtraError without trimesh.
    """

    def __init__(self) -> None:
        self._pipe, theirs = Pipe()
        try:
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-c", PROGRAM, json.dumps(_module_path()), str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                cwd="/",
                env=os.environ | ALONE,
                start_new_session=True,
            )
        except (OSError, ValueError, TypeError) as error:  # TypeError: a program that embeds Python names none
            raise _unavailable(str(getattr(error, "strerror", None) or error)) from error
        finally:
            theirs.close()
        self._ready = False

    @property
    def alive(self) -> bool:
        """Whether it can be asked."""
        return self._popen.poll() is None

    def ask(self, path: Path, most: float, seconds: float) -> dict[str, Any]:
        """The worker's answer.

        Raises TimeoutError after `seconds` or the end of its processor time, and EOFError if it ends otherwise. In
        these cases, and at an interruption, the process is ended.
        """
        try:
            if not self._ready:
                self._begin()
            with suppress(OSError):  # its end is told below
                self._pipe.send((path, most))
            return self._answer(seconds)
        except BaseException:
            self.kill()
            raise

    def kill(self) -> None:
        """End it and its children at once. Any thread may call it, repeatedly."""
        with suppress(ProcessLookupError, PermissionError):  # it has ended, and nobody has been told yet
            if self._popen.poll() is None:
                os.killpg(self._popen.pid, signal.SIGKILL)
        with suppress(subprocess.TimeoutExpired):  # a disk that does not answer holds it up, and nobody else
            self._popen.wait(LAST)

    def _begin(self) -> None:
        try:
            lacking = self._answer(START)["lacking"]
        except (EOFError, TimeoutError) as error:
            raise _unavailable(f"it did not begin: {type(error).__name__}") from error
        if lacking:
            raise missing_extra("drawing a mesh", "trimesh", "view")
        self._ready = True

    def _answer(self, seconds: float) -> dict[str, Any]:
        try:
            if not self._pipe.poll(seconds):
                raise TimeoutError
            answer: dict[str, Any] = self._pipe.recv()
            return answer
        except (EOFError, ConnectionError) as error:
            with suppress(subprocess.TimeoutExpired):
                if self._popen.wait(LAST) == -signal.SIGXCPU:
                    raise TimeoutError from error
            raise EOFError from error


def _module_path() -> list[str]:
    """Python's module path without the current folder, so files beside a description are never imported."""
    own, here = (os.path.realpath(folder) for folder in (Path(__file__).parents[3], "."))
    places = ((folder, os.path.realpath(folder)) for folder in sys.path if os.path.isabs(folder))
    return [folder for folder, place in places if place != here or place == own]


def _unavailable(why: str) -> TwistarmError:
    return TwistarmError(one_line(f"no mesh is drawn: the process that reads them could not be started here ({why})"))


_idle: list[Process] = []
_lock = threading.Lock()


def taken() -> Process:
    """A waiting process or a new one; its imports serve the next arm too."""
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
