"""A reader's code in a process of its own, with limits of time, memory and output: it cannot take the grader down."""

from __future__ import annotations

import json
import os
import selectors
import signal
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .processes import Process, copy_of_this_process, program

SECONDS = 10.0
"""For the file to be read, and for each exercise again."""

MEMORY = 2**30
"""Bytes that the process may take, where the platform has such a limit."""

FORGED = "wrote what is no result: leave the grader's files and modules alone"

OUTPUT = 10_000
"""Bytes of what is printed that are kept; the rest is read and forgotten."""

RESULTS = 64 * 2**20
"""Bytes of results; nobody who writes the exercises comes near."""

Instances = Mapping[str, Sequence[tuple[Any, ...]]]


@dataclass
class Run:
    """What a file did: its functions, each exercise's answers as the worker encodes them, and what went wrong.

    `answers` {exercise: list}, or {exercise: text} where the process ended in it. `syntax` (message, line, column,
    text); `failed` is the error that loading the file raised; `ended` says how the process ended while it was loaded.
    """

    loaded: bool = False
    functions: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    answers: dict[str, list[dict[str, Any]] | str] = field(default_factory=dict)
    syntax: tuple[str, int, int, str] | None = None
    failed: dict[str, Any] | None = None
    ended: str = ""
    printed: str = ""

    def take(self, event: dict[str, Any]) -> None:
        """Keep what the worker told of the file."""
        if "loaded" in event:
            self.functions, self.own = tuple(event["loaded"]), tuple(event["own"])
            self.loaded = True
        elif "syntax" in event:
            self.syntax = tuple(event["syntax"])
        elif "failed" in event:
            self.failed = event["failed"]
        elif "printed" in event:
            self.printed = self.printed or event["printed"]


def run(source: str, name: str, folder: Path, instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances; where one ends the process, the others get another."""
    done, left = Run(), encoded(instances)
    while True:
        job = {"name": name, "source": source, "folder": str(folder), "memory": MEMORY, "exercises": left}
        with program(job, folder) as process:
            at = _followed(process, left, done, seconds)
        left = dict(list(left.items())[list(left).index(at) + 1 :]) if at else {}
        if not left:
            return done


def run_function(function: Callable[..., Any], instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a function of this process, on the instances of its one exercise, in a copy of the process."""
    done, job = Run(), encoded(instances)
    with copy_of_this_process(function, job, MEMORY) as process:
        _followed(process, job, done, seconds)
    return done


def encoded(instances: Instances) -> dict[str, Any]:
    """Instances as the worker reads them."""
    return {
        name: [[{"array": each.tolist()} if hasattr(each, "tolist") else each for each in row] for row in rows]
        for name, rows in instances.items()
    }


def _followed(process: Process, exercises: Collection[str], done: Run, seconds: float) -> str | None:
    """Note what a process tells until it ends; the exercise in which it ended before its time, if any."""
    at: str | None = None
    end = ""
    try:
        for event in _events(process, seconds):
            if isinstance(event, str):
                end = event
            elif "begin" in event and event["begin"] in exercises:
                at = event["begin"]
            elif "answers" in event and at is not None:
                done.answers[at], at = event["answers"], None
            else:
                done.take(event)
    except (TypeError, KeyError, ValueError, RecursionError):  # events that the reader's code wrote with the mark
        end = FORGED
    end = end or _how_it_ended(process.poll())
    if at is not None:
        done.answers[at] = end
    elif not (done.loaded or done.syntax or done.failed or done.answers):
        done.ended = end
    return at


def _how_it_ended(code: int | None) -> str:
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        if name == "SIGSEGV":
            return "crashed (SIGSEGV): a recursion that never ends does so"
        return f"was ended by {name}"
    return "ended the whole process, as os._exit does: return the answer instead"


def _events(process: Process, seconds: float) -> Iterator[dict[str, Any] | str]:
    """What the worker tells, each line an event that gives it new time; a text where it is ended, and what it printed.

    Lines without the worker's mark are what the reader's code wrote, to whatever descriptor: they count for nothing.
    Descriptors that a process of the reader's holds open do not keep this waiting: it ends with the worker itself.
    """
    told, printed, most = b"", b"", 0
    with selectors.DefaultSelector() as selector:
        for descriptor in (process.results, process.output):
            os.set_blocking(descriptor, False)
            selector.register(descriptor, selectors.EVENT_READ)
        until = time.monotonic() + seconds
        while True:
            over = process.poll() is not None
            ready = selector.select(0.0 if over else min(0.05, max(until - time.monotonic(), 0.0)))
            for key, _ in ready:
                part = _part(key.fd)
                if part is None:
                    continue
                if not part:
                    selector.unregister(key.fd)
                elif key.fd == process.results:
                    told, most = told + part, most + len(part)
                else:
                    printed = (printed + part)[:OUTPUT]
            *lines, told = told.split(b"\n")
            for line in lines:
                if line.startswith(process.mark):
                    until = time.monotonic() + seconds
                    yield dict(json.loads(line.removeprefix(process.mark)))
            if time.monotonic() > until:
                yield f"was not done after {seconds:g} s: does a loop or a recursion never end?"
                break
            if most > RESULTS:
                yield "returned more than anybody reads"
                break
            if over and not ready:
                break
    yield {"printed": printed.decode("utf-8", "replace")}


def _part(descriptor: int) -> bytes | None:
    try:
        return os.read(descriptor, 65536)
    except BlockingIOError:
        return None
    except OSError:
        return b""
