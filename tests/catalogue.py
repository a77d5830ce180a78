"""Arms of the catalogue, each loaded once for the whole run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import twistarm
from twistarm.description.catalog import robots_dir
from twistarm.description.document import note_file, noted_files
from twistarm.description.expansion.expand import Expanded, expand_xacro

_EXPANDED: dict[str, tuple[Expanded, set[Path]]] = {}
_LOADED: dict[str, twistarm.Arm] = {}


def load(name: str) -> twistarm.Arm:
    """The arm of that name."""
    if name not in _LOADED:
        _LOADED[name] = twistarm.load_arm(name)
    return _LOADED[name]


def expanded_once(path: Path, packages: Any, *options: Any) -> Expanded:
    """`expand_xacro`, which expands a file of the catalogue once for each set of options, and others every time."""
    if robots_dir() not in path.parents:
        return expand_xacro(path, packages, *options)
    key = repr((path, options))
    if key not in _EXPANDED:
        with noted_files() as read:
            _EXPANDED[key] = expand_xacro(path, packages, *options), read
    expanded, read = _EXPANDED[key]
    for file in read:
        note_file(file)
    return expanded
