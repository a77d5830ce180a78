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
from .arm import Arm
from .arm_data import Coupling


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
    return Arm(
        name=name,
        source="screws",
        base="base",
        tip="tool",
        joint_names=names,
        joint_types=tuple(lower_pairs(twist[:, None], np.eye(1))[0].kind for twist in xi.T),
        screws=xi,
        home=g,
        coupling=Coupling(np.eye(n), np.zeros(n)),
        limits=limits if isinstance(limits, JointLimits) else JointLimits.unbounded(n).with_(limits, names),
        reach=_reach(xi, g[:3, 3]) or 1.0,
    )


def _reach(xi: Array, tool: Array) -> float:
    """Distances between successive axes of turns, each point nearest to the one before, out to the tool's origin."""
    path: list[Array] = []
    for screw in map(to_screw, xi.T):
        if np.isfinite(screw.pitch):
            near = path[-1] if path else tool
            path.append(screw.point + screw.axis * (screw.axis @ (near - screw.point)))
    return float(sum(np.linalg.norm(b - a) for a, b in pairwise([*path, tool])))
