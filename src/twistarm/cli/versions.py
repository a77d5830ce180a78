"""Installed versions, and the engine in use."""

from __future__ import annotations

import platform
import re
from importlib import metadata
from typing import Any

from ..arm import engine


def version() -> str:
    """twistarm's own."""
    return metadata.version("twistarm")


def versions_json() -> dict[str, Any]:
    """The answer of `info` without ARM, for programs. null means that a library is not installed."""
    return {
        "twistarm": version(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "engine": engine_here(),
        "core": engine.instruction_set() or None,
        "why_no_core": engine.why_not() or None,
        "libraries": {name: _version(name) for name, _ in libraries()},
    }


def versions_text() -> str:
    """The same for people."""
    said = versions_json()
    lines = [f"twistarm {version()}, Python {said['python']}, {said['platform']}", f"engine: {said['engine']}"]
    if said["why_no_core"]:
        lines.append(f"no compiled core: {said['why_no_core']}")
    for name, extra in libraries():
        missing = f"not installed: pip install 'twistarm[{extra}]'" if extra else "not installed"
        lines.append(f"  {name:<20} {said['libraries'][name] or missing}")
    return "\n".join([*lines, "an ARM's own: twistarm info ARM; the arms there are by name: twistarm arms"])


def engine_here() -> str:
    """The engine of kinematics for an arm from a description."""
    return f"compiled core ({engine.instruction_set()})" if engine.core() else "Pinocchio"


def libraries() -> list[tuple[str, str]]:
    """Name and extra ("" for the base install) of each requirement of the package."""
    pattern = re.compile(r"([\w.-]+)[^;]*(?:;.*extra == ['\"](\w+)['\"])?")
    here = [text for text in metadata.requires("twistarm") or () if "python_version" not in text]
    found = [pattern.match(text) for text in here]
    pairs = [(match[1], match[2] or "") for match in found if match]
    return [(name, extra) for name, extra in pairs if name != "twistarm" and extra not in ("dev", "all")]


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
