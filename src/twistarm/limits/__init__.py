"""Limits of joints and motors, and the motions that can still stop inside them."""

from .actuators import Actuators
from .joint_limits import JointLimits
from .motion_limits import MotionLimits

__all__ = ["Actuators", "JointLimits", "MotionLimits"]
