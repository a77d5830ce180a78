"""Requests of the page made from its schema: as they should be, and spoilt in every way that somebody thought of."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from math import isfinite
from typing import Any

from twistarm.viewer.messages import LONGEST_NAME, SCHEMA

GOOD: dict[str, Any] = {
    "number": 0.5,
    "numbers": [0.1, -0.2],
    "point": [0.1, 0.2, 0.3],
    "quaternion": [0.0, 0.0, 0.0, 1.0],
    "count": 3,
    "flag": True,
    "name": "somebody",
    "names": ["a", "b"],
    "poses": [{"name": "a", "theta": [0.0, 1.0]}],
}
"""What each word of the schema lets through."""

SCALARS = (None, {}, {"a": 1}, [[]], [None])
NUMBERS = ("1", True, float("nan"), float("inf"), 1e7, 10**400, "\ud800")
LISTS = (1, "1, 2", True, ["1"], [True], [float("nan")], [float("-inf")], [1e7], [10**400], [[1.0]], [{}])

BAD: dict[str, tuple[Any, ...]] = {
    "number": (*NUMBERS, []),
    "numbers": LISTS,
    "point": (*LISTS, [], [1, 2], [1, 2, 3, 4], [0.0] * 9000),
    "quaternion": (*LISTS, [], [1, 2, 3], [0, 0, 0, 1, 0]),
    "count": (-1, 0.5, 2**53, 10**30, "1", True, float("nan"), []),
    "flag": (0, 1, "true", 1.0, []),
    "name": (0, True, [], ["a"], "x" * (LONGEST_NAME + 1)),
    "names": ("a", [1], [["a"]], ["a", None], ["x" * (LONGEST_NAME + 1)]),
    "poses": (
        "a",
        [1],
        [["a", [0]]],
        [{}],
        [{"name": "a"}],
        [{"name": "a", "theta": "0"}],
        [{"name": 1, "theta": [0]}],
        [{"name": "a", "theta": [float("nan")]}],
        [{"name": "a", "theta": [0], "more": 1}],
    ),
}
"""What it does not, beside SCALARS."""


def good(word: str) -> Any:
    """A value that the word lets through."""
    return word.split("|")[0] if "|" in word else GOOD[word]


def bad(word: str) -> tuple[Any, ...]:
    """Values that it does not."""
    return (*SCALARS, *((0, "", "POSE", [word], word) if "|" in word else BAD[word]))


def request(kind: str) -> dict[str, Any]:
    """A request as the schema has it."""
    return {"type": kind, **{field: good(word) for field, word in SCHEMA["requests"][kind].items()}}


def spoilt(kind: str) -> Iterator[str | bytes]:
    """Messages that look like a request of this kind and are none."""
    whole = request(kind)
    text = json.dumps(whole)
    yield from (text[:cut] for cut in range(len(text)))
    yield text.encode()
    yield text + text
    yield text + "}"
    yield f"[{text}]"
    yield text[:-1] + f', "type": "{kind}"}}'  # a name twice
    yield text[:-1] + ', "more": 1}'
    yield text[:-1] + ', "more": ' + "[" * 20_000 + "]" * 20_000 + "}"
    yield text[:-1] + ', "\\ud800": 1}'
    for number in (-1, 0.5, "1", None, True, 2**53, [], float("nan")):
        yield json.dumps({**whole, "number": number})
    for name in ("", kind.upper(), kind + "\u0000", 1, None, [kind], {}):
        yield json.dumps({**whole, "type": name})
    for field, word in SCHEMA["requests"][kind].items():
        yield json.dumps({name: value for name, value in whole.items() if name != field})
        for value in bad(word):
            yield json.dumps({**whole, field: value})


FITS: dict[str, Callable[[Any], bool]] = {
    "number": lambda value: type(value) in (int, float) and isfinite(value),
    "numbers": lambda value: isinstance(value, list) and all(map(FITS["number"], value)),
    "list": lambda value: isinstance(value, list),
    "object": lambda value: isinstance(value, dict),
    "text": lambda value: isinstance(value, str),
    "name": lambda value: isinstance(value, str) and len(value) <= LONGEST_NAME,
    "count": lambda value: type(value) is int and 0 <= value < 2**53,
    "flag": lambda value: isinstance(value, bool),
}


def complaint(message: dict[str, Any]) -> str:
    """What the page would say against a message of the process."""
    fields = SCHEMA["messages"].get(message["type"])
    if fields is None or set(message) - {"type"} != set(fields):
        return f"{message['type']}: {sorted(message)}"
    wrong = [name for name, word in fields.items() if not _fits(word, message[name])]
    return f"{message['type']}: {wrong}" if wrong else ""


def _fits(word: str, value: Any) -> bool:
    if word.endswith("?"):
        return value is None or _fits(word[:-1], value)
    return value in word.split("|") if "|" in word else FITS[word](value)
