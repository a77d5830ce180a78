"""arm.toml: what a team says about its own arm beside the description (base, tip, tool, limits, poses)."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..checks import Array, as_vector, frozen
from ..errors import DescriptionError, InputError, closest, listed
from ..files import is_file
from ..limits import FIELDS
from ..rotations import from_rpy
from .document import read_text


@dataclass(frozen=True)
class Tool:
    """A tool frame beyond the tip: its name and its pose (4, 4) seen from the tip link."""

    name: str
    g_tip_tool: Array


@dataclass(frozen=True)
class ArmSpecification:
    """What is to be loaded: a description file and what is said about it, SI units and radians.

    `source` is what the user named: the description itself, an arm.toml or a name of the catalogue.
    """

    description: Path
    source: str
    name: str | None = None
    base: str | None = None
    tip: str | None = None
    tool: Tool | None = None
    package_dirs: tuple[str | os.PathLike[str], ...] = ()
    xacro_args: Mapping[str, object] = field(default_factory=dict)
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    locked: Mapping[str, float] = field(default_factory=dict)
    poses: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


_KEYS = ("name", "source", "base", "tip", "tool", "xacro_args", "package_dirs", "limits", "locked", "poses")


def read_arm_file(path: Path) -> ArmSpecification:
    """Read an arm.toml. Raises DescriptionError that names the file, the entry and what is allowed there."""
    content = _parse(path)
    _only(content, _KEYS, path, "at the top level")
    for key in ("name", "source", "base", "tip"):
        if key in content and not isinstance(content[key], str):
            raise DescriptionError(f"{path}: {key} must be a text; got {content[key]!r}")
    if "source" not in content:
        raise DescriptionError(f'{path}: it names no source: write source = "my_arm.urdf"')
    description = path.parent / content["source"]
    if not is_file(description):
        raise DescriptionError(f"{path}: source {content['source']!r} does not exist beside it")
    return ArmSpecification(
        description=description,
        source=str(path),
        name=content.get("name"),
        base=content.get("base"),
        tip=content.get("tip"),
        tool=_tool(content, path),
        xacro_args=_table(content, "xacro_args", path),
        package_dirs=_folders(content, path),
        limits=_limits(content, path),
        locked=_numbers(_table(content, "locked", path), path, "locked"),
        poses={
            name: _numbers(_table(_table(content, "poses", path), name, path), path, f"poses.{name}")
            for name in _table(content, "poses", path)
        },
    )


def _parse(path: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    try:
        content: dict[str, Any] = tomllib.loads(read_text(path))
        return content
    except tomllib.TOMLDecodeError as error:
        raise DescriptionError(f"{path}: not valid TOML: {error}") from error


def _only(table: Mapping[str, Any], allowed: Iterable[str], path: Path, place: str) -> None:
    for key in table:
        if key not in allowed:
            raise DescriptionError(
                f"{path}: unknown entry {key!r} {place}{closest(key, allowed)}; allowed: {listed(allowed)}"
            )


def _table(content: Mapping[str, Any], key: str, path: Path) -> Mapping[str, Any]:
    table = content.get(key, {})
    if not isinstance(table, dict):
        raise DescriptionError(f"{path}: {key} must be a table of name = value; got {table!r}")
    return table


def _folders(content: Mapping[str, Any], path: Path) -> tuple[Path, ...]:
    folders = content.get("package_dirs", [])
    if not isinstance(folders, list) or not all(isinstance(folder, str) for folder in folders):
        raise DescriptionError(f"{path}: package_dirs must be a list of texts; got {folders!r}")
    return tuple(path.parent / folder for folder in folders)


def _numbers(table: Mapping[str, Any], path: Path, place: str) -> dict[str, float]:
    return {name: _number(value, f"{path}: {place}.{name}") for name, value in table.items()}


def _number(value: Any, place: str) -> float:
    try:
        number = np.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = np.nan
    if np.isnan(number):
        raise DescriptionError(f"{place} must be a number (rad or m); got {str(value)[:60]!r}")
    return number


def _limits(content: Mapping[str, Any], path: Path) -> dict[str, dict[str, float]]:
    limits = _table(content, "limits", path)
    for joint in limits:
        _only(_table(limits, joint, path), FIELDS, path, f"in limits.{joint}")
    return {joint: _numbers(limits[joint], path, f"limits.{joint}") for joint in limits}


def _tool(content: Mapping[str, Any], path: Path) -> Tool | None:
    if "tool" not in content:
        return None
    table = _table(content, "tool", path)
    _only(table, ("name", "xyz", "rpy"), path, "in tool")
    if not isinstance(table.get("name"), str):
        raise DescriptionError(f"{path}: tool.name must be a text; got {table.get('name')!r}")
    g = np.eye(4)
    try:
        g[:3, 3] = as_vector(table.get("xyz", (0.0, 0.0, 0.0)), "tool.xyz")
        g[:3, :3] = from_rpy(as_vector(table.get("rpy", (0.0, 0.0, 0.0)), "tool.rpy"))
    except (InputError, ValueError) as error:
        raise DescriptionError(f"{path}: {error}") from error
    return Tool(table["name"], frozen(g))
