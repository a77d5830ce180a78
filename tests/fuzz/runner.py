"""Mutants made from seeds, and judged one after the other."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from random import Random
from typing import Any

from . import hostile
from .mutations import mutate
from .oracle import judged
from .sources import Source

LIMIT = 60  # Seconds on the clock for one mutant: others use the machine too.


def campaign(
    sources: Sequence[Source], count: int, folder: Path, printed: Callable[[], str]
) -> tuple[Counter[str], list[str]]:
    """Outcomes of `count` mutants of the sources in turn, and what failed, each kept as a file in `folder`.

    `printed` returns what was printed since its last call: a description makes no noise.
    """
    outcomes: Counter[str] = Counter()
    failed = []
    for source in sources:
        for file, data in source.texts().items():
            _written(_place(source, folder) / file, data)
    with _patience():
        for number in range(count):
            signal.alarm(LIMIT)
            source = sources[number % len(sources)]
            rng = Random(f"0:{source.name}:{number}")
            file = rng.choice(source.mutated)
            kind, data = mutate((source.folder / file).read_bytes(), Path(file), rng)
            verdict = _verdict(source, _place(source, folder), file, data, _arguments(source, rng))
            outcomes[verdict["outcome"]] += 1
            if problems := [*verdict["problems"], *(f"noise: {noise[:500]!r}" for noise in [printed()] if noise)]:
                kept = folder / "failed" / f"{number}_{Path(file).name}"
                _written(kept, data)
                failed.append(f"{source.name} #{number} ({kind}): {problems[0].strip()[-600:]}\n  kept as {kept}")
    return outcomes, failed


def _verdict(source: Source, place: Path, file: str, data: bytes, arguments: dict[str, Any]) -> dict[str, Any]:
    """The oracle's verdict on the copy of a source in `place` with one file changed."""
    beside = {name: str(place / other) for name, other in source.beside.items()}
    packages = {name: place / other for name, other in source.packages().items()}
    original = (place / file).read_bytes()
    (place / file).write_bytes(data)
    try:
        return judged(place / source.file, arguments | beside, packages)
    finally:
        (place / file).write_bytes(original)


@contextmanager
def _patience() -> Iterator[None]:
    def late(*_: object) -> None:
        raise TimeoutError(f"no answer within {LIMIT} s")

    before = signal.signal(signal.SIGALRM, late)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


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
