"""A first arm.toml: the known facts about an arm, and comments to fill in."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ...description.companions.srdf import files_beside
from ...description.companions.toml_entries import toml_key, toml_text
from ...description.document import existing_file
from ...description.expansion.expand import expand_xacro, is_xacro
from ...description.packages import package_index
from ...support.errors import InputError
from ...support.files import as_path
from .load import assemble, proven, read, specify

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


def draft_arm_file(source: str | os.PathLike[str], folder: str | os.PathLike[str] = ".", **load: Any) -> str:
    """An arm.toml for a URDF, xacro or MJCF file, with paths relative to `folder`. `load` are options of `load_arm`.

    It loads as the same arm that `load_arm` makes of these options, with the same `env_vars`, which it does not
    contain. The errors are those of `load_arm`.
    """
    file = existing_file(source, "a URDF or xacro file")
    if file.suffix == ".toml":
        raise InputError(f"{file} is an arm.toml already; give the URDF or xacro file")
    given = specify(file, **load)
    description = read(given)
    arm = proven(assemble(description, given, {}))

    def path(each: str | os.PathLike[str]) -> str:
        relative = os.path.relpath(as_path(each).resolve(), Path(folder).resolve())
        return toml_text(Path(relative).as_posix())

    entries = {
        "name": toml_text(arm.name),
        "source": path(file),
        "base": toml_text(arm.base),
        "tip": toml_text(arm.tip),
    }
    if given.srdf:
        entries["srdf"] = path(given.srdf)
    if given.package_dirs:
        entries["package_dirs"] = f"[{', '.join(map(path, given.package_dirs))}]"
    if given.ignore_packages:
        entries["ignore_packages"] = f"[{', '.join(map(toml_text, given.ignore_packages))}]"
    lines = [HEAD, *(f"{key} = {text}" for key, text in entries.items())]
    others = [toml_text(link) for link in description.leaves if link != arm.tip]
    lines += [f"# Other ends: {', '.join(others)}"] if others else []
    lines += [f"# joint_limits = {path(each)}" for each in files_beside(file.resolve(), "joint_limits.yaml")]
    lines.append(TOOL)
    if is_xacro(file):
        index = package_index(file, given.package_dirs)
        arguments = given.xacro_args, given.ignore_packages, given.env_vars
        lines += ["", "# Arguments of the xacro file; a line that begins with # shows the default.", "[xacro_args]"]
        for name, default in expand_xacro(file.resolve(), index, *arguments).arguments.items():
            own = name in given.xacro_args
            text = _value(given.xacro_args[name]) if own else toml_text(default or "")
            lines.append(f"{'' if own else '# '}{toml_key(name)} = {text}")
    keys = [toml_key(name) for name in arm.joint_names]
    lines.append(LIMITS)  # an unread mark does not load: it is not TOML
    for i, key in enumerate(keys):
        rates = {rate: getattr(arm.limits, rate)[i] for rate in ("velocity", "acceleration")}
        lines += [f"# {key}.{rate} = ?" for rate, limit in rates.items() if not np.isfinite(limit)]
    lines += [LOCKED, f"# {keys[0]} = 0.0"]
    lines += ["", "# Named poses give every joint; `ready` is where solvers and views start.", "[poses.ready]"]
    lines += [f"{key} = {value!r}" for key, value in zip(keys, arm.ready.tolist(), strict=True)]
    motors = [MOTOR.format(i=i, joint=key) for i, key in enumerate(keys[-2:], start=1)]
    return "\n".join([*lines, ACTUATORS, *motors]) + "\n"


def _value(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (int, float)) else toml_text(str(value))
