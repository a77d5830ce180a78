"""A ROS 2 node that drives an arm by twists or a joystick through twistarm's servo.

    source /opt/ros/jazzy/setup.bash          # Humble or later
    python -m venv --system-site-packages servo && servo/bin/pip install twistarm
    servo/bin/python servo_node.py --ros-args -p arm:=/path/to/arm.toml -p output:=velocity \
        -p velocity_topic:=/forward_velocity_controller/commands

In:   twist_topic    geometry_msgs/TwistStamped, or Twist with stamped:=false. header.frame_id is the arm's base or tip;
                     empty, as teleop_twist_joy and teleop_twist_keyboard send it, and in a Twist it is what the
                     parameter `frame` says, "tool" or "base"
      joy_topic      sensor_msgs/Joy, moves the arm in `frame` while button `joy_dead_man` is held
      state_topic    sensor_msgs/JointState, by name, in any order
Out:  velocity_topic      std_msgs/Float64MultiArray, rates base to tip, with output:=velocity
      trajectory_topic    trajectory_msgs/JointTrajectory, one point ahead, with output:=trajectory
      diagnostics_topic   diagnostic_msgs/DiagnosticArray, once a second, and at once when the status changes

A command holds for command_timeout seconds; joint states older than feedback_timeout stop the arm; a topic of commands
with two publishers moves nothing. Ctrl-C brakes the arm along its limits before the node goes. Whatever computes is
twistarm's: this file only connects topics to it.
"""

from __future__ import annotations

import sys

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from twistarm import InputError, TwistarmError, load_arm
from twistarm.servo import TwistCommand
from twistarm.stream import Inbox, Metronome, MonotonicClock, StateInbox, Streaming, come_to_rest, ros

PARAMETERS = {
    "arm": "rover_arm",
    "rate": 100.0,
    "frame": "tool",
    "stamped": True,
    "output": "velocity",
    "command_timeout": 0.2,
    "feedback_timeout": 0.2,
    "tolerance": 0.2,
    "twist_topic": "~/twist",
    "joy_topic": "joy",
    "state_topic": "joint_states",
    "velocity_topic": "~/commands",
    "trajectory_topic": "~/joint_trajectory",
    "diagnostics_topic": "/diagnostics",
    "joy_axes": [1, 0, 4, -1, -1, 3],
    "joy_scale": [0.1, 0.1, 0.1, 0.5, 0.5, 0.5],
    "joy_deadband": 0.1,
    "joy_dead_man": 4,
}

OUTPUTS = ("velocity", "trajectory")

EARLY = 0.25  # of a period: how much a timer may lead its grid


class ServoNode(Node):
    """Commands and joint states come in by callbacks, a timer steps the servo, setpoints go out."""

    def __init__(self) -> None:
        super().__init__("twistarm_servo")
        self.p = {name: self.declare_parameter(name, default).value for name, default in PARAMETERS.items()}
        if self.p["output"] not in OUTPUTS:
            raise InputError(f"output must be one of {', '.join(OUTPUTS)}; got {self.p['output']!r}")
        self.arm = load_arm(self.p["arm"])
        self.clock = MonotonicClock()
        self.inbox = Inbox(self.p["command_timeout"])
        self.states = StateInbox(self.p["feedback_timeout"])
        self.streaming = Streaming(
            self.arm, self.inbox, self, self.states, rate=self.p["rate"], command_timeout=self.p["command_timeout"],
            feedback_timeout=self.p["feedback_timeout"], tolerance=self.p["tolerance"],
            velocity_mode=self.p["output"] == "velocity",
        )  # fmt: skip
        self.metronome = Metronome(self.streaming.period, EARLY)
        self.joystick = ros.JoyMapping(
            list(self.p["joy_axes"]), list(self.p["joy_scale"]), self.p["joy_dead_man"], self.p["frame"],
            self.p["joy_deadband"],
        )  # fmt: skip
        self.held = False
        self.ending = None
        self.last = self.told = None
        self._connect()

    def _connect(self) -> None:
        p = self.p
        self.create_subscription(TwistStamped if p["stamped"] else Twist, p["twist_topic"], self.on_twist, 1)
        self.create_subscription(Joy, p["joy_topic"], self.on_joy, 1)
        self.create_subscription(JointState, p["state_topic"], self.on_state, 1)
        if p["output"] == "velocity":
            self.publisher = self.create_publisher(Float64MultiArray, p["velocity_topic"], 1)
        else:
            self.publisher = self.create_publisher(JointTrajectory, p["trajectory_topic"], 1)
        self.diagnostics = self.create_publisher(DiagnosticArray, p["diagnostics_topic"], 1)
        self.create_timer(self.streaming.period, self.on_timer)
        self.create_timer(1.0, self.diagnose)

    # -- in ------------------------------------------------------------------------------------------------------

    def on_twist(self, message) -> None:
        now, topic = self.clock.now(), self.p["twist_topic"]
        try:
            self._require_one_publisher(topic)
            if self.p["stamped"]:
                frame = ros.frame_of(self.arm, message.header.frame_id, self.p["frame"])
                number = ros.number_of(message.header.stamp)
                self.inbox.put(topic, ros.twist_of(self.arm, message.twist, frame), now, number)
            else:
                self.inbox.put(topic, ros.twist_of(self.arm, message, self.p["frame"]), now)
        except InputError as error:
            self.inbox.refuse(topic, str(error), now)

    def on_joy(self, message) -> None:
        """Nobody holds the button: not a word to the inbox, but the first time, which stops the arm."""
        now, topic = self.clock.now(), self.p["joy_topic"]
        try:
            self._require_one_publisher(topic)
            command = self.joystick.command(message)
        except InputError as error:
            self.inbox.refuse(topic, str(error), now)
            return
        if command is not None or self.held:
            self.inbox.put(topic, command or TwistCommand([0.0] * 6), now)
        self.held = command is not None

    def on_state(self, message) -> None:
        now, topic = self.clock.now(), self.p["state_topic"]
        try:
            self.states.put(topic, ros.theta_of(self.arm, message), now, ros.number_of(message.header.stamp))
        except InputError as error:
            self.states.refuse(topic, str(error), now)

    def _require_one_publisher(self, topic: str) -> None:
        if (count := self.count_publishers(self.resolve_topic_name(topic))) > 1:
            raise InputError(f"{count} publishers command on {topic}; stop all but one")

    # -- out -----------------------------------------------------------------------------------------------------

    def write(self, setpoint) -> None:
        """The sink of the stream."""
        if self.p["output"] == "velocity":
            self.publisher.publish(Float64MultiArray(data=setpoint.theta_dot.tolist()))
        else:
            self.publisher.publish(self._trajectory(ros.trajectory_point(setpoint, 2 * self.streaming.period)))

    def _trajectory(self, point: ros.TrajectoryPoint) -> JointTrajectory:
        message, out = JointTrajectory(), JointTrajectoryPoint()
        out.positions = point.positions
        out.time_from_start.sec, out.time_from_start.nanosec = point.sec, point.nanosec
        message.joint_names, message.points = list(self.arm.joint_names), [out]
        return message

    def diagnose(self) -> None:
        if self.last is None:
            return
        level, text, values = ros.diagnosis_of(self.last, self.streaming.tally)
        status = DiagnosticStatus(level=level, name="twistarm: servo", message=text, hardware_id=self.arm.name)
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self.diagnostics.publish(message)

    # -- the loop ------------------------------------------------------------------------------------------------

    def on_timer(self) -> None:
        now, due = self.clock.now(), self.metronome.next
        periods = self.metronome.tick(now)
        if self.ending is not None or periods == 0:
            return
        if due > 0.0:
            self.streaming.tally.lateness.add(now - due)
        self.last = self.streaming.cycle(now, periods)
        if self.last.ending is not None:
            self.ending = self.last.ending
            self.get_logger().fatal(f"{self.ending.value}: {self.last.reason}")
        if (status := ros.status_of(self.last)) != self.told:
            self.told = status
            self.diagnose()

    def stop(self) -> None:
        """Bring the arm to rest, then rates of 0."""
        come_to_rest(self.streaming, self.metronome, self.clock)


def main() -> int:
    # Without ROS's own handler, Ctrl-C leaves the publishers alive until the arm is at rest.
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = ServoNode()
    except TwistarmError as error:
        rclpy.shutdown()
        sys.exit(str(error))
    try:
        while rclpy.ok() and node.ending is None:
            rclpy.spin_once(node, timeout_sec=0.1)
    except KeyboardInterrupt:
        pass
    finally:
        node.stop()
        node.destroy_node()
        rclpy.shutdown()
    return 0 if node.ending is None else 1


if __name__ == "__main__":
    sys.exit(main())
