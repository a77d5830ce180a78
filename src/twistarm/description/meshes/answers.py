"""Answers of the process that reads meshes, as bytes: plain data, and parts with their arrays as they lie in memory."""

from __future__ import annotations

import io
import pickle
from math import inf
from typing import Any

import numpy as np

from .limits import LONGEST
from .part import Part

FLOAT, INTEGER = np.dtype("<f8"), np.dtype("<i8")


class _Plain(pickle.Unpickler):
    """Takes numbers, texts, bytes and what holds them: no name of a class or function."""

    def find_class(self, module_name: str, global_name: str, /) -> Any:
        raise pickle.UnpicklingError(f"{module_name}.{global_name} is no plain data")


def packed(answer: dict[str, Any]) -> bytes:
    """An answer, whose `parts` become plain data."""
    parts = [
        (part.vertices.astype(FLOAT).tobytes(), part.normals.astype(FLOAT).tobytes(),
         part.faces.astype(INTEGER).tobytes(), part.colour, part.exact)
        for part in answer.get("parts", ())
    ]  # fmt: skip
    return pickle.dumps(answer | {"parts": parts})


def unpacked(data: bytes) -> dict[str, Any]:
    """The answer; ValueError for what is none, whatever the process has become by what it read."""
    try:
        answer = _Plain(io.BytesIO(data)).load()
        return {
            "lacking": str(answer.get("lacking", "")),
            "memory": answer.get("memory") is True,
            "reason": answer.get("reason"),
            **{name: _amount(answer.get(name, 0.0)) for name in ("length", "seconds", "bytes")},
            "parts": [_part(*told) for told in answer["parts"]],
        }
    except Exception as error:  # bytes may stand for anything
        raise ValueError("no answer") from error


def _amount(value: float) -> float:
    """0 where it is none that is finite and positive."""
    return float(value) if 0.0 < value < inf else 0.0


def _part(points: bytes, directions: bytes, triangles: bytes, colour: Any, exact: Any) -> Part:
    vertices, normals = (np.frombuffer(data, FLOAT).reshape(-1, 3) for data in (points, directions))
    faces = np.frombuffer(triangles, INTEGER).reshape(-1, 3)
    fitting = len(normals) == len(vertices) and faces.min() >= 0 and faces.max() < len(vertices)
    if not (fitting and (np.abs(vertices) <= 2 * LONGEST).all() and (np.abs(normals) <= 2.0).all()):
        raise ValueError("no mesh")
    if colour is not None:
        red, green, blue, alpha = (float(np.clip(share, 0.0, 1.0)) for share in colour)
        colour = (red, green, blue, alpha)
    return Part(vertices, normals, faces, colour, exact is True)
