"""Motions in time: planned inside the joint limits, evaluated at any instant, exported."""

from .joint_space import plan_joint
from .trajectory import Samples, Trajectory

__all__ = ["Samples", "Trajectory", "plan_joint"]
