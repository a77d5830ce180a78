"""A reader's code run in a copy of this process, for a limited time: it cannot take the grader down."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from .answers import Answer, Failure
from .worker import Functions, Instances, Tell, grade, load

SECONDS = 10.0
"""For the file to be read, and for each exercise again."""


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


def run(source: str, name: str, folder: Path, instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances; where one ends the process, the others get another."""
    done, left, functions = Run(), dict(instances), partial(load, source, name, folder)
    while True:
        before = done.printed
        at = _run_copy(done, functions, left, name, seconds)
        done.printed = before or done.printed
        left = dict(list(left.items())[list(left).index(at) + 1 :]) if at else {}
        if not left:
            return done


def run_function(function: Callable[..., Any], instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a function of this process on the instances of its one exercise."""
    done = Run()
    _run_copy(done, lambda _: dict.fromkeys(instances, function), instances, function.__code__.co_filename, seconds)
    return done


def _run_copy(
    done: Run, functions: Callable[[Tell], Functions], instances: Instances, file: str, seconds: float
) -> str | None:
    """Run functions in a copy of this process, and end it with all that it started; the exercise in which it ended."""
    context = multiprocessing.get_context("fork")
    told, telling = context.Pipe(duplex=False)
    copy = context.Process(target=grade, args=(functions, instances, file, telling.send))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
        copy.start()
    telling.close()
    at, said, until = None, False, time.monotonic() + seconds
    try:
        while told.poll(max(until - time.monotonic(), 0.0)):
            what, value = told.recv()
            if what == "printed":
                done.printed += value
                continue
            until, said, at = time.monotonic() + seconds, True, value if what == "begin" else None
            if what == "answers":
                done.answers[value[0]] = value[1]
            elif what == "loaded":
                done.functions, done.own = value
            elif what != "begin":
                setattr(done, what, value)
        how = f"was not done after {seconds:g} s: does a loop or a recursion never end?"
    except (EOFError, OSError):
        copy.join(1.0)
        how = _how_it_ended(copy.exitcode)
    finally:
        for kill in (os.killpg, os.kill):
            with suppress(ProcessLookupError, PermissionError):
                kill(copy.pid or 0, signal.SIGKILL)
        copy.join()
        told.close()
    if at is not None:
        done.answers[at] = how
    elif not said:
        done.ended = how
    return at


def _how_it_ended(code: int | None) -> str:
    if code is None or code >= 0:
        return "ended the whole process, as os._exit does: return the answer instead"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return "crashed (SIGSEGV): a recursion that never ends does so" if name == "SIGSEGV" else f"was ended by {name}"
