"""Tolerances: how far off a target still counts as met, for every motion."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..arm.almost_exact import ORIENTATION_ROUNDING, POSITION_ROUNDING, angle_in_words, length_in_words
from ..arm.arm import Arm
from ..ik.request import as_tolerance
from ..ik.searches import USUAL
from ..ik.solution import missed_by_rounding
from ..ik.targets import KINDS, target_for
from ..ik.task_space import Tolerances
from ..support.checks import Array
from .segments import Move, Segment

ROUNDED = (
    f"the path is met to within the rounding of the arm's axes, by at most {length_in_words(POSITION_ROUNDING)} and "
    f"{angle_in_words(ORIENTATION_ROUNDING)}: the doctor's finding axes-almost-exact names them"
)
"""The note on a motion that needed `but_for_rounding`."""


def decided(arm: Arm, position_tol: float | None, orientation_tol: float | None) -> Tolerances:
    """Return the tolerances of a motion of this arm, the usual ones for None."""
    return Tolerances(
        USUAL.position if position_tol is None else as_tolerance(position_tol, "position_tol [m]"),
        USUAL.orientation if orientation_tol is None else as_tolerance(orientation_tol, "orientation_tol [rad]"),
    )


def but_for_rounding(arm: Arm, segments: list[Segment]) -> list[Segment]:
    """Widen the segments' tolerances by what rounded axes may miss; [] where that changes nothing."""
    if not any(arm.rounding):
        return []
    wider: list[Segment] = []
    for each in segments:
        if isinstance(each, Move):
            met = decided(arm, each.position_tol, each.orientation_tol).or_rounding(arm.rounding)
            wider.append(replace(each, position_tol=met.position, orientation_tol=met.orientation))
        else:
            wider.append(each)
    return [] if wider == segments else wider


def rounding_note(arm: Arm, target: Any, theta: Array, where: str, met: Tolerances) -> list[str]:
    """Return the note on a target that theta (n,) meets only within the arm's rounding."""
    if not isinstance(target, KINDS) or not any(arm.rounding):
        return []
    asked, g = target_for(arm, target), arm.fk(theta)
    missed = asked.position_error(g), asked.orientation_error(g)
    return [] if met.met(*missed) else [f"{where}: {missed_by_rounding(*missed)}"]


def leeway(tolerances: Tolerances) -> Tolerances | None:
    """Return the tolerances if they are wider than usual. None: configurations are sought exactly."""
    wide = tolerances.position > USUAL.position or tolerances.orientation > USUAL.orientation
    return tolerances if wide else None
