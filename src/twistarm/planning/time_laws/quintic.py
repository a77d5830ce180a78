"""The quintic time law: s = L (10 u³ − 15 u⁴ + 6 u⁵)."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ..joint_path import JointPath
from ..piecewise import bisected, shifted
from .bounds import PathBounds
from .law import TimeLaw

UNIT = np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])
"""Coefficients of the fraction travelled in the fraction u of the time, highest power first."""

BISECTIONS = 60


def quintic(path: JointPath, bounds: PathBounds) -> TimeLaw:
    """s = L (10 u³ − 15 u⁴ + 6 u⁵), u = t/T, with the least T that keeps every limit.

    Velocity and acceleration are zero at both ends. The jerk is limited where a jerk limit was given. A path that
    stays where it is takes no time. Source: Lynch & Park, Modern Robotics, §9.2.2.1.
    """
    if not path.moves:
        return TimeLaw.at_once()
    u = _reached(path.breakpoints / path.length)
    pieces = np.repeat(path.length * UNIT[:, None], len(u) - 1, axis=1)
    law = TimeLaw(u, shifted(pieces, u[:-1]))
    return law.at_full_pace(path, bounds, bounds.rates.jerk)


def _reached(fraction: Array) -> Array:
    """The u (m + 1,) at which these fractions of the way have been travelled."""
    ends = np.zeros_like(fraction), np.ones_like(fraction)
    _, high = bisected(lambda u: np.polyval(UNIT, u) < fraction, *ends, BISECTIONS)
    high[0], high[-1] = 0.0, 1.0
    return high
