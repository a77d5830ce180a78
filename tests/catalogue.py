"""Arms of the catalogue, each loaded once for the whole run."""

from __future__ import annotations

import twistarm

_LOADED: dict[str, twistarm.Arm] = {}


def load(name: str) -> twistarm.Arm:
    """The arm of that name."""
    if name not in _LOADED:
        _LOADED[name] = twistarm.load_arm(name)
    return _LOADED[name]
