"""What no configuration lets an arm do, in words, each true at almost every posture."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...support.checks import Array
from ...support.directions import axis_in_words, direction_in_words
from ...support.messages import plural
from .abilities import TOL, Abilities
from .wording import place_of


def summary(arm: Arm, able: Abilities) -> str:
    """One line: the directions of motion, of six, and how they split."""
    spare = arm.n - able.rank
    turns = "its orientation follows from its position" if not able.turning else f"{able.turning} of 3 rotations there"
    text = f"moves its tool in {able.rank} of 6 directions: {able.position} of 3 for the position, {turns}"
    return f"{text}; {plural(spare, 'joint')} to spare" if spare else text


def check_abilities(arm: Arm, able: Abilities) -> Iterator[Finding]:
    """The directions in which the tool's position, and its orientation, cannot change."""
    place = place_of(arm.description, arm.name)
    if able.position < 3:
        what = f"moves its tool's position in {able.position} of 3 directions at any configuration"
        if len(able.immovable):
            what += f", never along {_axes(able.immovable, 'base')}"
        remedy = "ask only for positions there; solve_ik gives the nearest to any other"
        yield finding("cannot-move", place, what, remedy)
    if len(able.unturned):
        what = f"never turns its tool about {_axes(able.unturned, 'base')}"
        remedy = "leave these rotations free: a Position, or a TolerancedPose with inf for them"
        yield finding("cannot-turn", place, what, remedy)
    if able.turning + len(able.unturned) < 3:
        what = f"with its position held, turns its tool about {able.turning} of 3 axes"
        always = [_axes(able.turned_tool, "tool"), _axes(able.turned_base, "base")]
        if any(always):
            what += f", always about {' and '.join(filter(None, always))}"
        yield finding("cannot-turn-in-place", place, what, _instead(able, arm.tool_axis))


def _axes(axes: Array, frame: str) -> str:
    return " and ".join(axis_in_words(axis, frame) for axis in axes)


def _instead(able: Abilities, tool_axis: Array) -> str:
    """What can be asked for instead of a whole pose."""
    nearest = "solve_ik gives the nearest to any other pose and says what is missing"
    if able.position < 3:
        return nearest
    # Whether the free rotations usually turn the axis of an `Approach` in both directions across it.
    pointed = able.R @ tool_axis
    turning = np.cross(np.swapaxes(able.free, 1, 2), pointed[:, None, :])
    if able.turning == 2 and np.median(np.linalg.svd(turning, compute_uv=False)[:, 1]) > TOL:
        axis = direction_in_words(tool_axis, "tool")
        return f"ask for an Approach: a position and where the tool points, by {axis}; {nearest}"
    return f"ask for a Position; {nearest}"
