"""Collisions of an arm with itself, with its robot and with obstacles."""

from .scene import Collision, Contact, Distance, Scene, require_scene

__all__ = ["Collision", "Contact", "Distance", "Scene", "require_scene"]
