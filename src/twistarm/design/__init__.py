"""Questions before an arm is built: what it holds, what its joints need, and which of several designs is better."""

from .designs import Design, compare_designs
from .payload import Cubes, Needs, Payload, payload

__all__ = ["Cubes", "Design", "Needs", "Payload", "compare_designs", "payload"]
