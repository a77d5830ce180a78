"""Exercises on rotations as a group: exponential, logarithm, change of coordinates."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import crossing, expm, scipy_rotation
from .instances import TIMES, angle, rotation, unit
from .words import ACOS, DEGREES


def skew(omega: Array) -> Array:
    """The matrix ω̂ (3, 3) of the cross product with `omega` (3,): ω̂ q = ω × q for every q."""
    x, y, z = omega
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rodrigues(omega: Array, theta: float) -> Array:
    """The rotation exp(ω̂θ) (3, 3), by Rodrigues' formula. `omega` (3,) may have any length, 0 too.

    The angle of the turn is ‖ω‖ θ [rad], including the length of `omega`. Where it is 0, that is the identity.
    """
    length = np.linalg.norm(omega)
    if length < 1e-12:
        return np.eye(3)
    x, y, z = omega / length
    W = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn = length * theta
    R: Array = np.eye(3) + W * np.sin(turn) + W @ W * (1.0 - np.cos(turn))
    return R


def rotation_log(R: Array) -> Array:
    """The rotation vector ωθ (3,) of a rotation `R` (3, 3).

    Its direction is the axis, and its length the angle [rad], from 0 to π.

    Take an angle below 1e-6 as 0. Above π − 1e-6 it is a half turn, and either axis direction is right. `R` comes from
    a computer: its trace may be slightly above 3, or below −1.
    """
    theta = np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0))
    if theta < 1e-6:
        return np.zeros(3)
    if theta > np.pi - 1e-6:
        column = (R + np.eye(3))[:, np.argmax(np.diag(R))]
        return np.pi * column / np.linalg.norm(column)
    w = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    scaled: Array = theta * w / (2.0 * np.sin(theta))
    return scaled


def change_frame(R_st: Array, R_tc: Array, q_c: Array) -> Array:
    """The coordinates q_s (3,) in frame S of the point that has `q_c` (3,) in C. The frames share their origin."""
    q_s: Array = R_st @ R_tc @ q_c
    return q_s


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
    yield (np.diag([-1.0, -1.0, 1.0]),)
    yield (np.diag([1.0, -1.0, -1.0]),)
    for _ in range(2):
        w = unit(rng)
        yield (2.0 * np.outer(w, w) - np.eye(3),)


def _up_to_sign_at_a_half_turn(w: Array, R: Array) -> Array:
    return np.outer(w, w) if np.trace(R) < -1.0 + 1e-12 else w


def _frames(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rotation(rng), rotation(rng), rng.normal(size=3)) for _ in range(TIMES))


EXERCISES = (
    Exercise(
        skew,
        lambda omega: np.column_stack([np.cross(omega, e) for e in np.eye(3)]),
        _vectors,
        (
            Slip(
                "transposed",
                "All signs are reversed: this matrix gives q × ω. The first row is (0, −ω₃, ω₂).",
                {"[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]": "[[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]"},
            ),
            Slip(
                "symmetric",
                "The matrix is symmetric; a cross product makes it skew: ω̂ᵀ = −ω̂, each number once with a minus.",
                {"-z": "z", "-x": "x", "-y": "y"},
            ),
            Slip(
                "normalised",
                "You divide by the length of ω, so the cross product loses it. Write ω into ω̂ without a division.",
                {"x, y, z = omega": "x, y, z = omega / np.linalg.norm(omega)"},
            ),
            Slip(
                "outer product",
                "This is the matrix ωωᵀ of the products of all pairs. ω̂ holds each number of ω twice, once with a "
                "minus.",
                {
                    "[[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]": "[[x * x, x * y, x * z], [x * y, y * y, y * z], "
                    "[x * z, y * z, z * z]]"
                },
            ),
        ),
    ),
    Exercise(
        rodrigues,
        lambda omega, theta: expm(crossing(omega) * theta),
        _axes,
        (
            Slip(
                "not normalised",
                "Rodrigues' formula holds for ‖ω‖ = 1. Here ω has another length, and the answer is no rotation: "
                "divide ω by its length, and multiply the angle by it.",
                {"x, y, z = omega / length": "x, y, z = omega", "turn = length * theta": "turn = theta"},
            ),
            Slip(
                "angle not scaled",
                "You divide ω by its length but turn by θ: the length of ω is a part of the angle, ‖ω‖ θ.",
                {"turn = length * theta": "turn = theta"},
            ),
            Slip("degrees", DEGREES, {"turn = length * theta": "turn = length * np.radians(theta)"}),
            Slip(
                "transposed",
                "This is the transpose, a turn by −θ: look at the signs of ω̂, whose first row is (0, −ω₃, ω₂).",
                {"return R": "return R.T"},
            ),
            Slip(
                "number by number",
                "You square ω̂ number by number ({squares}). The formula has the matrix product: W {matmul} W.",
                {"W @ W": "W * W"},
            ),
            Slip(
                "exponential of each number",
                "You take the exponential of each number by itself ({exp}). That of a matrix is the series I + X + "
                "X²/2! + …, which Rodrigues' formula sums ({expm} does as well).",
                {
                    "        return np.eye(3)\n": "        return np.ones((3, 3))\n",
                    "np.eye(3) + W * np.sin(turn) + W @ W * (1.0 - np.cos(turn))": "np.exp(W * turn)",
                },
            ),
            Slip(
                "ωωᵀ for ω̂²",
                "You have ωωᵀ where ω̂² stands: ω̂² = ωωᵀ − I for a unit vector. The square of ω̂ is the product "
                "W {matmul} W.",
                {"W @ W": "np.outer([x, y, z], [x, y, z])"},
            ),
            Slip(
                "one plus cosine",
                "The last term is ω̂² (1 − cos θ), yours has 1 + cos θ: at θ = 0 nothing may be left of it.",
                {"(1.0 - np.cos(turn))": "(1.0 + np.cos(turn))"},
            ),
            Slip(
                "no second term",
                "The term ω̂² (1 − cos θ) is missing: without it the answer is right for small angles alone.",
                {" + W @ W * (1.0 - np.cos(turn))": ""},
            ),
            Slip(
                "cosine alone",
                "The last term is ω̂² (1 − cos θ), yours ω̂² cos θ: at θ = 0 nothing may be left of it.",
                {"(1.0 - np.cos(turn))": "np.cos(turn)"},
            ),
            Slip(
                "sine for cosine",
                "Sine and cosine have changed places: I + ω̂ sin θ + ω̂² (1 − cos θ).",
                {"W * np.sin(turn) + W @ W * (1.0 - np.cos(turn))": "W * np.cos(turn) + W @ W * (1.0 - np.sin(turn))"},
            ),
            Slip(
                "zero divided by zero",
                "For ω = 0 you divide by its length, 0, and get {nan}. No axis means no turn: return the identity "
                "there.",
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
                {"theta * w / (2.0 * np.sin(theta))": "w / (2.0 * np.sin(theta))", "np.pi * column": "column"},
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
                "half turn forgotten",
                "At a half turn sin θ is 0 and so are all differences: nothing is left of the axis. Take it from R + "
                "I = 2ωωᵀ: a column of it that is not 0, divided by its length, times π.",
                {"    if theta > np.pi - 1e-6:\n": "    if False:\n"},
            ),
            Slip(
                "column of zeros",
                "At a half turn you always take the same column of R + I. It is 0 where the axis has no such part, and "
                "0/0 is NaN: take the longest column, the one with the largest number on the diagonal.",
                {"np.argmax(np.diag(R))": "0"},
            ),
            Slip(
                "sign of the middle number",
                "The middle number of the axis is R13 − R31, yours R31 − R13: in ω̂ the minus of the middle one is in "
                "the last row.",
                {"R[0, 2] - R[2, 0]": "R[2, 0] - R[0, 2]"},
            ),
            Slip(
                "trace not less one",
                "The cosine is (tr R − 1)/2: the trace of a rotation is 1 + 2 cos θ. You forgot the 1.",
                {"(np.trace(R) - 1.0)": "np.trace(R)"},
            ),
            Slip(
                "arcsine for the angle",
                "The arcsine never gives an angle above π/2, and θ goes up to π: take the arccos of (tr R − 1)/2.",
                {
                    "np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0))": "np.arcsin(min(1.0, np.linalg.norm("
                    "[R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2.0))"
                },
            ),
            Slip(
                "zero divided by zero",
                "At the identity sin θ is 0 and the quotient NaN: there the rotation vector is 0.",
                {"    if theta < 1e-6:\n        return np.zeros(3)\n": ""},
            ),
            Slip(
                "degrees",
                "The length of your vector is in degrees; it is to be in radians.",
                {"theta * w": "np.degrees(theta) * w", "np.pi * column": "180.0 * column"},
            ),
        ),
        seen=_up_to_sign_at_a_half_turn,
    ),
    Exercise(
        change_frame,
        lambda R_st, R_tc, q_c: np.einsum("ij,jk,k->i", R_st, R_tc, q_c),
        _frames,
        (
            Slip(
                "order reversed",
                "You multiply R_tc R_st. Neighbouring letters must meet: R_st R_tc q_c, and a point of C "
                "becomes one of T first.",
                {"R_st @ R_tc @ q_c": "R_tc @ R_st @ q_c"},
            ),
            Slip(
                "transposed",
                "You use the transposes (a row times R is Rᵀ times the column), which take coordinates of S to C. "
                "From C to S it is R_st R_tc itself.",
                {"R_st @ R_tc @ q_c": "(R_st @ R_tc).T @ q_c"},
            ),
            Slip(
                "each transposed",
                "Each matrix is transposed, but R_st takes coordinates of T to S as it is: leave out {transpose}.",
                {"R_st @ R_tc @ q_c": "R_st.T @ R_tc.T @ q_c"},
            ),
            Slip(
                "one step only",
                "You use only one of the two rotations: from C to T by R_tc, then from T to S by R_st.",
                {"R_st @ R_tc @ q_c": "R_st @ q_c"},
            ),
            Slip(
                "number by number",
                "You multiply number by number ({times}). Matrices are multiplied with {matmul}.",
                {"R_st @ R_tc @ q_c": "(R_st * R_tc) @ q_c"},
            ),
        ),
    ),
)
