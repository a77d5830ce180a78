"""Parameters that may change while the node runs: `ros2 param set /servo_node frame base`."""

from __future__ import annotations

from collections.abc import Sequence

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from twistarm import InputError
from twistarm.control.servo import TwistCommand

from .parameters import SWITCHES

NO_TWIST = (0.0,) * 6


class Switches:
    """`frame`, "tool" or "base", and `hold`, "position", "orientation" or "": parameters, for no standard service has
    a choice of more than two.
    """

    def __init__(self, node: Node, frame: str, hold: str) -> None:
        self.frame, self.hold = frame, hold
        self.twist(NO_TWIST, frame)
        node.add_on_set_parameters_callback(self._on_set)

    def twist(self, twist: Sequence[float], frame: str, released: bool = False) -> TwistCommand:
        """The command of a twist, with what is held; `released`: without what the twist says of held components."""
        command = TwistCommand(NO_TWIST, frame, self.hold or None)
        given = [0.0 if held and released else value for value, held in zip(twist, command.held, strict=True)]
        return TwistCommand(given, frame, self.hold or None)

    def _on_set(self, parameters: list[Parameter]) -> SetParametersResult:
        wanted = {each.name: each.value for each in parameters if each.name in SWITCHES}
        frame, hold = wanted.get("frame", self.frame), wanted.get("hold", self.hold)
        try:
            TwistCommand(NO_TWIST, frame, hold or None)
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        self.frame, self.hold = frame, hold
        return SetParametersResult(successful=True)
