"""Fields of files and messages: a number, text or table called X at a place Y, each checked by a declared `Check`.

A format is a table of names and checks, which `fields` applies. Every error is an InputError that names the field, what
is allowed and what was given. `inside` adds the file and the place in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from math import inf, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import InputError, TwistarmError, closest, listed, shown

Check = Callable[[Any, str], Any]
"""What a field may hold: it makes of the value, and the field's name for errors, what the field means."""

LARGEST = 1e300
"""Numbers beyond are no quantity of this world, and sums of them overflow."""

LARGEST_WHOLE = 2**53 - 1
"""Up to here every reader's numbers are whole."""

LONGEST_NUMBER = 400
"""Characters of a written number."""


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
        raise InputError(f"{name} must be a table with {', '.join(known) or 'no fields'}; got {shown(value)}")
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
            raise InputError(f"unknown entry {shown(key)}{place}{closest(key, names)} (allowed: {listed(names, 30)})")


def table_of(check: Check, least: int = 0) -> Check:
    """The check of a table of any names, at least so many, by the check of its entries."""

    def entries(value: Any, name: str) -> dict[str, Any]:
        if not isinstance(value, Mapping) or len(value) < least:
            raise InputError(f"{name} must be a table of name = value; got {shown(value)}")
        return {str(key): check(entry, f"{name}.{key}") for key, entry in value.items()}

    return entries


def list_of(check: Check, least: int = 0, most: float = inf) -> Check:
    """The check of a list of `least` to `most` entries, by the check of its entries."""

    def entries(value: Any, name: str) -> list[Any]:
        if not isinstance(value, (list, tuple)) or not least <= len(value) <= most:
            count = f" of {least:,} to {most:,} entries" if most < inf else f" of {least:,} or more" if least else ""
            raise InputError(f"{name} must be a list{count}; got {shown(value)}")
        return [check(entry, f"{name}[{k}]") for k, entry in enumerate(value)]

    return entries


def one_of(words: Sequence[str]) -> Check:
    """The check of a choice."""

    def choice(value: Any, name: str) -> str:
        if not isinstance(value, str) or value not in words:
            raise InputError(f"{name} must be one of {listed(words)}; got {shown(value)}{closest(value, words)}")
        return value

    return choice


def number(value: Any, name: str, least: float = -LARGEST, most: float = LARGEST, unit: str = "") -> float:
    """A number in [least, most], which is infinite only where these are. NaN, booleans and texts are refused."""
    real = nan
    if isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool):
        with suppress(OverflowError):  # an integer may be beyond the floats
            real = float(value)
    return _within(real, value, name, least, most, unit)


def number_in(text: str, name: str, least: float = -LARGEST, most: float = LARGEST, unit: str = "") -> float:
    """The number that a text of XML or CSV holds, as `number`.

    Python's 1_000 and digits of other scripts, which other readers refuse, are refused.
    """
    real = nan
    if text.isascii() and "_" not in text and len(text) <= LONGEST_NUMBER:
        with suppress(ValueError):
            real = float(text)
    return _within(real, text, name, least, most, unit)


def _within(real: float, given: Any, name: str, least: float, most: float, unit: str) -> float:
    if least <= real <= most:  # False for NaN
        return real
    low, high = least > -LARGEST, most < LARGEST
    size = f" from {least:g} to {most:g}" if low and high else f", {least:g} or more" if low else ""
    size = f", {most:g} or less" if high and not low else size
    kind = "a number" if least == -inf or most == inf else "a finite number"
    point = "; decimals have a point" if isinstance(given, str) and given.count(",") == 1 else ""
    raise InputError(f"{name} must be {kind}{size}{unit and f' [{unit}]'}; got {shown(given)}{point}")


def positive(value: Any, name: str, most: float = LARGEST, unit: str = "") -> float:
    """A number above 0."""
    real = number(value, name, 0.0, most, unit)
    if real == 0.0:
        raise InputError(f"{name} must be above 0; got {shown(value)}")
    return real


def numbers(value: Any, name: str, size: int | None = None, **bounds: Any) -> list[float]:
    """A list of numbers, `size` of them if given, each as `number` with these bounds."""
    if not isinstance(value, (list, tuple)) or (size is not None and len(value) != size):
        raise InputError(f"{name} must be a list of {'' if size is None else f'{size} '}numbers; got {shown(value)}")
    return [number(each, f"{name}[{k}]", **bounds) for k, each in enumerate(value)]


def vector(value: Any, name: str, size: int = 3) -> NDArray[np.float64]:
    """A list of `size` numbers as an array (size,)."""
    return np.array(numbers(value, name, size))


def whole(value: Any, name: str, least: int = 0, most: int = LARGEST_WHOLE) -> int:
    """A whole number in [least, most]."""
    if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
        raise InputError(f"{name} must be a whole number from {least} to {most}; got {shown(value)}")
    return value


def flag(value: Any, name: str) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise InputError(f"{name} must be true or false; got {shown(value)}")
    return value


def text(value: Any, name: str) -> str:
    """A text."""
    if not isinstance(value, str):
        raise InputError(f"{name} must be a text; got {shown(value)}")
    return value


def word(value: Any, name: str) -> str:
    """A text that is not empty."""
    if not text(value, name).strip():
        raise InputError(f"{name} must not be empty; got {shown(value)}")
    return str(value)


def anything(value: Any, name: str) -> Any:
    """Any value: another check follows."""
    return value
