"""Worker processes that solve the same problems in one run, a few targets each in turn.

So the noise of the machine affects all alike. The usual numeric libraries get one thread per worker. A worker that
dies, stays silent for too long or answers nonsense is reported with the reason; the others go on. A peer with a
requirements-<peer>.txt has an environment of its own; the others run in this one.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from .problems import Problems

HERE = Path(__file__).parent
DEFAULT_FOLDER = HERE / ".environments"


CHUNK = 25  # Targets that a worker gets at a time.
SECONDS = 120.0  # Within which a worker must have answered.

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)


class WorkerError(Exception):
    """Why a worker gave no answer, in one line."""


class NotInstalled(Exception):  # noqa: N818
    """Why a peer cannot be installed here, in one line."""


def python_of(peer: str, folder: Path, say: Callable[[str], None], requirements: Path = HERE) -> Path:
    """The interpreter that runs a peer. Makes its environment in `folder` if it is missing or out of date."""
    file = requirements / f"requirements-{peer}.txt"
    if not file.exists():
        return Path(sys.executable)
    place = folder.absolute() / peer
    python = place / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    stamp, wanted = place / "installed.txt", f"Python {sys.version}\n{file.read_text()}"
    if not stamp.exists() or stamp.read_text() != wanted:
        say(f"installing {', '.join(file.read_text().split())} into {place} ...")
        pip = [sys.executable, "-m", "pip", "--python", str(python), "--disable-pip-version-check"]
        for command in (
            [sys.executable, "-m", "venv", "--clear", "--without-pip", str(place)],
            [*pip, "install", "--quiet", "--requirement", str(file)],
        ):
            process = subprocess.run(command, capture_output=True, text=True, errors="replace")
            if process.returncode:
                lines = (process.stderr or process.stdout).strip().splitlines() or [f"{command[0]} failed"]
                raise NotInstalled(next((line for line in lines if line.startswith("ERROR")), lines[-1]))
        stamp.write_text(wanted)
    return python


@dataclass(frozen=True)
class Answers:
    """One solver's answers to N targets: theta (N, n) with NaN rows for none, its claims, its reasons, ns per call."""

    theta: np.ndarray
    converged: np.ndarray
    reasons: np.ndarray
    ns: np.ndarray


class Worker:
    """A process that speaks the protocol of `worker.py`."""

    def __init__(self, command: list[str], log: Path, seconds: float = SECONDS) -> None:
        self.log, self.seconds, self.failure = log, seconds, ""
        self._unread = b""
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        with log.open("w") as stderr:
            self._process = subprocess.Popen(
                command,
                cwd=HERE.parent,
                env=environment | ONE_THREAD,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=stderr,
            )

    def ask(self, do: str, **message: Any) -> dict[str, Any]:
        """The answer to one message. Raises WorkerError without one; a dead worker stays dead."""
        if self.failure:
            raise WorkerError(self.failure)
        try:
            assert self._process.stdin is not None
            self._process.stdin.write(json.dumps({"do": do, **message}).encode() + b"\n")
            self._process.stdin.flush()
            answer = json.loads(self._line())
        except (OSError, ValueError, WorkerError) as error:
            self.failure = str(error) if isinstance(error, WorkerError) else self._how_it_ended(error)
            self.close()
            raise WorkerError(self.failure) from error
        for trouble in ("error", "unfit"):
            if trouble in answer:
                raise WorkerError(answer[trouble])
        return dict(answer)

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with suppress(BrokenPipeError):  # what it was told last may still be in the buffer
                    pipe.close()

    def _line(self) -> bytes:
        assert self._process.stdout is not None
        end = monotonic() + self.seconds
        while b"\n" not in self._unread:
            if not select.select([self._process.stdout], [], [], max(end - monotonic(), 0.0))[0]:
                raise WorkerError(f"no answer within {self.seconds:g} s")
            part = os.read(self._process.stdout.fileno(), 1 << 20)
            if not part:
                raise WorkerError(self._how_it_ended())
            self._unread += part
        line, self._unread = self._unread.split(b"\n", 1)
        return line

    def _how_it_ended(self, error: Exception | None = None) -> str:
        if isinstance(error, ValueError):
            return "its answer is no JSON"
        code = self._process.wait()
        said = self.log.read_text(errors="replace").strip().splitlines()
        return f"died with exit code {code}" + (f": {said[-1]}" if said else "")


def interleave(workers: Mapping[str, Worker], problems: Problems, n: int) -> dict[str, Answers | str]:
    """What each worker answers to all problems, or why it does not."""
    parts: dict[str, list[tuple[Any, ...]]] = {name: [] for name in workers}
    failures: dict[str, str] = {}
    order = list(workers)
    for part in problems.chunks(CHUNK):
        order = order[1:] + order[:1]
        for name in order:
            if name in failures:
                continue
            try:
                targets, starts = part.targets.tolist(), part.starts.tolist()
                answer = workers[name].ask("solve", targets=targets, starts=starts)
                theta = [[np.nan] * n if row is None else row for row in answer["theta"]]
                parts[name].append((theta, answer["converged"], answer["reasons"], answer["ns"]))
            except WorkerError as error:
                done = sum(len(ns) for *_, ns in parts[name])
                failures[name] = f"{error} (after {done} of {len(problems)} targets)"
    return {
        name: failures.get(name) or Answers(*map(np.concatenate, zip(*parts[name], strict=True))) for name in workers
    }
