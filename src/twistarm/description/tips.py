"""Which link is the tool where nobody has said so: by usual names, else the only leaf that is no gripper."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ..errors import DescriptionError, listed
from .findings import Place, refusal
from .tree import Description

TIP_PATTERNS = (
    "tool0",
    "tcp",
    ".*_tcp",
    "gripper_frame_link",
    "tool_frame",
    "ee_link",
    "end_effector.*",
    ".*_end_effector",
)
"""Names that mean "this is the tool", in order of preference, looked for among all links."""

_GRIPPER = re.compile("grip|finger|jaw|claw|hand", re.IGNORECASE)


def find_tip(description: Description, groups: Iterable[str] = ()) -> str:
    """The tool's link: by an ordered list of usual names among all links, else the only leaf that is no gripper.

    Never a silent guess: DescriptionError lists the candidates, and `groups`, those that an SRDF offers.
    """
    for pattern in TIP_PATTERNS:
        found = [link for link in description.links if re.fullmatch(pattern, link, re.IGNORECASE)]
        if len(found) == 1:
            return found[0]
        if found:
            raise _unclear(description, f"several links could be the tip: {listed(found)}", groups)
    leaves = description.leaves
    if len(leaves) == 1 and not _is_gripper(description, leaves[0]):
        return leaves[0]
    why = "its only leaf looks like a gripper" if len(leaves) == 1 else "several links could be the tip"
    raise _unclear(description, f"{why}: {listed(leaves)}", groups, f"pass tip= (a link: {listed(description.links)})")


def _unclear(description: Description, what: str, groups: Iterable[str], remedy: str = "pass tip=") -> DescriptionError:
    offered = ", ".join(groups)
    if offered:
        what += f"; so could the groups of its SRDF: {offered}"
    return refusal("no-tip", Place(str(description.path or description.name)), what, remedy)


def _is_gripper(description: Description, leaf: str) -> bool:
    """Whether the last moving joint before the leaf, or the leaf itself, is named like a gripper's part."""
    moving = [joint for joint in description.chain(description.root, leaf) if joint.moving]
    names = [leaf, *(name for joint in moving[-1:] for name in (joint.name, joint.child))]
    return any(_GRIPPER.search(name) for name in names)
