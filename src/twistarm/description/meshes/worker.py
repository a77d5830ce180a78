"""The answer to a request for a mesh, in the worker process."""

from __future__ import annotations

import sys
import time
import types
from contextlib import suppress
from pathlib import Path
from typing import Any

from ...support.worker import limit_time
from .limits import seconds_for
from .loading import length_of, parts_from, pieces_of
from .mesh_file import RefusedError, mesh_file

guess = types.ModuleType("charset_normalizer")  # of text that is no UTF-8: its numbers are the same in any
guess.detect = lambda text: {"encoding": "latin-1", "confidence": 1.0}  # type: ignore[attr-defined]
sys.modules["charset_normalizer"] = sys.modules["chardet"] = guess
with suppress(ImportError):  # then COLLADA is not read
    import collada  # noqa: F401
    import trimesh  # noqa: F401


def answer(path: Path, most: float) -> dict[str, Any]:
    """The mesh's length, and its parts unless `most` is 0; or the `reason` why it is not read."""
    began, sizes = time.process_time(), [0]

    def allow(size: int) -> None:
        sizes.append(size)
        limit_time(began + seconds_for(sum(sizes)))

    limit_time(began + seconds_for(0))
    answer: dict[str, Any] = {"reason": None, "length": 0.0, "parts": []}
    try:
        pieces = pieces_of(mesh_file(path, allow))
        answer["length"] = length_of(pieces)
        answer["parts"] = parts_from(pieces, most) if most else []
    except MemoryError:
        raise
    except RefusedError as error:
        answer["reason"] = str(error)
    except RecursionError:
        answer["reason"] = "it is nested too deeply"
    except OSError as error:
        answer["reason"] = error.strerror or str(error)
    except Exception as error:  # the readers raise whatever a file makes them stumble over, and quote what they like
        answer["reason"] = f"its contents are malformed ({type(error).__name__})"
    return answer | {"seconds": time.process_time() - began, "bytes": sum(sizes)}
