"""Time laws: s(t) along a path in joint space, as fast as limits allow."""

from .bounds import PathBounds
from .double_s import double_s
from .law import TimeLaw
from .quintic import quintic
from .s_curve import s_curve
from .time_optimal import time_optimal

__all__ = ["PathBounds", "TimeLaw", "double_s", "quintic", "s_curve", "time_optimal"]
