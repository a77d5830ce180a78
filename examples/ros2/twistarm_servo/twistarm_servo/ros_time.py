"""Time as the node's clock has it: the system's, or the simulation's with use_sim_time."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from twistarm import InputError

from .messages import NANOSECONDS, number_of


def now_of(node: Node) -> float:
    """Seconds of the node's clock."""
    nanoseconds: int = node.get_clock().now().nanoseconds
    return nanoseconds / NANOSECONDS


def said_at(stamp: Any, now: float, timeout: float) -> float:
    """When a message was said [s]: its stamp, or `now`, when it came, where it has none or one a little ahead.

    InputError for a stamp that is ahead by more than `timeout` [s].
    """
    number = number_of(stamp)
    if number is None:
        return now
    ahead = number / NANOSECONDS - now
    if ahead > timeout:
        raise InputError(
            f"it is stamped {ahead:.3g} s in the future: its sender has another clock (use_sim_time on one side "
            f"only?), or time went back"
        )
    return now + min(ahead, 0.0)
