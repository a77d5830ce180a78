"""Messages of the loop (docs/streaming.md): JSON in and out, values of joints or motors, recordings."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from ...arm.arm import Arm, require_arm
from ...planning.files.mcap_file import LABELS, SETPOINTS, TEXT, Bag
from ...support.checks import (
    Array,
    as_number,
    as_theta,
    as_whole,
    require,
    require_choice,
    require_mapping,
    require_method,
)
from ...support.errors import InputError, TwistarmError, listed, quote
from ...support.fields import Check, anything, fields, list_of, numbers, one_of
from ...support.fields import text as any_text
from ...support.strict_json import decoded
from ...theory.rotations import from_quaternion_wxyz
from ..servo import AnyCommand, JogCommand, PoseCommand, TwistCommand
from .cycles import Cycle
from .protocols import STATES, WORDS, Interlock, Setpoint, Sink

QUATERNION_TOL = 1e-3  # Allowed error of a quaternion's length: four printed decimals.
UNITS = ("joint", "motor", "counts")  # Units of values to and from a robot.
# Text in every interlock message. The search for it is cheap even in a flood of messages.
INTERLOCK = b'"interlock"'

DIAGNOSTIC, KEYS = "diagnostic_msgs/msg/", ("status", "reason", "joint", "scale", "interlock")


class CommandMessage(NamedTuple):
    """A command and its number in the sender's own count, None where it has none."""

    command: AnyCommand
    number: int | None


class StateMessage(NamedTuple):
    """Measured values by name, of joints [rad, m] or motors, and the sender's counter. The robot's interlock is
    "enabled", "stopped", "emergency stop" or None.
    """

    values: dict[str, float]
    number: int | None
    interlock: str | None = None


class MotorSide:
    """The arm as its drives see it, motor = G theta + o, differentials included.

    units: "motor", rad and m on the motor side, or "counts" of the drives, not rounded.

    Raises InputError if the arm has no actuators, or joints that no motor determines.
    """

    def __init__(self, arm: Arm, units: str) -> None:
        if arm.actuators is None or arm.actuators.joint_names != arm.joint_names:
            raise InputError(
                f"units {units!r} need actuators for each joint of {arm.name}: [actuators] in its arm.toml"
            )
        if arm.actuators.undriven:
            raise InputError(f"no motor determines {listed(arm.actuators.undriven)} of {arm.name}")
        self._actuators = arm.actuators
        self.units = units
        self.names = arm.actuators.names
        self._scale = arm.actuators.counts_per_unit if units == "counts" else np.ones(len(self.names))

    def of(self, setpoint: Setpoint) -> tuple[Array, Array]:
        """Where the motors are to be (k,) and how fast they turn (k,), per second."""
        position = self._actuators.to_motor(setpoint.theta) * self._scale
        return position, self._actuators.velocity_to_motor(setpoint.theta_dot) * self._scale

    def theta(self, values: Sequence[float]) -> Array:
        """theta (n,) from the motors' values (k,) in their order. InputError where they are not k finite numbers."""
        motor = as_theta(values, len(self.names), "the motors' state", self.names)
        return self._actuators.to_theta(motor / self._scale)


def motor_side(arm: Arm, units: str) -> MotorSide | None:
    """The motors' side in these `UNITS`, None for "joint". InputError for other units, and as `MotorSide`."""
    require_choice(units, UNITS, "units")
    return None if units == "joint" else MotorSide(arm, units)


def parse_command(arm: Arm, text: str | bytes) -> CommandMessage:
    """The command in one JSON message, as `command_of` describes it, and the sender's counter.

    Args:
        arm: The arm.
        text: The message.

    Raises:
        InputError: It is not exactly one command.
    """
    message = decoded(text)
    return CommandMessage(command_of(arm, message), message.get("number"))


def command_of(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    """The command in a message, in m, rad and s.

    One of these objects, each with an optional counter "number":

    - {"twist": [vx, vy, vz, wx, wy, wz], "frame": "tool" or "base"}, with "hold": "position", "orientation" or six
      booleans
    - {"jog": {"joint": rate}}
    - {"pose": 4 × 4 numbers, or {"position": [3], "quaternion_wxyz": [4]}}, with "linear_speed", "angular_speed"
    - {"stop": true}: all joints at rest

    Args:
        arm: The arm.
        message: The object.

    Raises:
        InputError: It is not exactly one command.
    """
    require_arm(arm)
    require_mapping(message, "a command", "{'jog': {'elbow': 0.2}}")
    kind = next((kind for kind in _COMMANDS if kind in message), None)
    if kind is None:
        if "interlock" in message:
            also = "and may have reason and number"
            raise InputError(f"a word to the interlock is one of {listed(WORDS)}, {also}; got {quote(message)}")
        raise InputError(f"a command has one of {listed(_COMMANDS)}; got {quote(sorted(message))}")
    needed, optional, build = _COMMANDS[kind]
    given = fields(message, "", needed, {**optional, "number": as_whole})
    try:
        return build(arm, given)
    except InputError:
        raise
    except TwistarmError as error:
        raise InputError(str(error)) from error


def obey_interlock_message(interlock: Interlock, text: bytes, fresh: bool) -> bool:
    """Obey {"interlock": one of `WORDS`}, with an optional "reason". Returns whether the text was one.

    A stale one may stop the arm but not enable it.
    """
    if INTERLOCK not in text:
        return False
    try:
        message = fields(decoded(text), "", {"interlock": one_of(WORDS)}, {"reason": any_text, "number": anything})
    except InputError:
        return False
    interlock.obey(message["interlock"], message.get("reason", ""), fresh)
    return True


def parse_state(arm: Arm, text: str | bytes, motors: MotorSide | None = None) -> StateMessage:
    """The joint state in {"joint_names": [...], "theta": [...]} [rad, m], in any order. "number" is optional.

    It may have some joints only, and joints of others. "interlock" says whether the robot may move. With `motors` it is
    {"motor_names": [...], "motor": [...]} in their units.

    Args:
        arm: The arm.
        text: The message.
        motors: The motors, where the message is in their units; None for joints.

    Raises:
        InputError: It is not exactly one joint state.
    """
    require_arm(arm)
    names, value = ("joint_names", "theta") if motors is None else ("motor_names", "motor")
    needed = {names: list_of(any_text), value: numbers}
    sent = fields(decoded(text), "", needed, {"number": as_whole, "interlock": one_of(STATES)})
    known = arm.joint_names if motors is None else motors.names
    return StateMessage(values_by_name(known, sent[names], sent[value]), sent.get("number"), sent.get("interlock"))


def values_by_name(known: Collection[str], names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
    """Values by name, in any order. Unknown names are ignored.

    Raises InputError for unequal lengths, and for a known name that is repeated or not finite.
    """
    ours = [name for name in names if name in known]
    if ours and len(names) != len(values):
        raise InputError(f"a joint state has as many names as values; got {len(names)} names, {len(values)} values")
    if len(set(ours)) != len(ours):
        twice = [name for name in dict.fromkeys(ours) if ours.count(name) > 1]
        raise InputError(f"a joint state names each joint once; twice: {listed(twice)}")
    given = dict(zip(names, values, strict=False))  # lengths may differ in a message without any name of ours
    for name in ours:
        if not isfinite(given[name]):
            raise InputError(f"the joint state of {name} must be finite; got {given[name]}")
    return given


def setpoint_message(arm: Arm, setpoint: Setpoint, motors: MotorSide | None = None) -> dict[str, Any]:
    """The setpoint as a message that JSON can hold: positions, rates, the servo's status, and motors if given.

    Args:
        arm: The arm.
        setpoint: The setpoint.
        motors: The motors, or None.
    """
    require_arm(arm)
    require(setpoint, Setpoint, "setpoint", "as the loop makes it")
    message: dict[str, Any] = {
        "number": setpoint.number,
        "time": setpoint.time,
        "joint_names": list(arm.joint_names),
        "theta": setpoint.theta.tolist(),
        "theta_dot": setpoint.theta_dot.tolist(),
        "status": setpoint.output.status,
        "joint": setpoint.output.joint,
        "scale": float(setpoint.output.scale),
        "reason": setpoint.output.reason.name,
        "interlock": setpoint.interlock,
    }
    if motors is not None:
        require(motors, MotorSide, "motors", "the motors' side of an arm")
        motor, motor_dot = (values.tolist() for values in motors.of(setpoint))
        message |= {"motor_names": list(motors.names), "motor": motor, "motor_dot": motor_dot, "units": motors.units}
    return message


def _rates(rates: Any, name: str) -> dict[str, float]:
    if not isinstance(rates, Mapping) or not rates:
        raise InputError(f'jog must be {{"joint": rate}}, rates in rad/s or m/s; got {quote(rates)}')
    return {name: as_number(rate, f"jog of {quote(name)}") for name, rate in rates.items()}


def _pose(given: Any, name: str) -> Array:
    g = np.eye(4)
    if isinstance(given, list) and len(given) == 4:
        return np.array([numbers(row, f"pose[{k}]", 4) for k, row in enumerate(given)])
    if not isinstance(given, Mapping):
        raise InputError(f"pose must be four rows of four numbers, or position and quaternion_wxyz; got {quote(given)}")
    parts = fields(given, "pose", {"position": partial(numbers, size=3), "quaternion_wxyz": partial(numbers, size=4)})
    quaternion = np.array(parts["quaternion_wxyz"])
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) <= QUATERNION_TOL:
        raise InputError(f"quaternion_wxyz must have length 1; got {length:.6g}")
    g[:3, :3], g[:3, 3] = from_quaternion_wxyz(quaternion), parts["position"]
    return g


def _true(value: Any, name: str) -> bool:
    if value is not True:
        raise InputError(f"{name} must be true; got {quote(value)}")
    return True


SPEEDS = {"linear_speed": as_number, "angular_speed": as_number}
_Build = Callable[[Arm, dict[str, Any]], AnyCommand]

_COMMANDS: Mapping[str, tuple[Mapping[str, Check], Mapping[str, Check], _Build]] = {
    "twist": (
        {"twist": partial(numbers, size=6), "frame": anything},
        {"hold": anything},
        lambda arm, given: TwistCommand(given["twist"], given["frame"], given.get("hold")),
    ),
    "jog": ({"jog": _rates}, {}, lambda arm, given: JogCommand.of(arm, given["jog"])),
    "pose": (
        {"pose": _pose},
        SPEEDS,
        lambda arm, given: PoseCommand(given["pose"], **{name: given[name] for name in SPEEDS if name in given}),
    ),
    "stop": ({"stop": _true}, {}, lambda arm, given: JogCommand(np.zeros(arm.n))),
}
"""By kind of command: required fields, optional fields, and its constructor."""


class Recorder(Bag):
    """A sink that records each setpoint that it sends to `sink`. As `on_cycle` it records each joint state too.

    The file appears at the end of the block. /setpoints has JointTrajectory of one point each, /diagnostics their
    status. /joint_states and /tf have the usable joint states and the poses of all links. /labels has those of
    `follow`. Stamps are wall-clock time if the stream's clock is the system's. The extra `mcap` is needed.

    Args:
        arm: The arm.
        path: The file to write, named .mcap at its end.
        sink: Where setpoints go.
    """

    def __init__(self, arm: Arm, path: str | os.PathLike[str], sink: Sink) -> None:
        self._sink = require_method(sink, "sink", "write")
        super().__init__(arm, path, time.time_ns() - time.monotonic_ns(), time.monotonic())

    def __call__(self, cycle: Cycle) -> None:
        """Record the joint state and the labels of a cycle."""
        if cycle.theta is not None:
            self.add_state(cycle.time, cycle.theta)
        for label in getattr(cycle, "labels", ()):
            self.add(LABELS, cycle.time, TEXT, label)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint, then record it."""
        try:
            self._sink.write(setpoint)
        finally:
            now, output, message = setpoint.time, setpoint.output, setpoint_message(self._arm, setpoint)
            self.add_motion(SETPOINTS, now, [(0.0, setpoint.theta, setpoint.theta_dot)])
            values = [self.of(f"{DIAGNOSTIC}KeyValue", key, str(message[key] or "")) for key in KEYS]
            level, words = int(output.status != "OK"), output.explain()
            status = self.of(f"{DIAGNOSTIC}DiagnosticStatus", level, "twistarm", words, self._arm.name, values)
            self.add("/diagnostics", now, f"{DIAGNOSTIC}DiagnosticArray", [status])
