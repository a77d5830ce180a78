"""Arms made in Python: from their screws, or joint by joint from the six lower pairs."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...description.bounds import LIMIT_NAMES
from ...description.companions.arm_file import ArmSpecification
from ...description.document import LARGEST, Reading
from ...description.packages import PackageIndex
from ...description.urdf import build_description
from ...description.writing import add_joint, add_mimic
from ...limits.joint_limits import JointLimits
from ...support.checks import Array, as_floats, as_number, as_pose, as_positive, frozen, require_names, require_one
from ...support.errors import InputError, quote
from ...support.fields import fields, inside
from ...theory import joints
from ...theory.lines import NO_LINE, axis_points
from ...theory.lower_pairs import lower_pairs
from ...theory.screws import inverse, to_screw
from ..arm import Arm
from ..arm_data import Coupling
from .load import assemble, proven

BASE = "base"  # The root link: the base frame, in which everything is given.
UNIT = 1e-12  # Largest rounding of a unit twist, and of the pitch of a revolute one for each metre of reach.

_BOUND, _RATE = partial(as_number, least=-np.inf, most=np.inf), partial(as_positive, most=np.inf)
# The limits of a joint and their checks.
LIMITS = {"lower": _BOUND, "upper": _BOUND, "velocity": _RATE, "effort": _RATE}


@dataclass(frozen=True, eq=False)
class _Row:
    """One `<joint>`: an axis (3,) and a point (3,) [m] of it at rest, in axes turned by `turned` (3, 3) from the base.

    The checks make a unit axis, all `limits` (infinite where none is given), and the joint's `frame` (4, 4).
    """

    name: str
    kind: str
    axis: Any
    point: ArrayLike
    limits: Mapping[str, Any] = field(default_factory=dict)
    axes: Array = field(default_factory=lambda: np.eye(3))
    master: str = ""
    multiplier: float = 1.0
    frame: Array = field(default_factory=lambda: np.eye(4), init=False)

    def __post_init__(self) -> None:
        _checked(self.name)
        with inside(f"joint {self.name!r}"):
            object.__setattr__(self, "axis", joints.revolute(self.axis, self.point)[3:, 0])
            self.frame[:3, :3], self.frame[:3, 3] = self.axes, self.point
            as_number(float(np.abs(self.frame[:3, 3]).max()), "point", most=LARGEST, unit="m")
            given = {name: limit for name, limit in self.limits.items() if limit is not None}
            limits = dict.fromkeys(LIMITS, np.inf) | {"lower": -np.inf} | fields(given, "", {}, LIMITS)
            lower, upper = limits["lower"], limits["upper"]
            if not lower <= upper or lower == np.inf or upper == -np.inf:
                raise InputError(f"lower must not exceed upper; got lower {lower:g} and upper {upper:g}")
        object.__setattr__(self, "limits", {} if self.kind == "planar" else limits)
        if self.kind == "revolute" and np.isinf([lower, upper]).all():
            object.__setattr__(self, "kind", "continuous")


@dataclass(frozen=True, eq=False)
class ArmBuilder:
    """An arm joint by joint, base to tip: `ArmBuilder("arm").revolute(…).cylindrical(…).tool(home).build()`.

    Give every axis and normal (3,), of any length but 0, and every point (3,) [m] in base axes with the arm at rest,
    theta = 0, as in MLS §3.2. Each method adds to the end of the chain and returns a new builder. The old builder does
    not change. A joint `j` with several coordinates names them `j_rz, j_z` (cylindrical), `j_rz, j_ry, j_rx`
    (spherical) or `j_x, j_y, j_rz` (planar).

    `limits` of a joint are `lower`, `upper` [rad or m], `velocity` [rad/s or m/s] and `effort` [N m or N]. A limit that
    you leave out is infinite. `build(limits=…)` takes those of each coordinate.

    Each method raises InputError for a zero axis, a number that is not finite or swapped limits. A name used twice is
    the DescriptionError of `build`.
    """

    name: str
    _rows: tuple[_Row, ...] = field(default=(), repr=False)
    _home: Array | None = field(default=None, repr=False)
    _tool: str = field(default="", repr=False)
    _base: str = field(default=BASE, repr=False)

    def __post_init__(self) -> None:
        _checked(self.name, "the arm's name")

    def revolute(self, name: str, axis: ArrayLike, point: ArrayLike, **limits: float | None) -> ArmBuilder:
        """A turn [rad] about the line along `axis` through `point`. Without bounds it is continuous.

        Args:
            name: The joint's name.
            axis: The direction of the axis (3,).
            point: A point (3,) of the axis [m].
            **limits: Some of `lower`, `upper`, `velocity` and `effort`, in SI units.
        """
        return self._with(_Row(name, "revolute", axis, point, limits))

    def prismatic(self, name: str, axis: ArrayLike, **limits: float | None) -> ArmBuilder:
        """A slide [m] along `axis`. It is drawn at the previous joint.

        Args:
            name: The joint's name.
            axis: The direction of the axis (3,).
            **limits: Some of `lower`, `upper`, `velocity` and `effort`, in SI units.
        """
        return self._with(_Row(name, "prismatic", axis, self._last, limits))

    def helical(self, name: str, axis: ArrayLike, point: ArrayLike, pitch: float, **limits: float | None) -> ArmBuilder:
        """A turn [rad] about a line with `pitch` [m/rad] of slide along it. A thread of lead l has the pitch l/2π.

        URDF has no helical joint. The file gets a turn with the `limits`, and a slide `name_z` that mimics it.

        Args:
            name: The joint's name.
            axis: The direction of the axis (3,).
            point: A point (3,) of the axis [m].
            pitch: Slide of a turn [m/rad].
            **limits: Some of `lower`, `upper`, `velocity` and `effort`, in SI units.
        """
        with inside(f"joint {_checked(name)!r}"):
            advance = as_number(pitch, "pitch", -LARGEST, LARGEST)
        slide = _Row(f"{name}_z", "prismatic", axis, point, master=name, multiplier=advance)
        return self._with(_Row(name, "revolute", axis, point, limits), slide)

    def cylindrical(self, name: str, axis: ArrayLike, point: ArrayLike) -> ArmBuilder:
        """Add a turn `name_rz` [rad] about a line and a slide `name_z` [m] along it.

        Args:
            name: The joint's name, the start of the names of its coordinates.
            axis: The direction of the line (3,).
            point: A point (3,) of the line [m].
        """
        turn = _Row(f"{_checked(name)}_rz", "revolute", axis, point)
        return self._with(turn, _Row(f"{name}_z", "prismatic", axis, point))

    def spherical(self, name: str, point: ArrayLike, axes: ArrayLike | None = None) -> ArmBuilder:
        """Add a ball with its centre at `point`, as ZYX Euler angles `name_rz, name_ry, name_rx` [rad].

        The columns of the rotation `axes` (3, 3), by default the identity, are the joint's x, y and z at rest. The
        coordinates are singular at name_ry = ±π/2; the ball itself is not.

        Args:
            name: The joint's name, the start of the names of its coordinates.
            point: The centre (3,) [m].
            axes: The rotation (3, 3) of the joint's axes at rest.
        """
        with inside(f"joint {_checked(name)!r}"):
            turns = zip(("rz", "ry", "rx"), joints.spherical(point, axes).T, strict=True)
        return self._with(*(_Row(f"{name}_{end}", "revolute", twist[3:], point) for end, twist in turns))

    def planar(
        self, name: str, normal: ArrayLike, point: ArrayLike = (0.0, 0.0, 0.0), x_axis: ArrayLike | None = None
    ) -> ArmBuilder:
        """Add slides `name_x, name_y` [m] in a plane, then the turn `name_rz` [rad] about its normal through `point`.

        The slides go along the columns of `joints.plane_axes(normal, x_axis)`. The file has the normal along z,
        because some readers ignore the axis of a planar joint.

        Args:
            name: The joint's name, the start of the names of its coordinates.
            normal: The direction of the plane's normal (3,).
            point: A point (3,) of the axis of the turn [m].
            x_axis: The direction of the first slide; None for one by a rule.
        """
        with inside(f"joint {_checked(name)!r}"):
            axes = joints.plane_axes(normal, x_axis)
        return self._with(_Row(name, "planar", (0.0, 0.0, 1.0), point, axes=axes))

    def tool(self, home: ArrayLike, name: str = "tool") -> ArmBuilder:
        """The tool frame `name` at `home` (4, 4), seen from the base with the arm at rest.

        Args:
            home: The pose of the frame.
            name: The name of the frame, the tip of the arm.

        Raises:
            InputError: `home` is not one pose in SE(3), or the tool is given already.
        """
        _checked(name, "the tool's name")
        if self._home is not None:
            raise InputError(f"the tool {self._tool!r} is given already; give it once")
        g = require_one(as_pose(home, "home"), "home", 2)
        as_number(float(np.abs(g[:3, 3]).max()), "home", most=LARGEST, unit="m")
        return replace(self, _home=frozen(g), _tool=name)

    def urdf(self) -> str:
        """The arm as URDF. `load_arm` makes the same arm from it."""
        if self._home is None:
            raise InputError(f"{self.name} has no tool: say where it is with .tool(home)")
        if not self._rows:
            raise InputError(f"{self.name} has no joints: add one, such as .revolute(name, axis, point)")
        robot = ET.Element("robot", name=self.name)
        ET.SubElement(robot, "link", name=self._base)
        parent, last = self._base, np.eye(4)
        for row in self._rows:
            ends = parent, f"{row.name}_link"
            joint = add_joint(robot, row.name, row.kind, ends, inverse(last) @ row.frame, row.axis, row.limits)
            if row.master:
                add_mimic(joint, row.master, row.multiplier)
            parent, last = ends[1], row.frame
        add_joint(robot, f"{self._tool}_mount", "fixed", (parent, self._tool), inverse(last) @ self._home)
        ET.indent(robot)
        return ET.tostring(robot, encoding="unicode") + "\n"

    def build(self, *, limits: JointLimits | Mapping[str, Any] | None = None) -> Arm:
        """Read the arm from `urdf()` and prove it against Pinocchio. `limits` are as in `load_arm`."""
        specification = ArmSpecification(Path(self.name), "ArmBuilder", base=self._base, tip=self._tool)
        return arm_of_urdf(self.urdf(), specification, limits)

    @property
    def _last(self) -> Array:
        """Where the last joint is (3,)."""
        return self._rows[-1].frame[:3, 3] if self._rows else np.zeros(3)

    def _with(self, *rows: _Row) -> ArmBuilder:
        return replace(self, _rows=(*self._rows, *rows))


def builder_of(arm: Arm) -> ArmBuilder:
    """The builder of an arm that has no description, from its screws, home, coupling and limits.

    Raises InputError for a joint that turns or slides by another rate than its coordinate, or follows several.
    """
    builder = ArmBuilder(arm.name, _base=arm.base)
    for i, name in enumerate(arm.moving_names):
        screw, row = to_screw(arm.screws[:, i]), arm.coupling.A[i]
        if not row.any():  # a locked joint
            continue
        j, *others = np.flatnonzero(row)
        master, rate = arm.joint_names[j], float(row[j])
        if others or master not in arm.moving_names or abs(screw.magnitude - 1.0) > UNIT:
            raise InputError(f"{arm.name}: URDF has no joint like {name!r}: its screw is no unit twist")
        slides = bool(np.isinf(screw.pitch))
        point = builder._last if slides else screw.point
        limits = {limit: float(getattr(arm.limits, limit)[j]) for limit in LIMIT_NAMES} if master == name else {}
        follows: dict[str, Any] = {} if master == name else {"master": master, "multiplier": rate}
        builder = builder._with(_Row(name, "prismatic" if slides else "revolute", screw.axis, point, limits, **follows))
        if not slides and abs(screw.pitch) > UNIT * arm.reach:
            advance = rate * float(screw.pitch)
            slide = _Row(f"{name}_z", "prismatic", screw.axis, point, master=master, multiplier=advance)
            builder = builder._with(slide)
    return builder.tool(arm.home, arm.tip)


def arm_of_urdf(
    text: str, specification: ArmSpecification, limits: JointLimits | Mapping[str, Any] | None = None
) -> Arm:
    """The arm of a URDF text that no file holds, proven as one from a file is."""
    source = specification.description
    description = build_description(text, Reading(source, PackageIndex(source)))
    return proven(assemble(replace(description, path=None), specification, {} if limits is None else limits))


def _checked(name: object, what: str = "a joint's name") -> str:
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise InputError(f"{what} must be a text of printable characters; got {quote(name)}")
    return name


def arm_from_screws(
    screws: ArrayLike,
    home: ArrayLike,
    *,
    joints: Sequence[str] | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    name: str = "arm",
) -> Arm:
    """An arm from its space twists (6, n) and home pose (4, 4), both at theta = 0; MLS §3.2.2.

    Columns with w = 0 are prismatic [m]. The others turn [rad]: revolute, or helical with a pitch.

    Args:
        screws: Space twists (6, n), (v, w) in each column, linear part first.
        home: The tool's pose g_st(0) (4, 4), seen from the base.
        joints: The n joint names; by default joint1, joint2 and so on.
        limits: A `JointLimits`, or a mapping as in `load_arm`; by default unbounded.
        name: The arm's name.

    Returns:
        The `Arm`, without a description and so without a Pinocchio model.

    Raises:
        InputError: A wrong shape, a zero column, a pose that is not in SE(3), or names that do not fit.
    """
    xi = as_floats(screws, "screws")
    if xi.ndim != 2 or xi.shape[0] != 6 or xi.shape[1] == 0:
        raise InputError(f"screws must have shape (6, n), one column per joint; got {xi.shape}")
    n = xi.shape[1]
    names = tuple(f"joint{i + 1}" for i in range(n)) if joints is None else require_names(joints, "joints")
    if len(names) != n or len(set(names)) != n:
        raise InputError(f"joints must be {n} different names, one per column of screws; got {list(names)}")
    if not (np.abs(xi).max(axis=0) > 0).all():
        raise InputError("screws must not have a zero column: it moves nothing")
    g = require_one(as_pose(home, "home"), "home", 2)
    path = axis_points(xi, g[:3, 3])[np.abs(to_screw(xi.T).pitch) < NO_LINE]
    limits = {} if limits is None else limits
    if isinstance(limits, JointLimits) and limits.lower.size != n:
        raise InputError(f"limits must be those of {n} joints; got {limits.lower.size}")
    return Arm(
        name=name,
        source="screws",
        base="base",
        tip="tool",
        joint_names=names,
        joint_types=tuple(lower_pairs(twist[:, None], np.eye(1))[0].kind for twist in xi.T),
        screws=xi,
        home=g,
        coupling=Coupling(np.eye(n), np.zeros(n)),
        limits=limits if isinstance(limits, JointLimits) else JointLimits.unbounded(n).with_(limits, names),
        reach=float(sum(np.linalg.norm(b - a) for a, b in pairwise([*path, g[:3, 3]]))) or 1.0,
    )
