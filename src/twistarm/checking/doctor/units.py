"""Units that lengths are likely in where they cannot be metres."""

from __future__ import annotations

import numpy as np

from ...description.tree import Description

UNITS = {"inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001}
"""[m], the largest first: what lengths are exported in."""

USUAL = ("millimetres", "inches", "centimetres")
"""The most usual first."""

LONGEST_REACH = 20.0
"""[m]; in millimetres every arm is longer, in inches most."""

ARMS = (0.15, 3.2)
"""[m]: reaches of most arms."""

SMALLEST_SUSPECT = 4.0
"""[m]: longer arms are rare; of them one whose lengths are round in inches alone is in inches."""

ROUND = 5e-3
"""[mm], or parts of 1/16 inch: what a length may be off a whole number."""


def likely_units(description: Description, reach: float) -> list[str]:
    """The likely units of an arm's lengths, likeliest first; none if they may be metres.

    They give a usual reach; the unit with most round numbers comes first.
    """
    lengths = np.abs([x for joint in description.joints.values() for x in joint.origin[:3, 3] if x])
    rounds = {unit: _rounds(lengths, unit) for unit in USUAL}
    odd = reach > SMALLEST_SUSPECT and rounds["inches"] > max(2, len(lengths) / 2) and not _rounds(lengths, "metres")
    if not (reach > LONGEST_REACH or odd):
        return []
    fitting = [unit for unit in USUAL if ARMS[0] <= reach * UNITS[unit] <= ARMS[1]]
    fitting = fitting or (["inches"] if odd else ["millimetres"])
    return sorted(fitting, key=lambda unit: -rounds[unit])


def _rounds(lengths: np.ndarray, unit: str) -> int:
    """How many are whole millimetres, or whole sixteenths of an inch, in that unit."""
    whole = [lengths * UNITS.get(unit, 1.0) * 1e3] + ([lengths * 16.0] if unit == "inches" else [])
    return max(int((np.abs(x - np.round(x)) <= ROUND).sum()) for x in whole)
