"""Plain data as YAML that every reader takes alike, of YAML 1.1 and 1.2."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isinf
from typing import Any

ON_A_LINE = 2
"""Entries of a mapping that fit a line."""


def block(value: Mapping[str, Any], indent: str = "") -> Iterator[str]:
    """The lines of a mapping, one entry each: long and nested values below the name, others beside it."""
    for key, entry in value.items():
        if isinstance(entry, Mapping) and (len(entry) > ON_A_LINE or any(map(_nests, entry.values()))):
            yield f"{indent}{scalar(key)}:"
            yield from block(entry, f"{indent}  ")
        elif isinstance(entry, list) and entry and isinstance(entry[0], Mapping):
            yield f"{indent}{scalar(key)}:"
            for each in entry:
                first, *rest = block(each, f"{indent}  ")
                yield f"{indent}- {first.lstrip()}"
                yield from rest
        else:
            yield f"{indent}{scalar(key)}: {flow(entry)}"


def _nests(value: Any) -> bool:
    return isinstance(value, (Mapping, list))


def flow(value: Any) -> str:
    """A value on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{scalar(key)}: {flow(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(flow, value)) + "]"
    return scalar(value)


def scalar(value: bool | int | float | str) -> str:
    """A boolean, number or text; a text in quotes unless it is an unambiguous word."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        if isinf(value):
            return "-.inf" if value < 0 else ".inf"
        number = repr(value)
        # Without the point YAML 1.1 takes 1e-05 for a text.
        return number if "." in number or "e" not in number else number.replace("e", ".0e")
    plain = value.isascii() and value.replace("_", "").isalpha() and value.lower() not in _MEANT_OTHERWISE
    return value if plain else '"' + "".join(map(_character, value)) + '"'


_MEANT_OTHERWISE = {"y", "n", "yes", "no", "on", "off", "true", "false", "null"}


def _character(character: str) -> str:
    if character in '"\\':
        return f"\\{character}"
    if character.isprintable():
        return character
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
