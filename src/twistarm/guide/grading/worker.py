"""What a copy of this process does with a reader's code; it tells by events, which are pickled into a file.

("syntax", (message, line, column, text)), ("failed", Failure) and ("loaded", (functions, own ones)) are of a file;
("begin", name) and ("answers", (name, list of `Answer`)) of each exercise.
The system ends the copy when its time is over.
"""

from __future__ import annotations

import io
import os
import pickle
import resource
import signal
import sys
import types
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from .answers import Failure, of_function

MEMORY = 2**30
"""Bytes that the code may take, where the system has such a limit."""

OUTPUT = 10_000
"""Characters of what is printed that are kept; the rest is forgotten."""

IN_SANDBOX = "TWISTARM_GUIDE_GRADING"
"""Set where a reader's code is graded: a `check` in it does nothing then."""

FUNCTIONS = (types.FunctionType, types.BuiltinFunctionType, type)

Functions = Mapping[str, Callable[..., Any]]
Instances = Mapping[str, Sequence[tuple[Any, ...]]]


class Printed(io.TextIOBase):
    """The beginning of what is printed, in a file at once: nothing is lost where the process is ended."""

    def __init__(self, path: Path) -> None:
        self._file, self._left = path.open("w", encoding="utf-8", errors="replace"), OUTPUT

    def write(self, text: str) -> int:
        """Keep what there is room for."""
        kept = text[: self._left]
        self._left -= len(kept)
        if kept:
            self._file.write(kept)
            self._file.flush()
        return len(text)


class Worker:
    """The copy, prepared: events and what is printed go into `place`, and each step may take `seconds`."""

    def __init__(self, place: Path, seconds: float) -> None:
        self._seconds = seconds
        os.setsid()
        nothing = os.open(os.devnull, os.O_RDWR)
        for standard in range(3):  # those of a notebook are its own, and lead back into it
            os.dup2(nothing, standard)
        self._events = os.open(place / "events", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        sys.stdin, sys.stdout = io.StringIO(), Printed(place / "printed")
        sys.stderr = sys.stdout
        os.environ[IN_SANDBOX] = "1"
        warnings.simplefilter("ignore")
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        _limit_memory()

    def tell(self, what: str, value: Any) -> None:
        """Append an event."""
        os.write(self._events, pickle.dumps((what, value)))

    def limit_time(self) -> None:
        """Have the system end this process unless it is done in time, or this is called again."""
        signal.setitimer(signal.ITIMER_REAL, self._seconds)

    def answer(self, name: str, function: Callable[..., Any], rows: Sequence[tuple[Any, ...]], file: str) -> None:
        """Call an exercise's function on its instances, and tell what it answers."""
        self.limit_time()
        self.tell("begin", name)
        answers = []
        for row in rows:
            answers.append(of_function(function, row, file))
            if (error := answers[-1].error) is not None and error.kind == "NotImplementedError":
                break
        self.tell("answers", (name, answers))


def grade(
    functions: Callable[[Worker], Functions], instances: Instances, file: str, place: Path, seconds: float
) -> None:
    """Be the copy: find the functions, have them answer, and end with all that they registered or started."""
    try:
        worker = Worker(place, seconds)
        found = functions(worker)
        for name, rows in instances.items():
            if name in found:
                worker.answer(name, found[name], rows, file)
    finally:
        os._exit(0)


def load(source: str, name: str, folder: Path, worker: Worker) -> Functions:
    """The functions of a reader's file that are its own; none, and told why, where it cannot be run."""
    worker.limit_time()
    try:
        code = compile(source, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        worker.tell("syntax", (str(error.msg), error.lineno or 0, error.offset or 0, (error.text or "")[:200]))
        return {}
    except (ValueError, RecursionError, MemoryError, OverflowError) as error:
        worker.tell("syntax", (f"it cannot be read as Python: {error or type(error).__name__}", 0, 0, ""))
        return {}
    os.chdir(folder)
    sys.path.append(str(folder))
    module = types.ModuleType("exercises_of_the_reader")
    sys.modules[module.__name__] = module
    module.__file__ = name
    try:
        exec(code, vars(module))
    except (Exception, SystemExit) as error:
        worker.tell("failed", Failure.of(error, name))
        return {}
    there = {key: each for key, each in vars(module).items() if callable(each) and not key.startswith("_")}
    own = {key: each for key, each in there.items() if not _imported(each, module)}
    worker.tell("loaded", (tuple(there), tuple(own)))
    return own


def _imported(function: Any, module: types.ModuleType) -> bool:
    """Whether a function or a class comes from another module, and so is none of the reader's own in this file."""
    return isinstance(function, FUNCTIONS) and getattr(function, "__module__", None) not in (None, module.__name__)


def _limit_memory() -> None:
    """At most `MEMORY` more than now, and no core files, where the platform has such limits."""
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
        most = MEMORY + pages * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
