"""ROS 2's messages as plain data, without ROS: whatever has their fields serves; see examples/ros2/servo_node.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..arm import Arm
from ..checks import Array, as_vector
from ..errors import InputError
from ..servo import ServoStatus, TwistCommand
from ..servo.command import FRAMES
from .joint_order import theta_by_name
from .protocols import Setpoint
from .report import Ending, Tally
from .streaming import Cycle

NANOSECONDS = 10**9

OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"
"""Levels of a diagnostic_msgs/DiagnosticStatus."""

WAITING = "WAITING"
"""The status before the first joint state, and after a device has failed."""

UNUSED = -1
"""An axis or button that the joystick has not got."""


def theta_of(arm: Arm, message: Any) -> Array:
    """theta (n,) of a sensor_msgs/JointState, whose joints come in any order and with others among them."""
    return theta_by_name(arm, list(message.name), list(message.position))


def twist_of(arm: Arm, message: Any, frame: str) -> TwistCommand:
    """The command of a geometry_msgs/Twist in `frame`, "tool" or "base" [m/s, rad/s]."""
    v, w = message.linear, message.angular
    return TwistCommand(np.array([v.x, v.y, v.z, w.x, w.y, w.z]), frame)


def frame_of(arm: Arm, frame_id: str, unsaid: str) -> str:
    """Whether the frame_id of a stamped message means "tool" or "base", `unsaid` where it is empty, as the tools for
    joysticks and keyboards leave it; InputError for any other.
    """
    frames = {"": unsaid, arm.tip: "tool", arm.base: "base"}
    if frame_id not in frames:
        raise InputError(
            f"a twist of {arm.name} is given in {arm.base!r} (base) or {arm.tip!r} (tool); got frame_id {frame_id!r}"
        )
    return frames[frame_id]


def number_of(stamp: Any) -> int | None:
    """A stamp as a number that increases [ns], None where the sender sets none."""
    number = int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)
    return number if number > 0 else None


@dataclass(frozen=True, eq=False)
class JoyMapping:
    """How a sensor_msgs/Joy becomes a twist.

    axes: six indices, for (vx, vy, vz, wx, wy, wz), −1 for none. scale (6,) [m/s, rad/s]: the twist at full deflection,
    signs included. deadband: deflections below are none; beyond, they begin at 0. dead_man: the button that must be
    held. Raises InputError for anything else.
    """

    axes: Sequence[int]
    scale: Sequence[float]
    dead_man: int
    frame: str = "tool"
    deadband: float = 0.1

    def __post_init__(self) -> None:
        whole = all(isinstance(k, int) and not isinstance(k, bool) and k >= UNUSED for k in (*self.axes, self.dead_man))
        if len(self.axes) != 6 or not whole or self.dead_man < 0:
            raise InputError(
                f"a joystick needs six axes, counted from 0, {UNUSED} for none, and a dead man's button; got "
                f"{list(self.axes)} and {self.dead_man!r}"
            )
        if not 0.0 <= self.deadband < 1.0:
            raise InputError(f"deadband must be from 0 to below 1; got {self.deadband!r}")
        if self.frame not in FRAMES:
            raise InputError(f"frame must be 'tool' or 'base'; got {self.frame!r}")
        as_vector(self.scale, "scale", 6)

    def command(self, message: Any) -> TwistCommand | None:
        """The twist of a joystick; None while the dead man's button is not held. InputError where it lacks an axis."""
        axes, buttons = list(message.axes), list(message.buttons)
        if max(self.axes) >= len(axes) or self.dead_man >= len(buttons):
            raise InputError(
                f"the joystick has {len(axes)} axes and {len(buttons)} buttons; the mapping asks for axis "
                f"{max(self.axes)} and button {self.dead_man}, counted from 0"
            )
        if not buttons[self.dead_man]:
            return None
        deflections = np.array([0.0 if k == UNUSED else axes[k] for k in self.axes])
        return TwistCommand(self._beyond_deadband(deflections) * np.asarray(self.scale), self.frame)

    def _beyond_deadband(self, deflections: Array) -> Array:
        size = np.clip((np.abs(deflections) - self.deadband) / (1.0 - self.deadband), 0.0, 1.0)
        beyond: Array = np.sign(deflections) * size
        return beyond


class TrajectoryPoint(NamedTuple):
    """A point of a trajectory_msgs/JointTrajectory: positions, and time_from_start as sec and nanosec, more than 0.

    Positions alone: controllers refuse a trajectory that ends with a velocity, and every setpoint is an end.
    """

    positions: list[float]
    sec: int
    nanosec: int


def trajectory_point(setpoint: Setpoint, ahead: float) -> TrajectoryPoint:
    """The setpoint as a point `ahead` [s] from now."""
    nanoseconds = round(ahead * NANOSECONDS)
    if nanoseconds < 1:
        raise InputError(f"a trajectory's point lies ahead in time; got {ahead!r} s")
    return TrajectoryPoint(setpoint.theta.tolist(), *divmod(nanoseconds, NANOSECONDS))


def status_of(cycle: Cycle) -> tuple[str, str | None, Ending | None]:
    """What is worth a diagnosis at once where it changes: the status, the joint concerned, the ending."""
    if cycle.setpoint is None:
        return WAITING, None, cycle.ending
    return cycle.setpoint.output.status.name, cycle.setpoint.output.joint, cycle.ending


class Diagnosis(NamedTuple):
    """What a diagnostic_msgs/DiagnosticStatus holds: level, message, and values by key."""

    level: bytes
    message: str
    values: dict[str, str]


def diagnosis_of(cycle: Cycle, tally: Tally) -> Diagnosis:
    """How the stream is at this cycle: an error where the joint state is missing or it has ended."""
    output = cycle.setpoint.output if cycle.setpoint is not None else None
    late = tally.lateness
    status, joint, _ = status_of(cycle)
    values = {
        "status": status,
        "joint": joint or "",
        "scale": f"{output.scale:.3f}" if output is not None else "",
        "cycles": str(tally.cycles),
        "missed cycles": str(tally.missed),
        "late, 99 % [ms]": f"{late.percentile(99.0) * 1e3:.3f}",
    }
    if cycle.ending is not None:
        return Diagnosis(ERROR, f"{cycle.ending.value}: {cycle.reason}", values)
    if output is None or cycle.theta is None:
        return Diagnosis(ERROR, cycle.reason, values)
    return Diagnosis(OK if output.status is ServoStatus.OK else WARN, output.reason, values)
