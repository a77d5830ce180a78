"""Rows of numbers in CSV: targets for `ik` and configurations for `fk`, with or without a header."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..arm.arm import Arm
from ..ik import Pose
from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows, is_number, known_columns, lines_in
from ..support.errors import InputError, listed, shown
from ..support.fields import inside
from ..support.units import angle_hint
from .numbers import option
from .output import note, warn
from .targets import Orientation, Target

Columns = Annotated[str | None, option("A,B,…", "Names of the CSV's columns, where its header has none or others.")]

BOUNDS = Bounds(bytes=15_000_000, lines=100_000)
"""A row of seven numbers with all their digits has 140 bytes."""

STDIN = "-"

ROWS_SHOWN = 20
"""The most rows of answers and line numbers to show."""

POSITION, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
DIRECTION, QUATERNION = ("dx", "dy", "dz"), ("qx", "qy", "qz", "qw")
UNITS = dict.fromkeys(POSITION, "m") | dict.fromkeys(ANGLES, "rad") | dict.fromkeys((*DIRECTION, *QUATERNION), "1")

TARGET_COLUMNS = (
    "x, y, z [m], and to turn the tool qx, qy, qz, qw, or roll, pitch, yaw [rad], or dx, dy, dz to point it"
)

TARGET_NAMES = (
    {before + axis: axis for axis in "xyz" for before in ("", "p", "pos_", "position_", "position.", "pose.position.")}
    | {before + axis: f"d{axis}" for axis in "xyz" for before in ("d", "direction_", "direction.")}
    | {
        before + part: f"q{part}"
        for part in "xyzw"
        for before in ("q", "q_", "quaternion_", "quaternion.", "orientation_", "orientation.", "pose.orientation.")
    }
    | {name: name for name in ANGLES}
)
"""Names of the columns of targets, here and elsewhere."""

TWO_MEANINGS = {"rx", "ry", "rz"}
"""Some call the parts of a rotation vector so, others roll, pitch and yaw."""


def few(lines: Sequence[int]) -> str:
    """The first line numbers, and how many more there are."""
    left = len(lines) - ROWS_SHOWN
    return ", ".join(map(str, lines[:ROWS_SHOWN])) + (f" and {left} more" if left > 0 else "")


@dataclass(frozen=True)
class Sheet:
    """A CSV file: the names of its columns, and its rows."""

    file: str
    header: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def lines(self) -> list[int]:
        """The line of each row."""
        return [row.line for row in self.rows]

    def columns(self, known: Mapping[str, str], units: Mapping[str, str]) -> dict[str, Array]:
        """The values (N,) of the quantities in `units` [m, rad, 1] by the header's names in `known`, in SI.

        A unit may follow a name; the default is SI. Unknown columns are ignored with a note.
        """
        found, others = known_columns(self.header, known, units, self.file)
        if not found:
            return {}
        if others:
            note(f"{self.file}: not used: {', '.join(others)}")
        places, factors = zip(*found.values(), strict=True)
        values = [row.numbers(places, len(self.header), self.file) for row in self.rows]
        return dict(zip(found, (np.array(values) * factors).T, strict=True))

    def lacks(self, what: str) -> InputError:
        """The error for a header that does not name what is needed."""
        return InputError(f"{self.file}: {what}; its header has {listed(self.header)}")


def read_sheet(path: str, names: str | None, usual: Sequence[str]) -> Sheet:
    """The sheet in a file, or on standard input for -. `names` [a,b,c] replace its header.

    Lines with # are comments. The first other line is the header where it holds no numbers. Without a header and names
    the columns are the `usual` ones.
    """
    file = "standard input" if path == STDIN else path
    if path == STDIN and sys.stdin is None:
        raise InputError(f"there is no {file}: it is closed")
    lines = lines_in(sys.stdin.buffer, file, BOUNDS) if path == STDIN else csv_lines(path, BOUNDS)
    rows = list(csv_rows(lines, file))
    numeric = [is_number(cell.replace(",", ".")) for cell in rows[0].cells] if rows else []
    if any(numeric) and not all(numeric):
        raise InputError(f"{file}, line {rows[0].line}: neither a header nor a row of numbers: {shown(rows[0].cells)}")
    header = tuple(usual) if all(numeric) else tuple(cell.strip() for cell in rows.pop(0).cells)
    if not rows:
        raise InputError(f"{file} holds no rows of numbers")
    width = len(rows[0].cells)
    if names is not None:
        header = tuple(name.strip() for name in re.split(r"[,;]", names))
        if len(header) != width:
            raise InputError(f"--columns names {len(header)} columns; {file} has {width}")
    elif all(numeric) and len(usual) != width:
        raise InputError(f"{file} has {width} columns without names, not {', '.join(usual)}: name them by --columns")
    return Sheet(file, header, tuple(rows))


def configurations_in(arm: Arm, path: str, names: str | None) -> tuple[list[int], Array]:
    """Lines and theta (N, n) of a CSV's rows [rad, m]: a column per joint, by names or base to tip.

    Joints without a column take their value in ready, with a note.
    """
    sheet = read_sheet(path, names, arm.joint_names)
    known = {written: name for name in arm.joint_names for written in (name, f"{name}.position")}
    columns = sheet.columns(known, dict(zip(arm.joint_names, arm.units, strict=True)))
    if not columns:
        raise sheet.lacks(f"no column is a joint of {arm.name}: {listed(arm.joint_names)}")
    if others := [name for name in arm.joint_names if name not in columns]:
        note(f"{', '.join(others)} as in the pose ready")
    theta = np.tile(arm.ready, (len(sheet.rows), 1))
    theta[:, [arm.joint_names.index(name) for name in columns]] = np.stack([*columns.values()], axis=1)
    outside = [line for line, inside in zip(sheet.lines, arm.limits.contains(theta), strict=True) if not inside]
    if outside:
        advice = f"angles are rad unless the header says so, as in '{arm.joint_names[-1]} [deg]'"
        warn(f"{sheet.file}: outside the limits: line {few(outside)}; {advice}")
    return sheet.lines, theta


def targets_in(path: str, names: str | None, orientation: Orientation) -> tuple[list[int], list[Target]]:
    """Lines and targets of a CSV's rows: positions, with the header's or the options' orientation."""
    sheet = read_sheet(path, names, POSITION)
    if TWO_MEANINGS & {cell.casefold() for cell in sheet.header}:
        raise InputError(f"{sheet.file}: rx, ry, rz mean two things: name them roll, pitch, yaw, or write quaternions")
    columns = sheet.columns(TARGET_NAMES, UNITS)
    kinds = [kind for kind in (ANGLES, DIRECTION, QUATERNION) if any(name in columns for name in kind)]
    kind = kinds[0] if kinds else ()
    if missing := [name for name in (*POSITION, *kind) if name not in columns]:
        raise sheet.lacks(f"no column {', '.join(missing)}; targets have {TARGET_COLUMNS}")
    if len(kinds) > 1 or (kinds and orientation.is_given):
        raise InputError(f"{sheet.file}: its columns and the options turn the tool in more than one way; keep one")
    targets: list[Target] = []
    for line, values in zip(sheet.lines, np.stack([columns[name] for name in (*POSITION, *kind)], axis=1), strict=True):
        p, turned = values[:3], values[3:]
        with inside(sheet.file, f"line {line}"):
            if kind == ANGLES and (hint := angle_hint(turned)):
                raise InputError(f"{hint}: name the column 'roll [deg]'")
            if kind == ANGLES:
                targets.append(Pose.from_rpy(p, turned))
            elif kind == QUATERNION:
                targets.append(Pose.from_quaternion(p, xyzw=turned))
            else:
                towards = Orientation(direction=turned, axis=orientation.axis) if kind else orientation
                targets.append(towards.at(p))
    return sheet.lines, targets
