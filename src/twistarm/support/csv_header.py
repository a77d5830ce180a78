"""The names and units in the header of a CSV file."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

FACTORS = {
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254},
    "rad": {"rad": 1.0, "radians": 1.0, "deg": np.pi / 180, "degrees": np.pi / 180, "°": np.pi / 180},
    "1": {"1": 1.0, "-": 1.0},
}
"""The size of a header's unit in the unit of the quantity [m, rad, 1]."""

UNIT = re.compile(r"(.*?)(?:\s*[\[(]\s*([^\])]*?)\s*[\])]|[_ ](m|cm|mm|rad|deg|degrees))?")
"""A column's name with or without its unit: `x`, `x [mm]`, `roll (deg)`, `elbow_deg`."""


def quantity_and_unit(cell: str, known: Mapping[str, str]) -> tuple[str | None, str]:
    """The quantity that a header's cell names, and its unit."""
    match = UNIT.fullmatch(cell)
    name, unit = (match[1], match[2] or match[3] or "") if match else (cell, "")
    for said, its_unit in ((cell, ""), (name, unit)):
        found = known.get(said) or known.get(said.casefold())
        if found is not None:
            return found, its_unit
    return None, ""
