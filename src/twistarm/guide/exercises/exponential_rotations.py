"""Exercises on rotations as a group: exponential, logarithm, change of coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import crossing, expm, scipy_rotation
from .instances import TIMES, angle, rotation, unit
from .words import ACOS, DEGREES


def skew(w: Array) -> Array:
    """The matrix ŵ (3, 3) of the cross product with `w` (3,): ŵ q = w × q for every q."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def rodrigues(w: Array, theta: float) -> Array:
    """The rotation e^{ŵ θ} (3, 3), by Rodrigues' formula. `w` (3,) may have any length, 0 too: then it is the identity.

    The angle of the turn is ‖w‖ θ [rad].
    """
    length = np.linalg.norm(w)
    if length < 1e-12:
        return np.eye(3)
    x, y, z = w / length
    W = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = length * theta
    R: Array = np.eye(3) + W * np.sin(turn) + W @ W * (1.0 - np.cos(turn))
    return R


def rotation_log(R: Array) -> Array:
    """The rotation vector w (3,) with e^ŵ = R: its direction is the axis, its length the angle [rad], from 0 to below
    π.

    `R` comes out of a computer: its trace may be a hair above 3.
    """
    theta = np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0))
    if theta < 1e-6:
        return np.zeros(3)
    w = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    scaled: Array = theta * w / (2.0 * np.sin(theta))
    return scaled


def change_frame(R_ab: Array, R_bc: Array, q_c: Array) -> Array:
    """The coordinates q_a (3,) in frame A of the point that has `q_c` (3,) in C. The frames share their origin."""
    q_a: Array = R_ab @ R_bc @ q_c
    return q_a


def _vectors(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rng.normal(size=3),) for _ in range(TIMES))


def _axes(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((unit(rng) * rng.uniform(0.3, 2.0), angle(rng)) for _ in range(TIMES))
    yield from ((unit(rng), angle(rng)) for _ in range(2))
    yield np.zeros(3), 0.7


def _rotations(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((expm(crossing(unit(rng) * rng.uniform(0.2, 2.9))),) for _ in range(TIMES))
    yield (np.diag([1.0, 1.0, 1.0 + 4e-16]),)
    yield (np.eye(3),)


def _frames(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rotation(rng), rotation(rng), rng.normal(size=3)) for _ in range(TIMES))


EXERCISES = (
    Exercise(
        skew,
        lambda w: np.column_stack([np.cross(w, e) for e in np.eye(3)]),
        _vectors,
        (
            Slip(
                "transposed",
                "All signs are reversed: this matrix gives q × w. The first row is (0, −w₃, w₂).",
                {
                    "[[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], "
                    "[-w[1], w[0], 0.0]]": "[[0.0, w[2], -w[1]], [-w[2], 0.0, w[0]], [w[1], -w[0], 0.0]]"
                },
            ),
            Slip(
                "symmetric",
                "The matrix is symmetric; a cross product makes it skew: ŵᵀ = −ŵ, each number once with a minus.",
                {"-w[": "w["},
            ),
            Slip(
                "normalised",
                "You divide by the length of w: then the cross product has lost it. ŵ takes w as it is.",
                {"return np.array(": "w = w / np.linalg.norm(w)\n    return np.array("},
            ),
        ),
    ),
    Exercise(
        rodrigues,
        lambda w, theta: expm(crossing(w) * theta),
        _axes,
        (
            Slip(
                "not normalised",
                "The formula as it stands in the guide holds for ‖w‖ = 1. Here w has another length, and "
                "the answer is no rotation: divide w by its length, and multiply the angle by it.",
                {"x, y, z = w / length": "x, y, z = w", "turn = length * theta": "turn = theta"},
            ),
            Slip(
                "angle not scaled",
                "You divide w by its length but turn by θ: the length of w is part of the angle, ‖w‖ θ.",
                {"turn = length * theta": "turn = theta"},
            ),
            Slip("degrees", DEGREES, {"turn = length * theta": "turn = length * np.radians(theta)"}),
            Slip(
                "transposed",
                "This is the transpose, a turn by −θ: look at the signs of ŵ, whose first row is (0, −w₃, w₂).",
                {"return R": "return R.T"},
            ),
            Slip(
                "number by number",
                "You square ŵ number by number (`*` or `**`). The formula has the matrix product: W @ W.",
                {"W @ W": "W * W"},
            ),
            Slip(
                "no second term",
                "The term ŵ² (1 − cos θ) is missing: without it the answer is right for small angles alone.",
                {" + W @ W * (1.0 - np.cos(turn))": ""},
            ),
            Slip(
                "cosine alone",
                "The last term is ŵ² (1 − cos θ), yours ŵ² cos θ: at θ = 0 nothing may be left of it.",
                {"(1.0 - np.cos(turn))": "np.cos(turn)"},
            ),
            Slip(
                "sine for cosine",
                "Sine and cosine have changed places: I + ŵ sin θ + ŵ² (1 − cos θ).",
                {"W * np.sin(turn) + W @ W * (1.0 - np.cos(turn))": "W * np.cos(turn) + W @ W * (1.0 - np.sin(turn))"},
            ),
            Slip(
                "zero divided by zero",
                "For w = 0 you divide by its length, 0, and get NaN. No axis means no turn: return the identity there.",
                {"    if length < 1e-12:\n        return np.eye(3)\n": ""},
            ),
        ),
    ),
    Exercise(
        rotation_log,
        lambda R: scipy_rotation().from_matrix(R).as_rotvec(),
        _rotations,
        (
            Slip(
                "acos not clamped", ACOS, {"np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0)": "(np.trace(R) - 1.0) / 2.0"}
            ),
            Slip(
                "unit axis",
                "You return the axis alone. The logarithm is axis times angle: multiply by θ.",
                {"theta * w / (2.0 * np.sin(theta))": "w / (2.0 * np.sin(theta))"},
            ),
            Slip(
                "half forgotten",
                "The differences of the matrix are 2 sin θ times the axis: divide by 2 sin θ, not by sin θ.",
                {"(2.0 * np.sin(theta))": "np.sin(theta)"},
            ),
            Slip(
                "transposed",
                "The axis points the other way: its first number is R32 − R23. Yours is the logarithm of "
                "the transpose.",
                {"theta * w": "-theta * w"},
            ),
            Slip(
                "zero divided by zero",
                "At the identity sin θ is 0 and the quotient NaN: there the rotation vector is 0.",
                {"    if theta < 1e-6:\n        return np.zeros(3)\n": ""},
            ),
            Slip(
                "degrees",
                "The length of your vector is in degrees; it is to be in radians.",
                {"theta * w": "np.degrees(theta) * w"},
            ),
        ),
    ),
    Exercise(
        change_frame,
        lambda R_ab, R_bc, q_c: np.einsum("ij,jk,k->i", R_ab, R_bc, q_c),
        _frames,
        (
            Slip(
                "order reversed",
                "You multiply R_bc R_ab. Neighbouring letters must meet: R_ab R_bc q_c, and a point of C "
                "becomes one of B first.",
                {"R_ab @ R_bc @ q_c": "R_bc @ R_ab @ q_c"},
            ),
            Slip(
                "transposed",
                "You use the transposes, which take coordinates of A to C. From C to A it is R_ab R_bc itself.",
                {"R_ab @ R_bc @ q_c": "(R_ab @ R_bc).T @ q_c"},
            ),
            Slip(
                "each transposed",
                "Each matrix is transposed, but R_ab takes coordinates of B to A as it is: leave out .T.",
                {"R_ab @ R_bc @ q_c": "R_ab.T @ R_bc.T @ q_c"},
            ),
            Slip(
                "one step only",
                "You use only one of the two rotations: from C to B by R_bc, then from B to A by R_ab.",
                {"R_ab @ R_bc @ q_c": "R_ab @ q_c"},
            ),
            Slip(
                "number by number",
                "You multiply number by number (`*`). Matrices are multiplied with @.",
                {"R_ab @ R_bc @ q_c": "(R_ab * R_bc) @ q_c"},
            ),
        ),
    ),
)
