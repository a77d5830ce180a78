"""Tables for people, JSON for programs."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress

from ..arm.arm import Arm
from ..description.findings import Finding
from ..support.checks import Array
from ..support.errors import printable
from ..support.path_redaction import without_places
from ..theory.rotations import to_quaternion_wxyz, to_rpy
from .grid import Column, Grid
from .wording import words

PIPED_WIDTH = 160
"""Columns without a terminal. Tables stay in one piece."""


def console(file: TextIO | None = None) -> Console:
    """A console on stdout, or on `file`. Pass names through `literal` before you print them as markup."""
    out = file or sys.stdout
    known = out.isatty() or "COLUMNS" in os.environ
    return Console(file=out, width=None if known else PIPED_WIDTH, highlight=False, emoji=False)


def literal(text: object) -> str:
    """Text for a console's markup, shown unchanged and in one line."""
    return escape(printable(str(text)))


def as_written(text: str) -> str:
    """Text for output by Rich, with its brackets kept."""
    return escape(text)


def say(*lines: object, file: TextIO | None = None) -> None:
    """Print lines. Control characters in names do not reach the terminal."""
    print(*(printable(str(line)) for line in lines), sep="\n", file=file or sys.stdout, flush=True)


def warn(message: str, *, radians: bool = False) -> None:
    """A warning on stderr, in one line."""
    say(f"warning: {words(message, radians=radians)}", file=sys.stderr)


def note(message: str, *, radians: bool = False) -> None:
    """A note about an assumption, on stderr, in one line."""
    say(f"note: {words(message, radians=radians)}", file=sys.stderr)


def print_json(content: Any) -> None:
    """One JSON document; infinities become null."""
    text = json.dumps(plain(content), allow_nan=False, indent=2, ensure_ascii=False)
    print(_UNUSUAL.sub(_in_json, text))


_UNUSUAL = re.compile(r"[^\n -~]")


def _in_json(found: re.Match[str]) -> str:
    """A character that is not printable, escaped as in JSON."""
    return found[0] if found[0].isprintable() else json.dumps(found[0])[1:-1]


def finding_json(finding: Finding) -> dict[str, Any]:
    """A finding for programs: its place in parts, without folders of this machine."""
    place = finding.place
    here = Path(place.file)
    return {
        "code": finding.code,
        "severity": finding.severity,
        "file": without_places(place.file, here),
        "line": place.line,
        "element": place.element,
        "name": place.name,
        "what": without_places(words(finding.what, radians=True), here),
        "remedy": without_places(words(finding.remedy, radians=True), here),
        "repaired": finding.repaired,
    }


def plain(value: Any) -> Any:
    """Lists, numbers, texts and null only."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, (np.integer, np.bool_)):
        return value.item()
    return value


def table(
    title: str, columns: Sequence[str], rows: Sequence[Sequence[object]], text: Sequence[str] = (), caption: str = ""
) -> Grid:
    """A table of numbers, aligned to the right. The first column and the columns in `text` are aligned to the left."""
    cells = zip(*(map(printable, map(str, row)) for row in rows), strict=True) if rows else ((),) * len(columns)
    return Grid(
        printable(title),
        tuple(
            Column(printable(head), tuple(cell), left=i == 0 or head in text, wraps=head in text)
            for i, (head, cell) in enumerate(zip(columns, cells, strict=True))
        ),
        caption,
    )


def shown(arm: Arm, values: Array, radians: bool, digits: int = 4) -> list[str]:
    """Joint values for people: degrees (or rad) and metres."""
    return [
        number(x if unit == "m" or radians else np.degrees(x), digits)
        for x, unit in zip(values, arm.units, strict=True)
    ]


def units(arm: Arm, radians: bool) -> list[str]:
    """The units that `shown` uses."""
    return [unit if unit == "m" or radians else "°" for unit in arm.units]


def joint_heads(arm: Arm, radians: bool = True) -> list[str]:
    """The heads of columns of joints, with their units."""
    return [f"{name} [{unit}]" for name, unit in zip(arm.joint_names, units(arm, radians), strict=True)]


def theta_typed(arm: Arm, theta: Array, radians: bool) -> str:
    """theta (n,) as it can be typed or pasted: `--theta "0.1 -30 60"`."""
    return f'--theta "{theta_values(arm, theta, radians)}"' + " --rad" * radians


def theta_values(arm: Arm, theta: Array, radians: bool, digits: int = 6) -> str:
    """The numbers of `theta_typed`: 6 digits, to 1 µm and some 1e-8 rad (1e-6 rad in radians)."""
    return " ".join(shown(arm, theta, radians, digits=digits))


def number(value: float, digits: int = 4) -> str:
    """A number without trailing zeros; − for infinity and NaN."""
    if not np.isfinite(value):
        return "−"
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def matrix_rows(matrix: Array, names: Sequence[str]) -> list[list[str]]:
    """A row of text for each row of a matrix, its name first."""
    return [[name, *(f"{x:.6f}" for x in np.round(row, 6) + 0.0)] for name, row in zip(names, matrix, strict=True)]


def pose_table(title: str, g: Array, radians: bool) -> Grid:
    """A pose as matrix, position, rpy and quaternion."""
    angles = to_rpy(g[:3, :3])
    rpy = " ".join([*(number(x, 6) for x in angles), "rad"] if radians else [*map(number, np.degrees(angles)), "°"])
    quaternion = " ".join(number(x, 6) for x in to_quaternion_wxyz(g[:3, :3]))
    caption = f"quaternion (w x y z) {quaternion}\nroll pitch yaw {rpy}: turns about the base's x, then y, then z axis"
    return table(title, ["g", "x", "y", "z", "p [m]"], matrix_rows(g[:3], "xyz"), caption=caption)


def pose_json(g: Array) -> dict[str, Any]:
    """A pose for programs."""
    R = g[:3, :3]
    return {"matrix": g, "position": g[:3, 3], "rpy": to_rpy(R), "quaternion_wxyz": to_quaternion_wxyz(R)}


def jacobian_table(arm: Arm, title: str, J: Array) -> Grid:
    """A Jacobian with its rows and columns named."""
    return table(title, ["", *arm.joint_names], matrix_rows(J, ["v x", "v y", "v z", "ω x", "ω y", "ω z"]))


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], object]]:
    """A progress bar on stderr, on a terminal only, as a callback with the fraction done."""
    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(label, total=1.0)
        yield lambda fraction: bar.update(task, completed=fraction)
