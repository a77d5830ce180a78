"""The ROS 2 node: it connects topics and services to twistarm's stream, which computes; see README.md."""

from __future__ import annotations

import sys

import rclpy
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from twistarm import Arm, TwistarmError
from twistarm.control.servo import ServoSettings
from twistarm.control.stream import Interlock, Metronome, MonotonicClock, Streaming, StreamOptions, come_to_rest
from twistarm.support.errors import one_line
from twistarm.support.interrupts import ended_like_ctrl_c

from .description import find_arm
from .diagnostics import Diagnostics
from .inputs import Inputs
from .outputs import Outputs
from .parameters import declared
from .ros_time import now_of
from .services import Services
from .switches import Switches

NAME = "servo_node"
"""As MoveIt Servo's, so that the same topics are the same."""

EARLY = 0.25  # of a period: how much a timer may lead its grid


class ServoNode(Node):
    """Commands and joint states come in by callbacks, a timer steps the servo, setpoints go out."""

    def __init__(self) -> None:
        super().__init__(NAME)
        self.p = declared(self)
        self.failed = ""
        self.streaming: Streaming | None = None
        self.interlock = Interlock(enabled=self.p.enabled_at_start)
        Services(self, self.interlock)
        self.switches = Switches(self, self.p.frame, self.p.hold)
        find_arm(self, self.p, self.begin)

    def begin(self, arm: Arm) -> None:
        """Connect everything: the arm is known. Limits that it lacks are the stream's usual ones, and are told."""
        self.inputs = Inputs(self, arm, self.p, self.switches)
        options = StreamOptions(
            self.p.rate, self.p.feedback_timeout, self.p.tolerance, self.p.velocity_mode, self.interlock,
            command_timeout=self.p.incoming_command_timeout,
            settings=ServoSettings(position_margin=self.p.joint_limit_margin, on_unreachable=self.p.on_unreachable),
        )  # fmt: skip
        self.streaming = Streaming(arm, self.inputs.commands, Outputs(self, arm, self.p), self.inputs.states, options)
        if self.streaming.assumed:
            self.get_logger().warning(self.streaming.assumed)
        self.diagnostics = Diagnostics(self, arm, self.p, self.streaming, self.switches)
        self.metronome = Metronome(self.streaming.period, EARLY)
        self.create_timer(self.streaming.period, self.on_timer)
        self.get_logger().info(f"driving {arm.name}: {', '.join(arm.joint_names)}, {arm.base} to {arm.tip}")

    def on_timer(self) -> None:
        """One cycle, where one is due."""
        now, due = now_of(self), self.metronome.next
        periods = self.metronome.tick(now)
        if self.streaming is None or self.failed or periods == 0:
            return
        if due > 0.0:
            self.streaming.tally.begin(now - due)
        cycle = self.streaming.cycle(now, periods)
        self.diagnostics.follow(cycle)
        if cycle.ending is not None:
            self.failed = f"{cycle.ending.value}: {cycle.reason}"

    def stop(self) -> None:
        """Bring the arm to rest, then rates of 0; on the system's clock, for a simulation's may stand still."""
        if self.streaming is None:
            return
        clock, metronome = MonotonicClock(), Metronome(self.streaming.period)
        metronome.tick(clock.now())  # the first step is a period from here: nobody knows how long ago the last one was
        self.streaming.change_clock(clock.now())
        come_to_rest(self.streaming, metronome, clock)


def drive() -> int:
    """Run a node until Ctrl-C or until its stream fails, which is 1; the arm is at rest behind it."""
    node: ServoNode | None = None
    try:
        node = ServoNode()
        while rclpy.ok() and not node.failed:
            rclpy.spin_once(node, timeout_sec=0.1)
    except KeyboardInterrupt:
        pass
    finally:
        if node is not None:
            node.stop()
            node.destroy_node()
    return 1 if node is not None and node.failed else 0


def main() -> int:
    """The program: SIGTERM and SIGHUP end it as Ctrl-C does."""
    # Without ROS's own handlers the publishers live until the arm is at rest.
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    try:
        with ended_like_ctrl_c():
            return drive()
    except (TwistarmError, ParameterException, NameValidationException) as error:
        sys.exit(one_line(str(error)))
    finally:
        rclpy.shutdown()


if __name__ == "__main__":
    sys.exit(main())
