"""The program that reads meshes: started by `process.py`, one mesh after the other, until it is asked no more."""

from __future__ import annotations

import json
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
from math import inf
from pathlib import Path
from typing import Any, BinaryIO

from .answers import packed
from .limits import MEMORY, seconds_for
from .loading import length_of, parts_from, pieces_of
from .mesh_file import MeshFile, RefusedError, mesh_file

LIBRARIES = ("twistarm", "numpy", "trimesh", "collada", "dateutil", "six")
"""All that reading a mesh needs. What trimesh would use beside them decodes images, unpacks and tessellates."""


class _Needed(MetaPathFinder):
    """Finds what `finders` find of the standard library and LIBRARIES, and nothing else that is installed."""

    def __init__(self, finders: Iterable[Any]) -> None:
        self._finders = tuple(finders)

    def find_spec(self, name: str, path: Sequence[str] | None, target: Any = None) -> ModuleSpec | None:
        top = name.partition(".")[0]
        if top not in LIBRARIES and top not in sys.stdlib_module_names and not top.startswith("_sysconfigdata"):
            return None
        return next(filter(None, (finder.find_spec(name, path, target) for finder in self._finders)), None)


def main() -> None:
    """Answer the requests on standard input, on standard output; end with the one who asks."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # whatever a library prints is no answer
    requests: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_take, args=(sys.stdin.buffer, requests), daemon=True).start()
    answer: dict[str, Any] = {"lacking": _prepare()}
    while True:
        data = packed(answer)
        answers.write(len(data).to_bytes(8, "little"))
        answers.write(data)
        answers.flush()
        answer = _answer(json.loads(requests.get()))


def _take(source: BinaryIO, requests: queue.SimpleQueue[bytes]) -> None:
    """Whoever asked is gone at the end of `source`: what is being read is for nobody."""
    for line in source:
        requests.put(line)
    os._exit(0)


def _prepare() -> str:
    """Import what reads meshes and nothing else, then give up what no mesh needs; what is lacking, in words."""
    guess = types.ModuleType("charset_normalizer")  # of text that is no UTF-8: its numbers are the same in any
    guess.detect = lambda text: {"encoding": "latin-1", "confidence": 1.0}  # type: ignore[attr-defined]
    sys.modules["charset_normalizer"] = sys.modules["chardet"] = guess
    sys.meta_path[:] = [_Needed(sys.meta_path)]
    try:
        import trimesh  # noqa: F401

        with suppress(ImportError):  # then COLLADA is not read
            import collada  # noqa: F401
    except ImportError as error:
        return str(error)
    for what, most in ((resource.RLIMIT_AS, MEMORY), (resource.RLIMIT_FSIZE, 0), (resource.RLIMIT_CORE, 0)):
        with suppress(ValueError, OSError):  # where the system has no such limit, the clock is left
            resource.setrlimit(what, (most, most))
    return ""


def _answer(request: dict[str, Any]) -> dict[str, Any]:
    began, allowance = time.process_time(), _Allowance()
    try:
        answer = _read(mesh_file(Path(request["path"]), allowance.more), request["most"])
    except MemoryError:
        answer = {"memory": True}
    except RefusedError as error:
        answer = {"reason": str(error)}
    except RecursionError:
        answer = {"reason": "it is nested too deeply"}
    except OSError as error:
        answer = {"reason": error.strerror or str(error)}
    except Exception as error:  # the readers raise whatever a file makes them stumble over, and quote what they like
        answer = {"reason": f"its contents are malformed ({type(error).__name__})"}
    return answer | {"seconds": time.process_time() - began, "bytes": allowance.size}


def _read(file: MeshFile, most: float | None) -> dict[str, Any]:
    """Its length, and its parts but where `most` is 0."""
    pieces = pieces_of(file)
    length = length_of(pieces)
    return {"length": length, "parts": [] if most == 0 else parts_from(pieces, inf if most is None else most)}


class _Allowance:
    """Processor time for a mesh, by its bytes: the system ends the process that takes more."""

    def __init__(self) -> None:
        self.size = 0
        self._began = time.process_time()
        self.more(0)  # the last mesh's may be almost over

    def more(self, size: int) -> None:
        self.size += size
        end, most = int(self._began + seconds_for(self.size)) + 1, resource.getrlimit(resource.RLIMIT_CPU)[1]
        soft = end if most == resource.RLIM_INFINITY else min(end, most)  # a user's own limit stays
        resource.setrlimit(resource.RLIMIT_CPU, (soft, most))
