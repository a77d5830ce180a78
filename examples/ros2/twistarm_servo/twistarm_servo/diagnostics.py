"""The servo's status on /diagnostics: once a second, and at once when it changes."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from twistarm import Arm
from twistarm.control.stream import Cycle, Streaming

from . import messages
from .inputs import TELL_EVERY
from .parameters import Parameters
from .switches import Switches


class Diagnostics:
    """Tells status, reason and scale of the last cycle, and how timely the cycles are."""

    def __init__(self, node: Node, arm: Arm, parameters: Parameters, streaming: Streaming, switches: Switches) -> None:
        self._node, self._arm, self._streaming, self._switches = node, arm, streaming, switches
        self._publisher = node.create_publisher(DiagnosticArray, parameters.diagnostics_topic, 1)
        self._last: Cycle | None = None
        self._told: object = None
        node.create_timer(1.0, self.tell)

    def follow(self, cycle: Cycle) -> None:
        """Note a cycle; a change of status is told at once, and why the arm does not do as commanded is logged."""
        self._last = cycle
        if (status := messages.status_of(cycle)) != self._told:
            self._told = status
            self.tell()
        if cycle.ending is not None:
            self._node.get_logger().fatal(f"{cycle.ending.value}: {cycle.reason}")
        elif cycle.reason and (cycle.reading is None or not cycle.reading.idle):
            self._node.get_logger().warning(cycle.reason, throttle_duration_sec=TELL_EVERY)

    def tell(self) -> None:
        """Publish the last cycle's status."""
        if self._last is None:
            return
        level, text, values = messages.diagnosis_of(self._last, self._streaming.tally)
        values |= {"frame": self._switches.frame, "hold": self._switches.hold}
        status = DiagnosticStatus(
            level=level, name=f"{self._node.get_name()}: servo", message=text, hardware_id=self._arm.name
        )
        status.values = [KeyValue(key=key, value=value) for key, value in values.items()]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
