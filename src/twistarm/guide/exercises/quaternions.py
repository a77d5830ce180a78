"""Exercises on quaternions, (w, x, y, z)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import scipy_rotation
from .instances import TIMES, angle, unit
from .words import DEGREES

XYZW = (
    "Your quaternion has its scalar part last, (x, y, z, w), as SciPy, ROS and Pinocchio have it. In the course w "
    "comes first."
)


def multiply(Q1: Array, Q2: Array) -> Array:
    """The product Q₁ Q₂ of two quaternions (w, x, y, z), (4,).

    The rules are i i = j j = k k = −1, i j = k, j k = i, k i = j.
    """
    v1, v2 = Q1[1:], Q2[1:]
    return np.array([Q1[0] * Q2[0] - v1 @ v2, *(Q1[0] * v2 + Q2[0] * v1 + np.cross(v1, v2))])


def inverse_quaternion(Q: Array) -> Array:
    """The quaternion with Q Q⁻¹ = (1, 0, 0, 0). `Q` is (w, x, y, z) of any length but 0."""
    conjugate = np.array([Q[0], -Q[1], -Q[2], -Q[3]])
    return conjugate / (Q @ Q)


def from_axis_angle(axis: Array, theta: float) -> Array:
    """The unit quaternion (w, x, y, z) of the turn by `theta` [rad] about `axis` (3,).

    The axis may have any length but 0. Only its direction matters. Q and −Q are the same rotation: either is right.
    """
    u = axis / np.linalg.norm(axis)
    return np.array([np.cos(theta / 2), *(np.sin(theta / 2) * u)])


def rotate(Q: Array, p: Array) -> Array:
    """The point `p` (3,) turned by the quaternion `Q` (w, x, y, z).

    It is the vector part of Q (0, p) Q⁻¹.

    `Q` need not have the length 1.
    """
    Q = Q / np.linalg.norm(Q)
    v = Q[1:]
    t = 2.0 * np.cross(v, p)
    turned: Array = p + Q[0] * t + np.cross(v, t)
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
    """The matrix of Q ↦ P Q, by the complex matrices Q = [w + ix, y + iz; −y + iz, w − ix]."""

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
        lambda Q1, Q2: _left(Q1) @ Q2,
        _two,
        (
            Slip(
                "order reversed",
                "This is Q₂ Q₁. Quaternions do not commute: the order shows in the cross product, which is v₁ × v₂.",
                {"np.cross(v1, v2)": "np.cross(v2, v1)"},
            ),
            Slip(
                "no cross product",
                "The cross product v₁ × v₂ is missing in the vector part: i j = k comes from it.",
                {" + np.cross(v1, v2)": ""},
            ),
            Slip(
                "sign of the scalar part",
                "The scalar part is w₁w₂ − v₁ · v₂: i i = −1 makes the minus.",
                {"Q1[0] * Q2[0] - v1 @ v2": "Q1[0] * Q2[0] + v1 @ v2"},
            ),
            Slip(
                "xyzw",
                XYZW,
                {
                    "v1, v2 = Q1[1:], Q2[1:]": "v1, v2 = Q1[:3], Q2[:3]",
                    "[Q1[0] * Q2[0] - v1 @ v2, *(Q1[0] * v2 + Q2[0] * v1 + "
                    "np.cross(v1, v2))]": "[*(Q1[3] * v2 + Q2[3] * v1 + np.cross(v1, v2)), Q1[3] * Q2[3] - v1 @ v2]",
                },
            ),
            Slip(
                "number by number",
                "You multiply number by number (Q1 * Q2). The product of quaternions follows i j = k: scalar part "
                "w₁w₂ − v₁ · v₂, vector part w₁v₂ + w₂v₁ + v₁ × v₂.",
                {
                    "return np.array([Q1[0] * Q2[0] - v1 @ v2, "
                    "*(Q1[0] * v2 + Q2[0] * v1 + np.cross(v1, v2))])": "return Q1 * Q2"
                },
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
                "You divide by ‖Q‖⁴: Q Q* is the square of the length already. Divide by it once; Q Q⁻¹ for (1, 2, 3, "
                "4) is 1 then and not 1/30.",
                {"(Q @ Q)": "(Q @ Q) ** 2"},
            ),
            Slip(
                "scalar part negated",
                "The conjugate keeps w and negates the vector part; here w is negated too, or instead.",
                {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[-Q[0], Q[1], Q[2], Q[3]]"},
            ),
            Slip("xyzw", XYZW, {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[-Q[0], -Q[1], -Q[2], Q[3]]"}),
            Slip(
                "not conjugated",
                "You divide by ‖Q‖² and keep the signs: the vector part of the inverse is negated, Q* / ‖Q‖².",
                {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[Q[0], Q[1], Q[2], Q[3]]"},
            ),
            Slip(
                "all negated",
                "You negate all four numbers. The conjugate keeps the scalar part and negates the vector part alone.",
                {"[Q[0], -Q[1], -Q[2], -Q[3]]": "[-Q[0], -Q[1], -Q[2], -Q[3]]"},
            ),
            Slip(
                "number by number",
                "You invert each number by itself (1 / Q): the inverse is Q* / ‖Q‖².",
                {"conjugate / (Q @ Q)": "1.0 / Q"},
            ),
        ),
    ),
    Exercise(
        from_axis_angle,
        lambda axis, theta: np.roll(scipy_rotation().from_rotvec(axis / np.sqrt(axis @ axis) * theta).as_quat(), 1),
        _axis_and_angle,
        (
            Slip(
                "whole angle",
                "You take the cosine and sine of θ; a quaternion has those of θ/2, because it stands on "
                "both sides of the point, Q (0, p) Q⁻¹. Yours turns twice as far.",
                {"theta / 2": "theta"},
            ),
            Slip(
                "axis not normalised",
                "The axis has another length than 1 here, and so has your quaternion. Divide by its length before.",
                {"axis / np.linalg.norm(axis)": "axis"},
            ),
            Slip("degrees", DEGREES, {"theta / 2": "np.radians(theta) / 2"}),
            Slip(
                "length taken for a part of the angle",
                "You turn by θ times the length of the axis, as `rodrigues` of the next lesson does. Here only the "
                "direction of the axis counts: turn by θ.",
                {"theta / 2": "theta * np.linalg.norm(axis) / 2"},
            ),
            Slip(
                "all four divided",
                "You divide the whole quaternion by its length, (cos θ/2, ω sin θ/2) with ω of another length. The "
                "result has the length 1, but another angle. Divide the axis by its length first.",
                {
                    "u = axis / np.linalg.norm(axis)": "u = axis",
                    "return np.array([np.cos(theta / 2), *(np.sin(theta / 2) * u)])": "Q = "
                    "np.array([np.cos(theta / 2), *(np.sin(theta / 2) * u)])\n    return Q / np.linalg.norm(Q)",
                },
            ),
            Slip(
                "whole angle, xyzw",
                "Two slips: you take θ where a quaternion has θ/2, and your scalar part stands last, (x, y, z, w). In "
                "the course w comes first.",
                {"[np.cos(theta / 2), *(np.sin(theta / 2) * u)]": "[*(np.sin(theta) * u), np.cos(theta)]"},
            ),
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
            Slip("xyzw", XYZW, {"v = Q[1:]": "v = Q[:3]", "Q[0] * t": "Q[3] * t"}),
            Slip(
                "inverse rotation",
                "The point is turned the other way: Q stands on the left and Q⁻¹ on the right, Q (0, p) Q⁻¹. Yours is "
                "Q⁻¹ (0, p) Q.",
                {"v = Q[1:]": "v = -Q[1:]"},
            ),
            Slip(
                "not normalised",
                "Q has another length than 1 here, and the point grows by ‖Q‖². The inverse is Q* / "
                "‖Q‖², not Q* alone; or normalise Q first.",
                {
                    "    Q = Q / np.linalg.norm(Q)\n": "",
                    "p + Q[0] * t + np.cross(v, t)": "(Q[0] ** 2 - v @ v) * p + 2.0 * (v @ p) * v + Q[0] * t",
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
                {"turned: Array = p + Q[0] * t + np.cross(v, t)": "turned: Array = Q[0] * p + np.cross(v, p)"},
            ),
            Slip(
                "norm not squared",
                "The point grows by ‖Q‖: your inverse is Q* / ‖Q‖, and it takes the square, Q* / ‖Q‖².",
                {
                    "Q = Q / np.linalg.norm(Q)": "length = np.linalg.norm(Q)\n    Q = Q / length",
                    "turned: Array = p + Q[0] * t + np.cross(v, t)": "turned: Array = length * "
                    "(p + Q[0] * t + np.cross(v, t))",
                },
            ),
            Slip(
                "scalar part left",
                "The numbers are right, but the scalar part of Q (0, p) Q⁻¹, which is 0, still stands before them: "
                "leave it out, as in Q[1:].",
                {"return turned": "return np.array([0.0, *turned])"},
            ),
        ),
    ),
)
