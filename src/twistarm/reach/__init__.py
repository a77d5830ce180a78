"""What an arm reaches, and where to put its base."""

from .mapping import reach_map
from .reach_map import ReachMap

__all__ = ["ReachMap", "reach_map"]
