"""Fields of files and messages. A declared `Check` checks a number, text or table called X at a place Y.

A format is a table of names and checks, which `fields` applies. Every error is an InputError that names the field, what
is allowed and what was given. `inside` adds the file and the place in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .checks import as_number, require_choice
from .errors import InputError, TwistarmError, closest, listed, quote

# What a field may hold: it makes of the value, and the field's name for errors, what the field means.
Check = Callable[[Any, str], Any]


@contextmanager
def inside(*places: object) -> Iterator[None]:
    """Name the file and the place in it in errors, as with `inside(path, "segment 3")`."""
    try:
        yield
    except TwistarmError as error:
        raise InputError(f"{', '.join(map(str, places))}: {error}") from error


def fields(
    value: Any, name: str, needed: Mapping[str, Check], optional: Mapping[str, Check] | None = None
) -> dict[str, Any]:
    """The checked fields of a table: all that are `needed`, some that are `optional`, and no others."""
    known = {**needed, **(optional or {})}
    if not isinstance(value, Mapping):
        raise InputError(f"{name} must be a table with {', '.join(known) or 'no fields'}; got {quote(value)}")
    only(value, known, name)
    if missing := [key for key in needed if key not in value]:
        raise InputError(f"{name or 'it'} needs {listed(missing)}; it has {listed(map(str, value)) or 'nothing'}")
    return {key: check(value[key], f"{name}.{key}" if name else key) for key, check in known.items() if key in value}


def only(table: Mapping[str, Any], allowed: Iterable[str], name: str = "") -> None:
    """Refuse entries of other names in a table."""
    names = tuple(allowed)
    for key in table:
        if key not in names:
            place = f" in {name}" if name else ""
            raise InputError(f"unknown entry {quote(key)}{place}{closest(key, names)} (allowed: {listed(names, 30)})")


def table_of(check: Check, least: int = 0) -> Check:
    """The check of a table of any names, at least so many, by the check of its entries."""

    def entries(value: Any, name: str) -> dict[str, Any]:
        if not isinstance(value, Mapping) or len(value) < least:
            raise InputError(f"{name} must be a table of name = value; got {quote(value)}")
        return {str(key): check(entry, f"{name}.{key}") for key, entry in value.items()}

    return entries


def list_of(check: Check, least: int = 0, most: float = inf) -> Check:
    """The check of a list of `least` to `most` entries, by the check of its entries."""

    def entries(value: Any, name: str) -> list[Any]:
        if not isinstance(value, (list, tuple)) or not least <= len(value) <= most:
            count = f" of {least:,} to {most:,} entries" if most < inf else f" of {least:,} or more" if least else ""
            raise InputError(f"{name} must be a list{count}; got {quote(value)}")
        return [check(entry, f"{name}[{k}]") for k, entry in enumerate(value)]

    return entries


def one_of(words: Sequence[str]) -> Check:
    """The check of a choice."""
    return lambda value, name: require_choice(value, words, name)


def numbers(value: Any, name: str, size: int | None = None, **bounds: Any) -> list[float]:
    """A list of numbers, `size` of them if given, each as `number` with these bounds."""
    if not isinstance(value, (list, tuple)) or (size is not None and len(value) != size):
        raise InputError(f"{name} must be a list of {'' if size is None else f'{size} '}numbers; got {quote(value)}")
    return [as_number(number, f"{name}[{k}]", **bounds) for k, number in enumerate(value)]


def vector(value: Any, name: str, size: int = 3) -> NDArray[np.float64]:
    """A list of `size` numbers as an array (size,)."""
    return np.array(numbers(value, name, size))


def text(value: Any, name: str) -> str:
    """A text."""
    if not isinstance(value, str):
        raise InputError(f"{name} must be a text; got {quote(value)}")
    return value


def word(value: Any, name: str) -> str:
    """A text that is not empty."""
    if not text(value, name).strip():
        raise InputError(f"{name} must not be empty; got {quote(value)}")
    return str(value)


def anything(value: Any, name: str) -> Any:
    """Any value: another check follows."""
    return value
