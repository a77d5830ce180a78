"""The node's services: enable, stop, emergency stop and clear; and pause_servo, as MoveIt Servo has it."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from twistarm.control.stream import Interlock


class Services:
    """Services of std_srvs around an interlock: whoever has ROS can call them."""

    def __init__(self, node: Node, interlock: Interlock) -> None:
        self._node, self._interlock = node, interlock
        acts: dict[str, Callable[[], object]] = {
            "~/enable": interlock.enable,
            "~/stop": interlock.stop,
            "~/emergency_stop": lambda: interlock.emergency_stop("the service emergency_stop was called"),
            "~/clear": interlock.clear,
        }
        for name, act in acts.items():
            node.create_service(Trigger, name, self._answering(name, act))
        node.create_service(SetBool, "~/pause_servo", self._on_pause)

    def _answering(
        self, name: str, act: Callable[[], object]
    ) -> Callable[[Trigger.Request, Trigger.Response], Trigger.Response]:
        def on_call(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
            response.success, response.message = self._done(act, moving=name == "~/enable")
            return response

        return on_call

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        act = self._interlock.stop if request.data else self._interlock.enable
        response.success, response.message = self._done(act, moving=not request.data)
        return response

    def _done(self, act: Callable[[], object], moving: bool) -> tuple[bool, str]:
        """Do it; whether it has the effect that was wanted, and how the interlock stands now."""
        act()
        barrier = self._interlock.barrier
        text = barrier or self._interlock.word
        self._node.get_logger().info(text)
        return not (moving and barrier), text
