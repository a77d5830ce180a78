"""The messages of the loop as JSON: commands and joint states in, setpoints out; see docs/streaming.md."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ...model.arm import Arm, require_arm
from ...servo import AnyCommand, JogCommand, PoseCommand, TwistCommand
from ...support.checks import Array, require, require_mapping
from ...support.errors import InputError, TwistarmError, listed
from ...support.strict_json import counter, decoded, number, numbers, short
from ...theory.rotations import from_quaternion_wxyz
from ..interlock import STATES, WORDS, Interlocked
from ..motors import MotorSide
from ..protocols import Setpoint
from .by_name import values_by_name

QUATERNION_TOL = 1e-3
"""How far a quaternion's length may be from 1: beyond four printed decimals it is something else."""


INTERLOCK = b'"interlock"'
"""What a word to the interlock holds: a look that costs nothing, for every message of a flood."""


class CommandMessage(NamedTuple):
    """A command and its number in the sender's own count, None where it has none."""

    command: AnyCommand
    number: int | None


class StateMessage(NamedTuple):
    """Measured values by name, of joints [rad, m] or motors, its number in the sender's own count, and whether the
    robot may move: "enabled", "stopped", "emergency stop", None where it does not say.
    """

    values: dict[str, float]
    number: int | None
    interlock: str | None = None


def parse_command(arm: Arm, text: str | bytes) -> CommandMessage:
    """The command in one JSON message, as `command_of` describes it.

    Args:
        arm: The arm.
        text: The message.

    Returns:
        The command and the sender's counter.

    Raises:
        InputError: It is not exactly one command.
    """
    message = decoded(text)
    return CommandMessage(command_of(arm, message), _number_of(message))


def command_of(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    """The command that a message says, in m, rad and s.

    One of these objects, each with "number", a counter, where the sender counts:

    - {"twist": [vx, vy, vz, wx, wy, wz], "frame": "tool" or "base"}, with "hold": "position", "orientation" or six
      booleans
    - {"jog": {"joint": rate}}
    - {"pose": 4 × 4 numbers, or {"position": [3], "quaternion_wxyz": [4]}}, with "linear_speed", "angular_speed"
    - {"stop": true}: all joints at rest

    Args:
        arm: The arm.
        message: The object.

    Returns:
        The command.

    Raises:
        InputError: It is not exactly one command.
    """
    require_arm(arm)
    require_mapping(message, "a command", "{'jog': {'elbow': 0.2}}")
    kind = next((kind for kind in _COMMANDS if kind in message), None)
    if kind is None:
        if "interlock" in message:
            also = "and may have reason and number"
            raise InputError(f"a word to the interlock is one of {listed(WORDS)}, {also}; got {short(message)}")
        raise InputError(f"a command has one of {listed(_COMMANDS)}; got {short(sorted(message))}")
    needed, optional, build = _COMMANDS[kind]
    names = set(message) - {"number"}
    if not {kind, *needed} <= names <= {kind, *needed, *optional}:
        also = f" and may have {', '.join((*optional, 'number'))}"
        raise InputError(f"{kind} needs {', '.join((kind, *needed))}{also}; got {short(sorted(message))}")
    _number_of(message)
    try:
        return build(arm, message)
    except InputError:
        raise
    except TwistarmError as error:
        raise InputError(str(error)) from error


def heard_word(device: Interlocked, text: bytes, fresh: bool) -> bool:
    """Whether the text is a word to the device's interlock, {"interlock": one of `WORDS`}, with "reason" if there is
    one. It is done; one that is not fresh may stop the arm, and not let it move again.
    """
    if INTERLOCK not in text:
        return False
    try:
        message = decoded(text)
    except InputError:
        return False
    word, reason = message.get("interlock"), message.get("reason", "")
    if set(message) - {"reason", "number"} != {"interlock"} or word not in WORDS or not isinstance(reason, str):
        return False
    device.interlock.hear(word, reason, fresh)
    return True


def parse_state(arm: Arm, text: str | bytes, motors: MotorSide | None = None) -> StateMessage:
    """The joint state in {"joint_names": [...], "theta": [...]}, [rad, m], in any order, with "number" if it counts.

    It may tell of some joints alone, and of others that are not the arm's. With "interlock", the robot says whether it
    may move. Where `motors` are given, it is {"motor_names": [...], "motor": [...]} in their units.

    Args:
        arm: The arm.
        text: The message.
        motors: The motors, where the message is in their units; None for joints.

    Returns:
        The values by joint, the sender's counter and the robot's interlock.

    Raises:
        InputError: It is not exactly one joint state.
    """
    require_arm(arm)
    message = decoded(text)
    named, value = ("joint_names", "theta") if motors is None else ("motor_names", "motor")
    if set(message) - {"number", "interlock"} != {named, value}:
        raise InputError(
            f"a joint state has {named} and {value}, and may have number and interlock; got {short(sorted(message))}"
        )
    names = message[named]
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{named} must be a list of names; got {short(names)}")
    values = numbers(message[value], value)
    known = arm.joint_names if motors is None else motors.names
    return StateMessage(values_by_name(known, names, values), _number_of(message), _state_of(message))


def setpoint_message(arm: Arm, setpoint: Setpoint, motors: MotorSide | None = None) -> dict[str, Any]:
    """The setpoint as a message: positions, rates and the servo's status; those of the motors too where they are given.

    Args:
        arm: The arm.
        setpoint: The setpoint.
        motors: The motors, or None.

    Returns:
        A mapping that JSON can hold.
    """
    require_arm(arm)
    require(setpoint, Setpoint, "setpoint", "as the loop makes it")
    message: dict[str, Any] = {
        "number": setpoint.number,
        "time": setpoint.time,
        "joint_names": list(arm.joint_names),
        "theta": setpoint.theta.tolist(),
        "theta_dot": setpoint.theta_dot.tolist(),
        "status": setpoint.output.status.name,
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


def _number_of(message: Mapping[str, Any]) -> int | None:
    return counter(message["number"], "number") if "number" in message else None


def followed(
    device: Interlocked, parse: Callable[[bytes], StateMessage], text: bytes
) -> tuple[dict[str, float], int | None]:
    """Values and number of a robot's joint state; where the robot says that it may not move, nor may the stream."""
    state = parse(text)
    device.interlock.follow(state.interlock, "the robot")
    return state.values, state.number


def _state_of(message: Mapping[str, Any]) -> str | None:
    word = message.get("interlock")
    if "interlock" in message and word not in STATES:
        raise InputError(f"a robot's interlock is one of {listed(STATES)}; got {short(word)}")
    return word


def _twist(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    hold = message.get("hold")
    if not isinstance(hold, (str, list, type(None))):
        raise InputError(f"hold must be 'position', 'orientation' or six booleans; got {short(hold)}")
    return TwistCommand(np.array(numbers(message["twist"], "twist", 6)), message["frame"], hold)


def _jog(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    rates = message["jog"]
    if not isinstance(rates, Mapping) or not rates:
        raise InputError(f'jog must be {{"joint": rate}}, rates in rad/s or m/s; got {short(rates)}')
    return JogCommand.of(arm, {name: number(rate, f"jog of {short(name)}") for name, rate in rates.items()})


def _pose(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    given = message["pose"]
    g = _pose_from_parts(given) if isinstance(given, Mapping) else _pose_from_rows(given)
    speeds = {name: number(message[name], name) for name in _SPEEDS if name in message}
    return PoseCommand(g, (0.0,) * 6, **speeds)


def _pose_from_rows(rows: Any) -> Array:
    if not isinstance(rows, list) or len(rows) != 4:
        raise InputError(f"pose must be four rows of four numbers, or position and quaternion_wxyz; got {short(rows)}")
    return np.array([numbers(row, f"pose[{k}]", 4) for k, row in enumerate(rows)])


def _pose_from_parts(parts: Mapping[str, Any]) -> Array:
    if set(parts) != {"position", "quaternion_wxyz"}:
        raise InputError(f"pose needs position and quaternion_wxyz; got {short(sorted(parts))}")
    quaternion = np.array(numbers(parts["quaternion_wxyz"], "quaternion_wxyz", 4))
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) <= QUATERNION_TOL:
        raise InputError(f"quaternion_wxyz must have length 1; got {length:.6g}")
    g = np.eye(4)
    g[:3, :3] = from_quaternion_wxyz(quaternion)
    g[:3, 3] = numbers(parts["position"], "position", 3)
    return g


def _stop(arm: Arm, message: Mapping[str, Any]) -> AnyCommand:
    if message["stop"] is not True:
        raise InputError(f"stop must be true; got {short(message['stop'])}")
    return JogCommand(np.zeros(arm.n))


_SPEEDS = ("linear_speed", "angular_speed")

_Build = Callable[[Arm, Mapping[str, Any]], AnyCommand]

_COMMANDS: Mapping[str, tuple[tuple[str, ...], tuple[str, ...], _Build]] = {
    "twist": (("frame",), ("hold",), _twist),
    "jog": ((), (), _jog),
    "pose": ((), _SPEEDS, _pose),
    "stop": ((), (), _stop),
}
"""By kind: what it needs besides, what it may have, what it becomes."""
