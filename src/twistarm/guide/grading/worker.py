"""The process in which a reader's file runs: a program by itself, which imports nothing of twistarm.

It reads its job, JSON, from standard input: {"name", "source", "folder", "memory", "exercises": {name: [arguments]}}.
What it finds it writes, a JSON object a line, to the descriptor that its first argument numbers. What the reader's
code does to modules must not change what is told of it: everything that is needed then is bound before.
"""

from __future__ import annotations

import builtins
import inspect
import json
import linecache
import os
import resource
import sys
import traceback
import types
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

LARGEST = 10_000
"""Numbers of an answer; a larger one is told by its shape alone."""

encode, write, leave, extract, new_module = (
    json.JSONEncoder().encode,
    os.write,
    os._exit,
    traceback.extract_tb,
    types.ModuleType,
)
FUNCTIONS = (types.FunctionType, types.BuiltinFunctionType, type)
asarray, NDARRAY, NUMBERS = np.asarray, np.ndarray, (int, float, np.integer, np.floating, np.bool_)
whole_builtins, kept_builtins = vars(builtins), dict(vars(builtins))


def main() -> None:
    """Do the job, and leave at once: nothing that the reader's code registered runs afterwards."""
    job = json.load(sys.stdin)
    tell = teller(int(sys.argv[1]))
    limit(job["memory"])
    sys.path.append(job["folder"])
    warnings.simplefilter("ignore")
    try:
        module = _loaded(job, tell)
        if module is not None:
            for name, instances in job["exercises"].items():
                if callable(vars(module).get(name)) and not imported(vars(module)[name], module):
                    answer(name, vars(module)[name], instances, job["name"], tell)
        sys.stdout.flush()
    finally:  # whatever was changed so that not even this goes on
        leave(0)


def teller(channel: int) -> Callable[..., None]:
    """A function that writes an event to a descriptor."""

    def tell(**event: Any) -> None:
        line = encode(event).encode() + b"\n"
        while line:
            line = line[write(channel, line) :]

    return tell


def limit(memory: int) -> None:
    """At most so many bytes of memory more than now, and no core files, where the platform has such limits."""
    most_memory = memory + _size()
    for name, most in (("RLIMIT_AS", most_memory), ("RLIMIT_DATA", most_memory), ("RLIMIT_CORE", 0)):
        kind = getattr(resource, name, None)
        if kind is not None:
            try:
                resource.setrlimit(kind, (most, most))
            except (OSError, ValueError):
                continue


def _size() -> int:
    """Bytes of address space that the process has already; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm") as file:
            return int(file.read().split()[0]) * resource.getpagesize()
    except (OSError, ValueError):
        return 0


def _loaded(job: dict[str, Any], tell: Callable[..., None]) -> types.ModuleType | None:
    """The reader's file as a module; None, and told why, where it cannot be run."""
    name, source = job["name"], job["source"]
    linecache.cache[name] = (len(source), None, source.splitlines(True), name)
    try:
        code = compile(source, name, "exec", dont_inherit=True)
    except SyntaxError as error:
        tell(syntax=[str(error.msg), error.lineno or 0, error.offset or 0, (error.text or "").rstrip("\n")[:200]])
        return None
    except (ValueError, RecursionError, MemoryError, OverflowError) as error:
        tell(syntax=[f"it cannot be read as Python: {error or type(error).__name__}", 0, 0, ""])
        return None
    module = new_module("exercises_of_the_reader")
    sys.modules[module.__name__] = module
    vars(module)["__file__"] = name
    try:
        exec(code, vars(module))
    except BaseException as error:
        whole_builtins.update(kept_builtins)
        tell(failed=_error(error, name))
        return None
    whole_builtins.update(kept_builtins)
    functions = [each for each, value in list(vars(module).items()) if callable(value) and not each.startswith("_")]
    own = [each for each in functions if not imported(vars(module)[each], module)]
    tell(loaded=functions, own=own)
    return module


def imported(function: Callable[..., Any], module: types.ModuleType) -> bool:
    """Whether a function or a class comes from another module, and so is none of the reader's own in this file."""
    whence = getattr(function, "__module__", None)
    return isinstance(function, FUNCTIONS) and whence not in (None, module.__name__)


def answer(
    name: str, function: Callable[..., Any], instances: list[list[Any]], file: str, tell: Callable[..., None]
) -> None:
    """Call an exercise's function on its instances, and tell what it answers."""
    tell(begin=name)
    answers = []
    for given in instances:
        arguments = [_decoded(each) for each in given]
        before = [_encoded(each) for each in arguments]
        try:
            given_back = function(*arguments)
            whole_builtins.update(kept_builtins)
            one = _encoded(given_back)
        except BaseException as error:
            whole_builtins.update(kept_builtins)
            one = {"error": _error(error, file, function, len(arguments))}
        if changed := [i for i, each in enumerate(arguments) if _encoded(each) != before[i]]:
            one["changed"] = changed
        answers.append(one)
        if "error" in one and one["error"]["type"] == "NotImplementedError":
            break
    tell(answers=answers)


def _decoded(value: Any) -> Any:
    return asarray(value["array"], dtype=float) if isinstance(value, dict) else value


def _encoded(value: Any, depth: int = 0) -> dict[str, Any]:
    """What came back, as JSON: a number, an array, items, None, or the name of another type."""
    if value is None:
        return {"none": True}
    if isinstance(value, NUMBERS):
        try:
            return {"number": float(value)}
        except OverflowError:
            return {"number": float("inf")}
    if isinstance(value, NDARRAY):
        if value.dtype.kind not in "biuf":
            return {"other": f"array of {value.dtype}"}
        if value.size > LARGEST:
            return {"large": list(value.shape)}
        return {"array": asarray(value, dtype=float).tolist(), "shape": list(value.shape)}
    if isinstance(value, (list, tuple)) and depth < 5:
        if len(value) > LARGEST:
            return {"large": [len(value)]}
        return {"items": [_encoded(each, depth + 1) for each in value]}
    if depth == 0 and hasattr(type(value), "__array__"):
        try:
            return _encoded(asarray(value), 1)
        except BaseException:
            pass
    return {"other": type(value).__name__}


def _error(error: BaseException, file: str, function: Any = None, given: int = 0) -> dict[str, Any]:
    """Kind, text and line of an error; `calls` where the function does not take what it is given."""
    lines = [frame.lineno for frame in extract(error.__traceback__) if frame.filename == file]
    told = {"type": type(error).__name__, "text": str(error)[:300], "line": lines[-1] if lines else 0}
    if module := getattr(error, "name", None) if isinstance(error, ImportError) else None:
        told["module"] = str(module)
    if function is not None and isinstance(error, TypeError):
        try:
            inspect.signature(function).bind(*[None] * given)
        except TypeError:
            told["calls"] = str(inspect.signature(function))[:200]
        except ValueError:
            pass
    return told


if __name__ == "__main__":
    main()
