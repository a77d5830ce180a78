"""arm.toml: a team's data about an arm beside the description (base, tip, tool, limits, poses, actuators)."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from ...limits.joint_limits import FIELDS, RATES
from ...support.checks import Array, as_number, as_positive, frozen, pose_of
from ...support.errors import InputError, quote
from ...support.fields import Check, anything, fields, list_of, numbers, table_of, text, word
from ...support.files import NO_SUCH_FILE, as_path, closest_beside, is_file, what_is_at
from ...support.units import angle_hint
from ...theory.rotations import from_rpy
from ..document import LARGEST
from ..findings import Finding, Place, finding, refusal
from ..packages import is_too_wide
from ..urdf import PLAIN, ReadOptions
from .data_files import parse_toml, unusable

# Limits that a motor may have. Data sheets give no jerk.
MOTOR_LIMITS = ("lower", "upper", "velocity", "acceleration", "effort")


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

    `source` is the user's name for it: the description, an arm.toml or a name of the catalogue. `other_chain` says
    that the caller chose another base or tip, so that the other data need not fit. An arm.toml may come from a
    stranger. So only the caller sets `options.env_vars`, and package folders outside the arm.toml's tree are
    `options.mesh_dirs`, which give only meshes.
    """

    description: Path
    source: str
    name: str | None = None
    base: str | None = None
    tip: str | None = None
    tool: Tool | None = None
    options: ReadOptions = PLAIN
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    locked_joints: Mapping[str, float] = field(default_factory=dict)
    poses: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    srdf: str | os.PathLike[str] | None = None
    joint_limits: str | os.PathLike[str] | None = None
    motors: tuple[Motor, ...] = ()
    other_chain: bool = False
    findings: tuple[Finding, ...] = ()


def _ratio(value: Any, name: str) -> float:
    if (ratio := _coordinate(value, name)) == 0.0:
        raise InputError(f"{name} must not be 0: it is motor rad per joint rad, or per m")
    return ratio


def _motor_limits(value: Any, name: str) -> dict[str, float]:
    rates = {rate: partial(as_number, least=0.0, most=inf) for rate in RATES if rate in MOTOR_LIMITS}
    limits = fields(value, name, {}, {"lower": _bound, "upper": _bound, **rates})
    if limits.get("lower", -inf) > limits.get("upper", inf):
        raise InputError(f"{name} are swapped: lower {limits['lower']:g} > upper {limits['upper']:g}")
    return limits


_coordinate = partial(as_number, least=-LARGEST, most=LARGEST, unit="rad or m")
_bound = partial(as_number, least=-inf, most=inf, unit="rad or m")
_three = partial(numbers, size=3, least=-LARGEST, most=LARGEST)
_MOTOR: dict[str, Check] = {"offset": _coordinate, "unit": text, "ticks_per_turn": as_positive, "limits": _motor_limits}

FORMAT: dict[str, Check] = {
    **dict.fromkeys(("name", "source", "base", "tip", "srdf", "joint_limits"), word),
    "tool": partial(fields, needed={"name": word}, optional={"xyz": _three, "rpy": _three}),
    "xacro_args": table_of(anything),
    "package_dirs": list_of(text),
    "ignore_packages": list_of(text),
    "limits": table_of(partial(fields, needed={}, optional=dict.fromkeys(FIELDS, _bound))),
    "locked_joints": table_of(_coordinate),
    "poses": table_of(table_of(_coordinate)),
    "actuators": table_of(partial(fields, needed={"ratio": table_of(_ratio, least=1)}, optional=_MOTOR)),
}
"""The entries of an arm.toml and their checks."""


def read_arm_file(path: Path) -> ArmSpecification:
    """Read an arm.toml. Raises DescriptionError that names the file, the entry and what is allowed there."""
    try:
        return _specification(fields(parse_toml(path), "", {}, FORMAT), path)
    except InputError as error:
        raise unusable(path, str(error)) from error


def _specification(content: Mapping[str, Any], path: Path) -> ArmSpecification:
    if "source" not in content:
        raise InputError('it names no source: write source = "my_arm.urdf"')
    files = {key: _beside(content[key], key, path) for key in ("source", "srdf", "joint_limits") if key in content}
    folders = [_beside(folder, "package_dirs", path, os.path.isdir) for folder in content.get("package_dirs", ())]
    here = os.path.realpath(path.parent)
    # The way to a far folder leads through the home folder or one above it.
    far = tuple(folder for folder in folders if is_too_wide(Path(os.path.commonpath([os.path.realpath(folder), here]))))
    tool, doubtful = content.get("tool"), []
    if tool and (hint := angle_hint(np.array(tool.get("rpy", ())))):
        what, remedy = f"tool.rpy {quote(tool['rpy'])}: {hint}", "write radians: 90 degrees are 1.5707963"
        doubtful.append(finding("unit-doubtful", Place(str(path)), what, remedy))
    return ArmSpecification(
        description=files["source"],
        source=str(path),
        name=content.get("name"),
        base=content.get("base"),
        tip=content.get("tip"),
        tool=tool and Tool(tool["name"], _pose(tool)),
        options=ReadOptions(
            package_dirs=[folder for folder in folders if folder not in far],
            xacro_args=content.get("xacro_args", {}),
            ignore_packages=content.get("ignore_packages", ()),
            mesh_dirs=far,
        ),
        limits=content.get("limits", {}),
        locked_joints=content.get("locked_joints", {}),
        poses=content.get("poses", {}),
        srdf=files.get("srdf"),
        joint_limits=files.get("joint_limits"),
        motors=tuple(Motor(name, **motor) for name, motor in content.get("actuators", {}).items()),
        findings=tuple(doubtful),
    )


def _beside(name: str, key: str, path: Path, exists: Callable[[Path], bool] = is_file) -> Path:
    """A file, or a folder, that the arm.toml names, beside it."""
    file = path.parent / as_path(name)
    if not exists(file):
        there = what_is_at(file) or "a file"
        why = f"does not exist beside it{closest_beside(file)}" if there == NO_SUCH_FILE else f"is {there}"
        raise refusal("file-unreadable", Place(str(path)), f"{key} {name!r} {why}", "correct the path")
    return file


def _pose(table: Mapping[str, Any]) -> Array:
    """The pose (4, 4) of a table with xyz and rpy, the identity without them."""
    return frozen(pose_of(from_rpy(table.get("rpy", np.zeros(3))), table.get("xyz", 0.0)))
