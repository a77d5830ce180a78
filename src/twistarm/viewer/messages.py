"""The messages between page and process: one schema, checked on arrival, finite numbers only."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..errors import InputError
from ..strict_json import counter, decoded, flag, number, numbers, short, text

LARGEST_VALUE = 1e6
"""Joint values beyond this [rad, m] come from no page and no arm, and would overflow the drawing."""

LONGEST_NAME = 1000
"""Characters; a description may hold stranger names, but an error must stay readable."""


@dataclass(frozen=True)
class Request:
    """What a page asks for: its kind, the fields of that kind, and the number that its `done` carries back."""

    kind: str
    fields: Mapping[str, Any]
    number: int


def parse(message: str | bytes) -> Request:
    """The request in a message of the page.

    {"type": "theta", "theta": [...]}   {"type": "joint", "name": ..., "value": ...}   {"type": "pose", "name": ...}
    {"type": "random"}
    {"type": "play"}   {"type": "pause"}   {"type": "seek", "time": ...}
    {"type": "visible", "what": "screws"|"frames"|"path", "visible": true|false}
    {"type": "jog", "twist": [vx, vy, vz, wx, wy, wz], "frame": "tool"|"base"}   {"type": "stop"}
    each with "number", a counter. Values in rad, m and s. Raises InputError for anything else.
    """
    if isinstance(message, bytes):
        raise InputError("a message is JSON text; got bytes")
    fields = decoded(message)
    kind = fields.pop("type", None)
    if not isinstance(kind, str) or kind not in FIELDS:
        raise InputError(f"unknown message type {short(kind)}; one of {', '.join(FIELDS)}")
    count = counter(fields.pop("number", 0), "number")
    expected = FIELDS[kind]
    if set(fields) != set(expected):
        raise InputError(f"{kind} needs {', '.join(expected) or 'no fields'}; got {short(sorted(fields))}")
    return Request(kind, {name: check(fields[name], name) for name, check in expected.items()}, count)


def _name(value: Any, name: str) -> str:
    given = text(value, name)
    if len(given) > LONGEST_NAME:
        raise InputError(f"{name} must have at most {LONGEST_NAME} characters; got {len(given)}")
    return given


_number = partial(number, largest=LARGEST_VALUE)
_numbers = partial(numbers, largest=LARGEST_VALUE)

FIELDS: Mapping[str, Mapping[str, Callable[[Any, str], Any]]] = {
    "theta": {"theta": _numbers},
    "joint": {"name": _name, "value": _number},
    "pose": {"name": _name},
    "random": {},
    "play": {},
    "pause": {},
    "seek": {"time": _number},
    "visible": {"what": _name, "visible": flag},
    "jog": {"twist": _numbers, "frame": _name},
    "stop": {},
}
