"""A process that judges mutants, one JSON line in, one out; whatever else it says counts as noise."""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from .oracle import judged

MEMORY = 4 << 30
"""Bytes of address space: a mutant that wants more gets a MemoryError, which is a failure."""


def main() -> None:
    """Answer until standard input ends."""
    with suppress(ValueError, OSError):  # macOS knows no limit on address space
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    with tempfile.TemporaryFile() as noise:
        os.dup2(noise.fileno(), 1)
        os.dup2(noise.fileno(), 2)
        answers.write("ready\n")
        answers.flush()
        for line in sys.stdin:
            answers.write(json.dumps(_answer(json.loads(line), noise)) + "\n")
            answers.flush()


def _answer(question: dict[str, Any], noise: IO[bytes]) -> dict[str, Any]:
    # The timer counts what this process computes; the signal's default action ends it in the middle of anything.
    start = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, max(question["seconds"], 1e-6))
    packages = {name: Path(folder) for name, folder in question["packages"].items()}
    verdict = judged(Path(question["path"]), question["arguments"], packages)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    if time.process_time() - start > question["seconds"]:
        signal.raise_signal(signal.SIGPROF)
    if heard := _said(noise):
        verdict["problems"].append(f"noise: {heard[:500]!r}")
    return verdict


def _said(noise: IO[bytes]) -> str:
    """What was written to standard output and error since the last mutant."""
    sys.stdout.flush()
    sys.stderr.flush()
    noise.seek(0)
    heard = noise.read().decode("utf-8", "replace")
    noise.seek(0)
    noise.truncate()
    return heard


if __name__ == "__main__":
    main()
