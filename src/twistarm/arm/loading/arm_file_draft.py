"""A first arm.toml: the known facts about an arm, and comments to fill in."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...description.companions.companion_files import files_beside, srdf_beside
from ...description.companions.toml_entries import toml_key, toml_text
from ...description.document import existing_file
from ...description.expansion.expand import expand_xacro, is_xacro
from ...description.packages import package_index
from ...description.tips.choice import candidates
from ...description.tree import Description
from ...limits.joint_limits import unit_of
from ...support.errors import DescriptionError, InputError
from ...support.files import as_path
from ..arm import Arm
from .load import assemble, prove, read, specify

FILL_IN = "?"
"""Mark for a number that only the team knows. It is not TOML, so an unread mark does not load."""

_TOOL = [
    "# A tool beyond the tip, seen from the tip link: metres, and URDF's rpy in radians.",
    "# [tool]",
    '# name = "pen"',
    "# xyz = [0.0, 0.0, 0.1]",
    "# rpy = [0.0, 0.0, 0.0]",
]


@dataclass(frozen=True)
class Draft:
    """The text of an arm.toml. `unclear` says what is missing before it loads; it is empty for a complete file."""

    text: str
    unclear: str = ""


def draft_arm_file(source: str | os.PathLike[str], folder: str | os.PathLike[str] = ".", **load: Any) -> Draft:
    """An arm.toml for a URDF or xacro file, with paths relative to `folder`. `load` are options of `load_arm`.

    It loads as the same arm that `load_arm` makes of these options, with the same `env_vars`. It does not contain
    `env_vars`. If the tip is unclear, it lists the candidates and `Draft.unclear` says so. Any other error is that of
    `load_arm`.
    """
    file = existing_file(source, "a URDF or xacro file")
    if file.suffix == ".toml":
        raise InputError(f"{file} is an arm.toml already; give the URDF or xacro file")
    given = specify(file, **load)
    description = read(given)
    arm, unclear = None, ""
    try:
        arm = assemble(description, given, {})
        prove(arm)
    except DescriptionError as error:
        if not any(finding.code == "no-tip" for finding in error.findings):
            raise
        unclear = error.message
    declared: Mapping[str, str | None] = {}
    if is_xacro(file):
        index = package_index(file, given.package_dirs)
        expanded = expand_xacro(file.resolve(), index, given.xacro_args, given.ignore_packages, given.env_vars)
        declared = expanded.arguments
    where = Path(folder).resolve()
    folders = ", ".join(_path(as_path(each), where) for each in given.package_dirs)
    absent = given.ignore_packages
    parts = [
        _head(description, file, where),
        _ends(description, arm, given.base),
        _beside(description, where, given.srdf),
        [f"package_dirs = [{folders}]"] if folders else [],
        [f"ignore_packages = [{', '.join(map(toml_text, absent))}]"] if absent else [],
        _TOOL,
        _xacro_args(declared, given.xacro_args),
        _limits(description, arm),
        _locked(description, arm),
        _poses(description, arm),
        _actuators(_coordinates(description, arm)),
    ]
    return Draft("\n\n".join("\n".join(part) for part in parts if part) + "\n", unclear)


def _head(description: Description, file: Path, where: Path) -> list[str]:
    return [
        "# What we say about our arm beside its description. SI units and radians throughout.",
        "# A line that begins with # is a note or an example: take the # away to make it count.",
        f"name = {toml_text(description.name)}",
        f"source = {_path(file, where)}",
    ]


def _ends(description: Description, arm: Arm | None, base: str | None) -> list[str]:
    if arm is None:
        return [
            f"base = {toml_text(base or description.root)}",
            "# It is not clear which link is the tool. Take the # away from one of these, or name another link:",
            *(f"# tip = {toml_text(link)}" for link in candidates(description, base)),
        ]
    lines = [f"base = {toml_text(arm.base)}", f"tip = {toml_text(arm.tip)}"]
    chosen = [f"# {finding.what}" for finding in arm.findings if finding.code == "several-tips"]
    others = [toml_text(link) for link in description.leaves if link != arm.tip]
    return lines + (chosen or [f"# Other ends: {', '.join(others)}"] if chosen or others else [])


def _beside(description: Description, where: Path, srdf: str | os.PathLike[str] | None) -> list[str]:
    """The SRDF in use, and joint_limits.yaml files as comments."""
    semantics, _ = srdf_beside(description)
    used = as_path(srdf) if srdf else semantics.path if semantics else None
    limits = files_beside(description.path, "joint_limits.yaml") if description.path else ()
    lines = [f"srdf = {_path(used, where)}"] if used else []
    return lines + [f"# joint_limits = {_path(file, where)}" for file in limits]


def _xacro_args(declared: Mapping[str, str | None], given: Mapping[str, object]) -> list[str]:
    if not declared:
        return []
    lines = ["# Arguments of the xacro file; a line that begins with # shows the default.", "[xacro_args]"]
    for name, default in declared.items():
        if name in given:
            note = "" if default is not None else "  # required"
            lines.append(f"{toml_key(name)} = {_value(given[name])}{note}")
        else:
            lines.append(f"# {toml_key(name)} = {toml_text(default or '')}")
    return lines


def _limits(description: Description, arm: Arm | None) -> list[str]:
    lines = [
        f"# Limits: rad or m, per second, per second²; N m or N. Where {FILL_IN} stands the description says nothing.",
        "[limits]",
    ]
    for name, unit, limits in _rows(description, arm):
        given = {field: value for field, value in limits.items() if np.isfinite(value)}
        listed = ", ".join(f"{field} {value:.6g}" for field, value in given.items())
        lines.append(f"# {toml_key(name)} [{unit}]: {listed or 'nothing given'}")
        missing = [rate for rate in ("velocity", "acceleration") if rate not in given]
        lines += [f"# {toml_key(name)}.{rate} = {FILL_IN}" for rate in missing]
    return lines


def _rows(description: Description, arm: Arm | None) -> list[tuple[str, str, dict[str, float]]]:
    """Name, unit and limits of the arm's coordinates; of every joint if the arm is not known."""
    fields = ("lower", "upper", "velocity", "effort")
    if arm is not None:
        columns = zip(arm.joint_names, arm.units, *(getattr(arm.limits, field) for field in fields), strict=True)
        return [(name, unit, dict(zip(fields, values, strict=True))) for name, unit, *values in columns]
    joints = [joint for joint in description.outward_joints() if joint.scalar and joint.mimic is None]
    return [(joint.name, unit_of(joint.type), {field: getattr(joint, field) for field in fields}) for joint in joints]


def _coordinates(description: Description, arm: Arm | None) -> tuple[str, ...]:
    return tuple(name for name, _, _ in _rows(description, arm))


def _locked(description: Description, arm: Arm | None) -> list[str]:
    names = _coordinates(description, arm)
    stuck = [f.place.name for f in description.findings if f.code == "limit-zero-range" and f.place.name in names]
    why = "their limits leave these no room" if stuck else "a broken or blocked joint, say"
    return [
        f"# Joints that stand still, and where [rad or m]: {why}.",
        "# [locked_joints]",
        *(f"# {toml_key(name)} = 0.0" for name in stuck or names[:1]),
    ]


def _poses(description: Description, arm: Arm | None) -> list[str]:
    if arm is None:
        lines = ["# Named poses give every joint; `ready` is where solvers and views start.", "# [poses.ready]"]
        return [*lines, *(f"# {toml_key(name)} = 0.0" for name in _coordinates(description, arm))]
    condition = float(arm.manipulability(arm.ready).condition)
    others = [toml_text(name) for name in arm.named_states if name != "ready"]
    return [
        f"# Named poses give every joint. `ready` is where solvers and views start: condition number {condition:.1f}.",
        *([f"# From the SRDF: {', '.join(others)}."] if others else []),
        "[poses.ready]",
        *(f"{toml_key(name)} = {value!r}" for name, value in arm.theta_to_dict(arm.ready).items()),
    ]


def _actuators(names: tuple[str, ...]) -> list[str]:
    lines = [
        "# Motors: motor = sum of ratio · joint, plus offset; motors and joints in rad, or m where they slide. The two",
        '# motors of a differential wrist have two joints each. `unit` is what the drive counts in: "rad", "deg",',
        '# "turn", "tick" (with ticks_per_turn), "m" or "mm". `limits` are the motor\'s own, on its side of the gear:',
        "# lower, upper, velocity, acceleration, effort.",
    ]
    for motor, sign in ("left", ""), ("right", "-"):
        ratios = [f"{toml_key(name)} = {sign * (i > 0)}100.0" for i, name in enumerate(names[-2:])]
        lines += [f"# [actuators.{motor}]", f"# ratio = {{ {', '.join(ratios)} }}", "# offset = 0.0"]
        lines += ['# unit = "tick"', "# ticks_per_turn = 4096"]
        lines += ["# limits = { velocity = 300.0, acceleration = 3000.0 }"]
    return lines


def _path(file: Path, where: Path) -> str:
    return toml_text(Path(os.path.relpath(file.resolve(), where)).as_posix())


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (int, float)) else toml_text(str(value))
