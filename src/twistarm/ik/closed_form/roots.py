"""Candidates made into answers: corrected by forward kinematics, verified, brought inside the limits, compared."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arm.arm import Arm
from ...support.checks import Array
from ..ranges import TURN, joint_ranges
from ..targets import AnyTarget
from ..task_space import Tolerances

STEPS = 30  # Newton steps for a candidate. Exact ones need one or two, those of a nearby arm four or five.
LONGEST_STEP = 0.3  # Longest Newton step [rad, m]. A candidate farther from an answer is dropped.
FK_ROUNDING = 1e-14  # Errors [m, rad] below this are those of forward kinematics itself.
SINGULAR_RATIO = 1e-12  # Relative singular values below this are 0. Newton's step does not use those directions.
DEPENDENT = 1e-6  # Relative singular values below this are directions without first-order motion.
# Two candidates nearer together than this [rad, m] are one if the target is reached equally well halfway.
SAME = 1e-5
# Two answers nearer together than this [rad, m] are one if the target is reached to the tolerances halfway.
TWINS = 1e-2
HALFWAY = 1e-13  # Or to this precision [m, rad].
# An answer beyond a limit by less than this [rad, m] may be at the limit: multiple roots are no more exact.
ROUNDED_LIMIT = 1e-5
LEAST_ROUNDED = 1e-11  # Below this excess [rad, m] the target is reached at the limit as well.
# Greatest error of a family's members [m, rad], and the greatest if the first member has it too.
MEMBER_MISS, MAX_MEMBER_MISS = 1e-12, 1e-10
SIDESTEP = 0.05  # Step [rad, m] along a singular direction. If an answer exists there too, a family begins.

MOST_COPIES = 4096


@dataclass(frozen=True, eq=False)
class Root:
    """An answer theta (n,), with angles in any turn, and the joints free to move."""

    theta: Array
    free: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Task:
    """A target that an arm is to reach to tolerances."""

    arm: Arm
    target: AnyTarget
    tolerances: Tolerances

    def errors(self, theta: Array) -> tuple[float, float]:
        """The errors of forward kinematics at theta (n,): position [m] and orientation [rad]."""
        g = self.arm.fk(theta)
        return self.target.position_error(g), self.target.orientation_error(g)

    def converged(self, theta: Array) -> bool:
        """Whether forward kinematics reaches the target to the tolerances."""
        return self.tolerances.converged(*self.errors(theta))

    def rows(self, theta: Array) -> tuple[Array, Array]:
        """The error of theta (n,) from the target [m, rad] (k,), and its derivative (k, n)."""
        g, J_b = self.arm.fk_and_body_jacobian(theta)
        (e_p, J_p), (e_r, J_r) = self.target._position_rows(g, J_b), self.target._rotation_rows(g, J_b)
        return np.concatenate([e_p, e_r]), np.concatenate([J_p, J_r])

    def corrected(
        self, theta: Array, held: tuple[int, ...] = (), singular: float = SINGULAR_RATIO, enough: float = FK_ROUNDING
    ) -> Array:
        """theta (n,) after some of Newton's steps of least length, −J⁺ e, toward the target. `held` joints stay.

        No step is long in any of the directions that J distinguishes. Near a straight wrist one direction hardly moves
        the tool. The others still go all their way.
        """
        for _ in range(STEPS):
            error, J = self.rows(theta)
            if np.abs(error).max(initial=0.0) <= enough:
                break
            J[:, list(held)] = 0.0  # the step of least length then leaves these joints alone
            U, size, Vt = np.linalg.svd(J, full_matrices=False)
            there = size > singular * size.max(initial=0.0)
            theta = theta - np.clip((U.T @ error)[there] / size[there], -LONGEST_STEP, LONGEST_STEP) @ Vt[there]
        return theta

    def roots(self, candidates: Iterable[Array], held: tuple[int, ...], known: Sequence[Root]) -> list[Root]:
        """The different answers among the candidates that are not `known` yet, corrected and verified. `held` stay."""
        found: list[Root] = []
        for candidate in candidates:
            theta = self.corrected(np.array(candidate), held)
            if not self.converged(theta):
                continue
            if not self.known(theta, [*known, *found]):
                found.append(Root(theta, self.self_motion(theta, held)))
        return found

    def self_motion(self, theta: Array, held: tuple[int, ...] = ()) -> tuple[int, ...]:
        """The joints, beside those `held`, that move while the target stays reached.

        If more joints are left than independent rows, the null space is a family's tangent. All that it moves is free.
        Otherwise a direction in it only moves nothing at first. A step along it, corrected, may come back. If not, it
        is another answer of the family, provided it is as exact. A whole turn within the tolerances is exact enough.
        """
        solved = [i for i in range(self.arm.n) if i not in held]
        J = self.rows(theta)[1][:, solved]
        _, size, Vt = np.linalg.svd(J)
        rank = int((size > DEPENDENT * size.max(initial=1e-300)).sum())
        if rank == len(J) and np.abs(Vt[rank:]).max(axis=0, initial=0.0).min(initial=1.0) > DEPENDENT:
            return tuple(solved)
        moving: set[int] = set()
        alike = max(MEMBER_MISS, min(2.0 * max(self.errors(theta)), MAX_MEMBER_MISS))
        share = 0.5 * SIDESTEP
        loose = Tolerances(share * self.tolerances.position, share * self.tolerances.orientation)
        for direction in Vt[rank:]:
            step = np.zeros(self.arm.n)
            step[solved] = SIDESTEP * direction
            beside = self.corrected(theta + step, held, DEPENDENT)
            errors, moved = self.errors(beside), np.abs(beside - theta)
            if (max(errors) <= alike or loose.converged(*errors)) and np.linalg.norm(moved) > 0.5 * SIDESTEP:
                moving |= set(np.flatnonzero(moved > 1e-6).tolist())
        return tuple(sorted(moving))

    def may_be_inside(self, thetas: Array, near: Array) -> NDArray[np.bool_]:
        """Which of thetas (k, n) are inside the limits, or beyond them by no more than rounding, by whole turns."""
        moved = _nearest_copy(self.arm, thetas, near, ROUNDED_LIMIT)
        beyond = np.abs(np.clip(moved, self.arm.limits.lower, self.arm.limits.upper) - moved)
        return beyond.max(axis=-1, initial=0.0) <= ROUNDED_LIMIT

    def inside_limits(self, theta: Array, near: Array) -> Array | None:
        """theta (n,) by whole turns inside the limits, as near to `near` (n,) as possible. None where it is outside.

        A copy may pass a limit by the error of a multiple root. It is brought to the limit if the other joints can
        reach the target there too.
        """
        lower, upper = self.arm.limits.lower, self.arm.limits.upper
        # A copy within the first slack beyond a limit may miss the target there. Then only the second slack counts.
        for slack in (ROUNDED_LIMIT, LEAST_ROUNDED):
            moved = _nearest_copy(self.arm, theta, near, slack)
            clipped = np.clip(moved, lower, upper)
            if np.abs(clipped - moved).max(initial=0.0) > slack:
                return None
            still, before = clipped != moved, np.zeros(self.arm.n, dtype=np.bool_)
            while still.any() and not self.converged(clipped) and not np.array_equal(still, before):
                before, moved = still, self.corrected(clipped, tuple(np.flatnonzero(still).tolist()))
                clipped = np.clip(moved, lower, upper)
                still = still | (clipped != moved)
            if not still.any() or self.converged(clipped):
                return clipped
        return None

    def twin(self, theta: Array, others: Array) -> int | None:
        """The place of another answer (n,) that is one with theta (n,), or None."""
        if not len(others):
            return None
        left = joint_difference(self.arm, others, theta)
        near = np.flatnonzero(np.abs(left).max(axis=1, initial=0.0) <= TWINS)
        return next((int(i) for i in near if self.converged(theta + 0.5 * left[i])), None)

    def known(self, theta: Array, others: Sequence[Root]) -> bool:
        """Whether theta (n,) is one of the others."""
        if not others:
            return False
        left = joint_difference(self.arm, theta, np.array([other.theta for other in others]))
        for i in np.flatnonzero(np.abs(left).max(axis=1, initial=0.0) <= SAME):
            b = others[int(i)].theta
            here, halfway, there = (max(self.errors(x)) for x in (theta, b + 0.5 * left[i], b))
            if halfway <= max(HALFWAY, 2.0 * here, 2.0 * there):
                return True
        return False


def _nearest_copy(arm: Arm, theta: Array, near: Array, slack: float) -> Array:
    """theta (n,) by whole turns as near to `near` as limits and `slack` [rad, m] allow."""
    lowest = np.ceil((arm.limits.lower - slack - theta) / TURN)
    highest = np.floor((arm.limits.upper + slack - theta) / TURN)
    counts = np.maximum(np.minimum(np.round((near - theta) / TURN), highest), lowest)
    return np.where(joint_ranges(arm).periodic, theta + TURN * counts, theta)


def copies_inside(arm: Arm, theta: Array) -> Array:
    """All of theta's copies by whole turns inside the limits (k, n). Unbounded joints within a turn of 0."""
    lower = np.maximum(arm.limits.lower, np.where(np.isfinite(arm.limits.lower), arm.limits.lower, -TURN))
    upper = np.minimum(arm.limits.upper, np.where(np.isfinite(arm.limits.upper), arm.limits.upper, TURN))
    choices = []
    for value, low, high, turns in zip(theta, lower, upper, joint_ranges(arm).periodic, strict=True):
        first, last = np.ceil((low - value) / TURN), np.floor((high - value) / TURN)
        choices.append(value + TURN * np.arange(first, last + 1) if turns and last >= first else [value])
    return np.array(list(itertools.islice(itertools.product(*choices), MOST_COPIES)))


def joint_difference(arm: Arm, a: Array, b: Array) -> Array:
    """a − b (…, n), without whole turns."""
    return np.where(joint_ranges(arm).periodic, (a - b + np.pi) % TURN - np.pi, a - b)
