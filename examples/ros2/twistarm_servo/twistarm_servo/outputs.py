"""Publishers: trajectories, or arrays for a forward_command_controller."""

from __future__ import annotations

from rclpy.node import Node
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from twistarm import Arm
from twistarm.control.stream import Setpoint

from . import messages
from .parameters import Parameters
from .quality import quality

PERIODS_AHEAD = 2
"""How far ahead of its setpoint a trajectory begins: it must not be late where a message is."""


class Outputs:
    """The sink of the stream. Joints come in the arm's order, base to tip, which the controller must have too."""

    def __init__(self, node: Node, arm: Arm, parameters: Parameters) -> None:
        self._arm, self._p = arm, parameters
        kind = JointTrajectory if parameters.trajectory else Float64MultiArray
        self._publisher = node.create_publisher(kind, parameters.command_out_topic, quality(parameters.qos_out))

    def write(self, setpoint: Setpoint) -> None:
        """Publish the setpoint."""
        self._publisher.publish(self._trajectory(setpoint) if self._p.trajectory else self._array(setpoint))

    def _array(self, setpoint: Setpoint) -> Float64MultiArray:
        values = setpoint.theta if self._p.publish_joint_positions else setpoint.theta_dot
        return Float64MultiArray(data=values.tolist())

    def _trajectory(self, setpoint: Setpoint) -> JointTrajectory:
        """Without a stamp, which means at once: one of the past would be left out, and clocks differ."""
        ahead = PERIODS_AHEAD / self._p.rate
        points = messages.trajectory_points(self._arm, setpoint, ahead)
        with_rates = self._p.publish_joint_velocities
        message = JointTrajectory(joint_names=list(self._arm.joint_names))
        message.points = [_point(each, with_rates) for each in (points if with_rates else points[:1])]
        return message


def _point(given: messages.TrajectoryPoint, with_rates: bool) -> JointTrajectoryPoint:
    point = JointTrajectoryPoint(positions=given.positions, velocities=given.velocities if with_rates else [])
    point.time_from_start.sec, point.time_from_start.nanosec = given.sec, given.nanosec
    return point
