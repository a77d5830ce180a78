"""Stand-ins for the ROS 2 modules that the package twistarm_servo imports, as strict as the real ones.

Messages take keyword arguments alone, know their fields alone, and refuse values of another type, as the classes do
that rosidl generates: a float is no int, a byte is `bytes` of length 1, a list of floats holds floats and is kept as an
array. The fields are those of the published .msg and .srv files (control_msgs, diagnostic_msgs, geometry_msgs,
rcl_interfaces, sensor_msgs, std_msgs, std_srvs, trajectory_msgs; Humble to Kilted). The signatures are those of rclpy's
API documentation and its type hints (rclpy.node.Node, rclpy.qos, rclpy.init, spin_once, shutdown): names, order and
which are keyword-only. What Node has of its own (`services`, `publishers`, …) cannot be assigned, as there. A parameter
keeps the type of its default, and a read-only one its value.
"""

from __future__ import annotations

import inspect
import re
import sys
import types
from array import array
from collections.abc import Callable, Sequence
from enum import IntEnum
from typing import Any, ClassVar

# -- messages ------------------------------------------------------------------------------------------------------

FLOAT, SHORT_FLOAT, BOOL, STRING, BYTE = "float64", "float32", "bool", "string", "byte"
INT, UINT = "int32", "uint32"

SCALARS: dict[str, tuple[Callable[[], Any], Callable[[Any], bool]]] = {
    FLOAT: (float, lambda value: isinstance(value, float)),
    SHORT_FLOAT: (float, lambda value: isinstance(value, float)),
    BOOL: (bool, lambda value: isinstance(value, bool)),
    STRING: (str, lambda value: isinstance(value, str)),
    BYTE: (lambda: b"\0", lambda value: isinstance(value, bytes) and len(value) == 1),
    INT: (int, lambda value: isinstance(value, int) and -(2**31) <= value < 2**31),
    UINT: (int, lambda value: isinstance(value, int) and 0 <= value < 2**32),
}


ARRAYS = {FLOAT: "d", SHORT_FLOAT: "f", INT: "i", UINT: "I"}


class Message:
    """What rosidl makes of a .msg file: `FIELDS` by name, each a scalar, a message's class, or a list of one."""

    FIELDS: ClassVar[dict[str, Any]] = {}

    def __init__(self, **given: Any) -> None:
        unknown = set(given) - set(self.FIELDS)
        assert not unknown, f"Invalid arguments passed to constructor: {sorted(unknown)}"
        for name, kind in self.FIELDS.items():
            setattr(self, name, given[name] if name in given else _default(kind))

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in self.FIELDS:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        kind = self.FIELDS[name]
        assert _takes(kind, value), f"The {name!r} field must be of type {kind!r}; got {value!r}"
        object.__setattr__(self, name, _kept(kind, value))


def _kept(kind: Any, value: Any) -> Any:
    """Lists of numbers are kept as arrays of the type, in which a float32 is rounded."""
    code = ARRAYS.get(kind[0]) if isinstance(kind, list) and isinstance(kind[0], str) else None
    return value if code is None else array(code, value)


def _default(kind: Any) -> Any:
    if isinstance(kind, list):
        return []
    return SCALARS[kind][0]() if isinstance(kind, str) else kind()


def _takes(kind: Any, value: Any) -> bool:
    if isinstance(kind, list):
        several = isinstance(value, Sequence | array) and not isinstance(value, (str, bytes))
        return several and all(_takes(kind[0], each) for each in value)
    return SCALARS[kind][1](value) if isinstance(kind, str) else isinstance(value, kind)


def _message(name: str, /, **fields: Any) -> Any:
    return type(name, (Message,), {"FIELDS": fields})


Time = _message("Time", sec=INT, nanosec=UINT)
Duration = _message("Duration", sec=INT, nanosec=UINT)
Header = _message("Header", stamp=Time, frame_id=STRING)
String = _message("String", data=STRING)
MultiArrayDimension = _message("MultiArrayDimension", label=STRING, size=UINT, stride=UINT)
MultiArrayLayout = _message("MultiArrayLayout", dim=[MultiArrayDimension], data_offset=UINT)
Float64MultiArray = _message("Float64MultiArray", layout=MultiArrayLayout, data=[FLOAT])
Vector3 = _message("Vector3", x=FLOAT, y=FLOAT, z=FLOAT)
Point = _message("Point", x=FLOAT, y=FLOAT, z=FLOAT)
Quaternion = _message("Quaternion", x=FLOAT, y=FLOAT, z=FLOAT, w=FLOAT)
Twist = _message("Twist", linear=Vector3, angular=Vector3)
TwistStamped = _message("TwistStamped", header=Header, twist=Twist)
Pose = _message("Pose", position=Point, orientation=Quaternion)
PoseStamped = _message("PoseStamped", header=Header, pose=Pose)
JointJog = _message(
    "JointJog", header=Header, joint_names=[STRING], displacements=[FLOAT], velocities=[FLOAT], duration=FLOAT
)
JointState = _message("JointState", header=Header, name=[STRING], position=[FLOAT], velocity=[FLOAT], effort=[FLOAT])
Joy = _message("Joy", header=Header, axes=[SHORT_FLOAT], buttons=[INT])
JointTrajectoryPoint = _message(
    "JointTrajectoryPoint",
    positions=[FLOAT], velocities=[FLOAT], accelerations=[FLOAT], effort=[FLOAT], time_from_start=Duration,
)  # fmt: skip
JointTrajectory = _message("JointTrajectory", header=Header, joint_names=[STRING], points=[JointTrajectoryPoint])
KeyValue = _message("KeyValue", key=STRING, value=STRING)
DiagnosticStatus = _message(
    "DiagnosticStatus", level=BYTE, name=STRING, message=STRING, hardware_id=STRING, values=[KeyValue]
)
DiagnosticArray = _message("DiagnosticArray", header=Header, status=[DiagnosticStatus])
ParameterDescriptor = _message("ParameterDescriptor", name=STRING, description=STRING, read_only=BOOL)
SetParametersResult = _message("SetParametersResult", successful=BOOL, reason=STRING)


def _service(name: str, request: dict[str, Any], response: dict[str, Any]) -> Any:
    made = {"Request": _message(f"{name}_Request", **request), "Response": _message(f"{name}_Response", **response)}
    return type(name, (), made)


Trigger = _service("Trigger", {}, {"success": BOOL, "message": STRING})
SetBool = _service("SetBool", {"data": BOOL}, {"success": BOOL, "message": STRING})


# -- rclpy ---------------------------------------------------------------------------------------------------------


class ReliabilityPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    RELIABLE = 1
    BEST_EFFORT = 2


class DurabilityPolicy(IntEnum):
    SYSTEM_DEFAULT = 0
    TRANSIENT_LOCAL = 1
    VOLATILE = 2


class QoSProfile:
    """Keyword arguments alone; a depth, or a history."""

    def __init__(self, *, depth: int, reliability: Any = None, durability: Any = None) -> None:
        assert isinstance(depth, int)
        assert isinstance(reliability, ReliabilityPolicy | None)
        assert isinstance(durability, DurabilityPolicy | None)
        self.depth, self.reliability, self.durability = depth, reliability, durability


class ParameterException(Exception):  # noqa: N818  (rclpy's name)
    """The base of rclpy's errors about parameters."""


class NameValidationException(Exception):  # noqa: N818
    """The base of rclpy's errors about the names of topics, services and nodes."""


def _checked_name(name: str) -> None:
    if not re.fullmatch(r"(~/|/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", name):
        raise NameValidationException(f"Invalid topic name: topic name is invalid:\n  '{name}'\n   ^")


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

    def __getattr__(self, severity: str) -> Callable[..., bool]:
        if severity not in ("debug", "info", "warning", "error", "fatal"):
            raise AttributeError(severity)

        def log(message: str, *, throttle_duration_sec: float | None = None, once: bool = False) -> bool:
            assert isinstance(message, str)
            self.said.append((severity, message))
            return True

        return log


class Node:
    """Remembers what was subscribed, published and said; `overrides` are what the command line would give."""

    overrides: ClassVar[dict[str, Any]] = {}
    publishers_of: ClassVar[dict[str, int]] = {}

    def __init__(self, node_name: str) -> None:
        self._name, self._logger, self._clock = node_name, Logger(), Clock()
        self._parameters: dict[str, tuple[Any, Any]] = {}
        self._callbacks: list[Callable[[list[Parameter]], Any]] = []
        self.subscribed: dict[str, tuple[Any, Any, Any]] = {}
        self.published: dict[str, list[Any]] = {}
        self.quality: dict[str, Any] = {}
        self.served: dict[str, tuple[Any, Any]] = {}
        self.ticks: list[tuple[float, Callable[[], None]]] = []
        self.destroyed = False

    publishers = services = subscriptions = timers = clients = property(lambda self: iter(()))
    executor = context = handle = guards = waitables = default_callback_group = property(lambda self: None)

    def get_name(self) -> str:
        return self._name

    def get_logger(self) -> Logger:
        return self._logger

    def get_clock(self) -> Clock:
        return self._clock

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None, ignore_override: bool = False
    ) -> Parameter:
        assert name not in self._parameters
        assert value != [], "an empty list is declared as bytes"
        assert descriptor is None or isinstance(descriptor, ParameterDescriptor)
        given = self.overrides.get(name, value)
        if _kind(given) != _kind(value):
            raise ParameterException(f"Trying to set parameter '{name}' to '{given}', expecting type '{_kind(value)}'")
        self._parameters[name] = (given, descriptor)
        return Parameter(name, value=given)

    def add_on_set_parameters_callback(self, callback: Callable[[list[Parameter]], Any]) -> None:
        _takes_arguments(callback, 1)
        self._callbacks.append(callback)

    def set_parameter(self, name: str, value: Any) -> Any:
        """What `ros2 param set` does."""
        old, descriptor = self._parameters[name]
        if descriptor.read_only:
            return SetParametersResult(successful=False, reason="read-only")
        if _kind(old) != _kind(value):
            return SetParametersResult(successful=False, reason="wrong type")
        for callback in self._callbacks:
            result = callback([Parameter(name, value=value)])
            assert isinstance(result, SetParametersResult)
            if not result.successful:
                return result
        self._parameters[name] = (value, descriptor)
        return SetParametersResult(successful=True)

    def create_subscription(
        self, msg_type: Any, topic: str, callback: Callable[[Any], None], qos_profile: Any, *,
        callback_group: Any = None, event_callbacks: Any = None, qos_overriding_options: Any = None, raw: bool = False,
    ) -> None:  # fmt: skip
        assert issubclass(msg_type, Message)
        assert isinstance(qos_profile, QoSProfile | int)
        _takes_arguments(callback, 1)
        _checked_name(topic)
        assert topic not in self.subscribed
        self.subscribed[topic] = (msg_type, callback, qos_profile)

    def create_publisher(
        self, msg_type: Any, topic: str, qos_profile: Any, *, callback_group: Any = None, event_callbacks: Any = None,
        qos_overriding_options: Any = None,
    ) -> Any:  # fmt: skip
        assert issubclass(msg_type, Message)
        assert isinstance(qos_profile, QoSProfile | int)
        _checked_name(topic)
        messages = self.published.setdefault(topic, [])
        self.quality[topic] = qos_profile

        def publish(msg: Any) -> None:
            assert type(msg) is msg_type
            assert not self.destroyed
            messages.append(msg)

        return types.SimpleNamespace(publish=publish)

    def create_service(
        self, srv_type: Any, srv_name: str, callback: Callable[[Any, Any], Any], *, qos_profile: Any = None,
        callback_group: Any = None,
    ) -> None:  # fmt: skip
        _takes_arguments(callback, 2)
        _checked_name(srv_name)
        self.served[srv_name] = (srv_type, callback)

    def call(self, srv_name: str, **request: Any) -> tuple[bool, str]:
        """What `ros2 service call` does: success and message."""
        kind, callback = self.served[srv_name]
        response = callback(kind.Request(**request), kind.Response())
        assert isinstance(response, kind.Response)
        return response.success, response.message

    def create_timer(
        self, timer_period_sec: float, callback: Callable[[], None], callback_group: Any = None, clock: Any = None
    ) -> None:
        _takes_arguments(callback, 0)
        self.ticks.append((float(timer_period_sec), callback))

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        return topic.replace("~", f"/{self._name}")

    def count_publishers(self, topic_name: str) -> int:
        assert topic_name.startswith("/") or "~" not in topic_name
        return self.publishers_of.get(topic_name, 1)

    def destroy_node(self) -> None:
        self.destroyed = True


def _kind(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return f"{_kind(value[0])} array" if value else "byte array"
    return type(value).__name__


def _takes_arguments(callback: Callable[..., Any], count: int) -> None:
    inspect.signature(callback).bind(*range(count))


def install(monkeypatch: Any, spin_once: Callable[[Any], None]) -> list[str]:
    """Put the modules where `import` finds them; `spin_once(node)` is called as rclpy's. What was called is listed."""
    said: list[str] = []

    contents: dict[str, Sequence[Any]] = {
        "rclpy.node": (Node,),
        "rclpy.parameter": (Parameter,),
        "rclpy.qos": (QoSProfile, ReliabilityPolicy, DurabilityPolicy),
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
    modules = {name: {each.__name__: each for each in content} for name, content in contents.items()}
    modules["rclpy"] = {
        "init": lambda *, args=None, context=None, domain_id=None, signal_handler_options=None: said.append("init"),
        "ok": lambda *, context=None: True,
        "spin_once": lambda node, *, executor=None, timeout_sec=None: spin_once(node),
        "shutdown": lambda *, context=None, uninstall_handlers=None: said.append("shutdown"),
    }
    modules["rclpy.signals"] = {"SignalHandlerOptions": types.SimpleNamespace(NO=0)}
    for name in {name.split(".")[0] for name in modules} | set(modules):
        module = types.ModuleType(name)
        vars(module).update(modules.get(name, {}))
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(Node, "overrides", {})
    monkeypatch.setattr(Node, "publishers_of", {})
    return said
