"""arm.toml: what a team says about its own arm beside the description (base, tip, tool, limits, poses, actuators)."""

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
from ..files import as_path, is_file
from ..limits import FIELDS, RATES
from ..rotations import from_rpy
from .document import read_text
from .findings import Place, refusal
from .geometry import LARGEST

MAX_BYTES, MAX_LINE = 64_000, 2_000
"""An arm.toml has some 5 kB; TOML's reader takes seconds for a dotted key that fills a longer line."""


@dataclass(frozen=True)
class Tool:
    """A tool frame beyond the tip: its name and its pose (4, 4) seen from the tip link."""

    name: str
    g_tip_tool: Array


@dataclass(frozen=True)
class Motor:
    """A motor and the joints it drives: motor = Σ ratio[joint] · joint + offset, rad or m on either side.

    `unit` is what its drive counts in, `ticks_per_turn` how fine where that is known. `limits` are the motor's own, on
    its side of the gear, by the names of `MOTOR_LIMITS`.
    """

    name: str
    ratio: Mapping[str, float]
    offset: float = 0.0
    unit: str = "rad"
    ticks_per_turn: float | None = None
    limits: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ArmSpecification:
    """What is to be loaded: a description file and what is said about it, SI units and radians.

    `source` is what the user named: the description itself, an arm.toml or a name of the catalogue. `other_chain`
    tells that the caller has asked for another base or tip, so that not all of the rest need fit.
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
    srdf: str | os.PathLike[str] | None = None
    joint_limits: str | os.PathLike[str] | None = None
    motors: tuple[Motor, ...] = ()
    other_chain: bool = False


_TEXTS = ("name", "source", "base", "tip", "srdf", "joint_limits")
_KEYS = (*_TEXTS, "tool", "xacro_args", "package_dirs", "limits", "locked", "poses", "actuators")
_MOTOR_KEYS = ("ratio", "offset", "unit", "ticks_per_turn", "limits")
MOTOR_LIMITS = ("lower", "upper", "velocity", "acceleration", "effort")
"""What may be said of a motor; nobody gives its jerk."""


def read_arm_file(path: Path) -> ArmSpecification:
    """Read an arm.toml. Raises DescriptionError that names the file, the entry and what is allowed there."""
    content = _parse(path)
    _only(content, _KEYS, path, "at the top level")
    for key in _TEXTS:
        if key in content:
            _text(content[key], key, path)
    if "source" not in content:
        raise _unusable(path, 'it names no source: write source = "my_arm.urdf"')
    return ArmSpecification(
        description=_file(content["source"], "source", path),
        source=str(path),
        name=content.get("name"),
        base=content.get("base"),
        tip=content.get("tip"),
        tool=_tool(content, path),
        xacro_args=_table(content, "xacro_args", path),
        package_dirs=_folders(content, path),
        limits=_limits(content, path),
        locked=_locked(content, path),
        poses={
            name: _numbers(_table(_table(content, "poses", path), name, path), path, f"poses.{name}")
            for name in _table(content, "poses", path)
        },
        srdf=_file(content["srdf"], "srdf", path) if "srdf" in content else None,
        joint_limits=_file(content["joint_limits"], "joint_limits", path) if "joint_limits" in content else None,
        motors=tuple(_motor(name, content, path) for name in _table(content, "actuators", path)),
    )


def _unusable(path: Path, what: str, remedy: str = "correct it there") -> DescriptionError:
    return refusal("arm-file-unusable", Place(str(path)), what, remedy)


def _file(name: str, key: str, path: Path) -> Path:
    """A file that the arm.toml names, beside it."""
    file = path.parent / name
    if not is_file(file):
        what = f"{key} {name!r} does not exist beside it"
        raise refusal("file-not-found", Place(str(path)), what, "correct the path")
    return file


def _parse(path: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    text = read_text(path, MAX_BYTES)
    if max(map(len, text.splitlines()), default=0) > MAX_LINE:
        raise _unusable(path, f"a line of more than {MAX_LINE:,} characters", "break it; is it an arm.toml?")
    try:
        content: dict[str, Any] = tomllib.loads(text)
        return content
    except RecursionError as error:
        raise _unusable(path, "not valid TOML: it nests too deep", "is it an arm.toml?") from error
    except ValueError as error:  # TOMLDecodeError is one; so is Python's for an integer of too many digits
        raise _unusable(path, f"not valid TOML: {error}") from error


def _only(table: Mapping[str, Any], allowed: Iterable[str], path: Path, place: str) -> None:
    for key in table:
        if key not in allowed:
            what = f"unknown entry {key!r} {place}{closest(key, allowed)}"
            raise _unusable(path, what, f"allowed: {listed(allowed, 20)}")


def _text(value: Any, place: str, path: Path) -> str:
    if not isinstance(value, str):
        raise _unusable(path, f"{place} must be a text; got {value!r}")
    if not value.strip():
        raise _unusable(path, f"{place} must not be empty; got {value!r}")
    return value


def _table(content: Mapping[str, Any], key: str, path: Path) -> Mapping[str, Any]:
    table = content.get(key, {})
    if not isinstance(table, dict):
        raise _unusable(path, f"{key} must be a table of name = value; got {table!r}")
    return table


def _folders(content: Mapping[str, Any], path: Path) -> tuple[Path, ...]:
    folders = content.get("package_dirs", [])
    if not isinstance(folders, list) or not all(isinstance(folder, str) for folder in folders):
        raise _unusable(path, f"package_dirs must be a list of texts; got {folders!r}")
    found = tuple(path.parent / as_path(folder) for folder in folders)
    for name, folder in zip(folders, found, strict=True):
        if not os.path.isdir(folder):
            what = f"package_dirs names {name!r}; there is no such folder beside it"
            raise refusal("file-not-found", Place(str(path)), what, "correct the path")
    return found


def _numbers(table: Mapping[str, Any], path: Path, place: str) -> dict[str, float]:
    return {name: _number(value, path, f"{place}.{name}") for name, value in table.items()}


def _number(value: Any, path: Path, place: str, unit: str = "rad or m") -> float:
    try:
        number = np.nan if isinstance(value, (bool, str)) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = np.nan
    if np.isnan(number):
        raise _unusable(path, f"{place} must be a number ({unit}); got {str(value)[:60]!r}")
    return number


def _bounded(value: Any, path: Path, place: str, wanted: str = "finite") -> float:
    """A number of a size that robots have."""
    number = _number(value, path, place)
    if not abs(number) <= LARGEST:
        allowed = f"at most {LARGEST:g} in size" if np.isfinite(number) else wanted
        raise _unusable(path, f"{place} must be {allowed}; got {number:g}")
    return number


def _locked(content: Mapping[str, Any], path: Path) -> dict[str, float]:
    locked = _table(content, "locked", path)
    return {joint: _bounded(value, path, f"locked.{joint}") for joint, value in locked.items()}


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
    name = _text(table.get("name"), "tool.name", path)
    g = np.eye(4)
    g[:3, 3] = _three(table, "xyz", path)
    g[:3, :3] = from_rpy(_three(table, "rpy", path))
    return Tool(name, frozen(g))


def _three(table: Mapping[str, Any], key: str, path: Path) -> Array:
    try:
        numbers = as_vector(table.get(key, (0.0, 0.0, 0.0)), f"tool.{key}")
    except InputError as error:
        raise _unusable(path, str(error)) from error
    if numbers.ndim != 1:
        raise _unusable(path, f"tool.{key} must have shape (3,); got {numbers.shape}")
    return np.array([_bounded(number, path, f"tool.{key}") for number in numbers])


def _motor(name: str, content: Mapping[str, Any], path: Path) -> Motor:
    _text(name, "an actuator's name", path)
    place = f"actuators.{name}"
    table = content["actuators"][name]
    if not isinstance(table, dict):
        raise _unusable(path, f"{place} must be a table with ratio = {{ joint = number }}; got {table!r}")
    _only(table, _MOTOR_KEYS, path, f"in {place}")
    if not isinstance(table.get("ratio"), dict) or not table["ratio"]:
        what = f"{place}.ratio must be a table of joint = number; got {table.get('ratio')!r}"
        raise _unusable(path, what, "write ratio = { elbow = 100.0 }: motor rad per joint rad (or per m)")
    wanted = "finite and not 0"
    ratio = {name: _bounded(value, path, f"{place}.ratio.{name}", wanted) for name, value in table["ratio"].items()}
    for joint, value in ratio.items():
        if value == 0:
            raise _unusable(path, f"{place}.ratio.{joint} must be {wanted}; got {value:g}")
    if not isinstance(table.get("unit", ""), str):
        raise _unusable(path, f"{place}.unit must be a text; got {table['unit']!r}")
    ticks = table.get("ticks_per_turn")
    return Motor(
        name=name,
        ratio=ratio,
        offset=_bounded(table.get("offset", 0.0), path, f"{place}.offset"),
        unit=table.get("unit", "rad"),
        ticks_per_turn=None if ticks is None else _number(ticks, path, f"{place}.ticks_per_turn", "ticks"),
        limits=_motor_limits(table, path, f"{place}.limits"),
    )


def _motor_limits(motor: Mapping[str, Any], path: Path, place: str) -> dict[str, float]:
    table = motor.get("limits", {})
    if not isinstance(table, dict):
        what = f"{place} must be a table of limit = number; got {table!r}"
        raise _unusable(path, what, "write limits = { velocity = 300.0 }: motor rad (or m), per s, per s²; N m or N")
    _only(table, MOTOR_LIMITS, path, f"in {place}")
    limits = _numbers(table, path, place)
    for name, value in limits.items():
        if name in RATES and value < 0:
            raise _unusable(path, f"{place}.{name} must not be negative; got {value:g}")
    lower, upper = limits.get("lower", -np.inf), limits.get("upper", np.inf)
    if lower > upper:
        raise _unusable(path, f"{place} are swapped: lower {lower:g} > upper {upper:g}")
    return limits
