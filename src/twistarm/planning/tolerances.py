"""Tolerances: how far off a target still counts as met, decided here for every motion."""

from __future__ import annotations

from ..ik.request import as_tolerance
from ..ik.task_space import Tolerances
from ..model.arm import Arm

USUAL = Tolerances(1e-6, 1e-6)
"""Of a motion that names none [m, rad]."""


def decided(arm: Arm, position_tol: float | None, orientation_tol: float | None) -> Tolerances:
    """The tolerances that count for a motion of this arm: those given, the usual ones for None."""
    return Tolerances(
        USUAL.position if position_tol is None else as_tolerance(position_tol, "position_tol [m]"),
        USUAL.orientation if orientation_tol is None else as_tolerance(orientation_tol, "orientation_tol [rad]"),
    )


def leeway(tolerances: Tolerances) -> Tolerances | None:
    """The tolerances where they are wider than the usual ones; else None, and configurations are sought exactly."""
    wide = tolerances.position > USUAL.position or tolerances.orientation > USUAL.orientation
    return tolerances if wide else None
