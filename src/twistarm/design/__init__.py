"""Questions before an arm is built: what it reaches and holds, what its joints need, which design is better."""

from .chunks import Arrays, Sweep
from .designs import Design, compare_designs
from .mapping import reach_map
from .panel import Panel, PanelTask, load_panel
from .parking import PanelReport, TaskResult, best_parking, check_panel
from .payload import Needs, Payload, payload
from .sweeps import DesignTable, sweep
from .voxel_map import ReachMap

__all__ = [
    "Arrays", "Design", "DesignTable", "Needs", "Panel", "PanelReport", "PanelTask", "Payload", "ReachMap", "Sweep",
    "TaskResult", "best_parking", "check_panel", "compare_designs", "load_panel", "payload", "reach_map", "sweep",
]  # fmt: skip
