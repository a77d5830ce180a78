"""Messages in the words of the command line: options instead of arguments, and degrees where they were typed."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from typing import Any

from ..support.caller_words import CallerWords, Placeholder
from ..support.errors import TwistarmError

_OPTIONS = {
    "base": ("--base", "LINK"),
    "tip": ("--tip", "LINK"),
    "srdf": ("--srdf", "FILE"),
    "limits": ("--limits", "FILE"),
    "locked": ("--locked", "JOINT"),
    "without": ("--without", "PACKAGE"),
    "env": ("--env", "NAME"),
    "xacro_args": ("--xacro", "NAME:=VALUE"),
    "package_dirs": ("--package-dir", "FOLDER"),
    "stop_at_waypoints": ("--stop", ""),
    "approach": ("--approach", ""),
    "unwrap": ("--unwrap", ""),
    "position_tol": ("--position-tol", "M"),
    "orientation_tol": ("--orientation-tol", "ANGLE"),
}
"""The option of each argument that messages name, and how its value is called in `--help`."""

_COMMANDS = {"arm.frame_names": "twistarm info ARM --json"}


class CommandLineWords(CallerWords):
    """The words of the command line; `degrees`: of angles too."""

    def __init__(self, degrees: bool) -> None:
        self._degrees = degrees
        self.takes_radians = not degrees

    def name(self, argument: str) -> str:
        """`--tip`."""
        return _OPTIONS[argument][0]

    def argument(self, argument: str, value: Any) -> str:
        """`--tip wrist`, `--env NAME`, `--xacro dof:=7`."""
        option, metavar = _OPTIONS[argument]
        if isinstance(value, Mapping):
            pairs = [f"{key}:={'VALUE' if isinstance(each, Placeholder) else each}" for key, each in value.items()]
            return " ".join(shlex.join([option, pair]) for pair in pairs)
        if isinstance(value, Sequence) and not isinstance(value, str):
            return " ".join(self.argument(argument, each) for each in value)
        if isinstance(value, Placeholder):
            kind = f" (the one {value.removeprefix('folder ')})" if value.startswith("folder ") else ""
            return f"{option} {metavar}{kind}"
        if argument == "orientation_tol" and self._degrees:
            value = float(f"{math.degrees(value):.2g}")
        return option if value is True else f"{option} {shlex.quote(str(value))}"

    def expression(self, python: str) -> str:
        """The command that answers the same."""
        return _COMMANDS[python]

    def quantity(self, value: float, unit: str) -> str:
        """`28.6479°`, `28.6479°/s`, `0.1 m`."""
        if self._degrees and unit.startswith("rad"):
            return f"{math.degrees(value):.6g}°{unit.removeprefix('rad')}"
        return super().quantity(value, unit)

    def posture(self, theta: Sequence[float], units: Sequence[str]) -> str:
        """`"0.1 -28.65 57.3" (° and m)`."""
        values = [
            math.degrees(x) if self._degrees and unit == "rad" else x for x, unit in zip(theta, units, strict=True)
        ]
        return f'"{" ".join(f"{x:.4g}" for x in values)}" ({"°" if self._degrees else "rad"} and m)'


def told(error: Exception) -> str:
    """What an error is told as: ours in its own words, the system's as they are, any other as our fault."""
    if isinstance(error, TwistarmError):
        return str(error)
    if isinstance(error, OSError):
        return f"the operating system refuses: {error}"
    return f"{type(error).__name__}: {error}; a fault of twistarm's: please report it with the output of --debug"
