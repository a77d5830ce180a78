"""Entries of a TOML file, checked. Errors name the file, the place and what is allowed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .checks import Array, as_floats, as_number
from .errors import InputError, TwistarmError, closest, listed, shown


@contextmanager
def at(path: Path, place: str) -> Iterator[None]:
    """Name the file and the place in errors."""
    try:
        yield
    except TwistarmError as error:
        raise InputError(f"{path}, {place}: {error}") from error
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, StopIteration, RuntimeError) as error:
        raise InputError(f"{path}, {place}: an entry is missing or of the wrong kind ({error})") from error


def only(table: Mapping[str, Any], allowed: Iterable[str], place: str = "") -> None:
    """Refuse entries of other names, at a place such as " in limits"."""
    names = tuple(allowed)
    for key in table:
        if key not in names:
            raise InputError(f"unknown entry {key!r}{place}{closest(key, names)} (allowed: {listed(names, 20)})")


def real(value: Any, name: str) -> float:
    """Return a finite number. Booleans are refused."""
    if isinstance(value, bool):
        raise InputError(f"{name} must be a number; got {str(value).lower()}")
    return as_number(value, name)


def three(table: Mapping[str, Any], name: str) -> Array:
    """Three numbers [x, y, z]."""
    numbers = as_floats(table[name], name)
    if numbers.shape != (3,):
        raise InputError(f"{name} must be three numbers, as in [0.5, 0.0, 0.6]; got {shown(table[name])}")
    return numbers
