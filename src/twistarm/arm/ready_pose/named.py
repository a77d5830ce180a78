"""The named posture of a description that is the one to start from."""

from __future__ import annotations

from collections.abc import Iterable

USUAL_NAMES = ("ready", "home", "default", "rest", "stowed")
"""What descriptions call the posture that an arm waits in, the likeliest first."""


def named_ready(names: Iterable[str]) -> str | None:
    """The first name of `USUAL_NAMES` in any capitals (exact ones first), or None."""
    given = sorted(names, key=lambda name: name not in USUAL_NAMES)
    for usual in USUAL_NAMES:
        for name in given:
            if name.strip().casefold() == usual:
                return name
    return None
