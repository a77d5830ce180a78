"""Targets of inverse kinematics: a pose, a position, an approach, a pose with tolerances.

A solver sees the components that a target constrains. `_position_rows` and `_rotation_rows` take the pose g (4, 4) and
body Jacobian J_b (6, n), unchecked. They give an error (k,) and rows (k, n). For the position d error = rows · dθ. For
the rotation, rowsᵀ error is the gradient of a function that grows with the angle. A free component has no row, so it
makes no matrix singular. `_position_tolerance` and `_rotation_tolerance` say how far each row may be from 0 beside the
solver's tolerance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..arm import engine
from ..arm.arm import Arm, require_arm
from ..support.checks import (
    Array,
    Matrix,
    Row,
    as_direction,
    as_frame,
    as_given,
    as_pose,
    as_reals,
    as_vector,
    frozen,
    pose_of,
    require_choice,
    require_one,
    require_radians,
)
from ..support.directions import direction_in_words, metres, numbers
from ..support.display import Brief
from ..support.errors import InputError
from ..support.units import angle_hint
from ..theory.rotations import from_rpy, from_xyzw
from . import rotation_errors
from .task_space import Rows, excess, offset_rows

NONE, TWO, THREE = (frozen(np.zeros(count)) for count in (0, 2, 3))

# Allowed rounding of a quaternion's length. A greater error means that it is something else.
UNIT_LENGTH_TOL = 0.01
# A target beyond this [m] is a mistake in the units. Its square would exceed the range in which errors add up.
FARTHEST = 1e6


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Pose(Brief):
    """The whole pose: g_st(θ) = g, (4, 4); from position and orientation by `from_rpy` and `from_quaternion`.

    Position error ‖p − p_g‖. Orientation error the angle of R_gᵀ R. InputError for a matrix that is not in SE(3).
    """

    g: Array

    kind: ClassVar[int] = 0
    _off_by: ClassVar[str] = "as one turn about one axis"  # What the angle of its orientation error is.
    _position_tolerance: ClassVar[Array] = THREE
    _rotation_tolerance: ClassVar[Array] = THREE

    def __init__(self, g: Matrix) -> None:
        numbers = engine.asked("pose", as_given(g))
        object.__setattr__(self, "g", _one_pose(g, "pose g") if numbers is None else numbers)

    @classmethod
    def from_rpy(cls, p: Row, rpy: Row) -> Pose:
        """The pose at p, turned about the base's x, y and z axes in order.

        Args:
            p: Position (3,) [m].
            rpy: Angles (3,) [rad]. InputError beyond a whole turn, which looks like degrees.
        """
        angles = one_vector(rpy, "rpy", 3, "")
        if angle_hint(angles):
            raise InputError(f"rpy: {angle_hint(angles)}: numpy.radians converts them")
        return cls(pose_of(from_rpy(angles), one_vector(p, "p")))

    @classmethod
    def from_quaternion(cls, p: Row, *, wxyz: Row | None = None, xyzw: Row | None = None) -> Pose:
        """The pose at p, its rotation by one quaternion. InputError unless its length is within 0.01 of 1.

        Args:
            p: Position (3,) [m].
            wxyz: Quaternion (4,), scalar first.
            xyzw: Quaternion (4,), scalar last, as in ROS and SciPy.
        """
        if (wxyz is None) == (xyzw is None):
            raise InputError("give one quaternion: wxyz= with the scalar first, or xyzw= with the scalar last")
        Q = one_vector(xyzw, "xyzw", 4, "") if wxyz is None else np.roll(one_vector(wxyz, "wxyz", 4, ""), -1)
        length = float(np.linalg.norm(Q))
        if abs(length - 1.0) > UNIT_LENGTH_TOL:
            raise InputError(f"a quaternion has length 1; this one has {length:.3g}")
        return cls(pose_of(from_xyzw(Q), one_vector(p, "p")))

    @property
    def numbers(self) -> Array:
        """g."""
        return self.g

    def _position_rows(self, g: Array, J_b: Array) -> Rows:
        return offset_rows(self.g[:3, 3], g, J_b)

    def _rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """The chord of R_gᵀ R, in tool axes."""
        return rotation_errors.chord(self.g[:3, :3].T @ g[:3, :3]), J_b[3:]

    def position_error(self, g: Array) -> float:
        """‖p − p_g‖ [m]."""
        return math.dist(as_frame(g)[:3, 3], self.g[:3, 3])

    def orientation_error(self, g: Array) -> float:
        """Angle of R_gᵀ R [rad]."""
        return rotation_errors.angle(self.g[:3, :3].T @ as_frame(g)[:3, :3])

    def at(self, g: Array) -> Pose:
        """The same kind of target, reached by the pose g."""
        return Pose(g)

    def describe(self) -> str:
        """The target in words."""
        angle = math.degrees(rotation_errors.angle(self.g[:3, :3]))
        return f"the pose at {metres(self.g[:3, 3])}, turned {angle:.1f}° from the base's axes"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Position(Brief):
    """The tool's origin at p (3,) [m] in the base frame, the orientation free."""

    p: Array

    kind: ClassVar[int] = 1
    _off_by: ClassVar[str] = ""
    _position_tolerance: ClassVar[Array] = THREE
    _rotation_tolerance: ClassVar[Array] = NONE

    def __init__(self, p: Row) -> None:
        numbers = engine.asked("position", as_given(p))
        object.__setattr__(self, "p", one_vector(p, "p") if numbers is None else numbers)

    @property
    def numbers(self) -> Array:
        """p."""
        return self.p

    def _position_rows(self, g: Array, J_b: Array) -> Rows:
        return offset_rows(self.p, g, J_b)

    def _rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """Nothing: the rotation is free."""
        return NONE, J_b[:0]

    def position_error(self, g: Array) -> float:
        """Distance from p [m]."""
        return math.dist(as_frame(g)[:3, 3], self.p)

    def orientation_error(self, g: Array) -> float:
        """0: the rotation is free."""
        as_frame(g)
        return 0.0

    def at(self, g: Array) -> Position:
        """The same kind of target, reached by the pose g."""
        return Position(as_frame(g)[:3, 3])

    def describe(self) -> str:
        """The target in words."""
        return f"the position {metres(self.p)}"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Approach(Brief):
    """The tool's origin at p (3,) [m] and R @ tool_axis = direction (base axes). Turning about the tool axis is free.

    `tool_axis` (3,), in tool axes, points along the direction. None means `arm.tool_axis`, the axis about which the
    last joint rolls the tool. `solve_ik` puts it in, and its solution's target has it.

    Orientation error: the angle between the axes. The rotation has two rows, across the tool axis. Both axes may have
    any length. InputError for zero.
    """

    p: Array
    direction: Array
    tool_axis: Array | None
    _numbers: Array = field(init=False, repr=False)

    kind: ClassVar[int] = 2
    _off_by: ClassVar[str] = "from the tool's axis to the direction"
    _position_tolerance: ClassVar[Array] = THREE
    _rotation_tolerance: ClassVar[Array] = TWO

    def __init__(self, p: Row, direction: Row, tool_axis: Row | None = None) -> None:
        numbers = engine.asked("approach", *map(as_given, (p, direction, tool_axis)))
        if numbers is None:
            axis = () if tool_axis is None else one_direction(tool_axis, "tool_axis")
            numbers = frozen([*one_vector(p, "p"), *one_direction(direction, "direction"), *axis])
        object.__setattr__(self, "p", numbers[:3])
        object.__setattr__(self, "direction", numbers[3:6])
        object.__setattr__(self, "tool_axis", None if tool_axis is None else numbers[6:])
        object.__setattr__(self, "_numbers", numbers)

    def of(self, arm: Arm) -> Approach:
        """The approach with a tool axis: its own, or the arm's."""
        axis = require_arm(arm).tool_axis
        return self if self.tool_axis is not None else Approach(self.p, self.direction, axis)

    @property
    def axis(self) -> Array:
        """The tool axis (3,). InputError where the arm chooses it."""
        if self.tool_axis is None:
            raise InputError("this Approach leaves its tool axis to the arm: ask approach.of(arm), or give tool_axis=")
        return self.tool_axis

    @cached_property
    def across(self) -> Array:
        """Two unit vectors (2, 3) that span the plane across the tool axis."""
        # The rows of Vᵀ beyond the first span it.
        return frozen(np.linalg.svd(self.axis[None, :])[2][1:])

    @property
    def numbers(self) -> Array:
        """p, direction, tool axis; without the last where the arm chooses it."""
        return self._numbers

    def _position_rows(self, g: Array, J_b: Array) -> Rows:
        return offset_rows(self.p, g, J_b)

    def _rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """2 sin(φ/2) u across the axis: the turn by φ about u from the direction to the tool axis."""
        direction = g[:3, :3].T @ self.direction
        turn = _cross(direction, self.axis)
        length = math.sqrt(turn @ turn)
        # Parallel, the error is zero whatever u is; opposite, every u across the axis is as good.
        u = self.across @ (turn / length) if length > 0.0 else np.array([1.0, 0.0])
        return u * math.dist(direction, self.axis), self.across @ J_b[3:]

    def position_error(self, g: Array) -> float:
        """Distance from p [m]."""
        return math.dist(as_frame(g)[:3, 3], self.p)

    def orientation_error(self, g: Array) -> float:
        """Angle [rad] between R @ tool_axis and the direction."""
        axis = as_frame(g)[:3, :3] @ self.axis
        turn = _cross(axis, self.direction)
        return math.atan2(math.sqrt(turn @ turn), float(axis @ self.direction))

    def at(self, g: Array) -> Approach:
        """The same kind of target, reached by the pose g."""
        g = as_frame(g)
        return Approach(g[:3, 3], g[:3, :3] @ self.axis, self.axis)

    def describe(self) -> str:
        """The target in words."""
        axis = "" if self.tool_axis is None else f"{direction_in_words(self.tool_axis, 'tool')} "
        return f"the position {metres(self.p)} with the tool pointing {axis}along {numbers(self.direction)}"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class TolerancedPose(Brief):
    """The pose g within `tolerance`, six numbers (x, y, z [m], rx, ry, rz [rad]).

    The error is (p − p_g, log(R R_gᵀ)) in base axes. frame="target" turns it into the target's axes. A tolerance of 0
    means the solver's tolerance. inf, or π for a rotation, leaves the component free. Position and orientation error
    are the norms of the excess over the tolerances. InputError for a negative tolerance, an unknown frame, or six free
    components.
    """

    g: Array
    tolerance: Array
    frame: str
    numbers: Array = field(init=False, repr=False)

    kind: ClassVar[int] = 3
    _off_by: ClassVar[str] = "beyond its tolerances, as the length of a rotation vector"

    def __init__(self, g: Matrix, tolerance: Row, frame: str = "target") -> None:
        base_axes = require_choice(frame, ("target", "base"), "frame") == "base"
        numbers = engine.asked("task", as_given(g), as_given(tolerance), base_axes)
        if numbers is None:
            numbers = frozen([*_one_pose(g, "pose g").flat, *_as_tolerance(tolerance), base_axes])
        for i, angle in enumerate(numbers[19:22].tolist(), 3):
            if angle < math.inf:
                require_radians(angle, f"tolerance[{i}]", math.pi)
        object.__setattr__(self, "g", numbers[:16].reshape(4, 4))
        object.__setattr__(self, "tolerance", numbers[16:22])
        object.__setattr__(self, "frame", frame)
        object.__setattr__(self, "numbers", numbers)

    @cached_property
    def held(self) -> tuple[list[int], list[int]]:
        """Which components of position and of rotation are not left free."""
        position, rotation = self.tolerance[:3] < math.inf, self.tolerance[3:] < math.pi
        return np.flatnonzero(position).tolist(), np.flatnonzero(rotation).tolist()

    @cached_property
    def _position_tolerance(self) -> Array:
        """[m], of the held components."""
        return frozen(self.tolerance[:3][self.held[0]])

    @cached_property
    def _rotation_tolerance(self) -> Array:
        """[rad], of the held components."""
        return frozen(self.tolerance[3:][self.held[1]])

    def _position_rows(self, g: Array, J_b: Array) -> Rows:
        """The held components of p − p_g, along the axes of the frame."""
        held = self.held[0]
        R = g[:3, :3] if self.frame == "base" else self.g[:3, :3].T @ g[:3, :3]
        return self._position_offset(g), R[held] @ J_b[:3]

    def _rotation_rows(self, g: Array, J_b: Array) -> Rows:
        """The held components of the logarithm, along the axes of the frame."""
        phi = rotation_errors.log(self.g[:3, :3].T @ g[:3, :3])
        rate = rotation_errors.log_rate(phi)
        if self.frame == "base":
            phi, rate = self.g[:3, :3] @ phi, self.g[:3, :3] @ rate
        held = self.held[1]
        return phi[held], rate[held] @ J_b[3:]

    def position_error(self, g: Array) -> float:
        """Norm of the excess over the position tolerances [m]."""
        return float(np.linalg.norm(excess(self._position_offset(as_frame(g)), self._position_tolerance)))

    def orientation_error(self, g: Array) -> float:
        """Norm of the excess over the rotation tolerances [rad]."""
        phi = rotation_errors.log(self.g[:3, :3].T @ as_frame(g)[:3, :3])
        phi = self.g[:3, :3] @ phi if self.frame == "base" else phi
        return float(np.linalg.norm(excess(phi[self.held[1]], self._rotation_tolerance)))

    def at(self, g: Array) -> TolerancedPose:
        """The same kind of target, reached by the pose g."""
        return TolerancedPose(g, self.tolerance, self.frame)

    def describe(self) -> str:
        """The target in words."""
        free = [name for name, t in zip(("x", "y", "z"), self.tolerance[:3], strict=True) if math.isinf(t)]
        free += [f"turning about {name}" for name, t in zip("xyz", self.tolerance[3:], strict=True) if t >= math.pi]
        axes = f"{self.frame}'s"
        return f"the pose at {metres(self.g[:3, 3])} within tolerances along the {axes} axes" + (
            f" ({', '.join(free)} free)" if free else ""
        )

    def _position_offset(self, g: Array) -> Array:
        offset = g[:3, 3] - self.g[:3, 3]
        offset = offset if self.frame == "base" else self.g[:3, :3].T @ offset
        return offset[self.held[0]]


AnyTarget = Pose | Position | Approach | TolerancedPose
Target = AnyTarget

TargetLike = AnyTarget | Matrix  # What a caller may ask for: a target, or a bare pose (4, 4).

SHAPE_HINTS = {
    (3,): "; did you mean Position([x, y, z])?",
    (6,): "; did you mean Pose.from_rpy([x, y, z], [roll, pitch, yaw])?",
    (7,): "; did you mean Pose.from_quaternion([x, y, z], xyzw=[...])?",
}
"""By how many numbers there are."""

# Kinds of targets, by `kind`. The core receives `numbers`: g; p; p, direction, tool axis; g, tolerance, 1 for base.
KINDS = (Pose, Position, Approach, TolerancedPose)
MOST_NUMBERS = 23  # Of a `TolerancedPose`.


def target_for(arm: Arm, value: Any) -> AnyTarget:
    """`value` as a target for the arm. An approach without a tool axis gets the arm's."""
    target = as_target(value)
    return target.of(arm) if isinstance(target, Approach) else target


def checked_target(arm: Arm, value: Any) -> AnyTarget:
    """The same with its numbers checked again, because you may have written into its arrays."""
    target = target_for(arm, value)
    return target_of(target.kind, target.numbers)


def as_target(value: Any) -> AnyTarget:
    """`value` as a target. A bare (4, 4) means `Pose`."""
    if isinstance(value, KINDS):
        return value
    try:
        return Pose(value)
    except InputError as error:
        raise InputError(
            f"target must be a Pose, Position, Approach or TolerancedPose, or a pose (4, 4) in SE(3): "
            f"{error}{shape_hint(value)}"
        ) from error


def shape_hint(value: Any) -> str:
    """`; did you mean Position([x, y, z])?`: a guess for numbers of another shape, or ""."""
    try:
        return SHAPE_HINTS.get(as_reals(value, "target").shape[-1:], "")
    except InputError:
        return ""


def target_of(kind: int, numbers: Array) -> AnyTarget:
    """The target with this `kind` and these `numbers`. More numbers behind them do not count."""
    if kind == Position.kind:
        return Position(numbers[:3])
    if kind == Approach.kind:
        return Approach(numbers[:3], numbers[3:6], numbers[6:9])
    g = numbers[:16].reshape(4, 4)
    return Pose(g) if kind == Pose.kind else TolerancedPose(g, numbers[16:22], "base" if numbers[22] else "target")


def _cross(a: Array, b: Array) -> Array:
    # np.cross takes some thirty times as long for one pair of vectors.
    (a1, a2, a3), (b1, b2, b3) = a.tolist(), b.tolist()
    return np.array([a2 * b3 - a3 * b2, a3 * b1 - a1 * b3, a1 * b2 - a2 * b1])


def _one_pose(value: Matrix, name: str) -> Array:
    g = require_one(as_pose(value, name), name, 2)
    _require_near(g[:3, 3], name)
    return frozen(g)


def one_vector(value: Any, name: str, size: int = 3, unit: str = "m") -> Array:
    """One vector (size,), read-only. InputError for another, and for lengths [m] that are mistakes in the units."""
    vector = require_one(as_vector(value, name, size), name, 1)
    if unit:
        _require_near(vector, name)
    return frozen(vector)


def one_direction(value: ArrayLike, name: str) -> Array:
    """One unit vector (3,) along `value`, read-only. InputError for another shape or zero."""
    return frozen(require_one(as_direction(value, name), name, 1))


def _require_near(p: Array, name: str) -> None:
    if np.abs(p).max() > FARTHEST:
        raise InputError(f"{name} holds {np.abs(p).max():g}, beyond {FARTHEST:g} m: lengths are in metres")


def _as_tolerance(value: ArrayLike) -> Array:
    tolerance = as_reals(value, "tolerance")
    if tolerance.shape != (6,):
        raise InputError(f"tolerance must be six numbers (x, y, z [m], rx, ry, rz [rad]); got shape {tolerance.shape}")
    if not (tolerance >= 0).all():
        raise InputError(f"tolerance must not be negative or NaN (0: exact, inf: free); got {tolerance.tolist()}")
    if not (tolerance < np.repeat([math.inf, math.pi], 3)).any():
        raise InputError("tolerance leaves all six components free: there is nothing to solve for")
    return tolerance
