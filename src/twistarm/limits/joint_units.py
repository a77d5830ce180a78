"""Unit of a joint's coordinate by its type: metres for slides, radians for turns."""

from __future__ import annotations

SLIDING = frozenset({"prismatic"})
"""Types whose coordinate is a length; every other one is an angle, a helical joint's too."""


def slides(kind: str) -> bool:
    """Tell whether the coordinate of a joint of this type is a length."""
    return kind in SLIDING


def unit_of(kind: str) -> str:
    """Return `m` or `rad`."""
    return "m" if slides(kind) else "rad"
