"""The named configuration of a description to start from."""

from __future__ import annotations

from collections.abc import Iterable

USUAL_NAMES = ("ready", "home", "default", "rest", "stowed")
"""Usual names of the ready configuration, the most likely first."""


def named_ready(names: Iterable[str]) -> str | None:
    """The given name that comes first in `USUAL_NAMES`, or None. Case does not count, but exact case wins."""
    given = sorted(names, key=lambda name: name not in USUAL_NAMES)
    for usual in USUAL_NAMES:
        for name in given:
            if name.strip().casefold() == usual:
                return name
    return None
