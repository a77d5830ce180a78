"""Exercises on singularities and the manipulability ellipsoid."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import body_columns
from .instances import TIMES, angle, chain, own_chain


def two_link_determinant(l1: float, l2: float, theta1: float, theta2: float) -> float:
    """The determinant of the 2 × 2 Jacobian of the two-link arm's tip, `theta2` [rad] measured from the first link."""
    return float(l1 * l2 * np.sin(theta2))


def manipulability(J: Array) -> float:
    """Yoshikawa's measure √det(J Jᵀ) of a Jacobian `J` (3, m), m ≥ 3: the product of its singular values."""
    return float(np.sqrt(np.linalg.det(J @ J.T)))


def semi_axes(J_b: Array) -> Array:
    """The half axes (3,) of the velocity ellipsoid of the tool's origin, longest first.

    The joint rates have the length 1. `J_b` (6, m), m ≥ 3, is the body Jacobian, linear part first.
    """
    lengths = np.linalg.svd(J_b[:3], compute_uv=False)
    return lengths  # type: ignore[return-value]


def carried_wrench(J: Array) -> Array:
    """The wrench F = (f, τ), (6,), of norm 1 that asks nothing of any joint: Jᵀ F = 0. The arm is singular, its
    Jacobian `J` (6, m) has rank 5. Either sign is right.
    """
    return np.linalg.svd(J)[0][:, -1]


def _planar(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        l1, l2 = rng.uniform(0.2, 0.9, 2)
        yield float(l1), float(l2), angle(rng), angle(rng)


def _jacobians(rng: np.random.Generator, arm: Arm) -> Iterator[Array]:
    yield from (body_columns(*chain(rng)) for _ in range(TIMES))
    if arm.n >= 3:
        yield from (body_columns(*own_chain(rng, arm)) for _ in range(2))


def _linear(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((J[:3],) for J in _jacobians(rng, arm))


def _whole(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((J,) for J in _jacobians(rng, arm))


def _singular(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for m in (5, 6, 6, 7, 6):
        yield (rng.normal(size=(6, 5)) @ rng.normal(size=(5, m)),)


def _derivative(l1: float, l2: float, theta1: float, theta2: float) -> float:
    """The area that both columns span, by complex numbers."""
    second = 1j * l2 * np.exp(1j * (theta1 + theta2))
    first = 1j * l1 * np.exp(1j * theta1) + second
    return float((np.conj(first) * second).imag)


def _volume(J: Array) -> float:
    """By Cauchy and Binet: the sum of the squares of all 3 × 3 minors."""
    from itertools import combinations

    return float(np.sqrt(sum(np.linalg.det(J[:, list(three)]) ** 2 for three in combinations(range(J.shape[1]), 3))))


def _axes(J_b: Array) -> Array:
    values = np.linalg.eigvalsh(J_b[:3] @ J_b[:3].T)[::-1]
    return np.array(np.sqrt(np.maximum(values, 0.0)))


def _remainder(J: Array) -> Array:
    """The rest of a vector after its projection onto an orthonormal basis of the columns."""
    Q = np.linalg.qr(J[:, :5])[0]
    rest = np.eye(6) - Q @ Q.T
    longest = rest[:, np.argmax(np.diag(rest))]
    return np.array(longest / np.sqrt(longest @ longest))


def _up_to_sign(direction: Array, *_: Any) -> Array:
    return np.outer(direction, direction)


EXERCISES = (
    Exercise(
        two_link_determinant,
        _derivative,
        _planar,
        (
            Slip(
                "cosine for sine",
                "You have cos θ₂: the arm is singular where it is stretched or folded, θ₂ = 0 or π, and "
                "there the sine is 0.",
                {"np.sin": "np.cos"},
            ),
            Slip(
                "wrong angle",
                "The determinant does not depend on θ₁: turning the whole arm at its base changes nothing.",
                {"np.sin(theta2)": "np.sin(theta1)"},
            ),
            Slip("sum of angles", "The angle is θ₂ alone, not θ₁ + θ₂.", {"np.sin(theta2)": "np.sin(theta1 + theta2)"}),
            Slip(
                "absolute value",
                "A determinant has a sign: here it tells on which side the elbow is.",
                {"np.sin(theta2)": "abs(np.sin(theta2))"},
            ),
            Slip(
                "sign",
                "The sign is reversed: det J = J₁₁J₂₂ − J₁₂J₂₁ is positive for θ₂ from 0 to π.",
                {"float(l1": "float(-l1"},
            ),
        ),
    ),
    Exercise(
        manipulability,
        _volume,
        _linear,
        (
            Slip(
                "root forgotten",
                "This is det(J Jᵀ), the square of the measure: take the root.",
                {"np.sqrt(np.linalg.det(J @ J.T))": "np.linalg.det(J @ J.T)"},
            ),
            Slip(
                "JᵀJ for JJᵀ",
                "You have det(JᵀJ), which is 0 where there are more joints than directions; rounding brings it below "
                "0, and its root is NaN. It is J Jᵀ.",
                {"np.sqrt(np.linalg.det(J @ J.T))": "np.sqrt(np.linalg.det(J.T @ J))"},
            ),
            Slip(
                "trace for determinant",
                "You have the trace of J Jᵀ, the sum of the squares of the singular values; the measure is their "
                "product, by the determinant.",
                {"np.linalg.det": "np.trace"},
            ),
            Slip(
                "condition inverted",
                "This is 1 over the condition number, the shortest half axis by the longest; the measure is the "
                "product of all.",
                {"np.sqrt(np.linalg.det(J @ J.T))": "1.0 / np.linalg.cond(J)"},
            ),
            Slip(
                "least singular value",
                "This is the least singular value; the measure is the product of all.",
                {"np.sqrt(np.linalg.det(J @ J.T))": "np.linalg.svd(J, compute_uv=False)[-1]"},
            ),
            Slip(
                "condition number",
                "This is the condition number; the measure is the product of the singular values.",
                {"np.sqrt(np.linalg.det(J @ J.T))": "np.linalg.cond(J)"},
            ),
        ),
    ),
    Exercise(
        semi_axes,
        _axes,
        _whole,
        (
            Slip(
                "root forgotten",
                "These are the eigenvalues of J Jᵀ, the squares of the half axes: take the root.",
                {"return lengths": "return lengths**2"},
            ),
            Slip(
                "shortest first",
                "They are in the other order: the longest comes first.",
                {"return lengths": "return lengths[::-1]"},
            ),
            Slip(
                "turns for velocities",
                "You take the last three rows, of ω: the linear part comes first.",
                {"J_b[:3]": "J_b[3:]"},
            ),
            Slip(
                "all rows",
                "You take all six rows, where metres meet radians: of the origin's velocity it is the first three.",
                {"np.linalg.svd(J_b[:3], compute_uv=False)": "np.linalg.svd(J_b, compute_uv=False)[:3]"},
            ),
            Slip(
                "whole axes",
                "These are the whole axes, from end to end: half of that.",
                {"return lengths": "return 2 * lengths"},
            ),
        ),
        tolerance=1e-6,
    ),
    Exercise(
        carried_wrench,
        _remainder,
        _singular,
        (
            Slip(
                "row for column",
                "You take a row of U. The singular vectors are its columns, U[:, -1].",
                {"[0][:, -1]": "[0][-1]"},
            ),
            Slip(
                "joint rates",
                "This is the last right singular vector: the joints' rates that move nothing. The wrench is a left "
                "one: a column of U.",
                {"[0][:, -1]": "[2][-1]"},
            ),
            Slip(
                "easiest direction",
                "This is the wrench that the joints feel most; the one that they do not feel belongs to the least "
                "singular value, the last.",
                {"[:, -1]": "[:, 0]"},
            ),
            Slip(
                "torque first",
                "Your wrench is (τ, f); here the force comes first, (f, τ), as v does in twists.",
                {"return np.linalg.svd(J)[0][:, -1]": "return np.roll(np.linalg.svd(J)[0][:, -1], 3)"},
            ),
        ),
        seen=_up_to_sign,
    ),
)
