"""ROS 2's messages as plain data, without ROS, for any object with their fields."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from twistarm import Arm, InputError
from twistarm.arm.usual_limits import usually_limited
from twistarm.control.servo import AnyCommand
from twistarm.control.stream import Cycle, Ending, Setpoint, command_of
from twistarm.control.stream.messages import values_by_name
from twistarm.control.stream.report import Tally
from twistarm.support.checks import Array
from twistarm.support.errors import listed

NANOSECONDS = 10**9

OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"
"""Levels of a diagnostic_msgs/DiagnosticStatus."""

WAITING = "WAITING"
"""The status before the first joint state and after a device failure."""


def positions_of(arm: Arm, message: Any) -> dict[str, float]:
    """Positions by name of a sensor_msgs/JointState, in any order.

    A message without positions, with velocities or efforts only, gives none.
    """
    if not len(message.position):
        return {}
    return values_by_name(arm.joint_names, list(message.name), list(message.position))


def twist_of(message: Any) -> list[float]:
    """The six numbers of a geometry_msgs/Twist, linear part first."""
    v, w = message.linear, message.angular
    return [v.x, v.y, v.z, w.x, w.y, w.z]


def frame_of(arm: Arm, frame_id: str, unsaid: str) -> str:
    """The frame "tool" or "base" for a frame_id. `unsaid` replaces an empty one, as joystick tools send it.

    Raises InputError for any other.
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


def jog_of(arm: Arm, message: Any, scale: float = 1.0) -> AnyCommand:
    """The command of a control_msgs/JointJog.

    Its velocities times `scale` are rates [rad/s, m/s] by name; other joints rest.
    """
    names, rates = list(message.joint_names), [scale * rate for rate in message.velocities]
    if len(message.displacements):
        raise InputError("a jog is driven by velocities; got displacements, which a pose or a trajectory is for")
    if len(names) != len(rates):
        raise InputError(f"a jog has a velocity for each joint; got {len(names)} names, {len(rates)} velocities")
    if len(set(names)) != len(names):
        raise InputError(f"a jog names each joint once; got {listed(names)}")
    return command_of(arm, {"jog": dict(zip(names, rates, strict=True))})


def pose_of(arm: Arm, message: Any) -> AnyCommand:
    """The command of a geometry_msgs/PoseStamped, which is given in the base."""
    if message.header.frame_id != arm.base:
        raise InputError(f"a pose of {arm.name} is given in {arm.base!r} (base); got {message.header.frame_id!r}")
    p, q = message.pose.position, message.pose.orientation
    return command_of(arm, {"pose": {"position": [p.x, p.y, p.z], "quaternion_wxyz": [q.w, q.x, q.y, q.z]}})


class TrajectoryPoint(NamedTuple):
    """A point of a trajectory_msgs/JointTrajectory: positions, velocities, time_from_start (sec, nanosec)."""

    positions: list[float]
    velocities: list[float]
    sec: int
    nanosec: int


def trajectory_points(arm: Arm, setpoint: Setpoint, ahead: float) -> list[TrajectoryPoint]:
    """The setpoint as a point `ahead` [s] from now. If it moves then, a second point is at rest.

    All joints brake evenly over the slowest's time T, Δθ = θ̇ T / 2. The servo's rates leave room for this. Controllers
    refuse a trajectory that ends with a velocity, and each setpoint is an end. Without another trajectory the arm comes
    to rest within its limits, or the assumed ones.
    """
    if not ahead * NANOSECONDS >= 1.0:
        raise InputError(f"a trajectory's point lies ahead in time; got {ahead!r} s")
    limits, theta, rates = usually_limited(arm).limits, setpoint.theta, setpoint.theta_dot
    braking = float((np.abs(rates) / limits.acceleration).max())
    points = [_point(theta, rates, ahead)]
    if braking > 0.0:
        rest = np.clip(theta + rates * braking / 2.0, np.minimum(limits.lower, theta), np.maximum(limits.upper, theta))
        points.append(_point(rest, np.zeros(arm.n), ahead + braking))
    return points


def _point(theta: Array, rates: Array, time: float) -> TrajectoryPoint:
    return TrajectoryPoint(theta.tolist(), rates.tolist(), *divmod(round(time * NANOSECONDS), NANOSECONDS))


def status_of(cycle: Cycle) -> tuple[str, str | None, Ending | None, str]:
    """The values that give a diagnosis at each change: status, joint, ending, interlock."""
    if cycle.setpoint is None:
        return WAITING, None, cycle.ending, cycle.interlock
    return cycle.setpoint.output.status, cycle.setpoint.output.joint, cycle.ending, cycle.interlock


class Diagnosis(NamedTuple):
    """What a diagnostic_msgs/DiagnosticStatus holds: level, message, and values by key."""

    level: bytes
    message: str
    values: dict[str, str]


def diagnosis_of(cycle: Cycle, tally: Tally) -> Diagnosis:
    """The state of the stream now: an error without a joint state or after its end."""
    output = cycle.setpoint.output if cycle.setpoint is not None else None
    status, joint, *_ = status_of(cycle)
    values = {
        "status": status,
        "reason": output.reason.name if output is not None else "",
        "joint": joint or "",
        "scale": f"{output.scale:.3f}" if output is not None else "",
        "interlock": cycle.interlock,
        "cycles": str(tally.cycles),
        "missed cycles": str(tally.missed),
        "late, most [ms]": f"{tally.late_max * 1e3:.3f}",
    }
    if cycle.ending is not None:
        return Diagnosis(ERROR, f"{cycle.ending.value}: {cycle.reason}", values)
    if output is None or cycle.theta is None:
        return Diagnosis(ERROR, cycle.reason, values)
    return Diagnosis(OK if output.status == "OK" else WARN, output.explain(), values)
