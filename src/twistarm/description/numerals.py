"""Numbers that every reader of URDF takes, within the size of robots."""

from __future__ import annotations

import numpy as np

LARGEST = 1e9
"""Far above any length, angle, mass or multiplier of a robot. Products of larger numbers overflow."""

MAX_NUMBER = 400
"""Characters of a number."""


def floats(text: str, count: int) -> list[float]:
    """Exactly `count` numbers of at most LARGEST in size, or ValueError."""
    words = text.split(maxsplit=count)
    values = [number(word) for word in words] if text.isascii() and len(words) == count else []
    if len(values) != count or not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"{count} finite numbers expected, none beyond {LARGEST:g}; got {text[:60]!r}")
    return values


def number(word: str) -> float:
    """A number that every reader of URDF takes. Python's 1_000 and digits of other scripts are refused."""
    if not word.isascii() or "_" in word or len(word) > MAX_NUMBER:
        raise ValueError(f"no number: {word[:60]!r}")
    return float(word)
