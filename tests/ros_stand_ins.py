"""Stand-ins for what the package twistarm_servo imports of ROS 2, on simulated time.

They are for what `tests/ros` cannot have: a clock that jumps, JointJog, and Pythons without rclpy. How the real
messages, parameters, qualities and services behave is tested there.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from typing import Any, ClassVar

# -- messages ------------------------------------------------------------------------------------------------------


class Message:
    """A message by keyword arguments, with its fields alone: `FIELDS` are what makes each of them."""

    FIELDS: ClassVar[dict[str, Callable[[], Any]]] = {}

    def __init__(self, **given: Any) -> None:
        assert given.keys() <= self.FIELDS.keys(), f"{type(self).__name__} has no {given.keys() - self.FIELDS.keys()}"
        vars(self).update({name: make() for name, make in self.FIELDS.items()} | given)


def _message(name: str, /, **fields: Callable[[], Any]) -> Any:
    return type(name, (Message,), {"FIELDS": fields})


Time = _message("Time", sec=int, nanosec=int)
Header = _message("Header", stamp=Time, frame_id=str)
String = _message("String", data=str)
Float64MultiArray = _message("Float64MultiArray", data=list)
Vector3 = _message("Vector3", x=float, y=float, z=float)
Quaternion = _message("Quaternion", x=float, y=float, z=float, w=float)
Twist = _message("Twist", linear=Vector3, angular=Vector3)
TwistStamped = _message("TwistStamped", header=Header, twist=Twist)
Pose = _message("Pose", position=Vector3, orientation=Quaternion)
PoseStamped = _message("PoseStamped", header=Header, pose=Pose)
JointJog = _message("JointJog", header=Header, joint_names=list, displacements=list, velocities=list, duration=float)
JointState = _message("JointState", header=Header, name=list, position=list, velocity=list, effort=list)
Joy = _message("Joy", header=Header, axes=list, buttons=list)
JointTrajectoryPoint = _message("JointTrajectoryPoint", positions=list, velocities=list, time_from_start=Time)
JointTrajectory = _message("JointTrajectory", header=Header, joint_names=list, points=list)
KeyValue = _message("KeyValue", key=str, value=str)
DiagnosticStatus = _message("DiagnosticStatus", level=bytes, name=str, message=str, hardware_id=str, values=list)
DiagnosticArray = _message("DiagnosticArray", header=Header, status=list)
ParameterDescriptor = _message("ParameterDescriptor", name=str, description=str, read_only=bool)
SetParametersResult = _message("SetParametersResult", successful=bool, reason=str)
Trigger = types.SimpleNamespace(__name__="Trigger", Request=object, Response=object)
SetBool = types.SimpleNamespace(__name__="SetBool", Request=object, Response=object)


# -- rclpy ---------------------------------------------------------------------------------------------------------

Policy = types.SimpleNamespace(SYSTEM_DEFAULT=0, RELIABLE=1, BEST_EFFORT=2, TRANSIENT_LOCAL=1)
QoSProfile = types.SimpleNamespace


class ParameterException(Exception):  # noqa: N818  (rclpy's name)
    """The base of rclpy's errors about parameters."""


class NameValidationException(Exception):  # noqa: N818
    """The base of rclpy's errors about the names of topics, services and nodes."""


class Parameter:
    def __init__(self, name: str, type_: Any = None, value: Any = None) -> None:
        self.name, self.value = name, value


class RosTime:
    def __init__(self, nanoseconds: int) -> None:
        self.nanoseconds = nanoseconds

    def to_msg(self) -> Any:
        return Time(sec=self.nanoseconds // 10**9, nanosec=self.nanoseconds % 10**9)


class Clock:
    """The simulated time of a test [s]."""

    def __init__(self) -> None:
        self.seconds = 1000.0

    def now(self) -> RosTime:
        return RosTime(round(self.seconds * 1e9))


class Logger:
    """Remembers (severity, text)."""

    def __init__(self) -> None:
        self.said: list[tuple[str, str]] = []

    def __getattr__(self, severity: str) -> Callable[..., None]:
        return lambda message, **_: self.said.append((severity, message))


class Node:
    """Remembers what was subscribed, published and said; `overrides` are what the command line would give."""

    overrides: ClassVar[dict[str, Any]] = {}

    def __init__(self, node_name: str) -> None:
        self._name, self._logger, self._clock = node_name, Logger(), Clock()
        self.subscribed: dict[str, tuple[Any, Callable[[Any], None]]] = {}
        self.published: dict[str, list[Any]] = {}
        self.ticks: list[tuple[float, Callable[[], None]]] = []

    def get_name(self) -> str:
        return self._name

    def get_logger(self) -> Logger:
        return self._logger

    def get_clock(self) -> Clock:
        return self._clock

    def declare_parameter(self, name: str, value: Any, descriptor: Any) -> Parameter:
        given = self.overrides.get(name, value)
        assert type(given) is type(value), f"{name} is a {type(value).__name__}"
        return Parameter(name, value=given)

    def create_subscription(self, msg_type: Any, topic: str, callback: Callable[[Any], None], qos_profile: Any) -> None:
        self.subscribed[topic] = (msg_type, callback)

    def create_publisher(self, msg_type: Any, topic: str, qos_profile: Any) -> Any:
        return types.SimpleNamespace(publish=self.published.setdefault(topic, []).append)

    def create_timer(self, timer_period_sec: float, callback: Callable[[], None]) -> None:
        self.ticks.append((timer_period_sec, callback))

    def resolve_topic_name(self, topic: str) -> str:
        return topic.replace("~", f"/{self._name}")

    def count_publishers(self, topic_name: str) -> int:
        return 1

    def add_on_set_parameters_callback(self, callback: Any) -> None:
        """Parameters that are set while it runs are for the real ROS, as services are."""

    create_service = destroy_node = lambda self, *_: None


def install(monkeypatch: Any, spin_once: Callable[[Any], None]) -> None:
    """Put the modules where `import` finds them; `spin_once(node)` is called as rclpy's."""
    contents: dict[str, tuple[Any, ...]] = {
        "rclpy.node": (Node,),
        "rclpy.parameter": (Parameter,),
        "rclpy.exceptions": (NameValidationException, ParameterException),
        "rcl_interfaces.msg": (ParameterDescriptor, SetParametersResult),
        "control_msgs.msg": (JointJog,),
        "diagnostic_msgs.msg": (DiagnosticArray, DiagnosticStatus, KeyValue),
        "geometry_msgs.msg": (PoseStamped, Twist, TwistStamped),
        "sensor_msgs.msg": (JointState, Joy),
        "std_msgs.msg": (Float64MultiArray, String),
        "std_srvs.srv": (SetBool, Trigger),
        "trajectory_msgs.msg": (JointTrajectory, JointTrajectoryPoint),
    }
    modules = {name: {kind.__name__: kind for kind in content} for name, content in contents.items()}
    modules["rclpy.qos"] = {"QoSProfile": QoSProfile, "ReliabilityPolicy": Policy, "DurabilityPolicy": Policy}
    modules["rclpy.signals"] = {"SignalHandlerOptions": types.SimpleNamespace(NO=0)}
    modules["rclpy"] = {
        "init": lambda **_: None,
        "ok": lambda: True,
        "spin_once": lambda node, **_: spin_once(node),
        "shutdown": lambda: None,
    }
    for name in {name.split(".")[0] for name in modules} | set(modules):
        module = types.ModuleType(name)
        vars(module).update(modules.get(name, {}))
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(Node, "overrides", {})
