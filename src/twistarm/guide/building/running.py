"""Run lessons in separate processes with a time limit, two at once."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...support.errors import one_line
from ..course import lesson_file
from ..teaching.arm import VARIABLE

TIMEOUT = 120.0
"""Seconds that a lesson may take."""

Outcome = dict[str, Any]
"""What `lesson_process` writes."""


def run_lessons(
    names: Sequence[str], arm: Mapping[str, Any], scenes: Path, timeout: float = TIMEOUT
) -> Iterator[tuple[str, Outcome]]:
    """The outcome of each lesson as it arrives. No process outlives the iteration."""
    with ThreadPoolExecutor(max_workers=2) as pool:
        running = {pool.submit(_outcome, name, arm, scenes, timeout): name for name in names}
        try:
            yield from ((running[each], each.result()) for each in as_completed(running))
        finally:
            pool.shutdown(cancel_futures=True)


def _outcome(name: str, arm: Mapping[str, Any], scenes: Path, timeout: float) -> Outcome:
    # One thread each: two lessons at once fill two cores.
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = {**os.environ, **threads, VARIABLE: json.dumps(arm), "PYTHONWARNINGS": "ignore"}
    with TemporaryDirectory(prefix="twistarm-guide-") as folder:
        log, result = Path(folder, "log"), Path(folder, "outcome.json")
        command = (sys.executable, "-m", "twistarm.guide.building.lesson_process", lesson_file(name), scenes, result)
        try:
            with log.open("wb") as said:
                streams: dict[str, Any] = {"stdin": subprocess.DEVNULL, "stdout": said, "stderr": said}
                code = subprocess.run(command, **streams, env=environment, timeout=timeout, check=False).returncode
            if code == 0:
                outcome: Outcome = json.loads(result.read_text("utf-8"))
                return outcome
            how = f"ended with code {code}"
        except subprocess.TimeoutExpired:
            how = f"was ended after {timeout:g} s"
        last = log.read_text("utf-8", errors="replace").strip().rpartition("\n")[2]
    words = f"{name}: {how}" + (f": {one_line(last, 300)}" if last else "")
    body = f'<p class="failed" role="note">{escape(words)}. Its text is missing; twistarm guide tries again.</p>'
    return {"body": body, "sections": [], "failed": words}
