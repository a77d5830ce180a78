"""Arms made by hand from their screws, as in a textbook."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..limits.joint_limits import JointLimits
from ..support.checks import Array, as_floats, as_pose, require_names, require_one
from ..support.errors import InputError
from ..theory.lower_pairs import lower_pairs
from ..theory.screws import to_screw
from .arm import Arm, Coupling


def arm_from_screws(
    screws: ArrayLike,
    home: ArrayLike,
    *,
    joints: Sequence[str] | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    name: str = "arm",
) -> Arm:
    """An arm from its space twists (6, n) and home pose (4, 4), both at theta = 0; MLS §3.2.2.

    Columns with w = 0 are prismatic [m]. The others turn [rad]: revolute, or helical with a pitch.

    Args:
        screws: Space twists (6, n), (v, w) in each column, linear part first.
        home: The tool's pose g_st(0) (4, 4), seen from the base.
        joints: The n joint names; by default joint1, joint2 and so on.
        limits: A `JointLimits`, or a mapping as in `load_arm`; by default unbounded.
        name: The arm's name.

    Returns:
        The `Arm`, without a description and so without a Pinocchio model.

    Raises:
        InputError: A wrong shape, a zero column, a pose that is not in SE(3), or names that do not fit.
    """
    xi = as_floats(screws, "screws")
    if xi.ndim != 2 or xi.shape[0] != 6 or xi.shape[1] == 0:
        raise InputError(f"screws must have shape (6, n), one column per joint; got {xi.shape}")
    n = xi.shape[1]
    names = tuple(f"joint{i + 1}" for i in range(n)) if joints is None else require_names(joints, "joints")
    if len(names) != n or len(set(names)) != n:
        raise InputError(f"joints must be {n} different names, one per column of screws; got {list(names)}")
    if not (np.abs(xi).max(axis=0) > 0).all():
        raise InputError("screws must not have a zero column: it moves nothing")
    g = require_one(as_pose(home, "home"), "home", 2)
    limits = {} if limits is None else limits
    if isinstance(limits, JointLimits) and limits.lower.size != n:
        raise InputError(f"limits must be those of {n} joints; got {limits.lower.size}")
    prismatic = np.linalg.norm(xi[3:], axis=0) < 1e-12 * np.linalg.norm(xi[:3], axis=0)
    return Arm(
        name=name,
        source="screws",
        base="base",
        tip="tool",
        joint_names=names,
        joint_types=tuple("prismatic" if slide else _turning(xi[:, i]) for i, slide in enumerate(prismatic)),
        screws=xi,
        home=g,
        coupling=Coupling(np.eye(n), np.zeros(n)),
        limits=limits if isinstance(limits, JointLimits) else JointLimits.unbounded(n).with_(limits, names),
        reach=_reach(xi[:, ~prismatic], g[:3, 3]) or 1.0,
    )


def _turning(xi: Array) -> str:
    """Revolute or helical, by the pitch of this twist (6,) alone."""
    (pair,) = lower_pairs(xi[:, None], np.eye(1))
    return pair.kind


def _reach(turning: Array, tool: Array) -> float:
    """Distances between successive axes, each point nearest to the one before, out to the tool's origin."""
    if turning.shape[1] == 0:
        return 0.0
    screws = [to_screw(xi) for xi in turning.T]
    points = [screws[0].point + screws[0].axis * (screws[0].axis @ (tool - screws[0].point))]
    for screw in screws[1:]:
        points.append(screw.point + screw.axis * (screw.axis @ (points[-1] - screw.point)))
    path = [*points, tool]
    return float(sum(np.linalg.norm(b - a) for a, b in pairwise(path)))
