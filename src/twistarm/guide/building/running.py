"""Lessons run: each in a process of its own, for a limited time, two at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import suppress
from pathlib import Path
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
    running: set[subprocess.Popen[bytes]] = set()
    ended = threading.Event()
    with tempfile.TemporaryDirectory(prefix="twistarm-guide-") as folder, ThreadPoolExecutor(AT_ONCE) as pool:

        def run(name: str) -> Outcome:
            return _run(name, arm, scenes, Path(folder), timeout, running, ended)

        futures = {pool.submit(run, name): name for name in names}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        finally:
            ended.set()
            for future in futures:
                future.cancel()
            for process in list(running):
                _end(process)


def _run(
    name: str,
    arm: Mapping[str, Any],
    scenes: Path,
    folder: Path,
    timeout: float,
    running: set[subprocess.Popen[bytes]],
    ended: threading.Event,
) -> Outcome:
    result, log = folder / f"{name}.json", folder / f"{name}.log"
    program = (sys.executable, "-m", "twistarm.guide.building.lesson_process")
    command = [*program, str(lesson_file(name)), str(scenes), str(result)]
    # One thread each: two lessons at once fill two cores.
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, VARIABLE: json.dumps(arm), "PYTHONWARNINGS": "ignore"}
    with log.open("wb") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env=environment,
            start_new_session=True,
        )
    running.add(process)
    try:
        if ended.is_set():
            raise subprocess.TimeoutExpired(command, 0)
        process.wait(timeout)
    except subprocess.TimeoutExpired:
        return _failed(name, f"was ended after {timeout:g} s")
    finally:
        _end(process)
        running.discard(process)
    if not result.is_file():
        said = log.read_text("utf-8", errors="replace").strip().rpartition("\n")[2]
        return _failed(name, f"ended with code {process.returncode}: {one_line(said, 300)}")
    outcome: Outcome = json.loads(result.read_text("utf-8"))
    return outcome


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a lesson and whatever it has started."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _failed(name: str, why: str) -> Outcome:
    words = f"{name}: {why}"
    return {"title": name, "body": "", "sections": [], "scenes": [], "needs_script": False, "failed": words}
