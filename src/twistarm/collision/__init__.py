"""Collisions of an arm with itself, with its robot and with obstacles."""

from .answers import Collision, Contact, Distance
from .scene import Scene, require_scene

__all__ = ["Collision", "Contact", "Distance", "Scene", "require_scene"]
