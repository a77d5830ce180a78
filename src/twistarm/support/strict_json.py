"""JSON from outside, read strictly: one object, finite numbers, no name twice, nothing long."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from .errors import InputError, listed, one_line, shown

LARGEST_MESSAGE = 64 * 1024
"""Bytes of a message: a joint state of a thousand joints is half of it."""

LARGEST_NUMBER = 1e300
"""Numbers beyond mean nothing, and an integer may be beyond the floats."""

LARGEST_COUNTER = 2**53
"""Counters stay below, where every reader's numbers are whole."""

Check = Callable[[Any, str], Any]
"""What a field may hold: it makes of the value, and the field's name for words, what the field means, or InputError."""

_ENCODER = json.JSONEncoder(allow_nan=False, separators=(",", ":"))
"""Made once: making it takes a tenth of the time that a frame of the view takes to encode."""


def encode(message: Mapping[str, Any]) -> str:
    """A message as one line of JSON; NaN and infinity are refused rather than written."""
    return _ENCODER.encode(message)


def decoded(text: str | bytes) -> dict[str, Any]:
    """The JSON object that `text` holds, UTF-8 where it is bytes. Raises InputError for anything else."""
    if not isinstance(text, (str, bytes)):
        raise InputError(f"a message is a text or bytes; got {shown(text)}")
    if len(text) > LARGEST_MESSAGE:
        raise InputError(f"a message has at most {LARGEST_MESSAGE} bytes; got {len(text)}")
    try:
        message = parsed(text.decode("utf-8") if isinstance(text, bytes) else text)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"a message is one JSON object; {short(error)}: {short(text)}") from error
    if not isinstance(message, dict):
        raise InputError(f"a message is one JSON object; got {short(message)}")
    return message


DIGITS = 400
"""The most digits of an integer; the largest float has 309."""


def parsed(text: str) -> Any:
    """The value of a JSON text.

    Raises ValueError, in one line, for text that is no JSON, a name that is twice in an object, a number beyond the
    floats, or too deep nesting.
    """
    try:
        return json.loads(text, parse_int=_integer, parse_constant=_no_constant, object_pairs_hook=_once)
    except RecursionError as error:
        raise ValueError("it nests too deep") from error


def fields(
    message: Any, what: str, needed: Mapping[str, Check], optional: Mapping[str, Check] | None = None
) -> dict[str, Any]:
    """The checked fields of a message: all required ones, and no unknown ones."""
    known = {**needed, **(optional or {})}
    if not isinstance(message, Mapping) or not needed.keys() <= message.keys() <= known.keys():
        also = f" and may have {', '.join(optional)}" if optional else ""
        got = sorted(message) if isinstance(message, Mapping) else message
        raise InputError(f"{what} needs {', '.join(needed) or 'no fields'}{also}; got {short(got)}")
    return {name: check(message[name], name) for name, check in known.items() if name in message}


def one_of(words: Sequence[str]) -> Check:
    """The check of a choice."""

    def check(value: Any, name: str) -> str:
        if value not in words:
            raise InputError(f"{name} must be one of {listed(words)}; got {short(value)}")
        return str(value)

    return check


def list_of(each: Check) -> Check:
    """A check for a list by the check of its entries."""

    def check(value: Any, name: str) -> list[Any]:
        if not isinstance(value, list):
            raise InputError(f"{name} must be a list; got {short(value)}")
        return [each(entry, f"{name}[{k}]") for k, entry in enumerate(value)]

    return check


def numbers(value: Any, name: str, size: int | None = None, largest: float = LARGEST_NUMBER) -> list[float]:
    """A list of numbers, `size` of them if given, each at most `largest` in size."""
    if not isinstance(value, list) or (size is not None and len(value) != size):
        raise InputError(f"{name} must be a list of {'' if size is None else f'{size} '}numbers; got {short(value)}")
    return [number(each, f"{name}[{k}]", largest) for k, each in enumerate(value)]


def number(value: Any, name: str, largest: float = LARGEST_NUMBER) -> float:
    """A finite number, at most `largest` in size."""
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        raise InputError(f"{name} must be a number; got {short(value)}")
    if not abs(value) <= largest:  # infinity and NaN alike
        raise InputError(f"{name} must be finite and at most {largest:g} in size; got {short(value)}")
    return float(value)


def counter(value: Any, name: str) -> int:
    """A whole number from 0 on."""
    if not isinstance(value, int) or isinstance(value, bool) or not 0 <= value < LARGEST_COUNTER:
        raise InputError(f"{name} must be a whole number from 0 on, below 2^53; got {short(value)}")
    return value


def text(value: Any, name: str) -> str:
    """A string."""
    if not isinstance(value, str):
        raise InputError(f"{name} must be text; got {short(value)}")
    return value


def flag(value: Any, name: str) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise InputError(f"{name} must be true or false; got {short(value)}")
    return value


def short(value: Any) -> str:
    """`value` in a few words on one line."""
    try:
        words = str(value) if isinstance(value, BaseException) else repr(value)
    except (ValueError, RecursionError):  # an integer of thousands of digits has no decimal text
        words = type(value).__name__
    return one_line(words, 80)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    message = dict(pairs)
    if len(message) != len(pairs):
        raise InputError(f"an object has each name once; got {short([name for name, _ in pairs])}")
    return message


def _integer(text: str) -> int:
    if len(text) > DIGITS:  # Python refuses long ones in words for programmers
        raise InputError(f"numbers must be finite; got one of {len(text):,} digits")
    return int(text)


def _no_constant(name: str) -> float:
    raise InputError(f"numbers must be finite; got {name}")
