"""JSON from outside, read strictly: one object, finite numbers, no name twice, nothing long. See `fields`, too."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from .errors import QUOTED, InputError, one_line, quote

LARGEST_MESSAGE = 64 * 1024  # Bytes of a message: a joint state of a thousand joints is half of it.
# Made once: making it takes a tenth of the time that a frame of the view takes to encode.
_ENCODER = json.JSONEncoder(allow_nan=False, separators=(",", ":"))


def encode(message: Mapping[str, Any]) -> str:
    """A message as one line of JSON. NaN and infinity are refused rather than written."""
    return _ENCODER.encode(message)


def decoded(text: str | bytes) -> dict[str, Any]:
    """The JSON object that `text` holds, UTF-8 where it is bytes. Raises InputError for anything else."""
    if not isinstance(text, (str, bytes)):
        raise InputError(f"a message is a text or bytes; got {quote(text)}")
    if len(text) > LARGEST_MESSAGE:
        raise InputError(f"a message has at most {LARGEST_MESSAGE} bytes; got {len(text)}")
    try:
        message = parsed(text.decode("utf-8") if isinstance(text, bytes) else text)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(f"a message is one JSON object; {one_line(str(error), QUOTED)}: {quote(text)}") from error
    if not isinstance(message, dict):
        raise InputError(f"a message is one JSON object; got {quote(message)}")
    return message


def parsed(text: str) -> Any:
    """The value of a JSON text.

    Raises ValueError, in one line, for text that is no JSON. So it does for a name that is twice in an object, NaN,
    Infinity, and too deep nesting. A number beyond the floats is left to the reader of fields.
    """
    try:
        return json.loads(text, parse_constant=_no_constant, object_pairs_hook=_once)
    except RecursionError as error:
        raise ValueError("it nests too deep") from error
    except ValueError as error:
        # Python's own words for an integer of thousands of digits are for programmers.
        if "integer string conversion" in str(error):
            raise InputError("numbers must be finite; got one of thousands of digits") from error
        raise


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    message = dict(pairs)
    if len(message) != len(pairs):
        raise InputError(f"an object has each name once; got {quote([name for name, _ in pairs])}")
    return message


def _no_constant(name: str) -> float:
    raise InputError(f"numbers must be finite; got {name}")
