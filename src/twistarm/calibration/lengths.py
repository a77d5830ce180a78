"""Positions in other units than metres: by their size, and by the explanation."""

from __future__ import annotations

import numpy as np

from ..support.checks import Array
from .model import Wiring

UNITS = {"millimetres": 0.001, "centimetres": 0.01, "inches": 0.0254, "kilometres": 1000.0}
"""What positions may have been logged in instead of metres, and how many metres it is."""

ALIKE = 3.0
"""Two logs of one arm differ less than by this factor in how far the tool is from the base."""

POSTURES = 200


def plausible_units(wiring: Wiring) -> list[str]:
    """The `UNITS` that put the measured positions at the arm's distances; none for metres.

    The distances come from random configurations, because the motors' readings may be wrong.
    """
    usual = _mean_distance(wiring.arm.fk(wiring.arm.random_theta(0, POSTURES))[:, :3, 3])
    measured = _mean_distance(wiring.position)
    if not usual or not measured or 1 / ALIKE < measured / usual < ALIKE:
        return []
    return [unit for unit, metres in UNITS.items() if 1 / ALIKE < metres * measured / usual < ALIKE]


def _mean_distance(position: Array) -> float:
    return float(np.sqrt((position * position).sum(axis=-1).mean()))
