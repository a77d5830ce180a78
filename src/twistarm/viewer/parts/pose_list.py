"""The list of recorded poses, with undo and redo. Each has a unique number, a unique name, and theta."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...planning.keep import AS_AT_START
from ...planning.within import inside_from
from ...support.checks import Array, frozen
from ...support.errors import InputError, LimitError, one_line
from ...support.strict_json import LARGEST_MESSAGE, encode
from .arm_data import LIMIT_TOL, checked_theta, require_all_inside

LONGEST_NAME = 60  # Most characters of a pose's name. A row of the page shows half of it.
LARGEST_LIST = LARGEST_MESSAGE * 7 // 8  # Bytes of a whole list as a message: some 300 poses of seven joints.
MAX_STEPS = 100  # Most changes of the list that can be undone.
# How the arm moves to a pose: every joint straight, the tool on a straight line or a screw motion, or on the arc
# that leads through this pose to the next, or on any way round obstacles. The last ones keep something on that way.
FREE = ("free", *AS_AT_START)
MOVES = ("joint", "line", "screw", "via", *FREE)


@dataclass(frozen=True, eq=False)
class RecordedPose:
    """A pose of the list: theta (n,) [rad, m], and the way `by` of MOVES to it.

    theta is inside the limits. That of the first, a measured start, may be up to 0.2 rad or 20 mm beyond.
    """

    id: int
    name: str
    theta: Array
    by: str = MOVES[0]

    def entry(self) -> dict[str, Any]:
        """The saved pose: name, theta and by."""
        return {"name": self.name, "theta": self.theta.tolist(), "by": self.by}


class PoseList:
    """Poses of one arm in order. A refused change leaves the list unchanged."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._last = 0
        self.poses: tuple[RecordedPose, ...] = ()
        self._steps: dict[str, list[tuple[str, tuple[RecordedPose, ...]]]] = {"undo": [], "redo": []}
        """The changes that can be undone or redone: the name of each, and the poses without it."""

    def record(self, name: str, theta: Array) -> None:
        """Add theta (n,) at the end. An empty name is made up, and one that is taken gets a number."""
        self._keep([*self.poses, self._new(name, theta, self.poses)], "record a pose")

    def rename(self, number: int, name: str) -> None:
        """Give another name, by the same rules."""
        pose = self._pose(number)
        others = [other for other in self.poses if other is not pose]
        self._exchange("rename a pose", pose, replace(pose, name=_unused_name(name, others)))

    def move(self, number: int, by: str) -> None:
        """Have the arm move to a pose in another way, one of MOVES."""
        pose = self._pose(number)
        self._exchange("choose a move", pose, replace(pose, by=by))

    def reorder(self, number: int, place: int) -> None:
        """Move to `place`, 0 the first; beyond the end means the last."""
        pose = self._pose(number)
        others = [other for other in self.poses if other is not pose]
        poses = [*others[:place], pose, *others[place:]]
        for later in poses[1:]:  # the first alone may be outside, as a measured start is
            self._require_inside(later.name, later.theta)
        self._keep(poses, "reorder the poses")

    def delete(self, number: int) -> None:
        """Take a pose off the list."""
        self._exchange("delete a pose", self._pose(number))

    def replace(self, joints: Sequence[str], poses: Iterable[Mapping[str, Any]]) -> None:
        """Replace the list by poses with name and theta in the order of `joints`."""
        order = self._order(joints)
        taken: list[RecordedPose] = []
        for pose in poses:
            taken.append(self._read(pose, order, taken))
        self._keep(taken, "load a list")

    def go_back(self, kind: str) -> None:
        """Undo ("undo") the last change of the list, or redo it ("redo"). Raises InputError without one."""
        if not self._steps[kind]:
            raise InputError(f"nothing to {kind} in the list of poses")
        words, poses = self._steps[kind].pop()
        self._steps["redo" if kind == "undo" else "undo"].append((words, self.poses))
        self.poses = poses

    def next_steps(self) -> dict[str, str | None]:
        """The names of the changes that "undo" and "redo" concern. None without one."""
        return {kind: steps[-1][0] if steps else None for kind, steps in self._steps.items()}

    def take_over(self, other: PoseList) -> list[str]:
        """Take over the poses of another arm with joints of the same names. Returns in words what is left out."""
        reasons: list[str] = []
        for pose in other.poses:
            try:
                self.poses += (self._read(pose.entry(), self._order(other._arm.joint_names), self.poses),)
            except (InputError, LimitError) as error:  # noqa: PERF203
                reasons.append(str(error))
        which = "a pose is" if len(reasons) == 1 else f"{len(reasons)} poses are"
        return [f"{which} left out: {reasons[0]}"] if reasons else []

    def theta(self, number: int) -> Array:
        """The configuration (n,) of a pose."""
        return self._pose(number).theta

    def named(self) -> dict[str, Array]:
        """Theta (n,) by name, in order. The arrays are the caller's."""
        return {pose.name: pose.theta.copy() for pose in self.poses}

    def _exchange(self, words: str, old: RecordedPose, *new: RecordedPose) -> None:
        at = self.poses.index(old)
        self._keep([*self.poses[:at], *new, *self.poses[at + 1 :]], words)

    def _pose(self, number: int) -> RecordedPose:
        for pose in self.poses:
            if pose.id == number:
                return pose
        raise InputError(f"no pose number {number} in the list: it was deleted, or another list was loaded")

    def _new(self, name: str, theta: ArrayLike, others: Sequence[RecordedPose], by: str = MOVES[0]) -> RecordedPose:
        free, arm = _unused_name(name, others), self._arm
        checked = checked_theta(arm, theta)
        if others:
            self._require_inside(free, checked)
        else:
            inside_from(checked, arm.limits, arm.joint_names, arm.units)
        self._last += 1
        # A slider's end may lie beyond its limit by the rounding of decimal text, which a planner does not take.
        inside = np.clip(checked, arm.limits.lower, arm.limits.upper)
        return RecordedPose(self._last, free, frozen(np.where(abs(checked - inside) > LIMIT_TOL, checked, inside)), by)

    def _require_inside(self, name: str, theta: Array) -> None:
        try:
            require_all_inside(self._arm, theta)
        except LimitError as error:
            raise LimitError(f"the pose '{name}': {error}; only the first pose, the start, may be outside") from error

    def _read(self, pose: Mapping[str, Any], order: Sequence[int], others: Sequence[RecordedPose]) -> RecordedPose:
        """A pose of a list with another joint order."""
        values, name = np.array(pose["theta"], dtype=np.float64), one_line(pose["name"], LONGEST_NAME)
        if values.shape != (len(order),):
            raise InputError(f"the pose '{name}' has {len(values)} values, and the list moves {len(order)} joints")
        by = pose.get("by", MOVES[0])
        if by not in MOVES:
            raise InputError(f"by of the pose '{name}' must be one of {', '.join(MOVES)}")
        return self._new(pose["name"], values[order], others, by)

    def _order(self, joints: Sequence[str]) -> list[int]:
        """Where the arm's joints stand among `joints`."""
        names = self._arm.joint_names
        if sorted(joints) != sorted(names):
            moved = one_line(", ".join(joints), 200)
            raise InputError(f"the list is for the joints {moved}; {self._arm.name} has {', '.join(names)}")
        return [list(joints).index(name) for name in names]

    def _keep(self, poses: Sequence[RecordedPose], words: str) -> None:
        """Take these poses as the list. `words` name the change that can be undone."""
        entries = [pose.entry() for pose in poses]
        size = len(encode({"joints": self._arm.joint_names, "poses": entries}))
        if size > LARGEST_LIST and len(poses) >= len(self.poses):
            raise InputError(f"a list has at most {LARGEST_LIST} bytes; {len(poses)} poses would have {size}")
        if tuple(poses) != self.poses:
            self._steps = {"undo": [*self._steps["undo"][1 - MAX_STEPS :], (words, self.poses)], "redo": []}
        self.poses = tuple(poses)


def _unused_name(name: str, others: Sequence[RecordedPose]) -> str:
    """The name, made up if empty, with a number if another pose has it."""
    taken = {pose.name for pose in others}
    bare = " ".join(name.split())
    if len(bare) > LONGEST_NAME:
        raise InputError(f"a pose's name has at most {LONGEST_NAME} characters; got {len(bare)}")
    if bare and bare not in taken:
        return bare
    number = 2 if bare else len(others) + 1
    while f"{bare or 'pose'} {number}" in taken:
        number += 1
    return f"{bare or 'pose'} {number}"
