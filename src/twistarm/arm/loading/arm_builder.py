"""Arms built joint by joint in Python from the six lower pairs. They are read and proven like an arm from a file."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...description.bounds import LIMIT_NAMES
from ...description.companions.arm_file import ArmSpecification
from ...description.document import LARGEST, Reading
from ...description.packages import PackageIndex
from ...description.planar import coordinate_names
from ...description.urdf import build_description
from ...description.writing import add_joint, add_mimic
from ...limits.joint_limits import JointLimits
from ...support.checks import Array, as_pose, as_rotation, frozen, require_one
from ...support.errors import InputError, listed, shown
from ...support.fields import fields, inside, number, positive
from ...theory import joints
from ...theory.screws import inverse, to_screw
from ..arm import Arm
from .load import assemble, proven

BASE = "base"
"""The root link: the base frame, in which everything is given."""


UNIT = 1e-12
"""Largest rounding of a unit twist, and of the pitch of a revolute one for each metre of reach."""


LIMITS = {
    "lower": partial(number, least=-np.inf, most=np.inf),
    "upper": partial(number, least=-np.inf, most=np.inf),
    "velocity": partial(positive, most=np.inf),
    "effort": partial(positive, most=np.inf),
}
UNLIMITED = {"lower": -np.inf, "upper": np.inf, "velocity": np.inf, "effort": np.inf}


@dataclass(frozen=True, eq=False)
class _Part:
    """One `<joint>`: its frame (4, 4) in the base frame at rest, its unit axis (3,) in that frame, and its limits."""

    name: str
    kind: str
    frame: Array
    axis: Array
    limit: Mapping[str, float] = field(default_factory=dict)
    master: str = ""
    multiplier: float = 1.0


@dataclass(frozen=True, eq=False)
class ArmBuilder:
    """An arm joint by joint, base to tip: `ArmBuilder("arm").revolute(…).cylindrical(…).tool(home).build()`.

    Give every axis, normal and point (3,) [m] in base axes with the arm at rest, theta = 0, as in MLS §3.2. Each
    method adds to the end of the chain and returns a new builder. The old builder does not change. A joint `j` with
    several coordinates names them `j_rz, j_z` (cylindrical), `j_rz, j_ry, j_rx` (spherical) or `j_x, j_y, j_rz`
    (planar). Give limits with the joint [rad or m, /s, N m or N], or for each coordinate in `build(limits=…)`. A limit
    that you leave out is infinite.

    Each method raises InputError for a name used twice, a zero axis, a number that is not finite or swapped limits.
    """

    name: str
    _parts: tuple[_Part, ...] = field(default=(), repr=False)
    _names: tuple[str, ...] = field(default=(), repr=False)
    _home: Array | None = field(default=None, repr=False)
    _tool: str = field(default="", repr=False)
    _base: str = field(default=BASE, repr=False)

    def __post_init__(self) -> None:
        _check_name(self.name, "the arm's name")

    def revolute(self, name: str, axis: ArrayLike, point: ArrayLike, **limits: float | None) -> ArmBuilder:
        """A turn [rad] about the line along `axis` through `point`. Without bounds it is continuous.

        Args:
            name: The joint's name.
            axis: Direction (3,) in the base frame, of any length but 0.
            point: A point of the axis (3,) [m], in the base frame.
            limits: `lower` and `upper` [rad], `velocity` [rad/s] and `effort` [N m].
        """
        with _joint(name):
            return self._with(name, _turn(name, axis, _at(axis, point), limits))

    def prismatic(self, name: str, axis: ArrayLike, **limits: float | None) -> ArmBuilder:
        """A slide [m] along `axis`. It is drawn at the previous joint.

        Args:
            name: The joint's name.
            axis: Direction (3,) in the base frame, of any length but 0.
            limits: `lower` and `upper` [m], `velocity` [m/s] and `effort` [N].
        """
        with _joint(name):
            return self._with(name, _slide(name, axis, _at(axis, self._last), limits))

    def helical(self, name: str, axis: ArrayLike, point: ArrayLike, pitch: float, **limits: float | None) -> ArmBuilder:
        """A turn [rad] about a line with `pitch` [m/rad] of slide along it. A thread of lead l has the pitch l/2π.

        URDF has no helical joint. The file gets a turn, and a slide `name_z` that mimics it.

        Args:
            name: The joint's name.
            axis: Direction (3,) in the base frame, of any length but 0.
            point: A point of the axis (3,) [m], in the base frame.
            pitch: Advance [m/rad].
            limits: Those of the turn, as in `revolute`.
        """
        with _joint(name):
            turn = _turn(name, axis, _at(axis, point), limits)
            slide = _slide(f"{name}_z", axis, turn.frame)
            advance = number(pitch, "pitch", -LARGEST, LARGEST)
            return self._with(name, turn, replace(slide, master=name, multiplier=advance))

    def cylindrical(self, name: str, axis: ArrayLike, point: ArrayLike) -> ArmBuilder:
        """Add a turn `name_rz` [rad] about a line and a slide `name_z` [m] along it.

        Args:
            name: The joint's name.
            axis: Direction (3,) in the base frame, of any length but 0.
            point: A point of the axis (3,) [m], in the base frame.
        """
        with _joint(name):
            frame = _at(axis, point)
            return self._with(name, _turn(f"{name}_rz", axis, frame), _slide(f"{name}_z", axis, frame))

    def spherical(self, name: str, point: ArrayLike, axes: ArrayLike | None = None) -> ArmBuilder:
        """Add a ball at `point`, as ZYX Euler angles `name_rz, name_ry, name_rx` [rad].

        The columns of `axes` (3, 3) are the joint's x, y and z at rest. The coordinates are singular at
        name_ry = ±π/2; the ball itself is not.

        Args:
            name: The joint's name.
            point: The ball's centre (3,) [m], in the base frame.
            axes: A rotation (3, 3), or None for the identity.
        """
        with _joint(name):
            joints.spherical(point, axes)
            R = np.eye(3) if axes is None else as_rotation(axes, "axes")
            frame = _at(R[:, 2], point)
            turns = (_turn(f"{name}_r{'xyz'[i]}", R[:, i], frame) for i in (2, 1, 0))
            return self._with(name, *turns)

    def planar(
        self, name: str, normal: ArrayLike, point: ArrayLike = (0.0, 0.0, 0.0), x_axis: ArrayLike | None = None
    ) -> ArmBuilder:
        """Add slides `name_x, name_y` [m] in a plane, then the turn `name_rz` [rad] about its normal through `point`.

        The slides go along the columns of `joints.plane_axes(normal, x_axis)`. The file has the normal along z,
        because some readers ignore the axis of a planar joint.

        Args:
            name: The joint's name.
            normal: The plane's normal (3,) in the base frame, of any length but 0.
            point: A point of the line of the turn (3,) [m], in the base frame.
            x_axis: Direction of the first slide (3,), or None.
        """
        with _joint(name):
            frame = _at(normal, point)
            frame[:3, :3] = joints.plane_axes(normal, x_axis)
            return self._with(name, _Part(name, "planar", frame, np.array([0.0, 0.0, 1.0])))

    def tool(self, home: ArrayLike, name: str = "tool") -> ArmBuilder:
        """The tool frame `name` at `home` (4, 4) in the base frame, with the arm at rest.

        Args:
            home: The tool's pose (4, 4), seen from the base.
            name: The tool frame's name.

        Raises:
            InputError: home is not one pose in SE(3), or the tool is given already.
        """
        _check_name(name, "the tool's name")
        if self._home is not None:
            raise InputError(f"the tool {self._tool!r} is given already; give it once")
        g = require_one(as_pose(home, "home"), "home", 2)
        number(float(np.abs(g[:3, 3]).max()), "home", most=LARGEST, unit="m")
        return replace(self, _home=frozen(g), _tool=name)._checked()

    def urdf(self) -> str:
        """The arm as URDF. `load_arm` makes the same arm from it."""
        if self._home is None:
            raise InputError(f"{self.name} has no tool: say where it is with .tool(home)")
        if not self._parts:
            raise InputError(f"{self.name} has no joints: add one, .revolute(name, axis, point) say")
        robot = ET.Element("robot", name=self.name)
        ET.SubElement(robot, "link", name=self._base)
        parent, last = self._base, np.eye(4)
        for part in self._parts:
            ends = parent, f"{part.name}_link"
            joint = add_joint(robot, part.name, part.kind, ends, inverse(last) @ part.frame, part.axis, part.limit)
            if part.master:
                add_mimic(joint, part.master, part.multiplier)
            parent, last = ends[1], part.frame
        add_joint(robot, f"{self._tool}_mount", "fixed", (parent, self._tool), inverse(last) @ self._home)
        ET.indent(robot)
        return ET.tostring(robot, encoding="unicode") + "\n"

    def build(self, *, limits: JointLimits | Mapping[str, Any] | None = None) -> Arm:
        """Read the arm from `urdf()` and prove it against Pinocchio. `limits` are as in `load_arm`."""
        return arm_of_urdf(
            self.urdf(), ArmSpecification(Path(self.name), "ArmBuilder", base=self._base, tip=self._tool), limits
        )

    # -- inside --------------------------------------------------------------------------------------------------

    @property
    def _last(self) -> Array:
        """Where the last joint is (3,)."""
        return self._parts[-1].frame[:3, 3] if self._parts else np.zeros(3)

    def _with(self, name: str, *parts: _Part) -> ArmBuilder:
        coordinates = coordinate_names(name) if parts[0].kind == "planar" else tuple(part.name for part in parts)
        names = dict.fromkeys((name, *coordinates))
        taken = [each for each in names if each in self._names]
        if taken:
            raise InputError(f"the name {taken[0]!r} is used already; it needs {listed(names)}: rename one")
        return replace(self, _parts=(*self._parts, *parts), _names=(*self._names, *names))._checked()

    def _checked(self) -> ArmBuilder:
        """Return the builder. Raise InputError if the tool has the name of a link, or its mount the name of a joint."""
        links = [self._base, *(f"{name}_link" for name in self._names)]
        if self._tool in links or f"{self._tool}_mount" in self._names:
            raise InputError(f"the tool's name {self._tool!r} clashes with a joint's or its link's; rename the tool")
        return self


def builder_of(arm: Arm) -> ArmBuilder:
    """The builder of an arm that has no description, from its screws, home, coupling and limits.

    Raises InputError for a joint that turns or slides by another rate than its coordinate, or follows several.
    """
    builder = ArmBuilder(arm.name, _base=arm.base)
    moving = [(name, to_screw(arm.screws[:, i]), arm.coupling.A[i]) for i, name in enumerate(arm.moving_names)]
    for name, screw, row in moving:
        if not row.any():  # a locked joint
            continue
        j, *others = np.flatnonzero(row)
        master, rate = arm.joint_names[j], float(row[j])
        if others or master not in arm.moving_names or abs(screw.magnitude - 1.0) > UNIT:
            raise InputError(f"{arm.name}: URDF has no joint like {name!r}: it turns or slides by a rate of its own")
        limits = {each: float(getattr(arm.limits, each)[j]) for each in LIMIT_NAMES} if master == name else {}
        slides = bool(np.isinf(screw.pitch))
        frame = _at(screw.axis, builder._last if slides else screw.point)
        parts = [(_slide if slides else _turn)(name, screw.axis, frame, limits)]
        if not slides and abs(screw.pitch) > UNIT * arm.reach:
            parts.append(replace(_slide(f"{name}_z", screw.axis, frame), multiplier=float(screw.pitch)))
        follows = [part if part.name == master else replace(part, master=master) for part in parts]
        builder = builder._with(name, *(replace(p, multiplier=rate * p.multiplier) if p.master else p for p in follows))
    return builder.tool(arm.home, arm.tip)


def arm_of_urdf(
    text: str, specification: ArmSpecification, limits: JointLimits | Mapping[str, Any] | None = None
) -> Arm:
    """The arm of a URDF text that no file holds, proven as one from a file is."""
    source = specification.description
    description = build_description(text, Reading(source, PackageIndex(source)))
    return proven(assemble(replace(description, path=None), specification, {} if limits is None else limits))


def _joint(name: object) -> AbstractContextManager[None]:
    """Name the joint in errors."""
    _check_name(name, "a joint's name")
    return inside(f"joint {name!r}")


def _turn(name: str, axis: ArrayLike, frame: Array, limits: Mapping[str, float | None] | None = None) -> _Part:
    limit = _limit(limits or {})
    unbounded = np.isinf([limit["lower"], limit["upper"]]).all()
    return _Part(name, "continuous" if unbounded else "revolute", frame, joints.prismatic(axis)[:3, 0], limit)


def _slide(name: str, axis: ArrayLike, frame: Array, limits: Mapping[str, float | None] | None = None) -> _Part:
    return _Part(name, "prismatic", frame, joints.prismatic(axis)[:3, 0], _limit(limits or {}))


def _at(axis: ArrayLike, point: ArrayLike) -> Array:
    """A frame at `point` with base axes. `joints` checks the axis and the point."""
    joints.revolute(axis, point)
    frame = np.eye(4)
    frame[:3, 3] = point
    number(float(np.abs(frame[:3, 3]).max()), "point", most=LARGEST, unit="m")
    return frame


def _limit(given: Mapping[str, float | None]) -> dict[str, float]:
    """The checked limits, infinite where none is given."""
    limit = UNLIMITED | fields({name: x for name, x in given.items() if x is not None}, "", {}, LIMITS)
    if not limit["lower"] <= limit["upper"] or limit["lower"] == np.inf or limit["upper"] == -np.inf:
        raise InputError(f"lower must not exceed upper; got lower {limit['lower']:g} and upper {limit['upper']:g}")
    return limit


def _check_name(name: object, what: str) -> None:
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise InputError(f"{what} must be a text of printable characters; got {shown(name)}")
