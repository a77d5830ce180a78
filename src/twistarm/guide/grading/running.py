"""A reader's code run in a copy of this process, for a limited time: it cannot take the grader down."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from .answers import Answer, Failure
from .worker import Functions, Instances, Worker, grade, load

SECONDS = 10.0
"""For the file to be read, and for each exercise again."""

GRACE = 5.0
"""Seconds that the system may take to end a process."""


@dataclass
class Run:
    """What a file did: its functions, each exercise's answers, what it printed, and what went wrong.

    `answers` has a text in their place where the process ended in that exercise. `syntax` is (message, line, column,
    text), `failed` the error that loading the file raised; `ended` says how the process ended while it was loaded.
    """

    functions: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    answers: dict[str, list[Answer] | str] = field(default_factory=dict)
    syntax: tuple[str, int, int, str] | None = None
    failed: Failure | None = None
    ended: str = ""
    printed: str = ""

    def take(self, place: Path, end: str) -> str | None:
        """Note what a process left in its folder, and how it ended; the exercise in which it did, if any."""
        at, said = None, False
        with suppress(OSError, EOFError), (place / "events").open("rb") as events:
            while True:
                what, value = pickle.load(events)
                said = True
                if what == "begin":
                    at = value
                elif what == "answers":
                    name, answers = value
                    self.answers[name], at = answers, None
                elif what == "loaded":
                    self.functions, self.own = value
                else:
                    setattr(self, what, value)
        if at is not None:
            self.answers[at] = end
        elif not said:
            self.ended = end
        with suppress(OSError):
            self.printed = self.printed or (place / "printed").read_text("utf-8")
        return at


def run(source: str, name: str, folder: Path, instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances; where one ends the process, the others get another."""
    done, left, functions = Run(), dict(instances), partial(load, source, name, folder)
    while True:
        at = _run_copy(done, functions, left, name, seconds)
        left = dict(list(left.items())[list(left).index(at) + 1 :]) if at else {}
        if not left:
            return done


def run_function(function: Callable[..., Any], instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a function of this process on the instances of its one exercise."""
    done = Run()
    _run_copy(done, lambda _: dict.fromkeys(instances, function), instances, function.__code__.co_filename, seconds)
    return done


def _run_copy(
    done: Run, functions: Callable[[Worker], Functions], instances: Instances, file: str, seconds: float
) -> str | None:
    """Run functions in a copy of this process, end it with all that it started, and note what it told."""
    with TemporaryDirectory(prefix="twistarm-") as place:
        arguments = (functions, instances, file, Path(place), seconds)
        copy = multiprocessing.get_context("fork").Process(target=grade, args=arguments)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
            copy.start()
        try:
            copy.join(seconds * (len(instances) + 1) + GRACE)
        finally:
            code = copy.exitcode
            for kill in (os.killpg, os.kill):
                with suppress(ProcessLookupError, PermissionError):
                    kill(copy.pid or 0, signal.SIGKILL)
            copy.join()
        return done.take(Path(place), _how_it_ended(code, seconds))


def _how_it_ended(code: int | None, seconds: float) -> str:
    if code is None or code == -signal.SIGALRM:
        return f"was not done after {seconds:g} s: does a loop or a recursion never end?"
    if code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
        endless = "crashed (SIGSEGV): a recursion that never ends does so"
        return endless if name == "SIGSEGV" else f"was ended by {name}"
    return "ended the whole process, as os._exit does: return the answer instead"
