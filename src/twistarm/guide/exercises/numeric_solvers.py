"""Exercises on numeric inverse kinematics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import body_columns, inverted, pose_log
from .instances import TIMES, angle, chain, own_chain, pose
from .words import ANGULAR_FIRST


def pose_error(g: Array, target: Array) -> Array:
    """The error twist (v, ω), (6,), from the pose `g` (4, 4) to `target` (4, 4), in tool coordinates.

    It is the logarithm of g⁻¹ g_target. Use `screws.log` after `from twistarm import screws`.
    """
    from twistarm import screws

    return screws.log(screws.inverse(g) @ target)


def newton_step(l1: float, l2: float, theta: Array, target: Array) -> Array:
    """The configuration (2,) of the two-link arm after one step of Newton's method from `theta` (2,) [rad].

    The tip shall come to the position `target` (2,) [m]. `theta[1]` is measured from the first link. Whole turns do not
    count.
    """
    t1, t12 = theta[0], theta[0] + theta[1]
    tip = np.array([l1 * np.cos(t1) + l2 * np.cos(t12), l1 * np.sin(t1) + l2 * np.sin(t12)])
    J = np.array([[-tip[1], -l2 * np.sin(t12)], [tip[0], l2 * np.cos(t12)]])
    after: Array = theta + np.linalg.solve(J, target - tip)
    return after


def damped_step(J: Array, error: Array, damping: float) -> Array:
    """The step (n,) of damped least squares for the Jacobian `J` (6, n) and the error twist `error` (6,).

    It minimises ‖J Δ − error‖² + damping² ‖Δ‖².
    """
    step: Array = J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(6), error)
    return step


def approach_step(J_b: Array, error: Array) -> Array:
    """The shortest step (n,) towards an approach: the tool may turn freely about its own z axis.

    `J_b` (6, n) is the body Jacobian and `error` (6,) the error seen from the tool. Both have the rows (v_x, v_y, v_z,
    ω_x, ω_y, ω_z). Leave out what need not be met, and take np.linalg.pinv of the rest.
    """
    step: Array = np.linalg.pinv(J_b[:5]) @ error[:5]
    return step


def _two_poses(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng), pose(rng)) for _ in range(TIMES))


def _planar(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        l1, l2 = rng.uniform(0.2, 0.6, 2)
        theta = np.array([angle(rng), float(rng.uniform(0.5, 2.5))])
        yield float(l1), float(l2), theta, rng.uniform(-0.4, 0.4, 2)


def _jacobians(rng: np.random.Generator, arm: Arm) -> Iterator[Array]:
    yield from (body_columns(*chain(rng)) for _ in range(TIMES))
    yield from (body_columns(*own_chain(rng, arm)) for _ in range(3))


def _damped(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((J, rng.normal(size=6), float(rng.uniform(0.1, 0.6))) for J in _jacobians(rng, arm))


def _approaching(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Away from singularities, where least squares by any way agree."""
    for J in _jacobians(rng, arm):
        values = np.linalg.svd(J[:5], compute_uv=False)
        if values[-1] > 1e-3 * values[0]:
            yield J, rng.normal(size=6)
    yield rng.normal(size=(6, 5)), rng.normal(size=6)
    yield rng.normal(size=(6, 6)), rng.normal(size=6)
    yield rng.normal(size=(6, 4)), rng.normal(size=6)


def _newton(l1: float, l2: float, theta: Array, target: Array) -> Array:
    """The two equations of the step, solved by Cramer's rule; det J = l1 l2 sin θ₂."""
    a, b = np.exp(1j * theta[0]), np.exp(1j * (theta[0] + theta[1]))
    miss = complex(*target) - l1 * a - l2 * b
    first, second = 1j * (l1 * a + l2 * b), 1j * l2 * b

    def determinant(p: complex, q: complex) -> float:
        return p.real * q.imag - p.imag * q.real

    whole = l1 * l2 * np.sin(theta[1])
    return np.array(theta + np.array([determinant(miss, second), determinant(first, miss)]) / whole)


def _stacked(J: Array, error: Array, damping: float) -> Array:
    """The same least squares problem with the damping as extra rows."""
    n = J.shape[1]
    rows = np.vstack([J, damping * np.eye(n)])
    return np.array(np.linalg.lstsq(rows, np.concatenate([error, np.zeros(n)]), rcond=None)[0])


def _turned_to(theta: Array, *_: Any) -> Array:
    """The directions of the joints: whole turns make no difference."""
    return np.array([np.cos(theta), np.sin(theta)])


def _error(g: Array, target: Array) -> Array:
    return pose_log(inverted(g) @ target)


EXERCISES = (
    Exercise(
        pose_error,
        _error,
        _two_poses,
        (
            Slip(
                "reversed",
                "You have the way from the target to the tool: g_target⁻¹ g. The arm would move away from its target.",
                {"screws.inverse(g) @ target": "screws.inverse(target) @ g"},
            ),
            Slip(
                "spatial for body",
                "This is the error seen from the base, g_target g⁻¹. Seen from the tool, as the body "
                "Jacobian needs it, the inverse stands on the left: g⁻¹ g_target.",
                {"screws.inverse(g) @ target": "target @ screws.inverse(g)"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"screws.log(": "np.roll(screws.log(", "@ target)": "@ target), 3)"}),
            Slip(
                "difference for v",
                "Your v is the difference of the positions in the tool's axes. The logarithm's v is that "
                "of a screw that turns on its way: take the logarithm of the whole pose.",
                {
                    "return screws.log(screws.inverse(g) @ target)": "h = screws.inverse(g) @ target\n    return "
                    "np.concatenate([h[:3, 3], screws.log(h)[3:]])"
                },
            ),
            Slip(
                "difference in space",
                "Your v is the difference of the positions in the base's axes: the body Jacobian speaks of the tool's.",
                {
                    "return screws.log(screws.inverse(g) @ target)": "return np.concatenate([target[:3, 3] - g[:3, "
                    "3], screws.log(screws.inverse(g) @ target)[3:]])"
                },
            ),
            Slip(
                "all in base axes",
                "Your error is the difference of the positions and the turn, both in the base's axes: that goes with "
                "the hybrid Jacobian. The body Jacobian needs log(g⁻¹ g_target), whose turn is in the tool's axes.",
                {
                    "return screws.log(screws.inverse(g) @ target)": "return np.concatenate([target[:3, 3] - g[:3, "
                    "3], screws.log(target @ screws.inverse(g))[3:]])"
                },
            ),
            Slip(
                "matrix",
                "This is the motion itself, a pose: take its logarithm, the twist (6,).",
                {"screws.log(screws.inverse(g) @ target)": "screws.inverse(g) @ target"},
            ),
        ),
        tolerance=1e-5,
    ),
    Exercise(
        newton_step,
        _newton,
        _planar,
        (
            Slip(
                "step back",
                "The step goes the wrong way: the miss is target − tip, and the step is added.",
                {"target - tip": "tip - target"},
            ),
            Slip(
                "Jacobian transposed",
                "You solve with Jᵀ: its rows are x and y, a column for each joint. (Jᵀ alone is gradient descent.)",
                {"np.linalg.solve(J,": "np.linalg.solve(J.T,"},
            ),
            Slip(
                "transpose for inverse",
                "You multiply by Jᵀ, a step of gradient descent. Newton's step solves J Δ = target − tip.",
                {"np.linalg.solve(J, target - tip)": "J.T @ (target - tip)"},
            ),
            Slip(
                "sign in the first row",
                "The derivative of the cosine is minus the sine: the first row of J is negative.",
                {"[-tip[1], -l2 * np.sin(t12)]": "[tip[1], l2 * np.sin(t12)]"},
            ),
            Slip("step alone", "You return the step alone: add it to theta.", {"theta + np.linalg": "np.linalg"}),
            Slip(
                "half a step",
                "You go half of the way: Newton's step is Δ itself.",
                {"theta + np.linalg": "theta + 0.5 * np.linalg"},
            ),
            Slip(
                "degrees in the step",
                "The step is turned into degrees before it is added. The Jacobian is per radian, so that Δ is in "
                "radians, as theta is.",
                {"theta + np.linalg": "theta + 180 / np.pi * np.linalg"},
            ),
            Slip(
                "second angle from the x axis",
                "Your second link points at theta[1]; it is measured from the first link, so it points at "
                "theta[0] + theta[1].",
                {"theta[0] + theta[1]": "theta[1]", "[-tip[1],": "[-l1 * np.sin(t1),", "[tip[0],": "[l1 * np.cos(t1),"},
            ),
            Slip(
                "first column without the second link",
                "The first joint moves the whole arm: its column holds the derivative of both links, "
                "(−y, x) of the tip.",
                {"[-tip[1], -l2": "[-l1 * np.sin(t1), -l2", "[tip[0], l2 *": "[l1 * np.cos(t1), l2 *"},
            ),
        ),
        seen=_turned_to,
    ),
    Exercise(
        damped_step,
        _stacked,
        _damped,
        (
            Slip(
                "damping not squared",
                "You add the damping itself. The minimised sum has damping² ‖Δ‖², so the matrix has λ².",
                {"damping**2": "damping"},
            ),
            Slip(
                "identity forgotten",
                "You add the number λ² to every entry of J Jᵀ. It belongs on the diagonal alone: λ² {eye}(6).",
                {"damping**2 * np.eye(6)": "damping**2"},
            ),
            Slip(
                "damping missing",
                "There is no damping in your step: near a singularity it becomes enormous. Add λ² I before you solve.",
                {"J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(6), error)": "np.linalg.pinv(J) @ error"},
            ),
            Slip(
                "damping to the fourth", "The damping is squared twice: λ² I is enough.", {"damping**2": "damping**4"}
            ),
            Slip(
                "transpose alone",
                "You take Jᵀ alone, a step of gradient descent without its length: solve with J Jᵀ + λ² I.",
                {"np.linalg.solve(J @ J.T + damping**2 * np.eye(6), error)": "error"},
            ),
            Slip(
                "step back", "The step has the wrong sign: the error is what is still to go.", {"J.T @ np": "-J.T @ np"}
            ),
            Slip(
                "damping subtracted",
                "The damping is subtracted: that makes singularities worse. Add λ² I.",
                {"+ damping**2": "- damping**2"},
            ),
        ),
        tolerance=1e-5,
    ),
    Exercise(
        approach_step,
        lambda J, e: np.linalg.lstsq(J[[0, 1, 2, 3, 4]], e[[0, 1, 2, 3, 4]], rcond=None)[0],
        _approaching,
        (
            Slip(
                "nothing left out",
                "All six rows are still there: an arm with five joints cannot meet them, and misses all of them a "
                "little. Leave out ω_z, the last row.",
                {"J_b[:5]": "J_b", "error[:5]": "error"},
            ),
            Slip(
                "v_x left out",
                "You leave out v_x, the first row. The turn about the tool's z axis is free: ω_z, the last row.",
                {"J_b[:5]": "J_b[1:]", "error[:5]": "error[1:]"},
            ),
            Slip(
                "column left out",
                "You leave out a column of J_b, which is a joint. What need not be met is a number of the error: "
                "leave out a row.",
                {"np.linalg.pinv(J_b[:5]) @ error[:5]": "np.linalg.pinv(J_b[:, :5]) @ error"},
            ),
            Slip(
                "v_z left out",
                "You leave out v_z, the third row: that is where ω_z stands in twists (ω, v). Here it is the last.",
                {"J_b[:5]": "np.delete(J_b, 2, axis=0)", "error[:5]": "np.delete(error, 2)"},
            ),
            Slip(
                "ω_x left out",
                "You leave out ω_x, the fourth row; the tool's z axis is that of ω_z, the last row.",
                {"J_b[:5]": "np.delete(J_b, 3, axis=0)", "error[:5]": "np.delete(error, 3)"},
            ),
            Slip(
                "position alone",
                "You keep the position alone: the tool's direction is to be met as well, ω_x and ω_y.",
                {"J_b[:5]": "J_b[:3]", "error[:5]": "error[:3]"},
            ),
            Slip(
                "set to zero",
                "You set the error in ω_z to 0 instead of leaving its row out: the tool is then held from turning.",
                {"np.linalg.pinv(J_b[:5]) @ error[:5]": "np.linalg.pinv(J_b) @ np.append(error[:5], 0.0)"},
            ),
        ),
        tolerance=1e-5,
    ),
)
