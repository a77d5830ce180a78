"""A reader's code, run in a copy of this process with limits for its time, its memory and what it prints.

The copy sends its `Run` after each step. It sends what the code prints as text.
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
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ...support.errors import one_line
from .answers import Answer, Failure, of_function
from .verdict import why_stopped

SECONDS = 10.0
"""For the file to be read, and for each exercise again."""

MEMORY = 2**30
"""Bytes that the code may take, where the system has such a limit."""

OUTPUT = 10_000
"""Characters of what is printed that are kept; the rest is forgotten."""

IN_SANDBOX = "TWISTARM_GUIDE_GRADING"
"""Set while a reader's code is graded: a `check` in it does nothing then."""

Rows = Sequence[tuple[Any, ...]]


@dataclass
class Run:
    """The result of a file: its functions, each exercise's answers, its output, and its errors.

    `own` are the functions that the file defines itself. `answers` has a text for an exercise that ended the process.
    `problem` says why the file cannot be used; `excerpt` shows a syntax error with a caret below. `at` is the exercise
    that is being answered, empty while the file is read, None at the end.
    """

    functions: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    answers: dict[str, list[Answer] | str] = field(default_factory=dict)
    problem: str = ""
    excerpt: tuple[str, ...] = ()
    printed: str = ""
    at: str | None = ""


Tell = Callable[[Run | str], None]


def run(source: str, name: str, folder: Path, instances: Mapping[str, Rows], seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances.

    Where an exercise ends the process, another copy goes on with the next.
    """

    def work(done: Run, tell: Tell) -> None:
        functions = _load(done, source, name, folder)
        for each, rows in instances.items():
            if each in functions and each not in done.answers:
                _answer(done, each, functions[each], rows, name, tell)
        tell(replace(done, at=None))

    done = Run()
    while done.at is not None:
        printed = done.printed
        done = _in_a_copy(replace(done, at=""), work, seconds)
        done.printed = printed or done.printed
        if done.problem:
            break
    return done


def run_function(function: Callable[..., Any], name: str, rows: Rows, seconds: float = SECONDS) -> Run:
    """Run a function of this process on the instances of its exercise."""
    file = function.__code__.co_filename
    return _in_a_copy(Run(at=name), lambda done, tell: _answer(done, name, function, rows, file, tell), seconds)


def _in_a_copy(done: Run, work: Callable[[Run, Tell], None], seconds: float) -> Run:
    """The run after a copy of this process went on with it, with at most so many seconds for each step."""
    context = multiprocessing.get_context("fork")
    told, telling = context.Pipe(duplex=False)
    copy = context.Process(target=_be_the_copy, args=(work, done, telling.send, told.close))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
        copy.start()
    telling.close()
    until, printed = time.monotonic() + seconds, ""
    how = f"was not done after {seconds:g} s: does a loop or a recursion never end?"
    try:
        while told.poll(max(until - time.monotonic(), 0.0)):
            said = told.recv()
            if isinstance(said, str):
                printed += said
            else:
                done, until = said, time.monotonic() + seconds
    except (EOFError, OSError):
        copy.join(1.0)
        how = _how_it_ended(copy.exitcode)
    finally:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(copy.pid or 0, signal.SIGKILL)  # with all that it has started
        copy.kill()
        copy.join()
        told.close()
    if done.at:
        done.answers.setdefault(done.at, how)
    elif done.at is not None:
        done.problem = f"while it was read it {how}"
    done.printed = printed
    return done


def _how_it_ended(code: int | None) -> str:
    if code is None or code >= 0:
        return "ended the whole process, as os._exit does: return the answer instead"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return "crashed (SIGSEGV): a recursion that never ends does so" if name == "SIGSEGV" else f"was ended by {name}"


class _Printed(io.TextIOBase):
    """Standard output that sends its beginning."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._left = tell, OUTPUT

    def write(self, text: str) -> int:
        """Send what there is room for."""
        kept = text[: self._left]
        self._left -= len(kept)
        if kept:
            self._tell(kept)
        return len(text)


def _be_the_copy(work: Callable[[Run, Tell], None], done: Run, tell: Tell, close_other_end: Callable[[], None]) -> None:
    """Release the terminal or notebook, limit the memory to `MEMORY` more than now, work, and end at once."""
    try:
        close_other_end()  # sending then fails once the grader is gone
        os.setsid()
        sys.stdin, sys.stdout = io.StringIO(), _Printed(tell)
        sys.stderr = sys.stdout
        os.environ[IN_SANDBOX] = "1"
        warnings.simplefilter("ignore")
        with suppress(OSError, ValueError):
            pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
            most = MEMORY + pages * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
        work(done, tell)
    finally:
        os._exit(0)


def _answer(done: Run, name: str, function: Callable[..., Any], rows: Rows, file: str, tell: Tell) -> None:
    """Have a function answer each of the rows, until it says that it is not written."""
    done.at = name
    tell(done)
    answers: list[Answer] = []
    for row in rows:
        answers.append(of_function(function, row, file))
        if (error := answers[-1].error) is not None and error.kind == "NotImplementedError":
            break
    done.answers[name] = answers
    tell(done)


def _load(done: Run, source: str, name: str, folder: Path) -> Mapping[str, Callable[..., Any]]:
    """The functions that a reader's file defines; none, and a problem noted, where it cannot be run."""
    try:
        code = compile(source, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        message, text = str(error.msg), (error.text or "")[:200].rstrip("\n")
        at = max((error.offset or 0) - 1 - (len(text) - len(text.lstrip())), 0)
        done.problem = f"line {error.lineno}: {message}" if error.lineno else one_line(message, 200)
        done.excerpt = (f"    {text.strip()}", "    " + " " * at + "^") if text.strip() else ()
        return {}
    except (ValueError, RecursionError, MemoryError, OverflowError) as error:
        done.problem = one_line(f"it cannot be read as Python: {error or type(error).__name__}", 200)
        return {}
    os.chdir(folder)
    sys.path.append(str(folder))
    module = types.ModuleType("exercises_of_the_reader")
    sys.modules[module.__name__] = module
    module.__file__ = name
    try:
        exec(code, vars(module))
    except BaseException as error:
        failure = Failure.of(error, name)
        done.problem = f"{f'line {failure.line}: ' if failure.line else ''}it {why_stopped(failure)}"
        return {}
    there = {key: each for key, each in vars(module).items() if callable(each) and not key.startswith("_")}
    # A function that another module defines was imported; a value that can be called has no module.
    own = {key: each for key, each in there.items() if getattr(each, "__module__", None) in (None, module.__name__)}
    done.functions, done.own = tuple(there), tuple(own)
    return own
