"""A hostile case tried as its victim would: by the command line, in a process of its own, on a clock and on scales."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

SECONDS, MEGABYTES = 5.0, 500.0
"""Within these a hostile file is refused or loaded."""

PATIENCE = 600.0
"""Seconds on the clock after which an attempt is killed: what hangs does so on an idle machine too."""


@dataclass(frozen=True)
class Outcome:
    """What came of it: the exit code (None where it had to be killed), what was printed, and what it took.

    `seconds` are the clock's, `busy` the processor's; `megabytes` is the most that the process, or one that it waited
    for, held at a time. A process inherits the peak of the one that starts it; a peak no larger than that is looked up
    while it runs, where the system tells.
    """

    code: int | None
    output: str
    errors: str
    seconds: float
    megabytes: float
    busy: float = 0.0

    @property
    def fault(self) -> str:
        """What no input may cause, in words; empty where nothing is wrong."""
        if self.code is None:
            return f"hangs: killed after {self.seconds:.0f} s"
        if self.code < 0:
            return f"ends by signal {-self.code}"
        if "Traceback" in self.errors or "fault of twistarm" in self.errors:
            return f"traceback: {self.errors.strip().splitlines()[-1][:100]}"
        return f"exit {self.code} without a word" if self.code and not (self.errors + self.output).strip() else ""

    def within(self, seconds: float = SECONDS, megabytes: float = MEGABYTES) -> str:
        """`fault`, or what was taken beyond the given seconds of the processor and megabytes."""
        if self.fault or (self.busy <= seconds and self.megabytes <= megabytes):
            return self.fault
        return f"{self.busy:.1f} s, {self.megabytes:.0f} MB"


def attempt(
    *arguments: str,
    folder: Path,
    env: Mapping[str, str] | None = None,
    seconds: float = PATIENCE,
    stdin: IO[bytes] | int = subprocess.DEVNULL,
) -> Outcome:
    """`twistarm arguments` in `folder`, without a terminal, killed with all that it started after `seconds`."""
    command = [sys.executable, "-m", "twistarm", *arguments]
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:
        began = time.monotonic()
        process = subprocess.Popen(
            command,
            cwd=folder,
            env={**os.environ, "COLUMNS": "80", **(env or {})},
            stdin=stdin,
            stdout=output,
            stderr=errors,
            start_new_session=True,
        )
        late = threading.Event()

        def end() -> None:
            late.set()
            os.killpg(process.pid, signal.SIGKILL)

        clock = threading.Timer(seconds, end)
        clock.start()
        peak = _Peak(process.pid)
        peak.start()
        _, status, used = os.wait4(process.pid, 0)
        took = time.monotonic() - began
        clock.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        told = [file.seek(0) or file.read().decode("utf-8", "replace") for file in (output, errors)]
    busy = used.ru_utime + used.ru_stime
    unit = 1024 if sys.platform == "darwin" else 1
    kilobytes = used.ru_maxrss / unit
    if peak.kilobytes and used.ru_maxrss <= resource.getrusage(resource.RUSAGE_SELF).ru_maxrss:
        kilobytes = peak.kilobytes
    return Outcome(None if late.is_set() else process.returncode, told[0], told[1], took, kilobytes / 1000, busy)


class _Peak(threading.Thread):
    """The largest memory of the processes in a session, while one of them runs; 0 where no /proc tells."""

    def __init__(self, session: int) -> None:
        super().__init__(daemon=True)
        self.session, self.kilobytes = session, 0

    def run(self) -> None:
        while (found := self._now()) > 0:
            self.kilobytes = max(self.kilobytes, found)
            time.sleep(0.02)

    def _now(self) -> int:
        found = 0
        for folder in Path("/proc").glob("[0-9]*"):
            with suppress(OSError, IndexError, ValueError):
                if int((folder / "stat").read_text().rpartition(")")[2].split()[3]) == self.session:
                    found = max(found, int((folder / "status").read_text().partition("VmHWM:")[2].split()[0]))
        return found
