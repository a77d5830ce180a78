"""Configurations that meet targets: the ones near others along a curve, and all branches of one target."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..arm.engine import answered
from ..ik.answer import Configurations
from ..ik.closed_form.methods import method_for
from ..ik.ranges import joint_ranges
from ..ik.rotation_errors import log_rate
from ..ik.searches import searched
from ..ik.targets import AnyTarget, Approach, Pose, TolerancedPose
from ..ik.task_space import USUAL, Tolerances
from ..support.checks import Array
from ..theory import rotations
from .curves import MovingTarget, errors_from

EXACT = 1e-9  # Configurations meet the curve to this [m, rad], so that the spline through them is smooth.

ALL_BUT_EXACT = Tolerances(EXACT, EXACT)

LONGEST_JUMP = 0.5  # A joint that moves farther [rad, m] from rung to rung leaps.

STEPS = 12

# Of a step, as part of the squared error and at least. It is short far from targets and near singularities, and no
# joint turns far to correct rounding of an axis.
DAMPING, LEAST_DAMPING = 0.05, 1e-6
# Factor and limit of the least damping, which grows where a step increases errors.
GROWTH, MOST_GROWTH = 10.0, 1e8
MOST_WEIGHT = 1e3  # Greatest weight of an error with a narrow tolerance relative to one with a wide tolerance.
LIMIT = 1e-12  # A joint this near to a limit [rad, m] is at it.
# Searches from random starts, besides the one from the arm's configuration; also the most closed-form answers.
MANY = 96
# Values tried for the turn about an approach's axis, and for each joint that changes no other.
FREE_VALUES = 12
# Configurations nearer together than this [rad, m] in every joint are one. Branches may come close to each other.
DISTINCT = 0.02

SEED = 0

Solutions = tuple[Array, NDArray[np.bool_]]  # Configurations (k, n), and which of them meet their targets (k,).


def solve_near(
    arm: Arm,
    moving: MovingTarget,
    ideal: Array,
    near: Array,
    closed_form: Callable[[MovingTarget, Array, Array], Solutions | None] | None = None,
) -> Solutions:
    """Solve for configurations near `near` (k, n) at poses `ideal` (k, 4, 4).

    They meet targets exactly where possible, so that a spline through them is smooth. A search within tolerances comes
    last. Unless the curve is to be met exactly, the nearest configuration within tolerances comes first. `closed_form`
    replaces the search for exact configurations where it applies.
    """

    def without_leap(ideal: Array, near: Array) -> Solutions:
        theta, converged = projected(arm, moving.like, ideal, near, moving.tolerances)
        return theta, converged & (np.abs(theta - near).max(axis=1) <= LONGEST_JUMP)

    def exactly(ideal: Array, near: Array) -> Solutions:
        found = None if closed_form is None else closed_form(moving, ideal, near)
        return search(ideal, near, ALL_BUT_EXACT) if found is None else found

    def search(ideal: Array, near: Array, tolerances: Tolerances = moving.tolerances) -> Solutions:
        found = searched(arm, targets_at(moving.like, ideal), near, tolerances)
        return found.theta, found.converged

    theta, converged = near.copy(), np.zeros(len(near), dtype=bool)
    for solve in (exactly, search) if moving.exactly else (without_leap, exactly, search):
        left = np.flatnonzero(~converged)
        found, good = solve(ideal[left], near[left])
        theta[left[good]], converged[left[good]] = found[good], True
        if converged.all():
            break
    return theta, converged


def targets_at(like: AnyTarget, ideal: Array) -> Array | list[AnyTarget]:
    """Return targets like that one at poses (k, 4, 4), in the form that `searched` takes."""
    return ideal if isinstance(like, Pose) else [like.at(g) for g in ideal]


def projected(arm: Arm, like: AnyTarget, ideal: Array, theta: Array, within: Tolerances) -> Solutions:
    """Return configurations near theta (k, n) for targets at `ideal` (k, 4, 4), and which meet them within tolerances.

    Damped Gauss-Newton takes the shortest step: θ ← θ − Jᵀ (J Jᵀ + λ 1)⁻¹ e (Nakamura & Hanafusa 1986). So what a
    target leaves free stays. A joint at a limit is held if it would leave. The tolerances weigh the errors, and λ grows
    where errors do not shrink.
    """
    lower, upper = arm.limits.lower, arm.limits.upper
    theta = np.clip(theta, lower, upper)
    more, least, kept = np.ones(len(theta)), np.full(len(theta), np.inf), theta
    for _ in range(STEPS):
        e, J = errors_and_rows(like, ideal, arm.fk(theta), arm.body_jacobian(theta))
        exact: NDArray[np.bool_] = np.abs(e).max(axis=1) <= 0.5 * EXACT
        if exact.all():
            break
        tolerances = np.array([within.position] * 3 + [within.orientation] * (e.shape[1] - 3))
        weights = np.minimum(max(within.position, within.orientation) / tolerances, MOST_WEIGHT)
        size = ((e * weights) ** 2).sum(axis=1)
        less = size < least
        more = np.clip(np.where(less, more / GROWTH, more * GROWTH), 1.0, MOST_GROWTH)
        kept, least = np.where(less[:, None], theta, kept), np.minimum(size, least)
        if not less.all():
            theta = kept
            e, J = errors_and_rows(like, ideal, arm.fk(theta), arm.body_jacobian(theta))
        e, J = e * weights, J * weights[:, None]
        damping = (DAMPING * least + LEAST_DAMPING * more)[:, None, None] * np.eye(e.shape[1])
        step = shortest(e, J, damping)
        held = ((theta <= lower + LIMIT) & (step < 0.0)) | ((theta >= upper - LIMIT) & (step > 0.0))
        if held.any():
            step = shortest(e, J * ~held[:, None], damping)
        theta = np.where(exact[:, None], theta, np.clip(theta + step, lower, upper))
    position, angle = errors_from(like, ideal, arm.fk(theta))
    return theta, (position <= within.position) & (angle <= within.orientation)


def shortest(e: Array, J: Array, damping: Array) -> Array:
    """The shortest steps (k, n) with J @ step = −e, damped (r, r). Errors are (k, r), rows (k, r, n)."""
    across = np.swapaxes(J, 1, 2)
    return np.asarray(-(across @ np.linalg.solve(J @ across + damping, e[..., None]))[..., 0])


def errors_and_rows(like: AnyTarget, ideal: Array, g: Array, J_b: Array) -> tuple[Array, Array]:
    """Errors (k, r) of poses g (k, 4, 4) from targets at `ideal`, and their rows (k, r, n).

    They match the targets' `position_rows` and `rotation_rows`, except for the size of large errors. What a
    `TolerancedPose` tolerates is no error and has no rows.
    """
    turned = np.swapaxes(ideal[:, :3, :3], -1, -2)
    R, offset = g[:, :3, :3], (g[:, :3, 3] - ideal[:, :3, 3])[..., None]
    if isinstance(like, TolerancedPose):
        axes = np.broadcast_to(np.eye(3), R.shape) if like.frame == "base" else turned
        phi = rotations.log(turned @ R)
        back = axes @ np.swapaxes(turned, -1, -2)
        e = np.concatenate([(axes @ offset)[..., 0], (back @ phi[..., None])[..., 0]], axis=1)
        J = np.concatenate([axes @ R @ J_b[:, :3], back @ log_rate(phi) @ J_b[:, 3:]], axis=1)
        over = np.abs(e) > like.tolerance
        return np.where(over, e - np.clip(e, -like.tolerance, like.tolerance), 0.0), J * (
            over | (like.tolerance == 0.0)
        )[..., None]
    e, J = (np.swapaxes(R, 1, 2) @ offset)[..., 0], J_b[:, :3]
    if isinstance(like, Pose):
        E = turned @ R
        spin = 0.5 * np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
        return np.concatenate([e, spin], axis=1), J_b
    if isinstance(like, Approach):
        wanted = (np.swapaxes(R, 1, 2) @ ideal[:, :3, :3] @ like.axis[:, None])[..., 0]
        spin = np.cross(wanted, like.axis) @ like.across.T
        return np.concatenate([e, spin], axis=1), np.concatenate([J, like.across @ J_b[:, 3:]], axis=1)
    return e, J


def branches(arm: Arm, target: AnyTarget, near: Array, tolerances: Tolerances = USUAL) -> Array:
    """Return configurations (b, n) that meet the target, b ≥ 0, nearest to `near` (n,) first.

    The closed form of the arm's family gives them, with random values for free joints. Without a closed form, or for a
    continuous family, searches from random starts find them. Of close answers the nearest stays. Joints with room for
    whole turns give all their windings. Tolerances are used if no configuration meets the target exactly.
    """
    starts = np.vstack([near, arm.random_theta(SEED, MANY)])
    found, all_found = _by_closed_form(arm, target, starts)
    if not all_found:
        searches = searched(arm, [target] * len(starts), starts, ALL_BUT_EXACT).solutions
        found = np.vstack([_nearest(arm, target, near), found, searches])
    if not len(found):
        found = searched(arm, [target] * len(starts), starts, tolerances).solutions
    found = joint_ranges(arm).wrapped(found, near)
    return _in_order(_windings(arm, _distinct(_in_order(found, near))), near)


def _by_closed_form(arm: Arm, target: AnyTarget, starts: Array) -> tuple[Array, bool]:
    """Return configurations (k, n), and whether nothing is left to search for.

    Held joints take their values from `starts`. Of more than `MANY` the nearest half stays, and others evenly.
    """
    method = method_for(arm, target, families_alone=True)
    if method.core is None:
        return starts[:0], False
    held = list(method.held)
    values = np.ascontiguousarray(starts[: None if method.sampled else FREE_VALUES, held]) if held else None
    found = Configurations(*answered(method.core.solve(target.numbers, np.array(starts[0]), values, EXACT, EXACT)))
    theta, moving = found.theta[: found.inside], found.moves[: found.inside]
    moving[:, held] = False
    if len(theta) > MANY:
        theta = theta[np.append(np.arange(MANY // 2), np.linspace(MANY // 2, len(theta) - 1, MANY // 2).astype(int))]
    if held:
        theta = np.vstack([_nearest(arm, target, starts[0]), theta])
    return theta, not found.left and not moving.any()


def _nearest(arm: Arm, target: AnyTarget, near: Array) -> Array:
    """Return the configuration nearest to `near` that meets the target, (1, n), or none."""
    return searched(arm, [target], near[None], ALL_BUT_EXACT, restarts=100, posture="theta0").solutions


def _in_order(thetas: Array, near: Array) -> Array:
    """Sort configurations, nearest first."""
    return thetas[np.argsort(np.linalg.norm(thetas - near, axis=1), kind="stable")]


def _distinct(thetas: Array) -> Array:
    """Drop configurations close to an earlier one."""
    left = thetas
    kept: list[Array] = []
    while len(left):
        kept.append(left[0])
        left = left[np.abs(left - left[0]).max(axis=1) > DISTINCT]
    return np.array(kept).reshape(-1, thetas.shape[1])


def _windings(arm: Arm, thetas: Array) -> Array:
    """Add each configuration with one joint a whole turn on or back, inside its limits."""
    more = [thetas]
    for joint, unit in enumerate(arm.units):
        if unit != "rad" or not np.isfinite(arm.limits.upper[joint] - arm.limits.lower[joint]):
            continue
        for turn in (-2.0 * np.pi, 2.0 * np.pi):
            turned = thetas.copy()
            turned[:, joint] += turn
            more.append(turned[arm.limits.contains(turned)])
    return np.vstack(more)
