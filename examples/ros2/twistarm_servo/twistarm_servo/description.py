"""The arm's source: a file, the parameter robot_description, or the topic of robot_state_publisher."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

from twistarm import Arm, load_arm

from .parameters import Parameters


def find_arm(node: Node, parameters: Parameters, begin: Callable[[Arm], None]) -> None:
    """Call `begin` with the arm: now, or when its description has come by the topic. TwistarmError where it is none."""
    if parameters.description:
        begin(_loaded(parameters.description, parameters))
    elif parameters.robot_description:
        begin(arm_of_text(parameters.robot_description, parameters))
    else:
        _listen(node, parameters, begin)


def _listen(node: Node, parameters: Parameters, begin: Callable[[Arm], None]) -> None:
    began = False

    def on_description(message: String) -> None:
        nonlocal began
        if began:
            node.get_logger().warning("another robot_description came; restart the node to drive that robot")
            return
        began = True
        begin(arm_of_text(message.data, parameters))

    latched = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_subscription(String, parameters.description_topic, on_description, latched)
    node.get_logger().info(f"waiting for a description on {parameters.description_topic}")


def arm_of_text(text: str, parameters: Parameters) -> Arm:
    """The arm in the text of a URDF."""
    with tempfile.TemporaryDirectory(prefix="twistarm-") as folder:
        file = Path(folder) / "robot_description.urdf"
        file.write_text(text, encoding="utf-8")
        return _loaded(str(file), parameters)


def _loaded(source: str, parameters: Parameters) -> Arm:
    limits: Any = parameters.joint_limits or None
    arm = load_arm(source, base=parameters.base or None, tip=parameters.tip or None, limits=limits)
    caps = {"velocity": parameters.velocity_limit, "acceleration": parameters.acceleration_limit}
    given = {name: dict.fromkeys(arm.joint_names, cap) for name, cap in caps.items() if cap != 0.0}
    limits = arm.limits.with_(given, arm.joint_names)
    lowest = {name: np.minimum(getattr(arm.limits, name), getattr(limits, name)) for name in given}
    return replace(arm, limits=replace(arm.limits, **lowest))
