"""Mutants by the thousand: made from seeds, and judged in processes that may hang or die without harm."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from random import Random
from typing import Any

from . import hostile
from .mutations import mutate
from .oracle import judged
from .sources import Source

LIMIT = 60  # Seconds on the clock for one mutant: others use the machine too.


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
    """`count` mutants of the sources in turn. A process that dies ends the campaign with BrokenProcessPool."""
    result, start = Campaign(), time.perf_counter()
    spawned = multiprocessing.get_context("spawn")
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(workers, mp_context=spawned) as pool:
        chunks = [range(i, min(i + 20, count)) for i in range(0, count, 20)]
        judge = partial(verdicts, sources, folder=folder, seed=seed)
        for done in as_completed([pool.submit(judge, chunk) for chunk in chunks]):
            for number, verdict in done.result():
                result.add(mutant(sources, number, seed), verdict)
    result.seconds = time.perf_counter() - start
    return result


def verdicts(sources: Sequence[Source], numbers: Sequence[int], folder: Path, seed: int) -> list[tuple[int, Any]]:
    """The verdict on each mutant, by one process. What is printed meanwhile counts as noise."""
    own = folder / f"worker{os.getpid()}"
    for source in sources:
        for file, data in source.texts().items():
            _written(_place(source, own) / file, data)
    found = []
    signal.signal(signal.SIGALRM, _late)
    with tempfile.TemporaryFile() as noise:
        os.dup2(noise.fileno(), 1)
        os.dup2(noise.fileno(), 2)
        for number in numbers:
            signal.alarm(LIMIT)
            verdict = mutant(sources, number, seed).judge(own)
            signal.alarm(0)
            sys.stdout.flush()
            sys.stderr.flush()
            noise.seek(0)
            if heard := noise.read().decode("utf-8", "replace"):
                verdict["problems"].append(f"noise: {heard[:500]!r}")
            noise.seek(0)
            noise.truncate()
            found.append((number, verdict))
    return found


def _late(*_: object) -> None:
    raise TimeoutError(f"no answer within {LIMIT} s")


def mutant(sources: Sequence[Source], number: int, seed: int) -> Mutant:
    """The mutant of that number."""
    source = sources[number % len(sources)]
    rng = Random(f"{seed}:{source.name}:{number}")
    file = rng.choice(source.mutated)
    kind, data = mutate((source.folder / file).read_bytes(), Path(file), rng)
    return Mutant(number, source, kind, file, data, _arguments(source, rng))


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
