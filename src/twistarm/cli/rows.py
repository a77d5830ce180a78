"""Targets that are typed, and rows of numbers in CSV: targets for `ik` and configurations for `fk`."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..arm.arm import Arm
from ..ik import Approach, Pose, Position
from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows, is_number, known_columns, lines_in
from ..support.errors import InputError, listed, shown
from ..support.fields import inside
from ..support.units import angle_hint
from .numbers import AXIS, RPY, WXYZ, XYZ, XYZW, numbers, option, parse_numbers, quantity, typed_option
from .output import note, warn

Target = Pose | Approach | Position

TURNS = "turns about the base's x, y and z axes, in this order [°, or rad with --rad]"
POINTS = "where the tool points, in base axes; turning about that is free"
EACH = "one for all positions, or repeated for each"


def _axis(text: str, option: str, radians: bool) -> Array:
    """A typed axis of the tool: a letter with an optional sign, or three numbers."""
    letter = text.strip().lstrip("+-−")
    if letter in ("x", "y", "z"):
        return np.eye(3)["xyz".index(letter)] * (-1.0 if text.strip()[0] in "-−" else 1.0)
    try:
        return parse_numbers(text, "1 1 1", option)
    except InputError as error:
        raise InputError(f"{option} takes x, y, z, -x, -y, -z or three numbers; got {text!r}") from error


Xyz = Annotated[Any, numbers("m m m", XYZ, "Position of the tool in the base frame, in metres.")]
Rpy = Annotated[Any, numbers("rad rad rad", RPY, f"Orientation: {TURNS}.")]
Quaternion = Annotated[Any, numbers("1 1 1 1", WXYZ, "Orientation, scalar first.", "--quaternion", "--quaternion-wxyz")]
QuaternionXyzw = Annotated[Any, numbers("1 1 1 1", XYZW, "Orientation, scalar last, as in ROS and SciPy.")]
Direction = Annotated[Any, numbers("1 1 1", XYZ, f"Only {POINTS}.")]
Positions = Annotated[
    list[Any] | None, numbers("m m m", XYZ, "Instead of --to: where the tool is to be, in metres; repeat it.", "--xyz")
]
Rpys = Annotated[list[Any] | None, numbers("rad rad rad", RPY, f"Orientation at --xyz: {TURNS}; {EACH}.", "--rpy")]
Directions = Annotated[list[Any] | None, numbers("1 1 1", XYZ, f"Only {POINTS}, at --xyz; {EACH}.", "--direction")]
Axis = Annotated[
    Any,
    typed_option(
        _axis,
        AXIS,
        "The tool's axis that --direction points: x, -y, … or three numbers; unless given, the one about which the "
        "last joint rolls the tool.",
    ),
]
PositionTol = Annotated[
    float | None, quantity("m", "How far off a position is still met; 1e-6 m, with ik --all 1e-9 m.")
]
OrientationTol = Annotated[
    float | None,
    quantity("rad", "How far the tool may be turned off [°, or rad with --rad]; 1e-6 rad, with ik --all 1e-9 rad."),
]


@dataclass(frozen=True)
class Orientation:
    """The typed orientation of the tool: roll, pitch, yaw [rad], a quaternion, a direction for an axis, or nothing."""

    rpy: Array | None = None
    wxyz: Array | None = None
    xyzw: Array | None = None
    direction: Array | None = None
    axis: Array | None = None

    def __post_init__(self) -> None:
        options = {"--rpy": self.rpy, "--quaternion": self.wxyz, "--quaternion-xyzw": self.xyzw}
        given = [option for option, each in (options | {"--direction": self.direction}).items() if each is not None]
        if len(given) > 1:
            raise InputError(f"give {' or '.join(given)}, not both: a whole orientation, or only where the tool points")

    @property
    def is_given(self) -> bool:
        """Whether an orientation is wanted."""
        return any(each is not None for each in (self.rpy, self.wxyz, self.xyzw, self.direction))

    def at(self, p: Array) -> Target:
        """The target with the tool's origin at p (3,) [m]."""
        if self.direction is not None:
            return Approach(p, self.direction, self.axis)
        if self.axis is not None:
            raise InputError("--axis says which axis of the tool --direction points: give a direction too")
        if self.rpy is not None:
            return Pose.from_rpy(p, self.rpy)
        if self.wxyz is not None or self.xyzw is not None:
            return Pose.from_quaternion(p, wxyz=self.wxyz, xyzw=self.xyzw)
        return Position(p)


def typed_targets(
    xyz: Sequence[Array], rpy: Sequence[Array], direction: Sequence[Array], axis: Array | None = None
) -> list[Target]:
    """The targets at positions, with one orientation for all or one for each."""
    if (rpy or direction or axis is not None) and not xyz:
        raise InputError("--rpy, --direction and --axis turn the tool at the positions of --xyz: give --xyz too")
    if rpy and direction:
        raise InputError("give --rpy or --direction, not both: a whole orientation, or only where the tool points")
    option, turned = ("rpy", rpy) if rpy else ("direction", direction)
    if turned and len(turned) not in (1, len(xyz)):
        count = f"{len(turned)} go with {len(xyz)} --xyz"
        raise InputError(f"give one --{option} for all positions, or one for each: {count}")
    every = [{option: turned[k % len(turned)]} if turned else {} for k in range(len(xyz))]
    return [Orientation(**each, axis=axis).at(p) for each, p in zip(every, xyz, strict=True)]


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
