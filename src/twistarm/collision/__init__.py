"""Collisions of an arm with itself, with its robot and with obstacles."""

from .scene import Contact, Distance, Scene

__all__ = ["Contact", "Distance", "Scene"]
