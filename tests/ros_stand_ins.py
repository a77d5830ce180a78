"""Stand-ins for the ROS 2 modules that the example node imports: enough of each to be constructed, fed and read."""

from __future__ import annotations

import sys
import types
from dataclasses import dataclass, field
from typing import Any

Stamp = lambda sec=0, nanosec=0: types.SimpleNamespace(sec=sec, nanosec=nanosec)  # noqa: E731
Vector = lambda x=0.0, y=0.0, z=0.0: types.SimpleNamespace(x=x, y=y, z=z)  # noqa: E731


def header():
    return types.SimpleNamespace(frame_id="", stamp=Stamp())


@dataclass
class Twist:
    linear: Any = field(default_factory=Vector)
    angular: Any = field(default_factory=Vector)


@dataclass
class TwistStamped:
    header: Any = field(default_factory=header)
    twist: Twist = field(default_factory=Twist)


@dataclass
class JointState:
    header: Any = field(default_factory=header)
    name: list = field(default_factory=list)
    position: list = field(default_factory=list)


@dataclass
class Joy:
    axes: list = field(default_factory=list)
    buttons: list = field(default_factory=list)


@dataclass
class Float64MultiArray:
    data: list


@dataclass
class JointTrajectoryPoint:
    positions: list = field(default_factory=list)
    velocities: list = field(default_factory=list)
    time_from_start: Any = field(default_factory=Stamp)


@dataclass
class JointTrajectory:
    header: Any = field(default_factory=header)
    joint_names: list = field(default_factory=list)
    points: list = field(default_factory=list)


@dataclass
class KeyValue:
    key: str
    value: str


@dataclass
class DiagnosticStatus:
    level: bytes
    name: str
    message: str
    hardware_id: str
    values: list = field(default_factory=list)


@dataclass
class DiagnosticArray:
    status: list
    header: Any = field(default_factory=header)


class Node:
    """Remembers what was subscribed, published and said; `parameters` are what the command line would give."""

    parameters: dict = {}  # noqa: RUF012
    publishers_of: dict = {}  # noqa: RUF012

    def __init__(self, name):
        self.name = name
        self.subscribed, self.published, self.timers_, self.said = {}, {}, [], []
        self.destroyed = False

    def declare_parameter(self, name, default):
        return types.SimpleNamespace(value=self.parameters.get(name, default))

    def create_subscription(self, kind, topic, callback, depth):
        self.subscribed[topic] = (kind, callback)

    def create_publisher(self, kind, topic, depth):
        messages = self.published.setdefault(topic, [])

        def publish(message):
            assert type(message) is kind
            assert not self.destroyed
            messages.append(message)

        return types.SimpleNamespace(publish=publish)

    def create_timer(self, period, callback):
        self.timers_.append((period, callback))

    def resolve_topic_name(self, topic):
        return topic

    def count_publishers(self, topic):
        return self.publishers_of.get(topic, 1)

    def get_logger(self):
        return types.SimpleNamespace(fatal=self.said.append)

    def get_clock(self):
        now = types.SimpleNamespace(to_msg=lambda: Stamp(1, 2))
        return types.SimpleNamespace(now=lambda: now)

    def destroy_node(self):
        self.destroyed = True


def install(monkeypatch, spin_once):
    """Put the modules where `import` finds them; `spin_once(node)` is called as rclpy's."""
    said = []
    modules = {
        "rclpy": {
            "init": lambda **options: said.append("init"),
            "ok": lambda: True,
            "spin_once": lambda node, timeout_sec: spin_once(node),
            "shutdown": lambda: said.append("shutdown"),
        },
        "rclpy.node": {"Node": Node},
        "rclpy.signals": {"SignalHandlerOptions": types.SimpleNamespace(NO=0)},
        "geometry_msgs.msg": {"Twist": Twist, "TwistStamped": TwistStamped},
        "sensor_msgs.msg": {"JointState": JointState, "Joy": Joy},
        "std_msgs.msg": {"Float64MultiArray": Float64MultiArray},
        "trajectory_msgs.msg": {"JointTrajectory": JointTrajectory, "JointTrajectoryPoint": JointTrajectoryPoint},
        "diagnostic_msgs.msg": {
            "DiagnosticArray": DiagnosticArray, "DiagnosticStatus": DiagnosticStatus, "KeyValue": KeyValue,
        },
    }  # fmt: skip
    for name, content in modules.items():
        parent = name.split(".")[0]
        if parent not in modules:
            monkeypatch.setitem(sys.modules, parent, types.ModuleType(parent))
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(Node, "parameters", {})
    monkeypatch.setattr(Node, "publishers_of", {})
    return said
