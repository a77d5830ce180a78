"""The messages between page and process: one schema, checked on arrival, finite numbers only."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError

LARGEST_VALUE = 1e6
"""Joint values beyond this [rad, m] come from no page and no arm, and would overflow the drawing."""

LONGEST_NAME = 1000
"""Characters; a description may hold stranger names, but an error must stay readable."""

LARGEST_MESSAGE = 64 * 1024
"""Bytes a page may send at once: a theta of a thousand joints is a third of it."""


@dataclass(frozen=True)
class Request:
    """What a page asks for: its kind, the fields of that kind, and the number that its `done` carries back."""

    kind: str
    fields: Mapping[str, Any]
    number: int


def encode(message: Mapping[str, Any]) -> str:
    """A message as JSON text; NaN and infinity are refused rather than written."""
    return json.dumps(message, allow_nan=False, separators=(",", ":"))


def parse(text: str | bytes) -> Request:
    """The request in a message of the page.

    {"type": "theta", "theta": [...]}   {"type": "joint", "name": ..., "value": ...}   {"type": "pose", "name": ...}
    {"type": "play"}   {"type": "pause"}   {"type": "seek", "time": ...}
    {"type": "visible", "what": "screws"|"frames"|"path", "visible": true|false}
    {"type": "jog", "twist": [vx, vy, vz, wx, wy, wz], "frame": "tool"|"base"}   {"type": "stop"}
    each with "number", a counter. Values in rad, m and s. Raises InputError for anything else.
    """
    message = _decoded(text)
    kind = message.pop("type", None)
    if not isinstance(kind, str) or kind not in FIELDS:
        raise InputError(f"unknown message type {_short(kind)}; one of {', '.join(FIELDS)}")
    number = message.pop("number", 0)
    if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < 2**53:
        raise InputError(f"number must be a counter; got {_short(number)}")
    expected = FIELDS[kind]
    if set(message) != set(expected):
        raise InputError(f"{kind} needs {', '.join(expected) or 'no fields'}; got {_short(sorted(message))}")
    return Request(kind, {name: check(message[name], name) for name, check in expected.items()}, number)


def _decoded(text: str | bytes) -> dict[str, Any]:
    if isinstance(text, bytes):
        raise InputError("a message is JSON text; got bytes")
    try:
        message = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise InputError(f"a message is a JSON object; {type(error).__name__}: {_short(error)}") from error
    if not isinstance(message, dict):
        raise InputError(f"a message is a JSON object; got {_short(message)}")
    return message


def _no_constant(name: str) -> float:
    raise InputError(f"numbers must be finite; got {name}")


def _number(value: Any, name: str) -> float:
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise InputError(f"{name} must be a number; got {_short(value)}")
    if not abs(value) <= LARGEST_VALUE:
        raise InputError(f"{name} must be finite and at most {LARGEST_VALUE:g} in size; got {_short(value)}")
    return float(value)


def _numbers(value: Any, name: str) -> list[float]:
    if not isinstance(value, list):
        raise InputError(f"{name} must be a list of numbers; got {_short(value)}")
    return [_number(item, f"{name}[{i}]") for i, item in enumerate(value)]


def _name(value: Any, name: str) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} must be a string; got {_short(value)}")
    if len(value) > LONGEST_NAME:
        raise InputError(f"{name} must have at most {LONGEST_NAME} characters; got {len(value)}")
    return value


def _flag(value: Any, name: str) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"{name} must be true or false; got {_short(value)}")
    return value


FIELDS: Mapping[str, Mapping[str, Callable[[Any, str], Any]]] = {
    "theta": {"theta": _numbers},
    "joint": {"name": _name, "value": _number},
    "pose": {"name": _name},
    "play": {},
    "pause": {},
    "seek": {"time": _number},
    "visible": {"what": _name, "visible": _flag},
    "jog": {"twist": _numbers, "frame": _name},
    "stop": {},
}


def _short(value: Any) -> str:
    try:
        text = repr(value) if not isinstance(value, BaseException) else str(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits has no decimal text
        text = type(value).__name__
    return text if len(text) <= 80 else text[:77] + "…"
