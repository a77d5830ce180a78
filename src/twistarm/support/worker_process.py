"""The worker process, which reads meshes and expands xacro files: start it, send it requests, and end it."""

from __future__ import annotations

import atexit
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

from .errors import TwistarmError, one_line
from .worker import START

PROGRAM = (
    "import pickle, sys; sys.path[:], sys.argv = pickle.load(sys.stdin.buffer); "
    "from twistarm.support.worker import main; main()"
)

ALONE = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""Extra threads would take address space and time."""

PATIENCE = 4.0
"""Wall time of a request over its processor time. The machine may be busy, or its disk slow."""

LAST = 0.2
"""Seconds to wait for a killed process."""


class Process:
    """A process in a separate session, which a Ctrl-C in the terminal does not reach. It ends with this one.

    Raises TwistarmError if it cannot start.
    """

    def __init__(self) -> None:
        self._socket, theirs = socket.socketpair()
        self._answers = self._socket.makefile("rb")
        try:
            self._popen = subprocess.Popen(
                [sys.executable, "-I", "-S", "-c", PROGRAM],
                stdin=theirs.fileno(),
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd="/",
                env=os.environ | ALONE,
                start_new_session=True,
            )
        except (OSError, ValueError, TypeError) as error:  # TypeError: a program that embeds Python names none
            raise _unavailable(str(getattr(error, "strerror", None) or error)) from error
        finally:
            theirs.close()
        self._sending = threading.Lock()
        self._send((_module_path(), sys.argv))

    @property
    def alive(self) -> bool:
        """Whether it is running."""
        return self._popen.poll() is None

    def prepare(self, module: str) -> None:
        """Let it import `module`, and return at once."""
        self._send((module, None))

    def ask(self, module: str, request: tuple[Any, ...], seconds: float) -> Any:
        """What `answer` of the module returns for the request, which may take `seconds` of processor time.

        Raises TimeoutError after that or PATIENCE times of wall time, MemoryError, and EOFError if the process ends
        otherwise. Each error and interruption kills the process.
        """
        try:
            self._send((module, request))
            self._await_begin()
            answer = self._answer(PATIENCE * seconds)
            if isinstance(answer, MemoryError):
                raise answer
            return answer
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

    def _send(self, message: Any) -> None:
        with self._sending, suppress(OSError):  # its end is told by `_answer`
            self._socket.sendall(pickle.dumps(message))

    def _await_begin(self) -> None:
        try:
            self._answer(START)
        except (EOFError, TimeoutError) as error:
            raise _unavailable(f"it did not begin: {type(error).__name__}") from error

    def _answer(self, seconds: float) -> Any:
        try:
            self._socket.settimeout(seconds)
            return pickle.load(self._answers)
        except (EOFError, ConnectionError, pickle.UnpicklingError) as error:
            with suppress(subprocess.TimeoutExpired):
                if self._popen.wait(LAST) == -signal.SIGXCPU:
                    raise TimeoutError from error
            raise EOFError from error


def _module_path() -> list[str]:
    """The module path without the current folder, so no module beside a description is imported."""
    own, here = os.path.realpath(Path(__file__).parents[2]), working_folder()
    places = ((folder, os.path.realpath(folder)) for folder in sys.path if os.path.isabs(folder))
    return [folder for folder, place in places if place != here or place == own]


def working_folder() -> str | None:
    """The current folder without links, None where it has gone."""
    try:
        return os.getcwd()
    except FileNotFoundError:
        return None


def _unavailable(why: str) -> TwistarmError:
    what = "the process that draws meshes and expands xacro files could not be started here"
    return TwistarmError(one_line(f"{what} ({why})"))


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
