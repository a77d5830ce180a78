"""The tool frame beyond the last joint, and joints that do not move the tool: off the chain, or without effect."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...description.tips.link_names import tool_rank
from ...description.tree import Description
from ...limits.joint_limits import slides
from ...support.directions import direction_in_words
from ...support.errors import one_line
from ...support.messages import Argument, Text
from .abilities import Abilities
from .wording import grouped, place_of

NO_MOTION = 1e-9
"""A column of the Jacobian this small [m/reach, rad] is zero but for rounding."""

OUT = 0.1
"""How far out [m] the tool of the snippet is."""


def check_off_the_chain(arm: Arm, description: Description) -> Iterator[Finding]:
    """Independent joints that no coordinate of the arm moves: fingers, wheels, a second arm."""
    moved = {name for name, affine in arm.couplings.items() if affine.master in arm.joint_names}
    idle = [
        joint
        for joint in description.joints.values()
        if joint.moving and joint.name not in moved and joint.name not in arm.moving_names and joint.mimic is None
    ]
    if idle:
        what = (
            f"{'they are' if len(idle) > 1 else 'it is'} not between {arm.base} and {arm.tip_link} and "
            f"{'do' if len(idle) > 1 else 'does'} not move the tool"
        )
        remedy = Text("nothing, if that is meant; else pass {tip}", tip=Argument("tip"))
        yield grouped("off-the-chain", description, idle, what, remedy)


def check_without_effect(arm: Arm, able: Abilities) -> Iterator[Finding]:
    """Coordinates with a zero column of the Jacobian everywhere."""
    sizes = np.abs(able.body).max(axis=(0, 1))
    for name, size in zip(arm.joint_names, sizes, strict=True):
        if size <= NO_MOTION:
            what = f"joint {name!r} does not move the tool at any configuration: what it turns is turned back"
            remedy = "look at the mimics behind it, or lock it"
            yield finding("joint-without-effect", place_of(arm.description, arm.name), what, remedy)


def check_tool(arm: Arm, description: Description) -> Iterator[Finding]:
    """A tip that is the last joint's link without a tool's name: its origin is on that joint's axis."""
    last = description.chain(arm.base, arm.tip_link)[-1]
    named = tool_rank(arm.tip_link) is not None
    if last.moving and not slides(last.type) and not named and np.array_equal(arm.tool, np.eye(4)):
        xyz = ", ".join(f"{value + 0.0:.6g}" for value in OUT * arm.tool_axis)
        yield finding(
            "tool-frame-missing",
            description.place(description.links[arm.tip_link]),
            f"the tool is the frame of {last.name} itself: its origin lies on that joint's axis, "
            "and nothing says where the arm grips",
            f"say in arm.toml where the tool is, seen from {one_line(arm.tip_link)} [m, rad], "
            f"for one {OUT:g} m along {direction_in_words(arm.tool_axis, 'tool')}:\n"
            f'[tool]\nname = "tool"\nxyz = [{xyz}]\nrpy = [0.0, 0.0, 0.0]',
        )
