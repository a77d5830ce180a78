"""A recorder of streams: what they do, as ROS 2 messages in an MCAP file."""

from __future__ import annotations

import os
import time

from ...arm.arm import Arm
from ...planning.files.mcap_file import LABELS, SETPOINTS, TEXT, Bag
from ...support.checks import require_method
from .cycles import Cycle
from .messages import setpoint_message
from .protocols import Setpoint, Sink

DIAGNOSTIC, KEYS = "diagnostic_msgs/msg/", ("status", "reason", "joint", "scale", "interlock")


class Recorder(Bag):
    """A sink that records each setpoint that it sends to `sink`. As `on_cycle` it records each joint state too.

    The file appears at the end of the block. /setpoints has JointTrajectory of one point each, /diagnostics their
    status, /joint_states and /tf the usable joint states and the poses of all links, /labels those of `follow`. Stamps
    are wall-clock time if the stream's clock is the system's. The extra `mcap` is needed.

    Args:
        arm: The arm.
        path: The file to write, named .mcap at its end.
        sink: Where setpoints go.
    """

    def __init__(self, arm: Arm, path: str | os.PathLike[str], sink: Sink) -> None:
        self._sink = require_method(sink, "sink", "write")
        super().__init__(arm, path, time.time_ns() - time.monotonic_ns(), time.monotonic())

    def __call__(self, cycle: Cycle) -> None:
        """Record the joint state and the labels of a cycle."""
        if cycle.theta is not None:
            self.add_state(cycle.time, cycle.theta)
        for label in getattr(cycle, "labels", ()):
            self.add(LABELS, cycle.time, TEXT, label)

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint, then record it."""
        try:
            self._sink.write(setpoint)
        finally:
            now, output, message = setpoint.time, setpoint.output, setpoint_message(self._arm, setpoint)
            self.add_motion(SETPOINTS, now, [(0.0, setpoint.theta, setpoint.theta_dot)])
            values = [self.of(f"{DIAGNOSTIC}KeyValue", key, str(message[key] or "")) for key in KEYS]
            level, words = int(output.status != "OK"), output.explain()
            status = self.of(f"{DIAGNOSTIC}DiagnosticStatus", level, "twistarm", words, self._arm.name, values)
            self.add("/diagnostics", now, f"{DIAGNOSTIC}DiagnosticArray", [status])
