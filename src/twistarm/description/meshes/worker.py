"""The program that reads meshes one after the other. `process.py` starts and ends it."""

from __future__ import annotations

import os
import queue
import resource
import sys
import threading
import time
import types
from collections.abc import Iterable, Sequence
from contextlib import suppress
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from .loading import length_of, parts_from, pieces_of
from .mesh_file import MEMORY, RefusedError, mesh_file, seconds_for

LIBRARIES = ("twistarm", "numpy", "trimesh", "collada", "dateutil", "six")
"""All that reading a mesh needs. trimesh would use others to decode images, unpack and tessellate."""


class _Needed(MetaPathFinder):
    """Finds modules of the standard library and LIBRARIES only."""

    def __init__(self, finders: Iterable[Any]) -> None:
        self._finders = tuple(finders)

    def find_spec(self, name: str, path: Sequence[str] | None, target: Any = None) -> ModuleSpec | None:
        top = name.partition(".")[0]
        if top not in LIBRARIES and top not in sys.stdlib_module_names and not top.startswith("_sysconfigdata"):
            return None
        return next(filter(None, (finder.find_spec(name, path, target) for finder in self._finders)), None)


def main(descriptor: int) -> None:
    """Answer the requests that come through the pipe, until it closes."""
    pipe: Connection[Any, Any] = Connection(descriptor)
    requests: queue.SimpleQueue[tuple[Path, float]] = queue.SimpleQueue()
    _prepare()
    answer: dict[str, Any] = {}
    threading.Thread(target=_take, args=(pipe, requests), daemon=True).start()
    while True:
        pipe.send(answer)
        answer = _answer(*requests.get())


def _take(pipe: Connection[Any, Any], requests: queue.SimpleQueue[tuple[Path, float]]) -> None:
    """Queue the requests, and end the process when the pipe closes, also while it reads a mesh."""
    with suppress(EOFError, OSError):
        while True:
            requests.put(pipe.recv())
    os._exit(0)


def _prepare() -> None:
    """Import the readers, then limit the process."""
    guess = types.ModuleType("charset_normalizer")  # of text that is no UTF-8: its numbers are the same in any
    guess.detect = lambda text: {"encoding": "latin-1", "confidence": 1.0}  # type: ignore[attr-defined]
    sys.modules["charset_normalizer"] = sys.modules["chardet"] = guess
    sys.meta_path[:] = [_Needed(sys.meta_path)]
    import trimesh  # noqa: F401

    with suppress(ImportError):  # then COLLADA is not read
        import collada  # noqa: F401
    for what, most in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_CORE, 0)):
        with suppress(ValueError, OSError):  # where the system has no such limit, the clock is left
            resource.setrlimit(what, (most, most))


def _answer(path: Path, most: float) -> dict[str, Any]:
    """The mesh's length, and its parts unless `most` is 0; or the `reason` why it is not read."""
    began, sizes = time.process_time(), [0]

    def allow(size: int) -> None:
        sizes.append(size)
        limit_time(began + seconds_for(sum(sizes)))

    limit_time(began + seconds_for(0))  # the limit of the last mesh may be almost reached
    answer: dict[str, Any] = {"reason": None, "memory": False, "length": 0.0, "parts": []}
    try:
        pieces = pieces_of(mesh_file(path, allow))
        answer["length"] = length_of(pieces)
        answer["parts"] = parts_from(pieces, most) if most else []
    except MemoryError:
        answer["memory"] = True
    except RefusedError as error:
        answer["reason"] = str(error)
    except RecursionError:
        answer["reason"] = "it is nested too deeply"
    except OSError as error:
        answer["reason"] = error.strerror or str(error)
    except Exception as error:  # the readers raise whatever a file makes them stumble over, and quote what they like
        answer["reason"] = f"its contents are malformed ({type(error).__name__})"
    return answer | {"seconds": time.process_time() - began, "bytes": sum(sizes)}


def limit_time(end: float) -> None:
    """Let the system end the process that has taken `end` seconds of processor time, within the user's own limit."""
    most = resource.getrlimit(resource.RLIMIT_CPU)[1]
    soft = int(end) + 1
    resource.setrlimit(resource.RLIMIT_CPU, (soft if most == resource.RLIM_INFINITY else min(soft, most), most))
