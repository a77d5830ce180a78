"""Tolerances: how far off a target still counts as met, for every motion."""

from __future__ import annotations

from ..ik.request import as_tolerance
from ..ik.task_space import USUAL, Tolerances


def decided(position_tol: float | None, orientation_tol: float | None) -> Tolerances:
    """Return the tolerances of a motion, the usual ones for None."""
    return Tolerances(
        USUAL.position if position_tol is None else as_tolerance(position_tol, "position_tol [m]"),
        USUAL.orientation if orientation_tol is None else as_tolerance(orientation_tol, "orientation_tol [rad]"),
    )


def are_wide(tolerances: Tolerances) -> bool:
    """Whether the tolerances are wider than usual. A motion then uses them from the first, to bend less."""
    return tolerances.position > USUAL.position or tolerances.orientation > USUAL.orientation
