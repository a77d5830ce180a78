"""Numbers as every reader of URDF takes them, of a size that robots have."""

from __future__ import annotations

import numpy as np

LARGEST = 1e9
"""No length, angle, mass or multiplier of a robot comes near; beyond it products overflow."""

MAX_NUMBER = 400
"""Characters of a number."""


def floats(text: str, count: int) -> list[float]:
    """Exactly `count` numbers of a size that robots have, or ValueError."""
    words = text.split(maxsplit=count)
    values = [number(word) for word in words] if text.isascii() and len(words) == count else []
    if len(values) != count or not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"{count} finite numbers expected, none beyond {LARGEST:g}; got {text[:60]!r}")
    return values


def number(word: str) -> float:
    """A number as every reader of URDF takes it, without Python's 1_000 or other scripts' digits."""
    if not word.isascii() or "_" in word or len(word) > MAX_NUMBER:
        raise ValueError(f"no number: {word[:60]!r}")
    return float(word)
