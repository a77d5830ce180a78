"""The tool frame: whether there is one beyond the last joint."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...description.tips.link_names import tool_rank
from ...description.tree import Description
from ...limits.joint_limits import slides
from ...support.errors import one_line
from ...support.vector_words import direction_in_words

OUT = 0.1
"""How far out [m] the tool of the snippet is."""


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
