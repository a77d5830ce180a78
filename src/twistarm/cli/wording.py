"""Messages in the words of the command line: options instead of arguments, and degrees."""

from __future__ import annotations

import ast
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from contextvars import ContextVar
from types import EllipsisType
from typing import Any

from ..support.caller_words import ARGUMENT, FRAME_NAMES, POSTURE, QUANTITY
from ..support.errors import TwistarmError
from ..support.unit_hints import LOOK_LIKE_DEGREES

_OPTIONS = {
    "base": ("--base", "LINK"),
    "tip": ("--tip", "LINK"),
    "srdf": ("--srdf", "FILE"),
    "limits": ("--limits", "FILE"),
    "locked_joints": ("--locked-joint", "JOINT"),
    "ignore_packages": ("--ignore-package", "PACKAGE"),
    "env_vars": ("--env", "NAME"),
    "xacro_args": ("--xacro", "NAME:=VALUE"),
    "package_dirs": ("--package-dir", "FOLDER"),
    "stop_at_waypoints": ("--stop", ""),
    "approach": ("--approach", ""),
    "unwrap": ("--unwrap", ""),
    "scene": ("--avoid", "SCENE"),
    "max_time": ("--max-time", "S"),
    "position_tol": ("--position-tol", "M"),
    "orientation_tol": ("--orientation-tol", "ANGLE"),
}
"""The option of each argument in messages, and the name of its value in `--help`."""

DEGREES = ContextVar("degrees", default=True)
"""Whether the running command takes angles in degrees."""


def in_options(message: str) -> str:
    """The message with `--tip wrist` for `tip='wrist'`. With angles in degrees, 28.648° replaces 0.5 rad."""
    message = ARGUMENT.sub(_option, message)
    message = message.replace(FRAME_NAMES, "twistarm info ARM --json")
    message = POSTURE.sub(_configuration, message)
    if DEGREES.get():
        message = re.sub(rf"[:;]? \(?angles of up to \S+ {LOOK_LIKE_DEGREES}\)?", "", message)
        message = re.sub(rf"(?<!\w)'[^']*'|{QUANTITY.pattern}", _in_degrees, message)
    return message


def _option(found: re.Match[str]) -> str:
    name, literal = found["name"], found["value"]
    if name not in _OPTIONS:
        return found[0]
    option, metavar = _OPTIONS[name]
    if literal is None:
        return option
    try:
        value = ast.literal_eval(literal)
    except (ValueError, SyntaxError):  # not written as an argument is
        return found[0]
    if name == "orientation_tol" and DEGREES.get():
        value = float(f"{math.degrees(value):.2g}")
    return _typed(option, metavar, value)


def _typed(option: str, metavar: str, value: Any) -> str:
    """`--tip wrist`, `--env NAME`, `--xacro dof:=7`."""
    if isinstance(value, Mapping):
        pairs = [f"{key}:={'VALUE' if isinstance(each, EllipsisType) else each}" for key, each in value.items()]
        return " ".join(shlex.join([option, pair]) for pair in pairs)
    if isinstance(value, Sequence) and not isinstance(value, str):
        return " ".join(_typed(option, metavar, each) for each in value)
    if isinstance(value, EllipsisType):
        return f"{option} {metavar}"
    return option if value is True else f"{option} {shlex.quote(str(value))}"


def _configuration(found: re.Match[str]) -> str:
    """`"28.65 0.2" (° and m)`, as one types it."""
    values = [each.split(" ") for each in found[0][1:-1].split(", ")]
    angle = math.degrees if DEGREES.get() else float
    typed = " ".join(f"{angle(float(value)) if unit == 'rad' else float(value):.4g}" for value, unit in values)
    return f'"{typed}" ({"°" if DEGREES.get() else "rad"} and m)'


def _in_degrees(found: re.Match[str]) -> str:
    """A quantity in degrees. What stands in quotes was typed, and stays as it is."""
    value = found["value"]
    if value is None:
        return found[0]
    digits = max(2, len(re.findall(r"\d", value.partition("e")[0]))) if "e" in value else 5  # of noise two are enough
    return f"{math.degrees(float(value)):.{digits}g}°{found['unit'].removeprefix('rad')}"


def worded(error: Exception) -> str:
    """An error's message: ours in the words of the command line, any other with its origin."""
    if isinstance(error, TwistarmError):
        return in_options(str(error))
    if isinstance(error, OSError):
        return f"the operating system refuses: {error}"
    return f"{type(error).__name__}: {error}; a fault of twistarm's: please report it with the output of --debug"
