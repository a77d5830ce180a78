"""Statements of an arm's abilities and inabilities in words, each true at almost every posture."""

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

UP = np.array([0.0, 0.0, 1.0])
"""What counts as upward in the base, for the words pitch and yaw."""

FEWER = {2: "a surface", 1: "a curve"}


def summary(arm: Arm, able: Abilities) -> str:
    """One line: the directions of motion, of six, and how they split."""
    spare = arm.n - able.rank
    turns = "its orientation follows from its position" if not able.turning else f"{able.turning} of 3 rotations there"
    text = f"moves its tool in {able.rank} of 6 directions: {able.position} of 3 for the position, {turns}"
    return f"{text}; {plural(spare, 'joint')} to spare" if spare else text


def check_abilities(arm: Arm, able: Abilities) -> Iterator[Finding]:
    """What no configuration lets this arm do."""
    place = place_of(arm.description, arm.name)
    if able.position < 3:
        remedy = "ask only for positions there; solve_ik gives the nearest to any other"
        yield finding("cannot-move", place, cannot_move(able), remedy)
    if len(able.unturned):
        remedy = "leave these rotations free: a Position, or a TolerancedPose with inf for them"
        yield finding("cannot-turn", place, cannot_turn(able), remedy)
    if able.turning + len(able.unturned) < 3:
        yield finding("cannot-turn-in-place", place, cannot_turn_in_place(able), _instead(able, arm.tool_axis))


def cannot_move(able: Abilities) -> str:
    """The sentence for positions."""
    missing = able.immovable
    if able.position == 0:
        return "cannot move its tool at all: its origin never leaves its place"
    if len(missing) == 1 and able.position == 2:
        return f"cannot move its tool along {_base(missing[0])}: it stays in one plane across that axis"
    if len(missing) == 2:
        along = np.cross(missing[0], missing[1])
        return f"moves its tool along {_base(along)} only, to and fro on one line"
    across = f", never along {_base(missing[0])}" if len(missing) else ""
    directions = "one direction" if able.position == 1 else "two directions"
    return f"moves its tool on {FEWER[able.position]}, in {directions} at any configuration{across}"


def cannot_turn(able: Abilities) -> str:
    """The sentence for rotations that are always missing."""
    missing = able.unturned
    if len(missing) == 3:
        return "cannot turn its tool at all: it keeps its orientation"
    if len(missing) == 2:
        return f"turns its tool about {_base(np.cross(missing[0], missing[1]))} only: cannot tilt it"
    return f"cannot turn its tool about {_base(missing[0])}"


def cannot_turn_in_place(able: Abilities) -> str:
    """The sentence for rotations that are missing while the position is held."""
    if able.turning == 0:
        return "cannot turn its tool in place: at a position it has a few orientations at most"
    if able.turning == 1:
        return f"with its position held, turns its tool about {_one_axis(able)}"
    return _two_axes(able)


def _one_axis(able: Abilities) -> str:
    if len(able.turned_tool):
        return f"{axis_in_words(able.turned_tool[0], 'tool')} only"
    if len(able.turned_base):
        return f"{_base(able.turned_base[0])} only"
    return "one axis only, which changes with the configuration"


def _two_axes(able: Abilities) -> str:
    """Two of three rotations: roll is about an axis of the tool, pitch about a horizontal axis."""
    if len(able.turned_tool) != 1:
        known = f", one of them {_base(able.turned_base[0])}" if len(able.turned_base) == 1 else ""
        third = "the third changes with the configuration"
        return f"with its position held, turns its tool about two axes only{known}; {third}"
    fixed = _base(able.turned_base[0]) if len(able.turned_base) == 1 else ""
    if _pitches(able):
        return (
            f"cannot yaw the tool: with its position held it rolls about {_roll_name(able)} and pitches about "
            f"{fixed or 'one horizontal axis square to it'}, and nothing turns it about the third"
        )
    more = f", {fixed}" if fixed else ""
    return (
        f"with its position held, turns its tool about {_roll_name(able)} and one axis more{more}, not about the third"
    )


def _pitches(able: Abilities) -> bool:
    """Whether its two rotations are a roll about a tool axis and a pitch about a horizontal one."""
    if able.turning != 2 or len(able.turned_tool) != 1:
        return False
    return bool(np.abs(_other_axes(able, able.turned_tool[0]) @ UP).max() <= TOL)


def _roll_name(able: Abilities) -> str:
    return axis_in_words(able.turned_tool[0], "tool")


def _other_axes(able: Abilities, roll: Array) -> Array:
    """The second axis (k, 3) in base axes at each configuration: in the span of the free ones, across the roll."""
    rolls = able.R @ roll
    missing = np.cross(able.free[:, :, 0], able.free[:, :, 1])
    return np.cross(missing, rolls)


def _instead(able: Abilities, tool_axis: Array) -> str:
    """What can be asked for instead of a whole pose."""
    nearest = "solve_ik gives the nearest to any other pose and says what is missing"
    if able.position < 3:
        return nearest
    if able.turning == 2 and _points_anywhere(able, tool_axis):
        pointed = direction_in_words(tool_axis, "tool")
        return f"ask for an Approach: a position and where the tool points, by {pointed}; {nearest}"
    if _pitches(able):
        return f"ask for a Position, or for poses whose {_roll_name(able)[4:]} is square to the pitch axis; {nearest}"
    return f"ask for a Position; {nearest}"


def _points_anywhere(able: Abilities, tool_axis: Array) -> bool:
    """Whether the free rotations usually turn the axis of an `Approach` in both directions across it."""
    pointed = able.R @ tool_axis
    turning = np.cross(np.swapaxes(able.free, 1, 2), pointed[:, None, :])
    return bool(np.median(np.linalg.svd(turning, compute_uv=False)[:, 1]) > TOL)


def _base(axis: Array) -> str:
    return axis_in_words(axis, "base")
