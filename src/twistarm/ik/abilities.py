"""Motions of an arm's tool around a configuration, from the null spaces of its Jacobian."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.directions import nearest_axes
from .targets import AnyTarget, Approach, Pose

RANK_SAMPLES = 16
"""Random configurations among which a rank is the largest; almost every one has it."""

RANK_TOL = 1e-6
"""Singular values below this, relative to the largest, are directions the arm cannot move in."""

HELD_WEIGHT = 100.0
"""Weight of a radian relative to a metre where the rotation is held."""

OTHER_STARTS = 5
"""Random starts, beside the nearest configuration, of the search for the position that a rotation allows."""

MOST_STEPS = 100
"""Most steps of that search."""

SETTLED = 1e-7
"""A step shorter than this [rad, m] is the last."""

ROTATION_MET = 1e-3
"""Rotation error [rad] that an unreachable position may cause in a rotation held by `HELD_WEIGHT`."""

SIDESTEP = 0.2
"""Distance [rad, m] along the arm's freedom at which a plane is checked again."""

MISSED = 1e-9
"""A position error [m] above this is more than rounding."""

HELD = 1e-10
"""Precision [m] of the held position on the way there."""

STEPS = 20
"""Newton steps on that way. Without singularities four suffice."""

SAME_PLANE = 1e-6
"""Greatest difference of two unit normals of one plane."""


class Split(NamedTuple):
    """A rotation error [rad] with the position held: its part beyond all joints, its tool axis (3,), and the rest."""

    impossible: float
    axis: Array
    prevented: float


def split_rotation(arm: Arm, target: AnyTarget, theta: Array) -> Split:
    """The rotation error at theta (n,) with the position held, split into the part beyond all joints and the rest.

    The compiled core splits it (core/include/twistarm/ik/reason.hpp). Rotation rows times the null space of the
    position rows span what can be undone. Where a rotation reaches its end, a configuration lacks motions of its
    neighbours. Then the least over these counts. A `TolerancedPose` holds a component from the edge of its tolerance
    on. Without the core both parts are 0.
    """
    found = arm.compiled.split_rotation(target.kind, target.numbers, theta) if arm.compiled is not None else None
    if found is None:
        return Split(0.0, np.zeros(3), 0.0)
    return Split(float(found[0]), found[2:], float(found[1]))


def short_of(arm: Arm, target: AnyTarget, theta: Array) -> float | None:
    """The least position error [m] inside the limits with the rotation met, or None.

    The search begins at theta (n,), the nearest configuration, and at random ones.
    """
    starts = [theta, *arm.random_theta(0, OTHER_STARTS)]
    return min((found for start in starts if (found := _with_rotation(arm, target, start)) is not None), default=None)


def _with_rotation(arm: Arm, target: AnyTarget, theta: Array) -> float | None:
    """The same from one start, by Levenberg and Marquardt's steps. Joints pulled out of their bounds rest."""
    lower, upper = arm.limits.lower, arm.limits.upper

    def look(theta: Array) -> tuple[Array, Array]:
        (p, J_p), (r, J_r) = (
            rows(*arm.fk_and_body_jacobian(theta)) for rows in (target._position_rows, target._rotation_rows)
        )
        return np.concatenate([p, HELD_WEIGHT * r]), np.vstack([J_p, HELD_WEIGHT * J_r])

    damping, (e, J) = 1e-2, look(theta)
    for _ in range(MOST_STEPS):
        pull = e @ J
        rests = ((theta <= lower) & (pull > 0)) | ((theta >= upper) & (pull < 0))
        H = np.where(rests, 0.0, J).T @ np.where(rests, 0.0, J) + damping * np.eye(arm.n)
        moved = np.clip(theta - np.linalg.solve(H, np.where(rests, 0.0, pull)), lower, upper)
        there = look(moved)
        if there[0] @ there[0] < e @ e:
            settled = np.abs(moved - theta).max() < SETTLED
            theta, (e, J), damping = moved, there, max(0.1 * damping, 1e-9)
            if settled:
                break
        elif (damping := 10.0 * damping) > 1e6:
            break
    g = arm.fk(theta)
    return target.position_error(g) if target.orientation_error(g) < ROTATION_MET else None


def out_of_surface(arm: Arm, target: AnyTarget, theta: Array) -> Array:
    """Directions (k, 3) in base axes of a missed position in which the tool's origin never moves."""
    g = arm.fk_and_body_jacobian(theta)[0]
    error, axes = target._position_rows(g, np.vstack([np.eye(3), np.zeros((3, 3))]))
    offset = g[:3, :3] @ axes.T @ error
    motions = []
    for each in arm.random_theta(0, RANK_SAMPLES):
        g, J_b = arm.fk_and_body_jacobian(each)
        motions.append(g[:3, :3] @ J_b[:3] / arm.reach)
    U, size, _ = np.linalg.svd(np.hstack(motions))
    across = U[:, int((size > RANK_TOL).sum()) :]
    immovable = nearest_axes(across @ across.T, across.shape[1]).T
    return immovable[np.abs(immovable @ offset) > MISSED]


def approach_plane(arm: Arm, target: AnyTarget, theta: Array) -> tuple[Array, float] | None:
    """The plane in which the approach axis can turn with the position held, or None.

    The answer is its unit normal (3,) in base axes, and the wanted approach's angle to it [rad]. In such a plane the
    arm's free motions turn the axis a, ȧ = ω × a of rank 1. The plane is the same a good way along them.
    """
    wanted = _approach(arm, target)
    if wanted is None:
        return None
    tool_axis, direction = wanted
    normal = _approach_normal(arm, target, theta, tool_axis)
    if normal is None:
        return None
    g, J_b = arm.fk_and_body_jacobian(theta)
    for motion in _holding_position(target, g, J_b).T:
        moved = _moved_to(arm, g[:3, 3], theta + SIDESTEP * motion)
        there = _approach_normal(arm, target, moved, tool_axis)
        if there is None or np.linalg.norm(np.cross(there, normal)) > SAME_PLANE:
            return None
    return normal, math.asin(min(abs(float(normal @ direction)), 1.0))


def _moved_to(arm: Arm, p: Array, theta: Array) -> Array:
    """A theta nearby with the tool's origin at p (3,), limits aside, by Newton's shortest steps."""
    for _ in range(STEPS):
        g, J_b = arm.fk_and_body_jacobian(theta)
        offset = g[:3, :3].T @ (p - g[:3, 3])
        if np.linalg.norm(offset) <= HELD:
            break
        theta = theta + np.linalg.pinv(J_b[:3], rcond=RANK_TOL) @ offset
    return theta


def _approach_normal(arm: Arm, target: AnyTarget, theta: Array, tool_axis: Array) -> Array | None:
    """The normal of the plane of the approach axis at theta, in base axes, or None."""
    g, J_b = arm.fk_and_body_jacobian(theta)
    turning = np.cross((J_b[3:] @ _holding_position(target, g, J_b)).T, tool_axis)
    _, size, directions = np.linalg.svd(turning)
    if not len(turning) or size[0] <= RANK_TOL or (size[1:] > RANK_TOL * size[0]).any():
        return None
    return g[:3, :3] @ np.cross(tool_axis, directions[0])


def _approach(arm: Arm, target: AnyTarget) -> tuple[Array, Array] | None:
    """The tool axis and its wanted direction (base axes), for targets with both."""
    if isinstance(target, Approach):
        return target.axis, target.direction
    if isinstance(target, Pose):
        return arm.tool_axis, target.g[:3, :3] @ arm.tool_axis
    return None


def _holding_position(target: AnyTarget, g: Array, J_b: Array) -> Array:
    """Joint velocities (n, k) that keep the target's position error."""
    rows = target._position_rows(g, J_b)[1]
    _, size, Vt = np.linalg.svd(rows)
    rank = int((size > RANK_TOL * size.max(initial=0.0)).sum())
    return Vt[rank:].T
