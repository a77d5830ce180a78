"""Questions before an arm is built: what it holds, what its joints need, which design is better, what it does."""

from .designs import Design, compare_designs
from .panel import Panel, PanelTask, load_panel
from .parking import PanelReport, TaskResult, best_parking, check_panel
from .payload import Needs, Payload, payload

__all__ = [
    "Design", "Needs", "Panel", "PanelReport", "PanelTask", "Payload", "TaskResult", "best_parking",
    "check_panel", "compare_designs", "load_panel", "payload",
]  # fmt: skip
