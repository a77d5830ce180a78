"""A first arm.toml: the known facts about an arm, and comments to fill in."""

from __future__ import annotations

import os
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
from ...support.errors import DescriptionError, InputError
from ...support.files import as_path
from ..arm import Arm
from .load import assemble, prove, read, specify

HEAD = """\
# What we say about our arm beside its description. SI units and radians throughout.
# A line that begins with # is a note or an example: take the # away to make it count."""

TOOL = """\

# A tool beyond the tip, seen from the tip link: metres, and URDF's rpy in radians.
# [tool]
# name = "pen"
# xyz = [0.0, 0.0, 0.1]
# rpy = [0.0, 0.0, 0.0]"""

LOCKED = """\

# Joints that stand still, and where [rad or m].
# [locked_joints]"""

LIMITS = """\

# Limits: rad or m, per second, per second²; N m or N. Where ? stands the description says nothing.
[limits]"""

ACTUATORS = """\

# Motors: motor = sum of ratio · joint, plus offset; motors and joints in rad, or m where they slide. `unit` is what the
# drive counts in: "rad", "deg", "turn", "tick" (with ticks_per_turn), "m" or "mm". `limits` are the motor's own."""

MOTOR = """\
# [actuators.motor{i}]
# ratio = {{ {joint} = 100.0 }}
# offset = 0.0
# unit = "tick"
# ticks_per_turn = 4096
# limits = {{ velocity = 300.0, acceleration = 3000.0 }}"""


@dataclass(frozen=True)
class Draft:
    """The text of an arm.toml. `unclear` says what is missing before it loads; it is empty for a complete file."""

    text: str
    unclear: str = ""


def draft_arm_file(source: str | os.PathLike[str], folder: str | os.PathLike[str] = ".", **load: Any) -> Draft:
    """An arm.toml for a URDF, xacro or MJCF file, with paths relative to `folder`. `load` are options of `load_arm`.

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

    def path(each: str | os.PathLike[str]) -> str:
        relative = os.path.relpath(as_path(each).resolve(), Path(folder).resolve())
        return toml_text(Path(relative).as_posix())

    lines = [
        HEAD,
        f"name = {toml_text(description.name)}",
        f"source = {path(file)}",
        *_ends(description, arm, given.base),
    ]
    semantics, _ = srdf_beside(description)
    if used := given.srdf or (semantics and semantics.path):
        lines.append(f"srdf = {path(used)}")
    beside = files_beside(description.path, "joint_limits.yaml") if description.path else ()
    lines += [f"# joint_limits = {path(each)}" for each in beside]
    for key, texts in (
        ("package_dirs", [path(each) for each in given.package_dirs]),
        ("ignore_packages", [toml_text(each) for each in given.ignore_packages]),
    ):
        lines += [f"{key} = [{', '.join(texts)}]"] if texts else []
    lines.append(TOOL)
    if is_xacro(file):
        index = package_index(file, given.package_dirs)
        arguments = given.xacro_args, given.ignore_packages, given.env_vars
        declared = expand_xacro(file.resolve(), index, *arguments).arguments
        lines += ["", "# Arguments of the xacro file; a line that begins with # shows the default.", "[xacro_args]"]
        for name, default in declared.items():
            text = _value(given.xacro_args[name]) if name in given.xacro_args else toml_text(default or "")
            lines.append(f"{'' if name in given.xacro_args else '# '}{toml_key(name)} = {text}")
    joints = arm.joint_names if arm else [each.name for each in description.outward_joints() if each.scalar]
    lines += [LIMITS, *_limits(arm), LOCKED, *(f"# {toml_key(name)} = 0.0" for name in joints[:1])]
    lines += ["", "# Named poses give every joint; `ready` is where solvers and views start."]
    if arm is None:
        lines += ["# [poses.ready]", *(f"# {toml_key(name)} = 0.0" for name in joints)]
    else:
        values = arm.theta_to_dict(arm.ready).items()
        lines += ["[poses.ready]", *(f"{toml_key(name)} = {value!r}" for name, value in values)]
    motors = [MOTOR.format(i=i, joint=toml_key(name)) for i, name in enumerate(joints[-2:], start=1)]
    return Draft("\n".join([*lines, ACTUATORS, *motors]) + "\n", unclear)


def _ends(description: Description, arm: Arm | None, base: str | None) -> list[str]:
    """Base and tip, and what else could be the tip."""
    if arm is None:
        return [
            f"base = {toml_text(base or description.root)}",
            "# It is not clear which link is the tool. Take the # away from one of these, or name another link:",
            *(f"# tip = {toml_text(link)}" for link in candidates(description, base)),
        ]
    lines = [f"base = {toml_text(arm.base)}", f"tip = {toml_text(arm.tip)}"]
    others = [toml_text(link) for link in description.leaves if link != arm.tip]
    return [*lines, f"# Other ends: {', '.join(others)}"] if others else lines


def _limits(arm: Arm | None) -> list[str]:
    """The rates to fill in, which the description does not give. An unread mark does not load: it is not TOML."""
    return [
        f"# {toml_key(name)}.{rate} = ?"
        for i, name in enumerate(arm.joint_names if arm else ())
        for rate in ("velocity", "acceleration")
        if arm and not np.isfinite(getattr(arm.limits, rate)[i])
    ]


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (int, float)) else toml_text(str(value))
