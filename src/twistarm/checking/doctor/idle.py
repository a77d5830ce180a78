"""Joints that do not move the tool: off the chain, or on it without effect."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...description.tree import Description
from ...support.caller_words import argument
from .abilities import Abilities
from .wording import grouped, place_of

NO_MOTION = 1e-9
"""A column of the Jacobian this small [m/reach, rad] is zero but for rounding."""


def check_off_the_chain(arm: Arm, description: Description) -> Iterator[Finding]:
    """Independent joints that no coordinate of the arm moves: fingers, wheels, a second arm."""
    moved = {name for name, affine in arm.couplings.items() if affine.master in arm.joint_names}
    idle = [
        joint
        for joint in description.joints.values()
        if joint.moving and joint.name not in moved and joint.name not in arm.moving_names and joint.mimic is None
    ]
    if idle:
        yield grouped(
            "joint-off-the-chain",
            description,
            idle,
            f"{'they are' if len(idle) > 1 else 'it is'} not between {arm.base} and {arm.tip_link} and "
            f"{'do' if len(idle) > 1 else 'does'} not move the tool",
            f"nothing, if that is meant; else pass {argument('tip')}",
        )


def check_without_effect(arm: Arm, able: Abilities) -> Iterator[Finding]:
    """Coordinates with a zero column of the Jacobian everywhere."""
    sizes = np.abs(able.body).max(axis=(0, 1))
    for name, size in zip(arm.joint_names, sizes, strict=True):
        if size <= NO_MOTION:
            yield finding(
                "joint-without-effect",
                place_of(arm.description, arm.name),
                f"joint {name!r} does not move the tool at any configuration: what it turns is turned back",
                "look at the mimics behind it, or lock it",
            )
