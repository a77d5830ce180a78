"""The process that reads meshes: start it, send it requests, and end it."""

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

from ...support.errors import TwistarmError, one_line

PROGRAM = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from twistarm.description.meshes.worker import main; main(int(sys.argv[2]))"
)

ALONE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Extra threads would take address space and time."""

START = 30.0
"""Most seconds until the process is ready. It takes some tenths, and more from a cold disk."""

LAST = 0.2
"""Seconds to wait for a killed process."""


class Process:
    """A process in a separate session, which a Ctrl-C in the terminal does not reach. It ends with this one.

    Raises TwistarmError if it cannot start.
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
        """Whether it is running."""
        return self._popen.poll() is None

    def ask(self, path: Path, most: float, seconds: float) -> dict[str, Any]:
        """The worker's answer.

        Raises TimeoutError after `seconds` of wall time or all of its processor time, and EOFError if it ends
        otherwise. Each error and interruption kills the process.
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
        """Kill it with its children. Any thread may call this, also repeatedly."""
        with suppress(ProcessLookupError, PermissionError):  # it has ended, and nobody has been told yet
            if self._popen.poll() is None:
                os.killpg(self._popen.pid, signal.SIGKILL)
        with suppress(subprocess.TimeoutExpired):  # a disk that does not answer holds it up, and nobody else
            self._popen.wait(LAST)

    def _begin(self) -> None:
        try:
            self._answer(START)
        except (EOFError, TimeoutError) as error:
            raise _unavailable(f"it did not begin: {type(error).__name__}") from error
        self._ready = True

    def _answer(self, seconds: float) -> dict[str, Any]:
        try:
            if not self._pipe.poll(seconds):
                raise TimeoutError
            return self._pipe.recv()
        except (EOFError, ConnectionError) as error:
            with suppress(subprocess.TimeoutExpired):
                if self._popen.wait(LAST) == -signal.SIGXCPU:
                    raise TimeoutError from error
            raise EOFError from error


def _module_path() -> list[str]:
    """The module path without the current folder, so no module beside a description is imported."""
    own, here = (os.path.realpath(folder) for folder in (Path(__file__).parents[3], "."))
    places = ((folder, os.path.realpath(folder)) for folder in sys.path if os.path.isabs(folder))
    return [folder for folder, place in places if place != here or place == own]


def _unavailable(why: str) -> TwistarmError:
    return TwistarmError(one_line(f"no mesh is drawn: the process that reads them could not be started here ({why})"))


class Shared:
    """The process of this program, which has imported all it needs. Readers take turns with it."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Start anew after a fork: the process is the parent's."""
        self.turn, self._lock = threading.Lock(), threading.Lock()
        self._process: Process | None = None

    def process(self) -> Process:
        """The process, started if there is none."""
        with self._lock:
            if self._process is None or not self._process.alive:
                self._process = Process()
            return self._process

    def end(self) -> None:
        """Kill the process."""
        if self._process is not None:
            self._process.kill()


shared = Shared()
atexit.register(shared.end)
os.register_at_fork(after_in_child=shared.forget)
