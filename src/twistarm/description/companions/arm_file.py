"""arm.toml: a team's data about an arm beside the description (base, tip, tool, limits, poses, actuators)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...limits.joint_limits import FIELDS, RATES
from ...support.checks import Array, as_vector, frozen, require_one
from ...support.entries import only
from ...support.errors import InputError
from ...support.files import as_path, is_file
from ...theory.rotations import from_rpy
from ..findings import Place, refusal
from ..packages import is_too_wide, package_names
from .toml_entries import bounded, number_of, numbers_of, parse_toml, table_of, text_of, unusable

if TYPE_CHECKING:
    from ..dh import DhTable

MOTOR_LIMITS = ("lower", "upper", "velocity", "acceleration", "effort")
"""Limits that a motor may have. Data sheets give no jerk."""

_MOTOR_KEYS = ("ratio", "offset", "unit", "ticks_per_turn", "limits")


@dataclass(frozen=True)
class Motor:
    """A motor and the joints it drives: motor = Σ ratio[joint] · joint + offset, rad or m on either side.

    `unit` is the drive's unit, `ticks_per_turn` its resolution if known. `limits` hold on the motor's side of the gear,
    by the names of `MOTOR_LIMITS`.
    """

    name: str
    ratio: Mapping[str, float]
    offset: float = 0.0
    unit: str = "rad"
    ticks_per_turn: float | None = None
    limits: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Tool:
    """A tool frame beyond the tip: its name and its pose (4, 4) in the tip link's frame."""

    name: str
    g_tip_tool: Array


@dataclass(frozen=True)
class ArmSpecification:
    """A description file to load, with data about it in SI units and radians.

    `source` is the user's name for it: the description, an arm.toml or a name of the catalogue. `other_chain` tells
    that the caller chose another base or tip, so that the other data need not fit. An arm.toml may come from a
    stranger. So only the caller sets `env_vars`, the variables that the description may read. `mesh_dirs` are the
    package folders that an arm.toml names outside its tree. They give only meshes. A table `dh` stands in the place of
    a description.
    """

    description: Path
    source: str
    name: str | None = None
    base: str | None = None
    tip: str | None = None
    tool: Tool | None = None
    package_dirs: tuple[str | os.PathLike[str], ...] = ()
    mesh_dirs: tuple[Path, ...] = ()
    xacro_args: Mapping[str, object] = field(default_factory=dict)
    ignore_packages: tuple[str, ...] = ()
    env_vars: tuple[str, ...] = ()
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    locked_joints: Mapping[str, float] = field(default_factory=dict)
    poses: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    srdf: str | os.PathLike[str] | None = None
    joint_limits: str | os.PathLike[str] | None = None
    motors: tuple[Motor, ...] = ()
    other_chain: bool = False
    dh: DhTable | None = None


_TEXTS = ("name", "source", "base", "tip", "srdf", "joint_limits")
_KEYS = (
    *_TEXTS,
    "dh",
    "tool",
    "xacro_args",
    "package_dirs",
    "ignore_packages",
    "limits",
    "locked_joints",
    "poses",
    "actuators",
)


def read_arm_file(path: Path) -> ArmSpecification:
    """Read an arm.toml. Raises DescriptionError that names the file, the entry and what is allowed there."""
    content = parse_toml(path)
    try:
        return _specification(content, path)
    except InputError as error:
        raise unusable(path, str(error)) from error


def _specification(content: Mapping[str, Any], path: Path) -> ArmSpecification:
    only(content, _KEYS, " at the top level")
    for key in _TEXTS:
        if key in content:
            text_of(content[key], key)
    if ("source" in content) == ("dh" in content):
        what = "it has a source and a table [dh]" if "dh" in content else "it names no source"
        raise InputError(f'{what}: write source = "my_arm.urdf" or a table [dh]')
    dh = _dh(content, path) if "dh" in content else None
    folders = _folders(content, path)
    far = tuple(folder for folder in folders if _is_elsewhere(folder, path))
    poses = table_of(content, "poses")
    return ArmSpecification(
        description=path if dh else _file(content["source"], "source", path),
        source=str(path),
        name=content.get("name"),
        base=content.get("base", dh and "base"),
        tip=content.get("tip", dh and "tool"),
        dh=dh,
        tool=_tool(content),
        xacro_args=table_of(content, "xacro_args"),
        package_dirs=tuple(folder for folder in folders if folder not in far),
        mesh_dirs=far,
        ignore_packages=package_names(content.get("ignore_packages", [])),
        limits=_limits(content),
        locked_joints={
            joint: bounded(value, f"locked_joints.{joint}")
            for joint, value in table_of(content, "locked_joints").items()
        },
        poses={name: numbers_of(table_of(poses, name), f"poses.{name}") for name in poses},
        srdf=_file(content["srdf"], "srdf", path) if "srdf" in content else None,
        joint_limits=_file(content["joint_limits"], "joint_limits", path) if "joint_limits" in content else None,
        motors=_motors(content),
    )


def _dh(content: Mapping[str, Any], path: Path) -> DhTable:
    """The table in the file, or in a CSV file that it names."""
    from ..dh import rows_of_csv, table_of_rows  # few arms have one

    entries = table_of(content, "dh")
    only(entries, ("table", "rows", "convention", "base"), " in dh")
    file, rows = entries.get("table"), entries.get("rows", [])
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"dh.rows must be tables, each [[dh.rows]]; got {rows!r}")
    try:
        rows = rows if file is None else rows_of_csv(_file(text_of(file, "dh.table"), "dh.table", path))
        return table_of_rows(rows, entries.get("convention"), _pose(entries, "base"))
    except InputError as error:
        raise InputError(f"dh: {error}") from error


def read_table_file(path: Path) -> ArmSpecification:
    """Read a CSV file with a DH table as an arm. Raises DescriptionError that says what is missing."""
    from ..dh import BASE, TOOL, rows_of_csv, table_of_rows

    try:
        table = table_of_rows(rows_of_csv(path))
    except InputError as error:
        raise unusable(path, f"as a DH table: {error}") from error
    return ArmSpecification(path, str(path), base=BASE, tip=TOOL, dh=table)


def _file(name: str, key: str, path: Path) -> Path:
    """A file that the arm.toml names, beside it."""
    file = path.parent / name
    if not is_file(file):
        what = f"{key} {name!r} does not exist beside it"
        raise refusal("file-not-found", Place(str(path)), what, "correct the path")
    return file


def _folders(content: Mapping[str, Any], path: Path) -> tuple[Path, ...]:
    folders = content.get("package_dirs", [])
    if not isinstance(folders, list) or not all(isinstance(folder, str) for folder in folders):
        raise InputError(f"package_dirs must be a list of texts; got {folders!r}")
    found = tuple(path.parent / as_path(folder) for folder in folders)
    for name, folder in zip(folders, found, strict=True):
        if not os.path.isdir(folder):
            what = f"package_dirs names {name!r}; there is no such folder beside it"
            raise refusal("file-not-found", Place(str(path)), what, "correct the path")
    return found


def _is_elsewhere(folder: Path, path: Path) -> bool:
    """Whether the path from the arm.toml to `folder` leads through the home folder or one above it."""
    ends = os.path.realpath(folder), os.path.realpath(path.parent)
    return is_too_wide(Path(os.path.commonpath(ends)))


def _limits(content: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    limits = table_of(content, "limits")
    for joint in limits:
        only(table_of(limits, joint), FIELDS, f" in limits.{joint}")
    return {joint: numbers_of(limits[joint], f"limits.{joint}") for joint in limits}


def _tool(content: Mapping[str, Any]) -> Tool | None:
    if "tool" not in content:
        return None
    table = table_of(content, "tool")
    name = text_of(table.get("name"), "tool.name")
    return Tool(name, _pose(content, "tool", "name"))


def _pose(content: Mapping[str, Any], key: str, *more: str) -> Array:
    """The pose (4, 4) of a table with xyz and rpy, the identity without one."""
    table, g = table_of(content, key), np.eye(4)
    only(table, (*more, "xyz", "rpy"), f" in {key}")
    g[:3, 3] = _three(table, f"{key}.xyz")
    g[:3, :3] = from_rpy(_three(table, f"{key}.rpy"))
    return frozen(g)


def _three(table: Mapping[str, Any], place: str) -> Array:
    given = table.get(place.rpartition(".")[2], (0.0, 0.0, 0.0))
    numbers = require_one(as_vector(given, place), place, 1)
    return np.array([bounded(number, place) for number in numbers])


def _motors(content: Mapping[str, Any]) -> tuple[Motor, ...]:
    return tuple(_motor(name, table) for name, table in table_of(content, "actuators").items())


def _motor(name: str, table: Any) -> Motor:
    text_of(name, "an actuator's name")
    place = f"actuators.{name}"
    if not isinstance(table, dict):
        raise InputError(f"{place} must be a table with ratio = {{ joint = number }}; got {table!r}")
    only(table, _MOTOR_KEYS, f" in {place}")
    if not isinstance(table.get("ratio"), dict) or not table["ratio"]:
        what = f"{place}.ratio must be a table of joint = number; got {table.get('ratio')!r}"
        raise InputError(f"{what}; write ratio = {{ elbow = 100.0 }}: motor rad per joint rad (or per m)")
    wanted = "finite and not 0"
    ratio = {name: bounded(value, f"{place}.ratio.{name}", wanted) for name, value in table["ratio"].items()}
    for joint, value in ratio.items():
        if value == 0:
            raise InputError(f"{place}.ratio.{joint} must be {wanted}; got {value:g}")
    if not isinstance(table.get("unit", ""), str):
        raise InputError(f"{place}.unit must be a text; got {table['unit']!r}")
    ticks = table.get("ticks_per_turn")
    return Motor(
        name=name,
        ratio=ratio,
        offset=bounded(table.get("offset", 0.0), f"{place}.offset"),
        unit=table.get("unit", "rad"),
        ticks_per_turn=None if ticks is None else number_of(ticks, f"{place}.ticks_per_turn", "ticks"),
        limits=_motor_limits(table, f"{place}.limits"),
    )


def _motor_limits(motor: Mapping[str, Any], place: str) -> dict[str, float]:
    table = motor.get("limits", {})
    if not isinstance(table, dict):
        what = f"{place} must be a table of limit = number; got {table!r}"
        how = "write limits = { velocity = 300.0 }: motor rad (or m), per s, per s²; N m or N"
        raise InputError(f"{what}; {how}")
    only(table, MOTOR_LIMITS, f" in {place}")
    limits = numbers_of(table, place)
    for name, value in limits.items():
        if name in RATES and value < 0:
            raise InputError(f"{place}.{name} must not be negative; got {value:g}")
    lower, upper = limits.get("lower", -np.inf), limits.get("upper", np.inf)
    if lower > upper:
        raise InputError(f"{place} are swapped: lower {lower:g} > upper {upper:g}")
    return limits
