"""Targets that are typed: positions, orientations and tolerances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ..ik import Approach, Pose, Position
from ..support.checks import Array
from ..support.errors import InputError
from .numbers import AXIS, RPY, WXYZ, XYZ, XYZW, numbers, parse_numbers, quantity, typed_option

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
PositionTol = Annotated[float | None, quantity("m", "How far off a position is still met; 1e-5 m by default.")]
OrientationTol = Annotated[
    float | None, quantity("rad", "How far the tool may be turned off [°, or rad with --rad]; 5e-5 rad by default.")
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
