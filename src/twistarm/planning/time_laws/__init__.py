"""Time laws: s(t) along a path in joint space, as fast as limits allow."""

from .bounds import PathBounds
from .double_s import double_s, double_s_durations
from .law import TimeLaw, quintic
from .s_curve import s_curve
from .time_optimal import line_durations, time_optimal

__all__ = [
    "PathBounds",
    "TimeLaw",
    "double_s",
    "double_s_durations",
    "line_durations",
    "quintic",
    "s_curve",
    "time_optimal",
]
