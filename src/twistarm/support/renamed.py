"""Renamed words: those of earlier versions raise an error that names the new one, until 1.0."""

from __future__ import annotations

from collections.abc import Mapping


def refuse_renamed(owner: str, name: str, renamed: Mapping[str, str]) -> AttributeError:
    """The AttributeError for a name that `owner` does not have, with the new word where it has been renamed."""
    hint = f"; it is now {renamed[name]}" if name in renamed else ""
    return AttributeError(f"{owner} has no attribute {name!r}{hint}", name=name)
