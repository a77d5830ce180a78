"""The client of the tests of ROS 2: a node, a simulated arm, and a stick that says twists."""

import time

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from rclpy.duration import Duration
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

SOON, LATEST = 10.0, 30.0  # Seconds to wait for what happens in a moment, and for a process to begin.


class Client:
    """The node of a test, and a simulated arm that goes where the setpoints say."""

    def __init__(self, arm):
        self.arm, self.node = arm, rclpy.create_node("client")
        self.statuses: list = []
        self.ahead = 0.0  # Of the simulation's clock [s].
        clock = self.node.create_publisher(Clock, "/clock", 1)
        self.node.create_timer(0.01, lambda: clock.publish(Clock(clock=self.stamp())))
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, 10)

    def _on_diagnostics(self, message):
        self.statuses.append(message.status[0])

    def stamp(self, ahead=0.0):
        """The simulation's time, which is the system's before it jumps."""
        ahead = Duration(nanoseconds=round((self.ahead + ahead) * 1e9))
        return (self.node.get_clock().now() + ahead).to_msg()

    def until(self, done, seconds=SOON):
        """Spin until it is so."""
        end = time.monotonic() + seconds
        while not done():
            assert time.monotonic() < end, f"not within {seconds:g} s; the last status: {self.status}"
            rclpy.spin_once(self.node, timeout_sec=0.01)

    def during(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self.node, timeout_sec=0.01)

    @property
    def status(self):
        """Level, message and values of the last diagnosis."""
        if not self.statuses:
            return None, "", {}
        last = self.statuses[-1]
        return last.level, last.message, {entry.key: entry.value for entry in last.values}

    def call(self, kind, name, **request):
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(SOON), name
        answer = client.call_async(kind.Request(**request))
        rclpy.spin_until_future_complete(self.node, answer, timeout_sec=SOON)
        self.node.destroy_client(client)
        return answer.result()


class Robot:
    """Joints at 100 Hz that follow `topic` at once, unless they stand; and what they were told.

    Wheels on the same topic have another clock, fail, and tell of themselves twice.
    """

    def __init__(self, client, topic="/servo_node/commands", states="/joint_states"):
        self.client, self.theta = client, client.arm.ready.tolist()
        self.told: list = []
        self.mute = self.stands = False
        self.publisher = client.node.create_publisher(JointState, states, 10)
        client.node.create_subscription(JointTrajectory, topic, self._on_setpoint, 10)
        client.node.create_timer(0.01, self._tell)

    def _on_setpoint(self, message):
        self.told.append(message)
        if not self.stands:
            self.theta = list(message.points[0].positions)

    def _tell(self):
        if not self.mute:
            message = JointState(name=list(self.client.arm.joint_names), position=self.theta)
            message.header.stamp = self.client.stamp()
            self.publisher.publish(message)
            wheels = JointState(name=["wheel", "wheel"], position=[float("nan")])
            wheels.header.stamp.sec = 2**31 - 1
            self.publisher.publish(wheels)

    @property
    def moves(self):
        """Whether the last setpoint has a rate."""
        return bool(self.told) and any(self.told[-1].points[0].velocities)


class Stick:
    """A publisher of twists at 50 Hz while `twist` (linear, frame) is one."""

    def __init__(self, client, topic="/servo_node/delta_twist_cmds"):
        self.client, self.linear, self.frame, self.ahead = client, None, client.arm.base, 0.0
        self.publisher = client.node.create_publisher(TwistStamped, topic, 10)
        client.node.create_timer(0.02, self._say)

    def _say(self):
        if self.linear is not None:
            message = TwistStamped()
            message.header.frame_id, message.header.stamp = self.frame, self.client.stamp(self.ahead)
            message.twist.linear.x, message.twist.linear.y, message.twist.linear.z = self.linear
            self.publisher.publish(message)
