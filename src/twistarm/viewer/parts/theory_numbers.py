"""Jacobians, screws, singular values and ellipsoids of one configuration for the pages."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...control.servo.settings import ServoSettings
from ...limits.joint_units import slides
from ...support.checks import Array
from ...theory import poe
from ...theory.screws import to_screw
from ..scene.ellipsoids import ellipsoids
from .singularity_text import standing

BELOW = ServoSettings().singular_below
"""Singular values less than this are said to be singular by a servo of ordinary settings."""


def numbers(arm: Arm, theta: Array, rates: Array | None = None) -> dict[str, Any]:
    """The numbers at theta (n,) in SI units and radians; matrices are lists of rows.

    g (4, 4): g_st. spatial, body, hybrid (6, n): the Jacobians. columns: each column of J^s as a screw. axes: each
    moving joint's screw, null if equal to the columns. singular_values, condition (null if infinite), rank, yoshikawa,
    smallest, below, standing (in words): of the body Jacobian, with metres divided by `reach`. linear, angular: the
    ellipsoids. motion: V^s = J^s θ̇ for `rates` (n,), as twist and screw, and the velocity of the tool's origin.
    """
    g, J_b = arm._fk_and_body_jacobian(theta)
    J_s = arm.spatial_jacobian(theta)
    hybrid = (g[:3, :3] @ J_b.reshape(2, 3, -1)).reshape(6, -1)
    lengths = np.array([slides(kind) for kind in arm.joint_types], dtype=bool)
    return {
        "g": g.tolist(),
        "spatial": J_s.tolist(),
        "body": J_b.tolist(),
        "hybrid": hybrid.tolist(),
        "axes": None if _uncoupled(arm) else _screws(poe.spatial_jacobian(arm.screws, arm.coupling.A @ theta)),
        **_columns_and_motion(J_s, hybrid, rates),
        **_singularity(arm, theta),
        **_ellipsoids(arm, hybrid, lengths),
    }


def _columns_and_motion(J_s: Array, hybrid: Array, rates: Array | None) -> dict[str, Any]:
    if rates is None or not np.any(rates):
        return {"columns": _screws(J_s), "motion": None}
    n, twist = len(rates), J_s @ rates
    screws = _screws(np.column_stack([J_s, twist]))  # one call costs little more than for one column
    motion = {
        "twist": twist.tolist(),
        "screw": {name: each[n:] for name, each in screws.items()},
        "velocity": (hybrid[:3] @ rates).tolist(),
    }
    return {"columns": {name: each[:n] for name, each in screws.items()}, "motion": motion}


def _singularity(arm: Arm, theta: Array) -> dict[str, Any]:
    found = arm.manipulability(theta)
    values, rank = found.singular_values.tolist(), int(found.rank) if arm.n else 0
    return {
        "singular_values": values,
        "condition": values[0] / values[-1] if 0 < rank == len(values) else None,
        "rank": rank,
        "yoshikawa": float(found.yoshikawa),
        "smallest": values[-1] if values else 0.0,
        "below": BELOW,
        "standing": standing(found, rank, BELOW),
    }


def _ellipsoids(arm: Arm, hybrid: Array, lengths: Array) -> dict[str, Any]:
    pairs = zip(("linear", "angular"), *ellipsoids(hybrid, lengths, arm.reach), strict=True)
    return {name: {"semi_axes": long.tolist(), "directions": along.tolist()} for name, long, along in pairs}


def _screws(columns: Array) -> dict[str, list[Any]]:
    """Axis, point [m], pitch [m/rad] and magnitude of each column of (6, k). An infinite pitch is null."""
    screw = to_screw(columns.T)
    pitches = screw.pitch.tolist()
    return {
        "axis": screw.axis.tolist(),
        "point": screw.point.tolist(),
        "pitch": [None if np.isinf(pitch) else pitch for pitch in pitches],
        "magnitude": screw.magnitude.tolist(),
    }


def _uncoupled(arm: Arm) -> bool:
    A = arm.coupling.A
    return A.shape == (arm.n, arm.n) and bool((np.eye(arm.n) == A).all())
