"""What a copy of this process does with a reader's code, and tells as pairs.

("syntax", (message, line, column, text)), ("failed", Failure) and ("loaded", (functions, own ones)) are of a file;
("begin", name) and ("answers", (name, list of `Answer`)) of each exercise; ("printed", text) of either.
"""

from __future__ import annotations

import io
import os
import resource
import sys
import types
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from .answers import Answer, Failure, of_function

MEMORY = 2**30
"""Bytes that the code may take, where the system has such a limit."""

OUTPUT = 10_000
"""Characters of what is printed that are kept; the rest is forgotten."""

IN_SANDBOX = "TWISTARM_GUIDE_GRADING"
"""Set where a reader's code is graded: a `check` in it does nothing then."""

FUNCTIONS = (types.FunctionType, types.BuiltinFunctionType, type)

Functions = Mapping[str, Callable[..., Any]]
Instances = Mapping[str, Sequence[tuple[Any, ...]]]
Tell = Callable[[tuple[str, Any]], None]


class Printed(io.TextIOBase):
    """Standard output whose beginning is told."""

    def __init__(self, tell: Tell) -> None:
        self._tell, self._left = tell, OUTPUT

    def write(self, text: str) -> int:
        """Tell what there is room for."""
        kept = text[: self._left]
        self._left -= len(kept)
        if kept:
            self._tell(("printed", kept))
        return len(text)


def grade(functions: Callable[[Tell], Functions], instances: Instances, file: str, tell: Tell) -> None:
    """Be the copy: find the functions, have them answer, and end with all that they registered or started."""
    try:
        _prepare(tell)
        found = functions(tell)
        for name, rows in instances.items():
            if name in found:
                tell(("begin", name))
                tell(("answers", (name, list(_answers(found[name], rows, file)))))
    finally:
        os._exit(0)


def _prepare(tell: Tell) -> None:
    """Let go of the terminal or the notebook, and take at most `MEMORY` more than now."""
    os.setsid()
    nothing = os.open(os.devnull, os.O_RDWR)
    for standard in range(3):
        os.dup2(nothing, standard)
    sys.stdin, sys.stdout = io.StringIO(), Printed(tell)
    sys.stderr = sys.stdout
    os.environ[IN_SANDBOX] = "1"
    warnings.simplefilter("ignore")
    with suppress(OSError, ValueError):
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[0])
        most = MEMORY + pages * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _answers(function: Callable[..., Any], rows: Sequence[tuple[Any, ...]], file: str) -> Iterator[Answer]:
    """What a function answers, until it says that it is not written."""
    for row in rows:
        answer = of_function(function, row, file)
        yield answer
        if answer.error is not None and answer.error.kind == "NotImplementedError":
            return


def load(source: str, name: str, folder: Path, tell: Tell) -> Functions:
    """The functions of a reader's file that are its own; none, and told why, where it cannot be run."""
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
    own = {key: each for key, each in there.items() if not _imported(each, module)}
    tell(("loaded", (tuple(there), tuple(own))))
    return own


def _imported(function: Any, module: types.ModuleType) -> bool:
    """Whether a function or a class comes from another module, and so is none of the reader's own in this file."""
    return isinstance(function, FUNCTIONS) and getattr(function, "__module__", None) not in (None, module.__name__)
