"""Messages between page and process, checked on both sides by page/schema.json, and the changes to send."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.resources import files
from typing import Any

import numpy as np

from ..support.checks import as_flag, as_number, as_whole
from ..support.errors import InputError, TwistarmError, quote, without_places
from ..support.fields import Check, fields, list_of, numbers, one_of
from ..support.messages import Argument, Quantity, Value, rendered
from ..support.strict_json import decoded, encode

Message = dict[str, Any]  # A message to the pages: its `type`, and the fields of that type in the schema.
# Greatest joint values [rad, m]. Larger ones come from no arm and would overflow the drawing.
LARGEST_VALUE = 1e6
LONGEST_NAME = 1000  # Most characters of a name, so that an error stays readable.


@dataclass(frozen=True)
class PageRequest:
    """A page's request: its kind, its fields, and the number for its `done`."""

    kind: str
    fields: Mapping[str, Any]
    number: int


def parse(message: str | bytes) -> PageRequest:
    """The request in a page's message: {"type": kind, fields of REQUESTS, "number": a counter}.

    Values are in rad, m and s. Raises InputError for anything else.
    """
    if isinstance(message, bytes):
        raise InputError("a message is JSON text; got bytes")
    content = decoded(message)
    kind = content.pop("type", None)
    if not isinstance(kind, str) or kind not in REQUESTS:
        raise InputError(f"unknown message type {quote(kind)}; one of {', '.join(REQUESTS)}")
    count = as_whole(content.pop("number", 0), "number")
    return PageRequest(kind, fields(content, "", REQUESTS[kind]), count)


def number_of(message: str | bytes) -> int | None:
    """The number of a message that `parse` refuses, or None."""
    try:
        fields = json.loads(message)
        return as_whole(fields["number"], "number") if isinstance(fields, dict) else None
    except (ValueError, KeyError, RecursionError):
        return None


FIELDS = {
    "position_tol": "Tolerance in the Move panel",
    "orientation_tol": "the angle beside Tolerance in the Move panel",
    "torques": "Torque limits in the Poses panel",
    "scene": "the layer Collision",
}
"""The page's field for each argument of a message that a page can set."""


def page_words(message: str) -> str:
    """A message in degrees, with the page's fields for arguments and the remedies that a page offers."""
    text: str = rendered(message, _written, FIELDS.__contains__)
    return text


def words_of(error: Exception) -> str:
    """An error's message in the words of the page."""
    return page_words(error.message if isinstance(error, TwistarmError) else str(error)) or type(error).__name__


def _written(value: Value) -> str:
    if not isinstance(value, Argument):
        return value.in_degrees()
    field = FIELDS.get(value.name)
    if field is None:  # who started the page typed arguments or options
        return f"{value} (or its option) when you start the view"
    return f"{field}: {value.value.in_degrees()}" if isinstance(value.value, Quantity) else field


def failure(error: Exception) -> Message:
    """The message that tells of an error."""
    return {"type": "error", "message": without_places(words_of(error))}


def packed(values: Any, kind: str) -> str:
    """Numbers in base64, as `kind`, such as "<f4"."""
    return base64.b64encode(np.asarray(values).astype(kind).tobytes()).decode("ascii")


def as_name(value: Any, name: str) -> str:
    """`value` as text that is short enough for a page."""
    if not isinstance(value, str) or len(value) > LONGEST_NAME:
        raise InputError(f"{name} must be text of at most {LONGEST_NAME} characters; got {quote(value)}")
    return value


def _pose(value: Any, name: str) -> dict[str, Any]:
    return fields(value, name, {"name": as_name, "theta": _numbers}, {"by": as_name})


_number = partial(as_number, least=-LARGEST_VALUE, most=LARGEST_VALUE)
_numbers = partial(numbers, least=-LARGEST_VALUE, most=LARGEST_VALUE)

CHECKS: Mapping[str, Check] = {
    "number": _number,
    "numbers": _numbers,
    "point": partial(_numbers, size=3),
    "quaternion": partial(_numbers, size=4),
    "count": as_whole,
    "flag": as_flag,
    "name": as_name,
    "names": list_of(as_name),
    "poses": list_of(_pose),
}
"""Checks of a request by the schema's words. A | separates the words of a choice."""


def _check(word: str) -> Check:
    return one_of(word.split("|")) if "|" in word else CHECKS[word]


SCHEMA: Mapping[str, Mapping[str, Mapping[str, str]]] = json.loads(
    files(__package__).joinpath("page").joinpath("schema.json").read_text("utf-8")
)

REQUESTS = {kind: {name: _check(word) for name, word in fields.items()} for kind, fields in SCHEMA["requests"].items()}


# Returns what a part of the view shows now. A returned message never changes.
Source = Callable[[], Iterable[Message]]


class ChangePublisher:
    """Keeps what the pages know. A failing source keeps its last messages. Its error is reported once."""

    def __init__(self) -> None:
        self._messages: dict[str, Message] = {}
        self._texts: dict[str, str] = {}
        self._failing: dict[int, str] = {}

    def gather(self, sources: Sequence[Source]) -> dict[str, str]:
        """The texts of changes since the last call, by type, and the error of a failing source."""
        changed: dict[str, str] = {}
        for place, source in enumerate(sources):
            self._gather_from(place, source, changed)
        return changed

    def everything(self) -> dict[str, str]:
        """The texts for a new page, by type."""
        texts = dict(self._texts)
        if self._failing:
            *_, texts["error"] = self._failing.values()
        return texts

    def _gather_from(self, place: int, source: Source, changed: dict[str, str]) -> None:
        try:
            for message in source():
                kind = message["type"] + message.get("node", "")  # of one type there is one for each node
                if self._messages.get(kind) != message:
                    self._texts[kind] = changed[kind] = encode(message)
                    self._messages[kind] = message
            self._failing.pop(place, None)
        except Exception as error:
            if place not in self._failing:
                self._failing[place] = changed["error"] = encode(failure(error))
