"""Limits of joints and motors, and the motions that can still stop inside them."""

from .actuators import Actuators, MotionLimits
from .joint_limits import JointLimits

__all__ = ["Actuators", "JointLimits", "MotionLimits"]
