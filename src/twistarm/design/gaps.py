"""What a description does not tell about the efforts of an arm: masses, effort limits, motors."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..checking.doctor.inertia import check_inertias
from ..support.errors import listed

TOLD = ("inertial-unusable", "mass-missing", "mass-implausible", "inertia-placeholder", "centre-of-mass-far")
"""Findings that make torques wrong."""


def gaps(arm: Arm, unlimited: NDArray[np.bool_]) -> Iterator[str]:
    """A sentence for each gap. `unlimited` (n,) marks joints without an effort limit."""
    if not arm.pinocchio.moved_mass:
        yield "no link that moves has a mass: the arm's own weight counts as 0, and a real arm holds less"
    if arm.description is not None:
        found = (*arm.findings, *check_inertias(arm.description))
        yield from (f"{one.place}: {one.what}" for one in found if one.code in TOLD)
    if unlimited.any():
        lacking = listed(name for name, lacks in zip(arm.joint_names, unlimited, strict=True) if lacks)
        so = "the payload is unknown" if unlimited.all() else "what they hold is unknown, and the payload a bound"
        yield f"no effort limit of {lacking}: {so}; write effort in <limit>, or in [limits] of an arm.toml"
    turning = arm.limits.effort[np.array(arm.units) == "rad"]
    if len(turning) > 2 and np.isfinite(turning[0]) and (turning == turning[0]).all():
        yield f"all turning joints have the effort limit {turning[0]:g} N m: a placeholder?"
    if arm.actuators is not None and arm.actuators.undriven:
        yield f"the motors do not determine {listed(arm.actuators.undriven)}: limits of motors do not count"
