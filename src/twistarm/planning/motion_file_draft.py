"""A first motion.toml for an arm: a valid motion, with comments to fill in."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..arm.arm import Arm
from ..description.companions.toml_entries import toml_key
from ..support.code_text import filled

STEP = {"rad": 0.2, "m": 0.05}
"""How far the first joint that can moves away from the ready pose."""


def draft_motion_file(arm: Arm) -> str:
    """Return the text of a motion.toml for this arm, with every kind of segment."""
    x, y, z = np.round(arm.fk(arm.ready)[:3, 3], 3).tolist()
    joint, value = _first_move(arm)
    template = Path(__file__).parent / "files" / "motion.toml.in"
    return filled(template, arm=arm.name, joint=toml_key(joint), value=value, x=x, y=y, z=z)


def _first_move(arm: Arm) -> tuple[str, float]:
    """Return the first joint with room around the ready pose, and a value for it."""
    for j, (name, unit) in enumerate(zip(arm.joint_names, arm.units, strict=True)):
        for step in (STEP[unit], -STEP[unit]):
            value = float(np.round(arm.ready[j] + step, 3))
            if arm.limits.lower[j] <= value <= arm.limits.upper[j]:
                return name, value
    return arm.joint_names[0], float(arm.ready[0])
