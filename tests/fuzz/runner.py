"""Mutants by the thousand: made from seeds, judged in processes that may hang or die without harm."""

from __future__ import annotations

import multiprocessing
import os
import resource
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from typing import IO, Any
from unittest.mock import patch

from . import hostile
from .mutations import mutate
from .oracle import judged
from .sources import Source

LIMIT = 5.0
"""Seconds of a process's own computing for one mutant, loading and judging together: others use the machine too."""

PATIENCE = 600.0
"""Seconds on the clock for one mutant, and for a new process to start: what waits for something computes nothing, and
does so on an idle machine too."""

MEMORY = 4 << 30
"""Bytes of address space: a mutant that wants more gets a MemoryError, which is a failure."""

SPAWNED = multiprocessing.get_context("spawn")


@dataclass(frozen=True)
class Mutant:
    """One file of a source, changed, and how the source is then loaded. The same seed gives the same mutant."""

    number: int
    source: Source
    kind: str
    file: str
    data: bytes = field(repr=False)
    arguments: dict[str, Any]

    def judge(self, folder: Path) -> dict[str, Any]:
        """The oracle's verdict, on the copy of the sources in `folder`."""
        place = _place(self.source, folder)
        beside = {name: str(place / file) for name, file in self.source.beside.items()}
        packages = {name: place / file for name, file in self.source.packages().items()}
        original = (place / self.file).read_bytes()
        (place / self.file).write_bytes(self.data)
        try:
            return judged(place / self.source.file, self.arguments | beside, packages)
        finally:
            (place / self.file).write_bytes(original)


@dataclass
class Campaign:
    """All verdicts of a run, counted, with the mutants that failed."""

    seconds: float = 0.0
    kinds: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[str] = field(default_factory=Counter)
    codes: Counter[str] = field(default_factory=Counter)
    failed: list[tuple[Mutant, list[str]]] = field(default_factory=list)

    def add(self, mutant: Mutant, verdict: dict[str, Any]) -> None:
        self.kinds[mutant.kind] += 1
        self.outcomes[verdict["outcome"]] += 1
        if verdict.get("code"):
            self.codes[verdict["code"]] += 1
        if verdict["problems"]:
            self.failed.append((mutant, verdict["problems"]))

    def report(self, folder: Path) -> str:
        """What failed, each with the file in `folder` that it was kept as."""
        lines = []
        for mutant, problems in self.failed:
            kept = folder / f"{mutant.number}_{Path(mutant.file).name}"
            _written(kept, mutant.data)
            what = f"{mutant.source.name} #{mutant.number} ({mutant.kind})"
            lines.append(f"{what}: {problems[0].strip()[-600:]}\n  kept as {kept}")
        return "\n".join(lines)

    def __str__(self) -> str:
        tables = {"kinds": self.kinds, "outcomes": self.outcomes, "refusals": self.codes}
        told = [f"  {what}: {dict(counts.most_common())}" for what, counts in tables.items()]
        head = f"{self.outcomes.total()} mutants in {self.seconds:.0f} s, {len(self.failed)} failed"
        return "\n".join([head, *told])


def campaign(sources: Sequence[Source], count: int, folder: Path, *, seed: int = 0, workers: int = 1) -> Campaign:
    """`count` mutants of the sources in turn; each has its own bounds of time."""
    result, lock, start = Campaign(), threading.Lock(), time.perf_counter()

    def work(i: int) -> None:
        for number, verdict in verdicts(sources, range(i, count, workers), folder / f"worker{i}", seed):
            with lock:
                result.add(mutant(sources, number, seed), verdict)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(work, range(workers)))
    result.seconds = time.perf_counter() - start
    return result


def mutant(sources: Sequence[Source], number: int, seed: int) -> Mutant:
    """The mutant of that number."""
    source = sources[number % len(sources)]
    rng = Random(f"{seed}:{source.name}:{number}")
    file = rng.choice(source.mutated)
    kind, data = mutate((source.folder / file).read_bytes(), Path(file), rng)
    return Mutant(number, source, kind, file, data, _arguments(source, rng))


def verdicts(
    sources: Sequence[Source], numbers: Sequence[int], folder: Path, seed: int = 0, limit: float = LIMIT
) -> Iterator[tuple[int, dict[str, Any]]]:
    """The verdict on each mutant, by a process that is replaced when it hangs or dies."""
    while numbers:
        answers, theirs = SPAWNED.Pipe(duplex=False)
        process = SPAWNED.Process(target=_judge, args=(theirs, sources, numbers, folder, seed, limit))
        with patch.dict(os.environ, OPENBLAS_NUM_THREADS="1"):
            process.start()
        theirs.close()
        try:
            while answers.poll(PATIENCE):
                verdict = answers.recv()
                yield numbers[0], verdict
                numbers = numbers[1:]
            problem = f"no answer within {PATIENCE:g} s"
        except EOFError:
            process.join()
            late = process.exitcode == -signal.SIGPROF
            problem = f"no answer after {limit:g} s of computing" if late else f"it ended with {process.exitcode}"
        process.kill()
        if numbers:
            yield numbers[0], {"outcome": "hung or died", "problems": [problem]}
            numbers = numbers[1:]


def _judge(
    answers: Connection[Any, Any],
    sources: Sequence[Source],
    numbers: Sequence[int],
    folder: Path,
    seed: int,
    limit: float,
) -> None:
    """Send the verdicts, each within `limit` seconds of computing. What is printed meanwhile counts as noise."""
    with suppress(ValueError, OSError):  # macOS knows no limit on address space
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for source in sources:
        for file, data in source.texts().items():
            _written(_place(source, folder) / file, data)
    with tempfile.TemporaryFile() as noise:
        os.dup2(noise.fileno(), 1)
        os.dup2(noise.fileno(), 2)
        for number in numbers:
            one = mutant(sources, number, seed)
            # The timer counts what this process computes. Its signal ends the process in the middle of anything.
            start = time.process_time()
            signal.setitimer(signal.ITIMER_PROF, max(limit, 1e-6))
            verdict = one.judge(folder)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            if time.process_time() - start > limit:
                signal.raise_signal(signal.SIGPROF)
            if heard := _said(noise):
                verdict["problems"].append(f"noise: {heard[:500]!r}")
            answers.send(verdict)


def _said(noise: IO[bytes]) -> str:
    """What was written to standard output and error since the last mutant."""
    sys.stdout.flush()
    sys.stderr.flush()
    noise.seek(0)
    heard = noise.read().decode("utf-8", "replace")
    noise.seek(0)
    noise.truncate()
    return heard


def _place(source: Source, folder: Path) -> Path:
    """Where the copy of a source stands: the last folder keeps its name."""
    return folder / source.name.replace("/", "_").replace(" ", "_") / source.folder.name


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
