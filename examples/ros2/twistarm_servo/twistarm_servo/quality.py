"""Quality of service by name."""

from __future__ import annotations

from rclpy.qos import QoSProfile, ReliabilityPolicy

from twistarm import InputError

RELIABILITY = {
    "best_effort": ReliabilityPolicy.BEST_EFFORT,
    "reliable": ReliabilityPolicy.RELIABLE,
    "system_default": ReliabilityPolicy.SYSTEM_DEFAULT,
}


def quality(name: str, depth: int = 1) -> QoSProfile:
    """The profile of a reliability, which keeps `depth` messages; InputError for a name that is none."""
    if name not in RELIABILITY:
        raise InputError(f"qos_in and qos_out must be one of {', '.join(RELIABILITY)}; got {name!r}")
    return QoSProfile(depth=depth, reliability=RELIABILITY[name])
