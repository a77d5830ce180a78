"""The forms of arguments and quantities in messages, as in Python, which another program can find."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import EllipsisType
from typing import Any

from .errors import printable

ARGUMENT = re.compile(
    r"""(?<![\w.])(?P<name>[a-z_]+)=
    (?P<value>\.\.\. | True | -?\d[\d.e+-]*(?<!\.) | '(?:[^'\\]|\\.)*' | "(?:[^"\\]|\\.)*"
    | \[(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|[^]'"])*\] | \{(?:'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*"|[^}'"])*\})?""",
    re.VERBOSE,
)
"""What `argument` writes: a name and the literal of its value; `...` is a value that only the caller knows."""

QUANTITY = re.compile(r"(?<![\w.])(?P<value>-?(?:\d+(?:\.\d+)?(?:e[+-]?\d+)?|inf)) (?P<unit>rad(?:/s[²³]?)?)(?![\w/])")
"""What `quantity` writes of an angle or its rate."""

POSTURE = re.compile(r"\[-?[\d.e+-]+ (?:rad|m)(?:, -?[\d.e+-]+ (?:rad|m))*\]")
"""What `posture` writes."""

FRAME_NAMES = "arm.frame_names"
"""Where all frames are listed."""


def argument(name: str, value: Any = ...) -> str:
    """An argument with its value: `tip='wrist'`, `env=['NAME']`, `tip=...`."""
    return f"{name}={_literal(value)}"


def package_folder(held: str) -> str:
    """The argument for a package folder that holds `held`."""
    return f"{argument('package_dirs', [...])} (the folder that holds {printable(held)})"


def quantity(value: float, unit: str) -> str:
    """A value with its unit: `0.5 rad`."""
    return f"{value:.6g} {unit}"


def posture(theta: Sequence[float], units: Sequence[str]) -> str:
    """Joint values with their units: `[0.1 rad, 0.2 m]`."""
    return f"[{', '.join(f'{value:.4g} {unit}' for value, unit in zip(theta, units, strict=True))}]"


def _literal(value: Any) -> str:
    if isinstance(value, EllipsisType):
        return "..."
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{key!r}: {_literal(each)}' for key, each in value.items())}}}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return f"[{', '.join(map(_literal, value))}]"
    return repr(value)
