"""The protocol between the mesh reader's process and its caller: a line of JSON, then arrays as they lie in memory.

A request is `{"path": …, "parts": true | false, "most": number | null}`. An answer is a head, checked number by number,
and of parts the vertices, normals and faces of each, one after the other: no code, whatever the worker has become by
what it read.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from ...support.checks import Array
from ...support.strict_json import parsed
from .limits import LONGEST, PARTS, TRIANGLES
from .part import Part

LARGEST_HEAD = 1_000_000
"""Bytes: of PARTS parts."""

FLOAT, INTEGER = np.dtype("<f8"), np.dtype("<i8")

Read = Callable[[int], bytes]
"""The next so many bytes."""


class BrokenAnswerError(Exception):
    """An answer that is none: the worker has become something else."""


def packed(head: dict[str, Any], arrays: list[Any]) -> bytes:
    """A head and arrays as bytes."""
    line = json.dumps(head).encode("ascii") + b"\n"
    return b"".join([line, *(np.ascontiguousarray(array).tobytes() for array in arrays)])


def answer_of(parts: list[Part]) -> tuple[dict[str, Any], list[Any]]:
    """Head and arrays of an answer."""
    told = [
        {"vertices": len(part.vertices), "faces": len(part.faces), "colour": part.colour, "exact": part.exact}
        for part in parts
    ]
    arrays = [
        array
        for part in parts
        for array in (part.vertices.astype(FLOAT), part.normals.astype(FLOAT), part.faces.astype(INTEGER))
    ]
    return {"parts": told}, arrays


def head_of(line: bytes) -> dict[str, Any]:
    """The head in a line; BrokenAnswerError where it is none."""
    try:
        head = parsed(line.decode("ascii"))
    except ValueError as error:
        raise BrokenAnswerError from error
    if not isinstance(head, dict):
        raise BrokenAnswerError
    return head


def parts_of(head: dict[str, Any], read: Read) -> list[Part]:
    """The parts whose arrays follow the head; BrokenAnswerError for what no mesh comes to."""
    told = head.get("parts")
    if not isinstance(told, list) or not 0 < len(told) <= PARTS or not all(isinstance(one, dict) for one in told):
        raise BrokenAnswerError
    for what, most in (("faces", TRIANGLES), ("vertices", 3 * TRIANGLES)):
        if sum(_count(one, what) for one in told) > most:
            raise BrokenAnswerError
    return [_part(one, read) for one in told]


def _part(told: dict[str, Any], read: Read) -> Part:
    count, colour = _count(told, "vertices"), told.get("colour")
    vertices, normals = (np.frombuffer(read(24 * count), FLOAT).reshape(-1, 3) for _ in range(2))
    faces = np.frombuffer(read(24 * _count(told, "faces")), INTEGER).reshape(-1, 3)
    fitting = _within(vertices, 2 * LONGEST) and _within(normals, 2.0) and faces.min() >= 0 and faces.max() < count
    if not fitting or not (colour is None or _is_colour(colour)):
        raise BrokenAnswerError
    return Part(vertices, normals, faces, None if colour is None else tuple(colour), told.get("exact") is True)


def _count(told: dict[str, Any], what: str) -> int:
    count = told.get(what)
    if type(count) is not int or count < 1:
        raise BrokenAnswerError
    return count


def _within(values: Array, most: float) -> bool:
    return bool((np.abs(values) <= most).all())


def _is_colour(colour: Any) -> bool:
    return (
        isinstance(colour, list)
        and len(colour) == 4
        and all(type(part) in (int, float) and 0.0 <= part <= 1.0 for part in colour)
    )
