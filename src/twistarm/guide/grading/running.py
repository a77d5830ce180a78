"""A reader's code, run in copies of this process with limits of time, memory and output.

One copy reads a file. Another answers each exercise, so that one exercise cannot spoil the next.
"""

from __future__ import annotations

import io
import multiprocessing
import os
import signal
import sys
import types
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, TextIO

from ...support.errors import one_line
from .answers import Failure, ReturnValue, of_function
from .verdict import why_stopped

SECONDS = 10.0  # Time limit for reading the file, and for each exercise.
MEMORY = 2**30  # Bytes that the code may use, if the system has such a limit.
OUTPUT = 10_000  # Most characters of output to keep.
IN_SANDBOX = "TWISTARM_GUIDE_GRADING"  # Set while a reader's code is graded: a `check` in it does nothing then.

Rows = Sequence[tuple[Any, ...]]


Functions = Mapping[str, Callable[..., Any]]


@dataclass
class Run:
    """The result of a file: its functions, each exercise's answers, its output, and its errors.

    `own` are the functions that the file defines itself. `answers` has a text for an exercise that ended the process.
    `problem` says why the file is unusable. `excerpt` shows a syntax error with a caret below.
    """

    functions: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    answers: dict[str, list[ReturnValue] | str] = field(default_factory=dict)
    problem: str = ""
    excerpt: tuple[str, ...] = ()
    printed: str = ""


def run(source: str, name: str, folder: Path, instances: Mapping[str, Rows], seconds: float = SECONDS) -> Run:
    """Run a reader's file and its functions on those instances."""
    read, printed = _in_a_copy(lambda: _load(source, name, folder)[0], seconds)
    result = read if isinstance(read, Run) else Run(problem=f"while it was read it {read}")
    result.printed = printed

    def answered(exercise: str) -> list[ReturnValue] | str:
        again, own = _load(source, name, folder)
        return again.problem or _answers(own[exercise], instances[exercise], name)

    for exercise in instances:
        if exercise in result.own:
            result.answers[exercise], output = _in_a_copy(lambda name=exercise: answered(name), seconds)  # type: ignore[misc]
            result.printed += output.removeprefix(printed)
    result.printed = result.printed[:OUTPUT]
    return result


def run_function(function: Callable[..., Any], name: str, rows: Rows, seconds: float = SECONDS) -> Run:
    """Run a function of this process on the instances of its exercise."""
    answers, printed = _in_a_copy(lambda: _answers(function, rows, function.__code__.co_filename), seconds)
    return Run(answers={name: answers}, printed=printed)


def _in_a_copy(work: Callable[[], Any], seconds: float) -> tuple[Any, str]:
    """The result of the work in a copy of this process, and its output. A failed copy's result says how it ended."""
    # A fork takes the reader's function as it is: one of a notebook cannot be pickled or imported anew.
    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    with TemporaryFile("w+", encoding="utf-8", errors="replace") as printed:
        copy = context.Process(target=_run_copy, args=(lambda: sender.send(work()), printed))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # of threads: the copy uses nothing that they hold
            copy.start()
        sender.close()  # else the receiver would not see the end of a copy that died
        try:
            late = f"was not done after {seconds:g} s: does a loop or a recursion never end?"
            result = receiver.recv() if receiver.poll(seconds) else late
        except (EOFError, OSError):
            copy.join(1.0)
            result = _how_it_ended(copy.exitcode)
        finally:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(copy.pid or 0, signal.SIGKILL)  # with all that it has started
            copy.kill()
            copy.join()
            receiver.close()
        printed.seek(0)
        return result, printed.read()


def _how_it_ended(code: int | None) -> str:
    if code is None or code >= 0:
        return "ended the whole process, as os._exit does: return the answer instead"
    name = signal.Signals(-code).name if -code in set(signal.Signals) else f"signal {-code}"
    return "crashed (SIGSEGV): a recursion that never ends does so" if name == "SIGSEGV" else f"was ended by {name}"


class _Printed(io.TextIOBase):
    """Standard output that keeps its beginning in a file."""

    def __init__(self, file: TextIO) -> None:
        self._file, self._left = file, OUTPUT

    def write(self, text: str) -> int:
        """Keep what there is room for."""
        if self._left:
            self._file.write(text[: self._left])
            self._file.flush()
            self._left = max(self._left - len(text), 0)
        return len(text)


def _run_copy(work: Callable[[], None], printed: TextIO) -> None:
    """Release the terminal or notebook, limit the memory to `MEMORY` more, work, and end at once."""
    try:
        os.setsid()
        sys.stdin, sys.stdout = io.StringIO(), _Printed(printed)
        sys.stderr = sys.stdout
        os.environ[IN_SANDBOX] = "1"
        warnings.simplefilter("ignore")
        with suppress(OSError, ValueError):
            pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
            import resource

            most = MEMORY + pages * resource.getpagesize()
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
        work()
    finally:
        os._exit(0)


def _answers(function: Callable[..., Any], rows: Rows, file: str) -> list[ReturnValue]:
    """A function's answers to the rows, up to the first that is not written."""
    answers: list[ReturnValue] = []
    for row in rows:
        answers.append(of_function(function, row, file))
        if (error := answers[-1].error) is not None and error.kind == "NotImplementedError":
            break
    return answers


def _load(source: str, name: str, folder: Path) -> tuple[Run, Functions]:
    """A reader's file and the functions that it defines; none if it cannot be run."""
    try:
        # The reader's file has no `from __future__` unless it says so; ours has.
        code = compile(source, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        message, text = str(error.msg), (error.text or "")[:200].rstrip("\n")
        at = max((error.offset or 0) - 1 - (len(text) - len(text.lstrip())), 0)
        problem = f"line {error.lineno}: {message}" if error.lineno else one_line(message, 200)
        excerpt = (f"    {text.strip()}", "    " + " " * at + "^") if text.strip() else ()
        return Run(problem=problem, excerpt=excerpt), {}
    except (ValueError, RecursionError, MemoryError, OverflowError) as error:
        return Run(problem=one_line(f"it cannot be read as Python: {error or type(error).__name__}", 200)), {}
    os.chdir(folder)
    sys.path.append(str(folder))
    module = types.ModuleType("exercises_of_the_reader")
    sys.modules[module.__name__] = module  # dataclasses look their module up there
    module.__file__ = name
    try:
        exec(code, vars(module))
    except BaseException as error:
        failure = Failure.of(error, name)
        return Run(problem=f"{f'line {failure.line}: ' if failure.line else ''}it {why_stopped(failure)}"), {}
    callables = {key: value for key, value in vars(module).items() if callable(value) and not key.startswith("_")}
    # A function that another module defines was imported; a value that can be called has no module.
    own = {
        key: value for key, value in callables.items() if getattr(value, "__module__", None) in (None, module.__name__)
    }
    return Run(tuple(callables), tuple(own)), own
