"""Mutants by the thousand: made from seeds, judged in worker processes that may hang or die without harm."""

from __future__ import annotations

import json
import os
import queue
import select
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from . import hostile
from .mutations import mutate
from .sources import Source

LIMIT = 5.0
"""Seconds of the worker's own computing for one mutant, loading and judging together: others use the machine too."""

PATIENCE = 600.0
"""Seconds on the clock for one mutant, and for a new worker to start: what waits for something computes nothing, and
does so on an idle machine too."""


@dataclass(frozen=True)
class Case:
    """One mutant and its verdict."""

    source: str
    number: int
    kind: str
    file: str
    data: bytes = field(repr=False)
    verdict: dict[str, Any]

    @property
    def problems(self) -> list[str]:
        return list(self.verdict["problems"])


@dataclass
class Campaign:
    """All verdicts of a run, counted, with the cases that failed."""

    seconds: float = 0.0
    kinds: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[str] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)
    failed: list[Case] = field(default_factory=list)

    def add(self, case: Case) -> None:
        self.kinds[case.kind] += 1
        self.outcomes[case.verdict["outcome"]] += 1
        if case.verdict.get("code"):
            self.codes[case.verdict["code"]] += 1
        if case.problems:
            self.failed.append(case)

    def report(self, folder: Path) -> str:
        """What failed, each with the file in `folder` that it was kept as."""
        lines = []
        for case in self.failed:
            kept = folder / f"{case.number}_{Path(case.file).name}"
            _written(kept, case.data)
            lines.append(
                f"{case.source} #{case.number} ({case.kind}): {case.problems[0].strip()[-600:]}\n  kept as {kept}"
            )
        return "\n".join(lines)

    @property
    def total(self) -> int:
        return sum(self.outcomes.values())

    def __str__(self) -> str:
        tables = {"kinds": self.kinds, "outcomes": self.outcomes, "refusals": self.codes}
        told = [f"  {what}: {dict(counts.most_common())}" for what, counts in tables.items()]
        return "\n".join([f"{self.total} mutants in {self.seconds:.0f} s, {len(self.failed)} failed", *told])


class Worker:
    """A worker process with its own copy of every source, replaced when it hangs or dies."""

    def __init__(self, folder: Path, sources: Sequence[Source]) -> None:
        self.folder, self.limit, self.patience = folder, LIMIT, PATIENCE
        self.process: subprocess.Popen[bytes] | None = None
        for source in sources:
            for file, data in source.texts().items():
                _written(self.place(source) / file, data)

    def place(self, source: Source) -> Path:
        """Where this worker's copy of a source stands: the last folder keeps its name."""
        return self.folder / source.name.replace("/", "_").replace(" ", "_") / source.folder.name

    def judge(self, source: Source, file: str, data: bytes, arguments: dict[str, Any]) -> dict[str, Any]:
        """The verdict on the source with one file exchanged."""
        place = self.place(source)
        question = {
            "path": str(place / source.file),
            "arguments": arguments | {name: str(place / file) for name, file in source.beside.items()},
            "packages": {name: str(place / folder) for name, folder in source.packages().items()},
        }
        original = (place / file).read_bytes()
        _written(place / file, data)
        try:
            return self.ask(question)
        finally:
            _written(place / file, original)

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """The worker's answer, or that it hung or died."""
        self.process = self.process or self._started()
        start = time.perf_counter()
        answer = self._answer(self.process, {**question, "seconds": self.limit})
        if answer:
            verdict: dict[str, Any] = json.loads(answer)
            return verdict
        status = self.process.poll() if answer is None else self.process.wait()
        self.close()
        if status is None:
            outcome, problem = "hung", f"no answer within {self.patience:g} s"
        elif status == -signal.SIGPROF:
            outcome, problem = "hung", f"no answer after {self.limit:g} s of computing"
        else:
            outcome, problem = "died", f"the process ended with status {status}"
        return {"outcome": outcome, "problems": [problem], "seconds": time.perf_counter() - start}

    def close(self) -> None:
        """End the process; the next question starts another."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None

    def _answer(self, process: subprocess.Popen[bytes], question: dict[str, Any]) -> bytes | None:
        """One line; none in time: None; none ever: nothing."""
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps(question).encode() + b"\n")
            process.stdin.flush()
        except BrokenPipeError:
            return b""
        ready, _, _ = select.select([process.stdout], [], [], self.patience)
        return process.stdout.readline() if ready else None

    def _started(self) -> subprocess.Popen[bytes]:
        tests = Path(__file__).resolve().parents[1]
        environment = {**os.environ, "PYTHONPATH": str(tests), "OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "fuzz.worker"]
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, cwd=self.folder
        )
        assert process.stdout is not None
        ready, _, _ = select.select([process.stdout], [], [], PATIENCE)
        assert ready, f"the worker did not start within {PATIENCE:g} s"
        assert process.stdout.readline() == b"ready\n", "the worker did not start; see its traceback above"
        return process


def campaign(sources: Sequence[Source], count: int, folder: Path, *, seed: int = 0, workers: int = 1) -> Campaign:
    """`count` mutants of the sources in turn; each has its own bounds of time."""
    result, lock = Campaign(), threading.Lock()
    numbers: queue.SimpleQueue[int] = queue.SimpleQueue()
    for number in range(count):
        numbers.put(number)
    start = time.perf_counter()

    def work(worker: Worker) -> None:
        try:
            while True:
                case = one(worker, sources, numbers.get_nowait(), seed)
                with lock:
                    result.add(case)
        except queue.Empty:
            pass
        finally:
            worker.close()

    with ThreadPoolExecutor(workers) as pool:
        for done in [pool.submit(work, Worker(folder / f"worker{i}", sources)) for i in range(workers)]:
            done.result()
    result.seconds = time.perf_counter() - start
    return result


def one(worker: Worker, sources: Sequence[Source], number: int, seed: int) -> Case:
    """The mutant of that number, made and judged."""
    source = sources[number % len(sources)]
    rng = Random(f"{seed}:{source.name}:{number}")
    file = rng.choice(source.mutated)
    kind, data = mutate((source.folder / file).read_bytes(), Path(file), rng)
    return Case(source.name, number, kind, file, data, worker.judge(source, file, data, _arguments(source, rng)))


def _arguments(source: Source, rng: Random) -> dict[str, Any]:
    """The source's, at times without base and tip, with a hostile tip, or with a hostile xacro argument."""
    arguments = dict(source.arguments)
    fate = rng.random()
    if fate < 0.25:
        return {name: value for name, value in arguments.items() if name not in ("base", "tip")}
    if fate < 0.27:
        return {**arguments, "tip": rng.choice(hostile.NAMES)}
    given = {**arguments.get("xacro_args", {})}
    if fate < 0.35 and source.file.endswith(".xacro"):
        name = rng.choice([*given, "length", "x"])
        given[name] = rng.choice([*hostile.NUMBERS, *hostile.NAMES, *hostile.EXPRESSIONS])
        return {**arguments, "xacro_args": given}
    return arguments


def _written(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
