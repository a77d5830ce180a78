"""Subscriptions: twists, jogs, poses and a joystick's messages for the inbox, joint states for the servo."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from rclpy.node import Node
from sensor_msgs.msg import JointState, Joy

from twistarm import Arm, InputError
from twistarm.control.servo import AnyCommand, JogCommand
from twistarm.control.stream import Inbox, StateInbox

from . import messages
from .joystick import JoyMapping, Joystick
from .parameters import Parameters
from .quality import quality
from .ros_time import now_of, said_at
from .switches import Switches

try:
    from control_msgs.msg import JointJog
except ImportError:  # as with the ROS 2 of the Python package registry
    JointJog = None

SEVERAL = 100
"""Joint states that wait at most: of commands the last one counts, of these everybody's."""

TELL_EVERY = 2.0
"""Seconds between two lines of the log about what was refused."""


class Inputs:
    """The subscriptions of a node; `commands` and `states` are what the stream reads.

    A topic is a sender: two topics at once, or two publishers of one, move nothing. What is refused stops the arm, and
    is told.
    """

    def __init__(self, node: Node, arm: Arm, parameters: Parameters, switches: Switches) -> None:
        self._node, self._arm, self._p, self._switches = node, arm, parameters, switches
        self.commands = Inbox(parameters.incoming_command_timeout)
        self.states = StateInbox(arm, parameters.feedback_timeout)
        p = parameters
        mapping = JoyMapping(p.joy_axes, p.joy_rest, p.joy_scale, p.joy_deadband, p.joy_dead_man)
        self._joystick = Joystick(mapping, p.incoming_command_timeout)
        self._driving = False
        heard: list[tuple[Any, str, Callable[[Any], None]]] = [
            (TwistStamped if p.stamped else Twist, p.cartesian_command_in_topic, self._on_twist),
            (PoseStamped, p.pose_command_in_topic, self._on_pose),
            (JointState, p.joint_topic, self._on_state),
        ]
        if JointJog is not None:
            heard.append((JointJog, p.joint_command_in_topic, self._on_jog))
        if mapping.used:
            heard.append((Joy, p.joy_topic, self._on_joy))
        for kind, topic, callback in heard:
            depth = SEVERAL if kind is JointState else 1
            node.create_subscription(kind, topic, callback, quality(p.qos_in, depth))

    def _on_twist(self, message: Any) -> None:
        self._take(self._p.cartesian_command_in_topic, message, lambda: self._twist(message))

    def _on_jog(self, message: Any) -> None:
        self._take(self._p.joint_command_in_topic, message, lambda: self._jog(message))

    def _on_pose(self, message: Any) -> None:
        self._take(self._p.pose_command_in_topic, message, lambda: messages.pose_of(self._arm, message))

    def _on_joy(self, message: Any) -> None:
        """Nobody holds the button: not a word to the inbox, but the first time, which stops the arm."""
        now, topic = now_of(self._node), self._p.joy_topic
        try:
            time = said_at(message.header.stamp, now, self._p.incoming_command_timeout)
            twist = self._joystick.twist(message, now)
            if twist is not None:
                self._require_one_publisher(topic)
                self.commands.put(topic, self._switches.twist(twist, self._switches.frame, released=True), time)
            elif self._driving:
                self.commands.put(topic, JogCommand([0.0] * self._arm.n), now)
            self._driving = twist is not None
        except InputError as error:
            self._driving = False
            self._refuse(self.commands, topic, error, now)

    def _on_state(self, message: Any) -> None:
        now, topic = now_of(self._node), self._p.joint_topic
        try:
            positions = messages.positions_of(self._arm, message)
            # The clock of wheels or of a gripper, which others publish, is their affair.
            ours = not positions.keys().isdisjoint(self._arm.joint_names)
            time = said_at(message.header.stamp, now, self._p.feedback_timeout) if ours else now
            self.states.put(topic, positions, time, messages.number_of(message.header.stamp))
        except InputError as error:
            self._refuse(self.states, topic, error, now)

    def _take(self, topic: str, message: Any, build: Callable[[], AnyCommand]) -> None:
        now = now_of(self._node)
        try:
            self._require_one_publisher(topic)
            if isinstance(message, Twist):
                self.commands.put(topic, build(), now)
                return
            stamp = message.header.stamp
            time = said_at(stamp, now, self._p.incoming_command_timeout)
            self.commands.put(topic, build(), time, messages.number_of(stamp))
        except InputError as error:
            self._refuse(self.commands, topic, error, now)

    def _twist(self, message: Any) -> AnyCommand:
        frame, twist = self._switches.frame, message
        if not isinstance(message, Twist):
            frame, twist = messages.frame_of(self._arm, message.header.frame_id, frame), message.twist
        six = messages.twist_of(twist)
        if self._unitless(six):
            scales = [self._p.scale_linear] * 3 + [self._p.scale_rotational] * 3
            six = [value * scale for value, scale in zip(six, scales, strict=True)]
        return self._switches.twist(six, frame)

    def _jog(self, message: Any) -> AnyCommand:
        return messages.jog_of(self._arm, message, self._p.scale_joint if self._unitless(message.velocities) else 1.0)

    def _unitless(self, values: Sequence[float]) -> bool:
        """Whether commands are shares of a speed; InputError where one is more than all of it."""
        unitless = self._p.command_in_type == "unitless"
        if unitless and not all(abs(value) <= 1.0 for value in values):
            raise InputError(f"a unitless command has numbers from -1 to 1; got {list(values)}")
        return unitless

    def _require_one_publisher(self, topic: str) -> None:
        if (count := self._node.count_publishers(self._node.resolve_topic_name(topic))) > 1:
            raise InputError(f"{count} publishers command on {topic}; stop all but one")

    def _refuse(self, inbox: Inbox | StateInbox, topic: str, error: InputError, now: float) -> None:
        inbox.refuse(topic, str(error), now)
        self._node.get_logger().warning(f"{topic} refused: {error}", throttle_duration_sec=TELL_EVERY)
