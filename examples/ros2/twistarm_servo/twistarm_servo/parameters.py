"""The node's parameters: names, defaults and what they mean; names of MoveIt Servo where they mean the same."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from math import nan
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from twistarm import InputError

SWITCHES = ("frame", "hold")
"""Those that may be set while the node runs."""

TRAJECTORY, ARRAY = "trajectory_msgs/JointTrajectory", "std_msgs/Float64MultiArray"


def _is(default: Any, meaning: str) -> Any:
    return field(default=default, metadata={"meaning": meaning})


@dataclass(frozen=True)
class Parameters:
    """What the node was started with."""

    description: str = _is("", "file or name that twistarm's load_arm takes; wins over robot_description")
    robot_description: str = _is("", "the URDF itself, as text")
    description_topic: str = _is("/robot_description", "where the URDF is waited for when neither of these is given")
    base: str = _is("", "root link of the arm; empty: found")
    tip: str = _is("", "link that is driven; empty: found")
    joint_limits: str = _is("", "a joint_limits.yaml of MoveIt or ros2_control; wins over the URDF")
    velocity_limit: float = _is(0.0, "at most, of every joint [rad/s, m/s]; 0: the description's")
    acceleration_limit: float = _is(0.0, "at most, of every joint [rad/s², m/s²]; 0: the description's")
    joint_limit_margin: float = _is(0.0, "how far inside their limits joints are kept [rad, m]")
    on_unreachable: str = _is("slide", "where the arm cannot follow: slide along, or stop on the commanded course")
    rate: float = _is(100.0, "of the servo and of what it publishes [Hz]")
    frame: str = _is("tool", "axes of twists that name no frame, and of the joystick: tool or base")
    hold: str = _is("", "what twists leave as it is: position, orientation or nothing")
    enabled_at_start: bool = _is(True, "false: nothing moves before ~/enable")
    incoming_command_timeout: float = _is(0.2, "how long a command holds [s]")
    feedback_timeout: float = _is(0.2, "how long a joint state holds [s]")
    tolerance: float = _is(0.2, "how far a joint may be from where it was commanded [rad, m]")
    command_in_type: str = _is("speed_units", "speed_units [m/s, rad/s], or unitless: -1 to 1 of the scales")
    scale_linear: float = _is(0.4, "speed of a unitless twist [m/s]")
    scale_rotational: float = _is(0.8, "speed of a unitless twist [rad/s]")
    scale_joint: float = _is(0.5, "speed of a unitless jog [rad/s, m/s]")
    cartesian_command_in_topic: str = _is("~/delta_twist_cmds", "geometry_msgs/TwistStamped")
    stamped: bool = _is(True, "false: geometry_msgs/Twist instead")
    joint_command_in_topic: str = _is("~/delta_joint_cmds", "control_msgs/JointJog")
    pose_command_in_topic: str = _is("~/pose_target_cmds", "geometry_msgs/PoseStamped")
    joy_topic: str = _is("joy", "sensor_msgs/Joy")
    joint_topic: str = _is("/joint_states", "sensor_msgs/JointState")
    command_out_topic: str = _is("~/commands", "where the controller listens")
    command_out_type: str = _is(TRAJECTORY, f"{TRAJECTORY} or {ARRAY}")
    publish_joint_positions: bool = _is(True, "in a trajectory's points, or as the array")
    publish_joint_velocities: bool = _is(True, "in a trajectory's points, or as the array")
    diagnostics_topic: str = _is("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    qos_in: str = _is("best_effort", "of what is heard: best_effort, which hears everybody, reliable, system_default")
    qos_out: str = _is("system_default", "of what is published: system_default, reliable or best_effort")
    joy_axes: tuple[int, ...] = _is((-1,) * 6, "axes of a joystick for vx, vy, vz, wx, wy, wz; -1: none")
    joy_rest: tuple[float, ...] = _is((nan,) * 6, "what each of them says at rest: 0 for a stick, 1 for most triggers")
    joy_scale: tuple[float, ...] = _is(
        (0.1, 0.1, 0.1, 0.5, 0.5, 0.5), "twist at full deflection [m/s, rad/s], with signs"
    )
    joy_deadband: float = _is(0.1, "deflections below this are none")
    joy_dead_man: int = _is(4, "button that must be held")

    def __post_init__(self) -> None:
        self._require("on_unreachable", "slide", "stop")
        self._require("command_in_type", "speed_units", "unitless")
        self._require("command_out_type", TRAJECTORY, ARRAY)
        if self.trajectory and not self.publish_joint_positions:
            raise InputError("a JointTrajectory needs positions: set publish_joint_positions")
        if not self.trajectory and self.publish_joint_positions == self.publish_joint_velocities:
            raise InputError(
                "a Float64MultiArray holds positions or velocities: set one of publish_joint_positions and "
                "publish_joint_velocities, the one that the controller takes"
            )

    @property
    def trajectory(self) -> bool:
        """Whether trajectories are published, and no arrays."""
        return self.command_out_type == TRAJECTORY

    @property
    def velocity_mode(self) -> bool:
        """Whether the robot is told rates alone."""
        return not self.publish_joint_positions

    def _require(self, name: str, *allowed: str) -> None:
        if (value := getattr(self, name)) not in allowed:
            raise InputError(f"{name} must be one of {', '.join(allowed)}; got {value!r}")


def declared(node: Node) -> Parameters:
    """The parameters as they were given to `node`, each declared with its meaning."""
    values: dict[str, Any] = {}
    for each in fields(Parameters):
        what = ParameterDescriptor(description=each.metadata["meaning"], read_only=each.name not in SWITCHES)
        default: Any = each.default
        several = isinstance(default, tuple)
        value = node.declare_parameter(each.name, list(default) if several else default, what).value
        values[each.name] = tuple(value) if several else value
    return Parameters(**values)
