"""How all configurations of an arm are found, before a target is known."""

from __future__ import annotations

from dataclasses import dataclass

from ...arm.arm import Arm
from ..targets import AnyTarget, Approach, Pose, TargetLike, checked_target
from .families import NEARLY
from .methods import ELIMINATION, closest_miss_of, method_for

FITS_APPROACH = 5
"""Joints that an `Approach` determines."""


@dataclass(frozen=True)
class ClosedFormReport:
    """How `solve_ik_all` finds every configuration of an arm, for one kind of `target`.

    method: "closed form", "elimination" or "search from many starts". family: the family in words; for a search, why
    the axes have none. exact: whether every configuration is found, with the joints `held` at their values. held:
    joints that the target does not determine, base to tip. miss: which axes miss a family by least, and by how much; ""
    if none do. nearly: whether that is so little that it looks like rounding.
    """

    target: str
    method: str
    family: str
    exact: bool
    held: tuple[str, ...] = ()
    miss: str = ""
    nearly: bool = False

    def __str__(self) -> str:
        held = f", for each value of {' and '.join(self.held)}" if self.held else ""
        miss = f"; {self.miss}" if self.method == ELIMINATION and self.miss else ""
        return f"{self.method}, {self.family}{held}{miss}"


def closed_form_of(arm: Arm, like: TargetLike | None = None) -> ClosedFormReport:
    """The report for targets like this one. By default an approach for five joints, else a pose."""
    target = _usual(arm) if like is None else checked_target(arm, like)
    method = method_for(arm, target)
    off, miss = closest_miss_of(arm, method)
    held = tuple(arm.joint_names[i] for i in method.swept)
    return ClosedFormReport(
        type(target).__name__, method.name, method.in_words(arm), method.exact, held, miss,
        nearly=bool(miss) and off <= NEARLY,
    )  # fmt: skip


def _usual(arm: Arm) -> AnyTarget:
    g = arm.home
    approach = Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis, arm.tool_axis)
    return approach if arm.n == FITS_APPROACH and not method_for(arm, approach).swept else Pose(g)
