"""The program of the worker process, which answers one request after the other. `worker_process` starts and ends it."""

from __future__ import annotations

import os
import pickle
import queue
import resource
import sys
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, BinaryIO

LIBRARIES = ("twistarm", "numpy", "trimesh", "collada", "dateutil", "six", "xacro", "yaml", "_yaml")
"""All that meshes and xacro files need. trimesh would use others to decode images, unpack and tessellate."""

START = 30.0
"""Most seconds until the process, or a module in it, is ready. It takes some tenths, and more from a cold disk."""

MEMORY = 1_200_000_000
"""Bytes of address space. To simplify and shade a mesh of a million triangles takes 0.9 GB."""


class _Needed:
    """Finds modules of the standard library and LIBRARIES only."""

    def __init__(self, finders: Iterable[Any]) -> None:
        self._finders = tuple(finders)

    def find_spec(self, name: str, path: Sequence[str] | None, target: Any = None) -> Any:
        top = name.partition(".")[0]
        if top not in LIBRARIES and top not in sys.stdlib_module_names and not top.startswith("_sysconfigdata"):
            return None
        return next(filter(None, (finder.find_spec(name, path, target) for finder in self._finders)), None)


def main() -> None:
    """Answer the requests from standard input by `answer` of their module, until it closes.

    A request of None is not answered: the module is only imported.
    """
    answers = os.fdopen(os.dup(0), "wb")  # standard input is a socket
    requests: queue.SimpleQueue[tuple[str, tuple[Any, ...] | None]] = queue.SimpleQueue()
    sys.meta_path[:] = [_Needed(sys.meta_path)]
    threading.Thread(target=_take, args=(sys.stdin.buffer, requests), daemon=True).start()
    while True:
        name, request = requests.get()
        limit_time(time.process_time() + START)  # the limit of the last request may be almost reached
        module = import_module(name)
        confine()
        for answer in () if request is None else _answers(module, request):
            answers.write(answer)
            answers.flush()


def _answers(module: Any, request: tuple[Any, ...]) -> Iterator[bytes]:
    """That the request begins, and its answer."""
    yield pickle.dumps(None)
    try:
        yield pickle.dumps(module.answer(*request))
    except MemoryError:
        yield pickle.dumps(MemoryError())


def _take(pipe: BinaryIO, requests: queue.SimpleQueue[Any]) -> None:
    """Queue the requests, and end the process when the pipe closes, also while it works."""
    try:
        while True:
            requests.put(pickle.load(pipe))
    finally:
        os._exit(0)


def confine() -> None:
    """Limit its memory, and let it write no files."""
    for what, most in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_CORE, 0)):
        with suppress(ValueError, OSError):  # where the system has no such limit, the clock is left
            resource.setrlimit(what, (most, most))


def limit_time(end: float) -> None:
    """Let the system end the process that has taken `end` seconds of processor time, within the user's own limit."""
    most = resource.getrlimit(resource.RLIMIT_CPU)[1]
    soft = int(end) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (soft if most == resource.RLIM_INFINITY else min(soft, most), most))


def limit_memory(more: int) -> None:
    """Let the process take `more` bytes of address space than now, at most MEMORY, where the system knows both."""
    with suppress(ValueError, OSError):
        now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (min(now + more, MEMORY), MEMORY))
