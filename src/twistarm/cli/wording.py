"""Messages in the words of the command line: options instead of arguments, and degrees."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from functools import partial
from types import EllipsisType
from typing import Any

from ..support.errors import TwistarmError
from ..support.messages import Posture, Quantity, Value, rendered

OPTIONS = {
    "base": ("--base", "LINK"),
    "tip": ("--tip", "LINK"),
    "srdf": ("--srdf", "FILE"),
    "limits": ("--limits", "FILE"),
    "locked_joints": ("--locked-joint", "JOINT=VALUE"),
    "ignore_packages": ("--ignore-package", "PACKAGE"),
    "env_vars": ("--env", "NAME"),
    "xacro_args": ("--xacro", "NAME:=VALUE"),
    "package_dirs": ("--package-dir", "FOLDER"),
    "stop_at_waypoints": ("--stop", ""),
    "scene": ("--avoid", "SCENE"),
    "max_time": ("--max-time", "S"),
    "clearance": ("--clearance", "M"),
    "tol": ("--keep-tol", "ANGLE"),
    "position_tol": ("--position-tol", "M"),
    "orientation_tol": ("--orientation-tol", "ANGLE"),
    "tag_size": ("--tag-size", "M"),
}
"""The options of arguments that messages name, and their values in `--help`. Any other is Typer's: `--camera …`."""


def words(message: str, *, radians: bool = False) -> str:
    """The message with `--tip wrist` for `tip='wrist'` and, unless `radians`, with 28.648° for 0.5 rad."""
    text: str = rendered(message, partial(written, radians=radians))
    return text


def words_of(error: Exception, *, radians: bool = False) -> str:
    """An error's message: ours in the words of the command line, any other with its origin."""
    if isinstance(error, TwistarmError):
        return words(error.message, radians=radians)
    if isinstance(error, OSError):  # a full disk, a port in use: no fault of twistarm
        return f"the operating system refuses: {error}"
    return f"{type(error).__name__}: {error}; a fault of twistarm's: please report it with the output of --debug"


def written(value: Value, *, radians: bool = False) -> str:
    """A quantity, a posture or an argument as one types it."""
    if isinstance(value, Quantity):
        return str(value) if radians else value.in_degrees()
    if isinstance(value, Posture):
        values = (_number(quantity, radians=radians) for quantity in value.quantities())
        return f'"{" ".join(values)}" ({"rad" if radians else "°"} and m)'
    option, metavar = OPTIONS.get(value.name, (f"--{value.name.replace('_', '-')}", "…"))
    return _option(option, metavar, value.value, radians)


def _number(of: Quantity, *, radians: bool = False) -> str:
    """The number alone."""
    return re.split("[° ]", str(of) if radians else of.in_degrees())[0]


def _option(option: str, metavar: str, value: Any, radians: bool) -> str:
    """`--tip wrist`, `--env NAME`, `--xacro dof:=7`."""
    if isinstance(value, Mapping):
        pairs = [f"{key}:={'VALUE' if isinstance(text, EllipsisType) else text}" for key, text in value.items()]
        return " ".join(shlex.join([option, pair]) for pair in pairs)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " ".join(_option(option, metavar, entry, radians) for entry in value)
    if value is None or value is True:
        return option
    typed = _number(value, radians=radians) if isinstance(value, Quantity) else str(value)
    return f"{option} {metavar if isinstance(value, EllipsisType) else shlex.quote(typed)}"
