"""Targets for inverse kinematics, typed or in a CSV file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import typer

from ..ik import Approach, Pose, Position
from ..support.checks import Array, as_positive
from ..support.errors import InputError
from ..support.fields import inside
from ..support.unit_hints import TURN, angle_hint
from .command import AXIS, RPY, WXYZ, XYZ, XYZW
from .csv_rows import Sheet, no_column
from .quantities import quantity
from .typed import parse_numbers

Target = Pose | Approach | Position

Rpy = Annotated[
    str | None,
    typer.Option(
        metavar=RPY, help="Orientation: turns about the base's x, y and z axes, in this order [°, or rad with --rad]."
    ),
]
Quaternion = Annotated[
    str | None, typer.Option("--quaternion", "--quaternion-wxyz", metavar=WXYZ, help="Orientation, scalar first.")
]
QuaternionXyzw = Annotated[
    str | None, typer.Option(metavar=XYZW, help="Orientation, scalar last, as in ROS and SciPy.")
]
Direction = Annotated[
    str | None, typer.Option(metavar=XYZ, help="Only where the tool points, in base axes; turning about that is free.")
]
Axis = Annotated[
    str | None,
    typer.Option(
        metavar=AXIS,
        help="The tool's axis that --direction points: x, -y, … or three numbers; unless given, the one about which "
        "the last joint rolls the tool.",
    ),
]
PositionTol = Annotated[
    float | None, quantity("m", "How far off a position is still met; 1e-6 m, with ik --all 1e-9 m.")
]
OrientationTol = Annotated[
    str | None,
    typer.Option(
        metavar="ANGLE",
        help="How far the tool may be turned off [°, or rad with --rad]; 1e-6 rad, with ik --all 1e-9 rad.",
    ),
]

ORIGIN = (0.0, 0.0, 0.0)

POSITION, ANGLES = ("x", "y", "z"), ("roll", "pitch", "yaw")
DIRECTION, QUATERNION = ("dx", "dy", "dz"), ("qx", "qy", "qz", "qw")
UNITS = dict.fromkeys(POSITION, "m") | dict.fromkeys(ANGLES, "rad") | dict.fromkeys((*DIRECTION, *QUATERNION), "1")

COLUMNS = "x, y, z [m], and to turn the tool qx, qy, qz, qw, or roll, pitch, yaw [rad], or dx, dy, dz to point it"

COLUMN_NAMES = (
    {said + axis: axis for axis in "xyz" for said in ("", "p", "pos_", "position_", "position.", "pose.position.")}
    | {said + axis: f"d{axis}" for axis in "xyz" for said in ("d", "direction_", "direction.")}
    | {
        said + part: f"q{part}"
        for part in "xyzw"
        for said in ("q", "q_", "quaternion_", "quaternion.", "orientation_", "orientation.", "pose.orientation.")
    }
    | {name: name for name in ANGLES}
)
"""Names of the columns, here and elsewhere."""

TWO_MEANINGS = {"rx", "ry", "rz"}
"""Some call the parts of a rotation vector so, others roll, pitch and yaw."""


@dataclass(frozen=True)
class Orientation:
    """The wanted orientation of the tool: a rotation, a direction for an axis, or nothing."""

    rotation: Array | None = None
    direction: Array | None = None
    axis: Array | None = None

    @property
    def is_given(self) -> bool:
        """Whether an orientation is wanted."""
        return self.rotation is not None or self.direction is not None

    def at(self, p: Array) -> Target:
        """The target with the tool's origin at p (3,) [m]."""
        if self.direction is not None:
            return Approach(p, self.direction, self.axis)
        if self.axis is not None:
            raise InputError("--axis says which axis of the tool --direction points: give a direction too")
        if self.rotation is None:
            return Position(p)
        g = np.eye(4)
        g[:3, :3], g[:3, 3] = self.rotation, p
        return Pose(g)


def typed_orientation(
    rpy: str | None, wxyz: str | None, xyzw: str | None, direction: str | None, axis: str | None, radians: bool
) -> Orientation:
    """The orientation of the options."""
    options = {"--rpy": rpy, "--quaternion": wxyz, "--quaternion-xyzw": xyzw, "--direction": direction}
    given = {option: text for option, text in options.items() if text is not None}
    if len(given) > 1:
        which = " or ".join(given)
        raise InputError(f"give {which}, not both: a whole orientation, or only where the tool points")
    tool_axis = None if axis is None else _axis(axis)
    for option, text in given.items():
        if option == "--direction":
            return Orientation(direction=parse_numbers(text, "1 1 1", option), axis=tool_axis)
        if option == "--rpy":
            angles = parse_numbers(text, "rad rad rad", option, radians)
            turned = Pose.from_rpy(ORIGIN, angles if radians else np.fmod(angles, TURN))
        else:
            order = "xyzw" if option == "--quaternion-xyzw" else "wxyz"
            turned = Pose.from_quaternion(ORIGIN, **{order: parse_numbers(text, "1 1 1 1", option)})
        return Orientation(rotation=turned.g[:3, :3])
    return Orientation(axis=tool_axis)


def typed_tolerances(position: float | None, orientation: str | None, radians: bool) -> dict[str, Any]:
    """The tolerances that were typed [m, rad], as solvers and planners take them."""
    typed: dict[str, Any] = {}
    if position is not None:
        typed["position_tol"] = position
    if orientation is not None:
        (angle,) = parse_numbers(orientation, "rad", "--orientation-tol", radians)
        typed["orientation_tol"] = as_positive(angle, "--orientation-tol")
    return typed


def _axis(text: str) -> Array:
    """A typed axis of the tool: a letter with an optional sign, or three numbers."""
    letter = text.strip().lstrip("+-−")
    if letter in ("x", "y", "z"):
        axis = np.zeros(3)
        axis["xyz".index(letter)] = -1.0 if text.strip()[0] in "-−" else 1.0
        return axis
    try:
        return parse_numbers(text, "1 1 1", "--axis")
    except InputError as error:
        raise InputError(f"--axis takes x, y, z, -x, -y, -z or three numbers; got {text!r}") from error


def targets_in(sheet: Sheet, orientation: Orientation) -> list[Target]:
    """The targets of a CSV's rows: positions, with the header's or the options' orientation."""
    if sheet.header is None:
        width = len(sheet.rows[0].cells)
        if width != 3:
            raise InputError(f"{sheet.file} has {width} columns without names: add --columns with those of {COLUMNS}")
        sheet = Sheet(sheet.file, POSITION, sheet.rows)
    if TWO_MEANINGS & {cell.casefold() for cell in sheet.header or ()}:
        raise InputError(f"{sheet.file}: rx, ry, rz mean two things: name them roll, pitch, yaw, or write quaternions")
    columns = sheet.columns(COLUMN_NAMES, UNITS)
    kinds = [kind for kind in (ANGLES, DIRECTION, QUATERNION) if any(name in columns for name in kind)]
    needed = (*POSITION, *(kinds[0] if kinds else ()))
    missing = [name for name in needed if name not in columns]
    if missing:
        raise no_column(sheet, f"no column {', '.join(missing)}; targets have {COLUMNS}")
    if len(kinds) > 1 or (kinds and orientation.is_given):
        raise InputError(f"{sheet.file}: its columns and the options turn the tool in more than one way; keep one")
    places = [columns[name] for name in needed]
    targets = []
    for row in sheet.rows:
        values = sheet.numbers(row, places)
        with inside(sheet.file, f"line {row.line}"):
            targets.append(_target(values, kinds[0] if kinds else (), orientation))
    return targets


def _target(values: Array, kind: tuple[str, ...], orientation: Orientation) -> Target:
    """The target of a row: its position, then what `kind` names."""
    if kind == ANGLES:
        if angle_hint(values[3:]):
            raise InputError(f"{angle_hint(values[3:])}: name the column 'roll [deg]'")
        return Pose.from_rpy(values[:3], values[3:])
    if kind == QUATERNION:
        return Pose.from_quaternion(values[:3], xyzw=values[3:])
    if kind == DIRECTION:
        orientation = Orientation(direction=values[3:], axis=orientation.axis)
    return orientation.at(values[:3])
