"""A hostile case tried as its victim would: by the command line, in a process of its own, on a clock and on scales."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
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
    for, held at a time.
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


MEASURED = """
import json, resource, subprocess, sys
code = subprocess.call(sys.argv[2:])
used = resource.getrusage(resource.RUSAGE_CHILDREN)
json.dump([code, used.ru_maxrss, used.ru_utime + used.ru_stime], open(sys.argv[1], "w"))
"""
"""A small process between: a child's peak of memory begins with that of its parent, and pytest's is large."""


def attempt(
    *arguments: str, folder: Path, seconds: float = PATIENCE, stdin: IO[bytes] | int = subprocess.DEVNULL
) -> Outcome:
    """`twistarm arguments` in `folder`, without a terminal, killed with all that it started after `seconds`."""
    with tempfile.TemporaryDirectory() as place:
        report, output, errors = (Path(place, name) for name in ("report", "output", "errors"))
        began = time.monotonic()
        with output.open("wb") as said, errors.open("wb") as wrong:
            process = subprocess.Popen(
                [sys.executable, "-S", "-c", MEASURED, report, sys.executable, "-m", "twistarm", *arguments],
                cwd=folder,
                env={**os.environ, "COLUMNS": "80"},
                stdin=stdin,
                stdout=said,
                stderr=wrong,
                start_new_session=True,
            )
            with suppress(subprocess.TimeoutExpired):
                process.wait(seconds)
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        took = time.monotonic() - began
        code, peak, busy = json.loads(report.read_text()) if report.exists() else (None, 0, took)
        told = [file.read_bytes().decode("utf-8", "replace") for file in (output, errors)]
    return Outcome(code, told[0], told[1], took, peak / (1e6 if sys.platform == "darwin" else 1e3), busy)
