"""Run a reader's code in a copy of this process, with limits of time, memory and output.

The copy sends pairs: ("syntax", (message, line, column, text)), ("failed", Failure) and ("loaded", (functions, own
ones)) of a file; ("begin", name) and ("answers", (name, list of `Answer`)) of each exercise; ("printed", text) of
either. The last is ("ended", how), of the copy.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import resource
import signal
import sys
import time
import types
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from .answers import Answer, Failure, of_function

SECONDS = 10.0
"""For the file to be read, and for each exercise again."""

MEMORY = 2**30
"""Bytes that the code may take, where the system has such a limit."""

OUTPUT = 10_000
"""Characters of what is printed that are kept; the rest is forgotten."""

IN_SANDBOX = "TWISTARM_GUIDE_GRADING"
"""Set where a reader's code is graded: a `check` in it does nothing then."""

Functions = Mapping[str, Callable[..., Any]]
Instances = Mapping[str, Sequence[tuple[Any, ...]]]
Tell = Callable[[tuple[str, Any]], None]


@dataclass
class Run:
    """The result of a file: its functions, each exercise's answers, its output, and its errors.

    `answers` has a text for an exercise that ended the process. `syntax` is (message, line, column, text), `failed` the
    error of loading. `ended` says how the process ended during loading.
    """

    functions: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    answers: dict[str, list[Answer] | str] = field(default_factory=dict)
    syntax: tuple[str, int, int, str] | None = None
    failed: Failure | None = None
    ended: str = ""
    printed: str = ""


def run(source: str, name: str, folder: Path, instances: Instances, seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances. If one ends the process, the others get another."""
    done, left, functions = Run(), list(instances), partial(_load, source, name, folder)
    while True:
        before = done.printed
        at = _run_copy(done, functions, {each: instances[each] for each in left}, name, seconds)
        done.printed = before or done.printed
        left = left[left.index(at) + 1 :] if at else []
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
    """Note in `done` what a copy tells; the exercise in which it ended."""
    at, said = None, False
    for what, value in _told(partial(_grade, functions, instances, file), seconds):
        if what == "printed":
            done.printed += value
        elif what == "begin":
            at = value
        elif what == "ended":
            if at is not None:
                done.answers[at] = value
            elif not said:
                done.ended = value
        elif what == "answers":
            at, done.answers[value[0]] = None, value[1]
        elif what == "loaded":
            done.functions, done.own = value
        else:
            setattr(done, what, value)
        said = said or what != "printed"
    return at


def _told(work: Callable[[Tell], None], seconds: float) -> Iterator[tuple[str, Any]]:
    """The messages of a copy of this process, with at most so many seconds between them."""
    context = multiprocessing.get_context("fork")
    told, telling = context.Pipe(duplex=False)
    copy = context.Process(target=_be_the_copy, args=(work, telling.send))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
        copy.start()
    telling.close()
    until = time.monotonic() + seconds
    how = f"was not done after {seconds:g} s: does a loop or a recursion never end?"
    try:
        while told.poll(max(until - time.monotonic(), 0.0)):
            what, value = told.recv()
            if what != "printed":
                until = time.monotonic() + seconds
            yield what, value
    except (EOFError, OSError):
        copy.join(1.0)
        how = _how_it_ended(copy.exitcode)
    finally:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(copy.pid or 0, signal.SIGKILL)  # with all that it has started
        copy.kill()
        copy.join()
        told.close()
    yield "ended", how


def _how_it_ended(code: int | None) -> str:
    if code is None or code >= 0:
        return "ended the whole process, as os._exit does: return the answer instead"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return "crashed (SIGSEGV): a recursion that never ends does so" if name == "SIGSEGV" else f"was ended by {name}"


class _Printed(io.TextIOBase):
    """Standard output with a limited length."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._left = tell, OUTPUT

    def write(self, text: str) -> int:
        """Tell what there is room for."""
        kept = text[: self._left]
        self._left -= len(kept)
        if kept:
            self._tell(("printed", kept))
        return len(text)


def _be_the_copy(work: Callable[[Tell], None], tell: Tell) -> None:
    """Release the terminal or notebook, limit the memory to `MEMORY` more, work, and end at once."""
    try:
        os.setsid()
        sys.stdin, sys.stdout = io.StringIO(), _Printed(tell)
        sys.stderr = sys.stdout
        os.environ[IN_SANDBOX] = "1"
        warnings.simplefilter("ignore")
        with suppress(OSError, ValueError):
            pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
            most = MEMORY + pages * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
        work(tell)
    finally:
        os._exit(0)


def _grade(functions: Callable[[Tell], Functions], instances: Instances, file: str, tell: Tell) -> None:
    """Find the functions and have them answer."""
    found = functions(tell)
    for name, rows in instances.items():
        if name in found:
            tell(("begin", name))
            tell(("answers", (name, list(_answers(found[name], rows, file)))))


def _answers(function: Callable[..., Any], rows: Sequence[tuple[Any, ...]], file: str) -> Iterator[Answer]:
    """What a function answers, until it says that it is not written."""
    for row in rows:
        answer = of_function(function, row, file)
        yield answer
        if answer.error is not None and answer.error.kind == "NotImplementedError":
            return


def _load(source: str, name: str, folder: Path, tell: Tell) -> Functions:
    """The functions that a reader's file defines; none, with the reason, if it cannot be run."""
    try:
        code = compile(source, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        tell(("syntax", (str(error.msg), error.lineno or 0, error.offset or 0, (error.text or "")[:200])))
        return {}
    except (ValueError, RecursionError, MemoryError, OverflowError) as error:
        tell(("syntax", (f"it cannot be read as Python: {error or type(error).__name__}", 0, 0, "")))
        return {}
    os.chdir(folder)
    sys.path.append(str(folder))
    module = types.ModuleType("exercises_of_the_reader")
    sys.modules[module.__name__] = module
    module.__file__ = name
    try:
        exec(code, vars(module))
    except BaseException as error:
        tell(("failed", Failure.of(error, name)))
        return {}
    there = {key: each for key, each in vars(module).items() if callable(each) and not key.startswith("_")}
    # What another module defines is none of the reader's own; a value that can be called has no module.
    own = {key: each for key, each in there.items() if getattr(each, "__module__", None) in (None, module.__name__)}
    tell(("loaded", (tuple(there), tuple(own))))
    return own
