"""Lessons run: each in a process of its own, for a limited time, two at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...support.errors import one_line
from ..course import lesson_file
from ..teaching.arm import VARIABLE

TIMEOUT = 120.0
"""Seconds that a lesson may take."""

AT_ONCE = 2

Outcome = dict[str, Any]
"""What `lesson_process` writes."""


def run_lessons(
    names: Sequence[str], arm: Mapping[str, Any], scenes: Path, timeout: float = TIMEOUT
) -> Iterator[tuple[str, Outcome]]:
    """The outcome of each lesson as it is there; none of their processes outlives the iteration."""
    waiting, running = list(names), dict[str, tuple[subprocess.Popen[bytes], float]]()
    with TemporaryDirectory(prefix="twistarm-guide-") as folder:
        try:
            while waiting or running:
                while waiting and len(running) < AT_ONCE:
                    process = _started(waiting[0], arm, scenes, Path(folder))
                    running[waiting.pop(0)] = process, time.monotonic() + timeout
                for name, (process, until) in list(running.items()):
                    ended = process.poll() is not None
                    if ended or time.monotonic() > until:
                        _end(process)
                        del running[name]
                        late = f"was ended after {timeout:g} s"
                        yield (
                            name,
                            _outcome(name, Path(folder), f"ended with code {process.returncode}" if ended else late),
                        )
                time.sleep(0.02)
        finally:
            for process, _ in running.values():
                _end(process)


def _started(name: str, arm: Mapping[str, Any], scenes: Path, folder: Path) -> subprocess.Popen[bytes]:
    command = (sys.executable, "-m", "twistarm.guide.building.lesson_process", str(lesson_file(name)), str(scenes))
    # One thread each: two lessons at once fill two cores.
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, VARIABLE: json.dumps(arm), "PYTHONWARNINGS": "ignore"}
    with (folder / f"{name}.log").open("wb") as log:
        return subprocess.Popen(
            [*command, str(folder / f"{name}.json")],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            env=environment,
            start_new_session=True,
        )


def _outcome(name: str, folder: Path, how_it_ended: str) -> Outcome:
    with suppress(OSError, ValueError):
        outcome: Outcome = json.loads((folder / f"{name}.json").read_text("utf-8"))
        return outcome
    said = (folder / f"{name}.log").read_text("utf-8", errors="replace").strip().rpartition("\n")[2]
    words = f"{name}: {how_it_ended}" + (f": {one_line(said, 300)}" if said else "")
    return {"body": "", "sections": [], "failed": words}


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a lesson and whatever it has started."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
