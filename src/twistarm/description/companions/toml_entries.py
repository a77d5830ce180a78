"""Entries of an arm.toml, checked and written. Errors name the entry and the allowed values."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...support.errors import DescriptionError, InputError
from ..document import LARGEST, read_text
from ..findings import Place, refusal

MAX_BYTES, MAX_LINE = 64_000, 2_000
"""An arm.toml has some 5 kB. TOML's reader takes seconds for a dotted key that fills a longer line."""


def unusable(path: Path, what: str, remedy: str = "") -> DescriptionError:
    """The error for an unusable file or entry."""
    return refusal("arm-file-unusable", Place(str(path)), what, remedy)


def parse_toml(path: Path, what: str = "an arm.toml") -> dict[str, Any]:
    """The content of the file. DescriptionError, which names `what` it should be, if it is not TOML or too large."""
    return toml_content(read_text(path, MAX_BYTES), path, what)


def toml_content(text: str, path: Path, what: str = "an arm.toml") -> dict[str, Any]:
    """The content of such a text."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    if max(map(len, text.splitlines()), default=0) > MAX_LINE:
        raise unusable(path, f"a line of more than {MAX_LINE:,} characters", f"break it; is it {what}?")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise unusable(path, "not valid TOML: it nests too deep", f"is it {what}?") from error
    except ValueError as error:  # TOMLDecodeError is one; so is Python's for an integer of too many digits
        raise unusable(path, f"not valid TOML: {error}", "correct it there") from error


def text_of(value: Any, place: str) -> str:
    """The value, if it is a text that is not empty."""
    if not isinstance(value, str):
        raise InputError(f"{place} must be a text; got {value!r}")
    if not value.strip():
        raise InputError(f"{place} must not be empty; got {value!r}")
    return value


def table_of(content: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """The table `key`, empty if there is none."""
    table = content.get(key, {})
    if not isinstance(table, dict):
        raise InputError(f"{key} must be a table of name = value; got {table!r}")
    return table


def numbers_of(table: Mapping[str, Any], place: str) -> dict[str, float]:
    """Numbers by name."""
    return {name: number_of(value, f"{place}.{name}") for name, value in table.items()}


def number_of(value: Any, place: str, unit: str = "rad or m") -> float:
    """A number, infinity too."""
    try:
        number = np.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = np.nan
    if np.isnan(number):
        raise InputError(f"{place} must be a number ({unit}); got {str(value)[:60]!r}")
    return number


def bounded(value: Any, place: str, wanted: str = "finite") -> float:
    """A number of a size that robots have."""
    number = number_of(value, place)
    if not abs(number) <= LARGEST:
        allowed = f"at most {LARGEST:g} in size" if np.isfinite(number) else wanted
        raise InputError(f"{place} must be {allowed}; got {number:g}")
    return number


def toml_key(name: str) -> str:
    """A key: bare where TOML allows that, else quoted."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else toml_text(name)


def toml_text(text: str) -> str:
    """A TOML string; JSON's escapes are TOML's, except delete."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
