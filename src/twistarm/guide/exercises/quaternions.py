"""Exercises on quaternions, (w, x, y, z)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import scipy_rotation
from .instances import TIMES, angle, unit
from .words import DEGREES

XYZW = (
    "Your quaternion has its scalar part last, (x, y, z, w), as SciPy, ROS and Pinocchio have it. In the guide w comes "
    "first."
)


def multiply(P: Array, Q: Array) -> Array:
    """The product P Q of two quaternions (w, x, y, z), (4,): i i = j j = k k = −1, i j = k, j k = i, k i = j."""
    p, q = P[1:], Q[1:]
    return np.array([P[0] * Q[0] - p @ q, *(P[0] * q + Q[0] * p + np.cross(p, q))])


def inverse_quaternion(Q: Array) -> Array:
    """The quaternion with Q Q⁻¹ = (1, 0, 0, 0). `Q` is (w, x, y, z) of any length but 0."""
    conjugate = np.array([Q[0], -Q[1], -Q[2], -Q[3]])
    return conjugate / (Q @ Q)


def from_axis_angle(w: Array, theta: float) -> Array:
    """The unit quaternion (w, x, y, z) of the turn by `theta` [rad] about the axis `w` (3,), which has any length.

    Q and −Q are the same rotation: either is right.
    """
    u = w / np.linalg.norm(w)
    return np.array([np.cos(theta / 2), *(np.sin(theta / 2) * u)])


def rotate(Q: Array, p: Array) -> Array:
    """The point `p` (3,) turned by the quaternion `Q` (w, x, y, z): the vector part of Q (0, p) Q⁻¹.

    `Q` need not have the length 1.
    """
    Q = Q / np.linalg.norm(Q)
    q = Q[1:]
    t = 2.0 * np.cross(q, p)
    turned: Array = p + Q[0] * t + np.cross(q, t)
    return turned


def _two(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rng.normal(size=4), rng.normal(size=4)) for _ in range(TIMES))


def _one(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rng.normal(size=4),) for _ in range(TIMES))
    yield (np.array([1.0, 2.0, 3.0, 4.0]),)


def _axis_and_angle(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((unit(rng) * rng.uniform(0.5, 3.0), angle(rng)) for _ in range(TIMES))
    yield from ((unit(rng), angle(rng)) for _ in range(2))


def _and_point(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rng.normal(size=4), rng.normal(size=3)) for _ in range(TIMES))
    yield (np.array([0.6, 0.0, 0.8, 0.0]), np.array([1.0, 0.0, 0.0]))


def _left(P: Array) -> Array:
    """The matrix of Q ↦ P Q: quaternions as 2 × 2 complex matrices, Q = [w + ix, y + iz; −y + iz, w − ix]."""

    def complex_of(A: Array) -> Any:
        w, x, y, z = A
        return np.array([[w + 1j * x, y + 1j * z], [-y + 1j * z, w - 1j * x]])

    def row(A: Array) -> Array:
        M = complex_of(P) @ complex_of(A)
        return np.array([M[0, 0].real, M[0, 0].imag, M[0, 1].real, M[0, 1].imag])

    return np.column_stack([row(e) for e in np.eye(4)])


def _scipy_of(Q: Array) -> Any:
    return scipy_rotation().from_quat(np.roll(Q, -1))


def _up_to_sign(Q: Array, *_: Any) -> Array:
    return np.outer(Q, Q)


EXERCISES = (
    Exercise(
        multiply,
        lambda P, Q: _left(P) @ Q,
        _two,
        (
            Slip(
                "order reversed",
                "This is Q P. Quaternions do not commute: the order shows in the cross product, which is p × q.",
                {"np.cross(p, q)": "np.cross(q, p)"},
            ),
            Slip(
                "no cross product",
                "The cross product p × q is missing in the vector part: i j = k comes from it.",
                {" + np.cross(p, q)": ""},
            ),
            Slip(
                "sign of the scalar part",
                "The scalar part is w₁w₂ − p · q: i i = −1 makes the minus.",
                {"P[0] * Q[0] - p @ q": "P[0] * Q[0] + p @ q"},
            ),
            Slip(
                "xyzw",
                XYZW,
                {
                    "p, q = P[1:], Q[1:]": "p, q = P[:3], Q[:3]",
                    "[P[0] * Q[0] - p @ q, *(P[0] * q + Q[0] * p + "
                    "np.cross(p, q))]": "[*(P[3] * q + Q[3] * p + np.cross(p, q)), P[3] * Q[3] - p @ q]",
                },
            ),
            Slip(
                "number by number",
                "You multiply number by number (P * Q). The product of quaternions follows i j = k: scalar part "
                "w₁w₂ − p · q, vector part w₁q + w₂p + p × q.",
                {"return np.array([P[0] * Q[0] - p @ q, *(P[0] * q + Q[0] * p + np.cross(p, q))])": "return P * Q"},
            ),
        ),
    ),
    Exercise(
        inverse_quaternion,
        lambda Q: np.linalg.solve(_left(Q), [1.0, 0.0, 0.0, 0.0]),
        _one,
        (
            Slip(
                "only the conjugate",
                "The conjugate is the inverse of unit quaternions alone: Q Q* = ‖Q‖². Divide by ‖Q‖².",
                {" / (Q @ Q)": ""},
            ),
            Slip(
                "norm not squared",
                "You divide by ‖Q‖, but Q Q* is ‖Q‖², so it takes the square. With unit quaternions the "
                "slip hides: try (1, 2, 3, 4).",
                {"(Q @ Q)": "np.linalg.norm(Q)"},
            ),
            Slip(
                "norm to the fourth",
                "You divide by ‖Q‖⁴: the guide calls ‖Q‖ what is ‖Q‖² = Q Q*, and squares it once more. Divide by Q Q* "
                "once; Q Q⁻¹ for (1, 2, 3, 4) is 1 then and not 1/30.",
                {"(Q @ Q)": "(Q @ Q) ** 2"},
            ),
            Slip(
                "scalar part negated",
                "The conjugate keeps w and negates the vector part; here w is negated too, or instead.",
                {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[-Q[0], Q[1], Q[2], Q[3]]"},
            ),
            Slip("xyzw", XYZW, {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[-Q[0], -Q[1], -Q[2], Q[3]]"}),
            Slip(
                "number by number",
                "You invert each number by itself (1 / Q): the inverse is Q* / ‖Q‖².",
                {"conjugate / (Q @ Q)": "1.0 / Q"},
            ),
        ),
    ),
    Exercise(
        from_axis_angle,
        lambda w, theta: np.roll(scipy_rotation().from_rotvec(w / np.sqrt(w @ w) * theta).as_quat(), 1),
        _axis_and_angle,
        (
            Slip(
                "whole angle",
                "You take the cosine and sine of θ; a quaternion has those of θ/2, because it stands on "
                "both sides of the point, Q p Q⁻¹. Yours turns twice as far.",
                {"theta / 2": "theta"},
            ),
            Slip(
                "axis not normalised",
                "The axis has another length than 1 here, and so has your quaternion. Divide by its length before.",
                {"w / np.linalg.norm(w)": "w"},
            ),
            Slip("degrees", DEGREES, {"theta / 2": "np.radians(theta) / 2"}),
            Slip(
                "xyzw",
                XYZW,
                {"[np.cos(theta / 2), *(np.sin(theta / 2) * u)]": "[*(np.sin(theta / 2) * u), np.cos(theta / 2)]"},
            ),
            Slip(
                "sine for cosine",
                "Sine and cosine have changed places: no turn at all is (1, 0, 0, 0), so the scalar part is cos θ/2.",
                {"[np.cos(theta / 2), *(np.sin(theta / 2) * u)]": "[np.sin(theta / 2), *(np.cos(theta / 2) * u)]"},
            ),
            Slip(
                "other way",
                "This turns the other way: the vector part is +ω sin θ/2. A minus makes the conjugate, the inverse.",
                {"*(np.sin(theta / 2) * u)": "*(-np.sin(theta / 2) * u)"},
            ),
        ),
        seen=_up_to_sign,
    ),
    Exercise(
        rotate,
        lambda Q, p: _scipy_of(Q).apply(p),
        _and_point,
        (
            Slip("xyzw", XYZW, {"q = Q[1:]": "q = Q[:3]", "Q[0] * t": "Q[3] * t"}),
            Slip(
                "inverse rotation",
                "The point is turned the other way: Q stands on the left and Q⁻¹ on the right, Q (0, p) Q⁻¹. Yours is "
                "Q⁻¹ (0, p) Q.",
                {"q = Q[1:]": "q = -Q[1:]"},
            ),
            Slip(
                "not normalised",
                "Q has another length than 1 here, and the point grows by ‖Q‖². The inverse is Q* / "
                "‖Q‖², not Q* alone; or normalise Q first.",
                {
                    "    Q = Q / np.linalg.norm(Q)\n": "",
                    "p + Q[0] * t + np.cross(q, t)": "(Q[0] ** 2 - q @ q) * p + 2.0 * (q @ p) * q + Q[0] * t",
                },
            ),
            Slip(
                "formula of unit quaternions",
                "Your formula holds for ‖Q‖ = 1, and Q has another length here: divide Q by its length first.",
                {"    Q = Q / np.linalg.norm(Q)\n": ""},
            ),
            Slip(
                "only one side",
                "You take the vector part of Q (0, p) alone, which is no rotation. Multiply by Q⁻¹ on "
                "the right as well.",
                {"turned: Array = p + Q[0] * t + np.cross(q, t)": "turned: Array = Q[0] * p + np.cross(q, p)"},
            ),
        ),
    ),
)
