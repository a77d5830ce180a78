"""A first arm.toml: the known facts about an arm, and comments to fill in."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ...description.companions.data_files import toml_key, toml_text
from ...description.companions.srdf import files_beside
from ...description.document import existing_file
from ...description.expansion.expand import expand_xacro, is_xacro
from ...description.packages import package_index
from ...description.planar import free_name
from ...support.checks import Array
from ...support.errors import InputError
from ...support.files import as_path
from .load import assemble, proven, read, specify

HEAD = """\
# What we say about our arm beside its description. SI units and radians throughout.
# A line that begins with # is a note or an example: take the # away to make it count."""

LIMITS = """\

# Limits: rad or m, per second, per second²; N m or N. ? means that the description gives none.
[limits]"""

MORE = """
# Further tables: [tool] beyond the tip, [locked_joints], and [actuators.NAME] for motors.
# docs/descriptions.md has an example of each."""


def draft_arm_file(
    source: str | os.PathLike[str], folder: str | os.PathLike[str] = ".", tool: Array | None = None, **load: Any
) -> str:
    """An arm.toml for a URDF, xacro or MJCF file, with paths relative to `folder`. `load` are options of `load_arm`.

    `tool` is the place (3,) of a tool frame beyond the tip [m].

    It loads as the same arm that `load_arm` makes of these options, with the same `env_vars`, which it does not
    contain. The errors are those of `load_arm`.
    """
    file = existing_file(source, "a URDF or xacro file")
    if file.suffix == ".toml":
        raise InputError(f"{file} is an arm.toml already; give the URDF or xacro file")
    given = specify(file, **load)
    options = given.options
    description = read(given)
    arm = proven(assemble(description, given, {}))

    def path(other: str | os.PathLike[str]) -> str:
        relative = os.path.relpath(as_path(other).resolve(), Path(folder).resolve())
        return toml_text(Path(relative).as_posix())

    own = {"name": toml_text(arm.name), "source": path(file), "base": toml_text(arm.base), "tip": toml_text(arm.tip)}
    if given.srdf:
        own["srdf"] = path(given.srdf)
    lists = {
        "package_dirs": map(path, options.package_dirs),
        "ignore_packages": map(toml_text, options.ignore_packages),
    }
    own |= {key: f"[{values}]" for key, texts in lists.items() if (values := ", ".join(texts))}
    lines = [HEAD, *(f"{key} = {text}" for key, text in own.items())]
    others = [toml_text(link) for link in description.leaves if link != arm.tip]
    lines += [f"# Other ends: {', '.join(others)}"] if others else []
    lines += [f"# joint_limits = {path(beside)}" for beside in files_beside(file.resolve(), "joint_limits.yaml")]
    if is_xacro(file):
        index = package_index(file, options.package_dirs)
        arguments = options.xacro_args, options.ignore_packages, options.env_vars
        lines += ["", "# Arguments of the xacro file; a line that begins with # shows the default.", "[xacro_args]"]
        for name, default in expand_xacro(file.resolve(), index, *arguments).arguments.items():
            value = options.xacro_args.get(name)
            text = toml_text(default or "") if value is None else _toml(value)
            lines.append(f"{'# ' if value is None else ''}{toml_key(name)} = {text}")
    keys = [toml_key(name) for name in arm.joint_names]
    lines.append(LIMITS)  # an unread mark does not load: it is not TOML
    for i, key in enumerate(keys):
        rates = {rate: getattr(arm.limits, rate)[i] for rate in ("velocity", "acceleration")}
        lines += [f"# {key}.{rate} = ?" for rate, limit in rates.items() if not np.isfinite(limit)]
    lines += ["", "# Named configurations give every joint; `ready` is where solvers and views start.", "[poses.ready]"]
    lines += [f"{key} = {value!r}" for key, value in zip(keys, arm.ready.tolist(), strict=True)]
    if tool is not None:
        name = free_name("tool", {*arm.frame_names})
        lines += ["", "[tool]", f"name = {toml_text(name)}", f"xyz = {tool.tolist()}"]
    return "\n".join([*lines, MORE]) + "\n"


def _toml(value: object) -> str:
    """An argument of xacro as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, (int, float)) else toml_text(str(value))
