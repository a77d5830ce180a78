"""Targets that are typed, and rows of numbers in CSV: targets for `ik` and configurations for `fk`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..arm.arm import Arm
from ..ik import Approach, Pose, Position
from ..support.checks import Array
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows, is_number, known_columns, lines_in
from ..support.errors import InputError, listed, quote
from ..support.fields import inside
from ..support.units import angle_hint
from .command import Shared
from .numbers import AXIS, RPY, WXYZ, XYZ, XYZW, numbers, parse_numbers, quantity, typed_option
from .output import note, warn

Target = Pose | Approach | Position

TURNS = ("rpy", "quaternion", "quaternion_xyzw", "direction")  # What turns the tool: one of them at most.

Repeated = list[Any] | None

ROWS_SHOWN = 20  # The most rows of answers and line numbers to show.


def _axis(text: str, option: str, radians: bool) -> Array:
    """A typed axis of the tool: a letter with an optional sign, or three numbers."""
    sign, letter = text.strip()[:-1], text.strip()[-1:]
    if letter in ("x", "y", "z") and sign in ("", "+", "-", "−"):
        return np.eye(3)["xyz".index(letter)] * (-1.0 if sign in ("-", "−") else 1.0)
    try:
        return parse_numbers(text, "1 1 1", option)
    except InputError as error:
        raise InputError(f"{option} takes x, y, z, -x, -y, -z or three numbers; got {text!r}") from error


PositionTol = Annotated[float | None, quantity("m", "Tolerance of the position; 1e-5 m by default.")]
OrientationTol = Annotated[
    float | None, quantity("rad", "Tolerance of the orientation [°, or rad with --rad]; 5e-5 rad by default.")
]


@dataclass(frozen=True)
class TypedTargets:
    """The typed positions of the tool, with one orientation for all of them, or one for each.

    `ik` takes one position, `plan` and `designs` take several.
    """

    xyz: Annotated[Repeated, numbers("m m m", XYZ, "Where the tool is to be, in the base frame [m].")] = None
    rpy: Annotated[
        Repeated, numbers("rad rad rad", RPY, "Turns about the base's x, y and z axes, in this order [°, or rad].")
    ] = None
    quaternion: Annotated[Repeated, numbers("1 1 1 1", WXYZ, "Orientation, scalar first.")] = None
    quaternion_xyzw: Annotated[Repeated, numbers("1 1 1 1", XYZW, "Orientation, scalar last, as in ROS and SciPy.")] = (
        None
    )
    direction: Annotated[
        Repeated, numbers("1 1 1", XYZ, "Only where the tool points, in base axes; turning about that is free.")
    ] = None
    axis: Annotated[
        Any, typed_option(_axis, AXIS, "The tool's axis that --direction points: x, -y, … or three numbers; unless "
                          "given, the one about which the last joint rolls the tool."),
    ] = None  # fmt: skip

    def __post_init__(self) -> None:
        given = [f"--{name.replace('_', '-')}" for name in TURNS if getattr(self, name)]
        if len(given) > 1:
            raise InputError(f"give {' or '.join(given)}, not both: a whole orientation, or only where the tool points")
        if self.axis is not None and not self.direction:
            raise InputError("--axis chooses the axis of the tool for --direction: give a direction too")
        count = len(self.xyz or ())
        turns = max(len(getattr(self, name) or ()) for name in TURNS)
        if turns > 1 and turns != count:
            raise InputError(f"give one {given[0]} for all positions, or one for each; got {turns} for {count} --xyz")

    @property
    def has_orientation(self) -> bool:
        """Whether an orientation is wanted."""
        return any(getattr(self, name) for name in TURNS)

    def at(self, p: Array, k: int = 0) -> Target:
        """The target with the tool's origin at p (3,) [m], turned as the k-th."""
        rpy, wxyz, xyzw, direction = (
            values[k % len(values)] if values else None for values in (getattr(self, name) for name in TURNS)
        )
        if direction is not None:
            return Approach(p, direction, self.axis)
        if rpy is not None:
            return Pose.from_rpy(p, rpy)
        if wxyz is not None or xyzw is not None:
            return Pose.from_quaternion(p, wxyz=wxyz, xyzw=xyzw)
        return Position(p)

    def all(self) -> list[Target]:
        """The targets at the typed positions."""
        if self.has_orientation and not self.xyz:
            raise InputError("an orientation turns the tool at the positions of --xyz: give --xyz too")
        return [self.at(p, k) for k, p in enumerate(self.xyz or ())]


TargetOptions = Annotated[TypedTargets, Shared(TypedTargets, panel="The target")]

BOUNDS = Bounds(bytes=15_000_000, lines=100_000)  # A row of seven numbers with all their digits has 140 bytes.

STDIN = "-"

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

TWO_MEANINGS = {"rx", "ry", "rz"}  # Some call the parts of a rotation vector so, others roll, pitch and yaw.


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

        A unit may follow a name. The default is SI. Unknown columns are ignored with a note.
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


def read_sheet(path: str, usual: Sequence[str]) -> Sheet:
    """The sheet in a file, or on standard input for -.

    Lines with # are comments. The first other line is the header where it holds no numbers. Without a header the
    columns are the `usual` ones.
    """
    file = "standard input" if path == STDIN else path
    if path == STDIN and sys.stdin is None:
        raise InputError(f"there is no {file}: it is closed")
    lines = lines_in(sys.stdin.buffer, file, BOUNDS) if path == STDIN else csv_lines(path, BOUNDS)
    rows = list(csv_rows(lines, file))
    numeric = [is_number(cell.replace(",", ".")) for cell in rows[0].cells] if rows else []
    if any(numeric) and not all(numeric):
        raise InputError(f"{file}, line {rows[0].line}: neither a header nor a row of numbers: {quote(rows[0].cells)}")
    header = tuple(usual) if all(numeric) else tuple(cell.strip() for cell in rows.pop(0).cells)
    if not rows:
        raise InputError(f"{file} holds no rows of numbers")
    if all(numeric) and len(usual) != len(rows[0].cells):
        raise InputError(f"{file} has {len(rows[0].cells)} columns without names, not {', '.join(usual)}: add a header")
    return Sheet(file, header, tuple(rows))


def configurations_in(arm: Arm, path: str) -> tuple[list[int], Array]:
    """Lines and theta (N, n) of a CSV's rows [rad, m]. A column per joint, by names or base to tip.

    Joints without a column take their value in ready, with a note.
    """
    sheet = read_sheet(path, arm.joint_names)
    known = {written: name for name in arm.joint_names for written in (name, f"{name}.position")}
    columns = sheet.columns(known, dict(zip(arm.joint_names, arm.units, strict=True)))
    if not columns:
        raise sheet.lacks(f"no column is a joint of {arm.name}: {listed(arm.joint_names)}")
    if others := [name for name in arm.joint_names if name not in columns]:
        note(f"{', '.join(others)} as in ready")
    theta = np.tile(arm.ready, (len(sheet.rows), 1))
    theta[:, [arm.joint_names.index(name) for name in columns]] = np.stack([*columns.values()], axis=1)
    outside = [line for line, inside in zip(sheet.lines, arm.limits.contains(theta), strict=True) if not inside]
    if outside:
        advice = f"angles are rad unless the header says so, as in '{arm.joint_names[-1]} [deg]'"
        warn(f"{sheet.file}: outside the limits: line {few(outside)}; {advice}")
    return sheet.lines, theta


def targets_in(path: str, typed: TypedTargets) -> tuple[list[int], list[Target]]:
    """Lines and targets of a CSV's rows: positions, with the header's or the options' orientation."""
    sheet = read_sheet(path, POSITION)
    if TWO_MEANINGS & {cell.casefold() for cell in sheet.header}:
        raise InputError(f"{sheet.file}: rx, ry, rz mean two things: name them roll, pitch, yaw, or write quaternions")
    columns = sheet.columns(TARGET_NAMES, UNITS)
    kinds = [kind for kind in (ANGLES, DIRECTION, QUATERNION) if any(name in columns for name in kind)]
    kind = kinds[0] if kinds else ()
    if missing := [name for name in (*POSITION, *kind) if name not in columns]:
        raise sheet.lacks(f"no column {', '.join(missing)}; targets have {TARGET_COLUMNS}")
    if len(kinds) > 1 or (kinds and typed.has_orientation):
        raise InputError(f"{sheet.file}: its columns and the options turn the tool in more than one way; keep one")
    targets: list[Target] = []
    for line, values in zip(sheet.lines, np.stack([columns[name] for name in (*POSITION, *kind)], axis=1), strict=True):
        p, orientation = values[:3], values[3:]
        with inside(sheet.file, f"line {line}"):
            if kind == ANGLES and (hint := angle_hint(orientation)):
                raise InputError(f"{hint}: name the column 'roll [deg]'")
            if kind == ANGLES:
                targets.append(Pose.from_rpy(p, orientation))
            elif kind == QUATERNION:
                targets.append(Pose.from_quaternion(p, xyzw=orientation))
            else:
                targets.append(Approach(p, orientation, typed.axis) if kind else typed.at(p))
    return sheet.lines, targets
