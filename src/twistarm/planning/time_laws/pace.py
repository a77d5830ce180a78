"""A law, slowed down or sped up as a whole, that just meets its limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...support.checks import Array
from ..bernstein import largest
from ..joint_path import JointPath
from ..piecewise import derivative, rescaled
from ..spans import MARGIN, require_span
from ..within import slowed_by
from .bounds import PathBounds
from .law import TimeLaw


def at_full_pace(path: JointPath, law: TimeLaw, bounds: PathBounds, jerk: Array) -> TimeLaw:
    """The law slowed until one rate just meets its limit. `jerk` (r,) is the limit of the jerk.

    A law slowed by f has 1/f of the velocity, 1/f² of the acceleration and 1/f³ of the jerk.
    """
    breakpoints, coefficients = law.along(path)
    steps = np.diff(breakpoints)
    speed = derivative(law.coefficients[:, :, None]) / bounds.ceiling_of(path)[law.pieces(path)][:, None]
    rates = slowed_by(coefficients @ bounds.C.T, steps, replace(bounds.rates, jerk=jerk))
    factor = max(rates, largest(speed, steps)) * (1.0 + MARGIN)
    require_span(law.duration * factor)
    return TimeLaw(law.breakpoints * factor, rescaled(law.coefficients, 1.0 / factor))
