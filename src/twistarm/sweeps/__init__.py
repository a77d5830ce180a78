"""Sweeps on any executor: maps of an arm's reach, and measures of many designs."""

from .chunks import Arrays, Sweep
from .designs import DesignTable, sweep
from .mapping import reach_map
from .voxel_map import ReachMap

__all__ = ["Arrays", "DesignTable", "ReachMap", "Sweep", "reach_map", "sweep"]
