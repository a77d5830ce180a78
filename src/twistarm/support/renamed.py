"""Renamed words: those of earlier versions raise an error that names the new one, until 1.0."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn


def refuse_renamed(owner: str, name: str, renamed: Mapping[str, str]) -> AttributeError:
    """The AttributeError for a name that `owner` does not have, with the new word where it has been renamed."""
    hint = f"; it is now {renamed[name]}" if name in renamed else ""
    return AttributeError(f"{owner} has no attribute {name!r}{hint}", name=name)


class Renamed:
    """An attribute of an earlier version: asked for, it is an AttributeError that names the new word.

    A class that says so attribute by attribute keeps its other attributes as fast as they are; `__getattr__` would
    cost a tenth of every forward kinematics.
    """

    def __init__(self, now: str) -> None:
        self.now = now

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, instance: Any, owner: type) -> NoReturn:
        raise refuse_renamed(owner.__name__, self.name, {self.name: self.now})
