"""Segments of a motion: joint, line, screw and arc moves, and dwells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ..ik.request import as_orientation_tol, as_tolerance
from ..ik.targets import KINDS, AnyTarget, Pose, one_direction, one_vector
from ..support.checks import Array, Row, as_flag, as_floats, as_number, as_positive, frozen, require, require_choice
from ..support.display import Brief
from ..support.errors import InputError, quote
from .keep import Keep

# End of a move: a configuration (n,), {joint: value}, its name, a target, or a pose (4, 4).
Goal = Row | Mapping[str, float] | str | AnyTarget

Constrained = Literal["pose", "approach", "position"]
CONSTRAINED: tuple[Constrained, ...] = ("pose", "approach", "position")

LABEL_LENGTH = 200
# How far [m] states of a free move keep from everything, so that the paths between them do too; less where start or
# goal is nearer.
CLEARANCE = 0.004

OPTIONAL = {
    "linear_speed": as_positive,
    "angular_speed": as_positive,
    "position_tol": as_tolerance,
    "orientation_tol": as_orientation_tol,
}
"""Options of a move that may be None, and their checks."""


class Segment(Brief):
    """A part of a motion: `JointMove`, `FreeMove`, `LineMove`, `ScrewMove`, `ArcMove` or `Dwell`."""

    label: str


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Move(Segment):
    """The options of every move.

    blend: radius [m] of the ball at the move's end in which the corner may be rounded; 0 stops.

    velocity_scaling: the greatest share, in (0, 1], of the joints' velocity limits.

    linear_speed, angular_speed: the greatest speeds of the tool's origin [m/s] and rotation [rad/s].

    position_tol, orientation_tol: tolerances of the target [m, rad], along a curve too.

    label: an action due at the move's end, such as "close gripper". Files carry it.
    """

    blend: float = 0.0
    velocity_scaling: float = 1.0
    linear_speed: float | None = None
    angular_speed: float | None = None
    position_tol: float | None = None
    orientation_tol: float | None = None
    label: str = ""

    def __post_init__(self) -> None:
        scaling = as_positive(self.velocity_scaling, "velocity_scaling")
        if scaling > 1.0:
            raise InputError(
                "velocity_scaling must be a share of the joints' velocity limits, more than 0 and at most 1; got "
                f"{scaling:g} (linear_speed= takes m/s)"
            )
        kept: dict[str, Any] = {"velocity_scaling": scaling, "blend": as_number(self.blend, "blend", 0.0)}
        kept["label"] = as_label(self.label)
        for name, check in OPTIONAL.items():
            value = getattr(self, name)
            kept[name] = None if value is None else check(value, name)
        for name, value in kept.items():
            object.__setattr__(self, name, value)

    @property
    def slowed(self) -> bool:
        """Whether it limits a speed further than the joints do."""
        return self.velocity_scaling < 1.0 or self.linear_speed is not None or self.angular_speed is not None


@dataclass(frozen=True, eq=False, repr=False)
class JointMove(Move):
    """A move of every joint to the goal, straight in joint space.

    To a target the arm takes the nearest configuration, with the least ‖θ − θ₀‖, of all that the closed form or the
    searches find. In a scene it is the nearest free one. Where curves follow, it is one from which it can follow them.

    Raises InputError for an unusable goal, blend, speed or label.
    """

    to: Goal

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "to", as_goal(self.to))


@dataclass(frozen=True, eq=False, repr=False)
class FreeMove(JointMove):
    """A move to the goal on any path that collides with nothing. `plan` needs a scene for it.

    The straight path in joint space is taken if it is free. For a target that is the path to the configuration that
    `solve_ik` finds in the scene. Otherwise the search ends at any free configuration that meets the target.

    keep: what the tool keeps all along, such as `Keep.level()`, or None. Start and goal must keep it too.
    """

    keep: Keep | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.keep is not None:
            require(self.keep, Keep, "keep", "Keep.level()")


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class _CurveMove(Move):
    """A move along a curve, to a goal or as far as it gives. `constrain` is the part of the pose to keep then."""

    constrain: Constrained | None = None

    def _check_way(self, name: str, size: int, way: str) -> None:
        """Check the goal, or the attribute of that name (size,) that replaces it."""
        goal, given = getattr(self, "to", None), getattr(self, name)
        if (goal is None) == (given is None):
            raise InputError(f"{type(self).__name__} needs a goal, to=, or {way}, and not both")
        if given is None:
            object.__setattr__(self, "to", as_goal(goal))
        else:
            object.__setattr__(self, name, one_vector(given, name, size, ""))
        if self.constrain is not None:
            require_choice(self.constrain, CONSTRAINED, "constrain")


@dataclass(frozen=True, eq=False, repr=False)
class LineMove(_CurveMove):
    """The tool's origin on a straight line, with a proportional rotation about one fixed axis (slerp).

    The target's free components stay free on the way. That is the rotation for a `Position`, and the turn about the
    tool axis for an `Approach`. The direction of the tool axis then swings in one plane. A `TolerancedPose` keeps its
    tolerances. To a configuration the tool goes to its pose there. An arm of fewer than six joints leaves out the turn
    about the tool axis, or all rotation.

    Raises InputError for an unusable goal, blend, speed or label.
    """

    to: Goal | None
    offset: Array | None = field(default=None, kw_only=True)
    frame: str = field(default="tool", kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_way("offset", 3, "LineMove.by(offset)")
        require_choice(self.frame, ("tool", "base"), "frame")

    @classmethod
    def by(cls, offset: Row, *, frame: str = "tool", constrain: Constrained | None = None, **options: Any) -> LineMove:
        """A line by an offset (3,) [m] in the axes of the base or of the tool.

        Args:
            offset: From the start to the end (3,) [m].
            frame: The axes: "tool", those of the tool at the start, or "base".
            constrain: The part of the pose to keep: "pose", "position" or "approach" (free turn about the tool axis).
                None: the first of pose, approach and position that the arm can keep.
            **options: Those of every `Move`: blend, speed and so on.
        """
        return cls(None, offset=one_vector(offset, "offset", unit=""), frame=frame, constrain=constrain, **options)


@dataclass(frozen=True, eq=False, repr=False)
class ScrewMove(_CurveMove):
    """The tool along one screw, g(s) = exp(s ξ̂) g0, s from 0 to 1 (MLS §2.3.3, Chasles' theorem).

    To a goal, ξ = log(g1 g0⁻¹) is the screw of at most half a turn.

    Raises InputError for an unusable goal, blend, speed or label.
    """

    to: Goal | None
    twist: Array | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check_way("twist", 6, "ScrewMove.about(axis, point, angle)")

    @classmethod
    def about(
        cls,
        axis: Row,
        point: Row,
        angle: float,
        pitch: float = 0.0,
        *,
        constrain: Constrained | None = None,
        **options: Any,
    ) -> ScrewMove:
        """A turn about a base axis that advances by `pitch` per radian: ξ = (−ω × q + h ω, ω) · angle.

        MLS §2.3.3: ω is the unit axis, q a point on it, h the pitch [m/rad]. The angle may be several turns.

        Args:
            axis: Direction of the axis (3,), of any length but 0.
            point: A point on it (3,) [m].
            angle: How far to turn [rad], by the right-hand rule.
            pitch: Advance along the axis per angle [m/rad].
            constrain: As for `LineMove.by`.
            **options: Those of every `Move`: blend, speed and so on.
        """
        w, q = one_direction(axis, "axis"), one_vector(point, "point", unit="")
        v = np.cross(q, w) + as_number(pitch, "pitch") * w
        return cls(None, twist=as_number(angle, "angle") * np.concatenate([v, w]), constrain=constrain, **options)


@dataclass(frozen=True, eq=False, repr=False)
class ArcMove(_CurveMove):
    """The tool's origin on a circular arc through `via` to the goal, its rotation by slerp.

    `via` is (3,) [m] in base axes, or a target with a position. The three points must not coincide or lie on a line,
    within 20 µm and 1e-5 rad. Otherwise rounding would choose the plane. What the goal leaves free stays free, as in
    `LineMove`.

    Raises InputError for an unusable goal, blend, speed or label.
    """

    via: Row | AnyTarget | None
    to: Goal | None
    twist: Array | None = field(default=None, kw_only=True)
    turn: bool = field(default=True, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.twist is None and (self.to is None or self.via is None):
            raise InputError("an ArcMove needs via and a goal, or ArcMove.about(axis, centre, angle)")
        self._check_way("twist", 6, "ArcMove.about(axis, centre, angle)")
        if self.twist is None:
            object.__setattr__(self, "via", frozen(_point(self.via)))
        as_flag(self.turn, "turn")

    @classmethod
    def about(
        cls,
        axis: Row,
        centre: Row,
        angle: float,
        *,
        turn: bool = True,
        constrain: Constrained | None = None,
        **options: Any,
    ) -> ArcMove:
        """Make an arc about an axis through `centre` in the base frame.

        Args:
            axis: Direction of the axis (3,), of any length but 0.
            centre: A point on it (3,) [m].
            angle: How far [rad], by the right-hand rule; several turns too.
            turn: Whether the tool turns with the arc, like a hand on a door handle.
            constrain: As for `LineMove.by`.
            **options: Those of every `Move`: blend, speed and so on.
        """
        w, q = one_direction(axis, "axis"), one_vector(centre, "centre", unit="")
        twist = as_number(angle, "angle") * np.concatenate([np.cross(q, w), w])
        return cls(None, None, twist=twist, turn=turn, constrain=constrain, **options)


@dataclass(frozen=True, eq=False, repr=False)
class Dwell(Segment):
    """A stay [s] of the arm. Its label, such as "close gripper", is due when it begins.

    Raises InputError for a negative time or a label that cannot be used.
    """

    seconds: float
    label: str = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "seconds", as_number(self.seconds, "seconds", 0.0))
        object.__setattr__(self, "label", as_label(self.label))


SEGMENTS = (JointMove, LineMove, ScrewMove, ArcMove, Dwell)


def as_segments(segments: Any, **whole: Any) -> list[Segment]:
    """Return the segments. Moves without one of the `OPTIONAL` options take the one given here."""
    Move(**whole)  # says what is wrong with them
    given = [segments] if isinstance(segments, SEGMENTS) else list(segments) if np.iterable(segments) else None
    if not given or isinstance(segments, str):
        raise InputError(f"segments must be one or more of JointMove, LineMove, …, Dwell; got {quote(segments)}")
    for i, segment in enumerate(given):
        if not isinstance(segment, SEGMENTS):
            allowed = "a JointMove, FreeMove, LineMove, ScrewMove, ArcMove or Dwell"
            raise InputError(f"segment {i + 1} must be {allowed}; got {quote(segment)}")
        if isinstance(segment, Move):
            given[i] = replace(segment, **{name: whole[name] for name in whole if getattr(segment, name) is None})
            if segment.blend and (i + 1 == len(given) or isinstance(given[i + 1], Dwell)):
                raise InputError(f"{place(i, segment)} cannot blend: the arm stops at its end; leave blend out")
    return given


def place(i: int, segment: Segment) -> str:
    """Name a segment in words: `segment 2 (LineMove)` is at index 1."""
    return f"segment {i + 1} ({type(segment).__name__})"


def as_goal(value: Any) -> Goal:
    """Return a goal: names, mappings and targets unchanged, numbers as an array, (4, 4) as a `Pose`."""
    if isinstance(value, (str, Mapping, *KINDS)):
        return value
    if value is None:
        raise InputError("to must be a goal: a configuration, the name of one, or a target such as Pose(g)")
    numbers = as_floats(value, "to, a goal that is no name and no target,")
    return Pose(numbers) if numbers.shape == (4, 4) else frozen(numbers)


def as_label(value: Any) -> str:
    """Check a label: one line of text."""
    if not isinstance(value, str) or len(value) > LABEL_LENGTH or not (value.isprintable() or not value):
        raise InputError(f"label must be one line of text of at most {LABEL_LENGTH} characters; got {quote(value)}")
    return value


def _point(value: Any) -> Array:
    """Return the position of a target, or the point itself."""
    if isinstance(value, KINDS):
        return np.array(value.g[:3, 3] if hasattr(value, "g") else value.p)
    numbers = as_floats(value, "via")
    return np.array(Pose(numbers).g[:3, 3]) if numbers.shape == (4, 4) else one_vector(numbers, "via", unit="")
