"""Exercises on rotation matrices and Euler angles."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import scipy_rotation
from .instances import TIMES, angle
from .words import ACOS, DEGREES


def rotation_z(alpha: float) -> Array:
    """The rotation by `alpha` [rad] about the z axis, a (3, 3) array.

    Its columns are the axes x, y and z after the turn, in the coordinates of before.
    """
    c, s = np.cos(alpha), np.sin(alpha)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def zyz(alpha: float, beta: float, gamma: float) -> Array:
    """The rotation (3, 3) of the ZYZ Euler angles [rad].

    Turn by `alpha` about z, then by `beta` about the *new* y axis, then by `gamma` about the *new* z axis.
    """

    def turn_z(a: float) -> Array:
        return np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]])

    def turn_y(a: float) -> Array:
        return np.array([[np.cos(a), 0.0, np.sin(a)], [0.0, 1.0, 0.0], [-np.sin(a), 0.0, np.cos(a)]])

    R: Array = turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)
    return R


def zyz_angles(R: Array) -> Array:
    """The ZYZ Euler angles (alpha, beta, gamma) [rad] of a rotation, (3,): beta from 0 to π, the others from −π to π.

    At beta = 0 only alpha + gamma is determined, at beta = π only alpha − gamma. Let gamma be 0 in both cases (take a
    sin beta below 1e-6 as 0). `R` comes from a computer: its corner may be slightly above 1.
    """
    beta = np.arccos(np.clip(R[2, 2], -1.0, 1.0))
    if np.sin(beta) < 1e-6:
        return np.array([np.arctan2(-R[0, 1], R[1, 1]), beta, 0.0])
    return np.array([np.arctan2(R[1, 2], R[0, 2]), beta, np.arctan2(R[2, 1], -R[2, 0])])


def _one_angle(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((angle(rng),) for _ in range(TIMES))
    yield (0.0,)
    yield (np.pi / 2,)


def _three_angles(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((angle(rng), angle(rng), angle(rng)) for _ in range(TIMES))
    yield (0.4, 0.0, 0.7)


def _rotations(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        yield (_by_scipy(angle(rng), float(rng.uniform(0.2, 2.9)), angle(rng)),)
    for turn in (0.8, -2.5):
        above_one = _by_scipy(turn, 0.0, 0.0)
        above_one[2, 2] = 1.0 + 4e-16
        yield (above_one,)
        c, s = np.cos(turn), np.sin(turn)
        yield (np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]]),)  # straight down, typed by hand


def _by_scipy(alpha: float, beta: float, gamma: float) -> Array:
    R: Array = scipy_rotation().from_euler("ZYZ", [alpha, beta, gamma]).as_matrix()
    return R


def _angles_by_the_columns(R: Array) -> Array:
    """The third column gives alpha and beta; the rotation left after these turns is gamma."""
    x, y, z = R[:, 2]
    beta = np.arctan2(np.hypot(x, y), z)
    if min(beta, np.pi - beta) < 1e-6:
        turned = scipy_rotation().from_matrix(R @ _by_scipy(0.0, beta, 0.0).T)
        return np.array([float(turned.as_rotvec()[2]), beta, 0.0])
    alpha = np.arctan2(y, x)
    gamma = scipy_rotation().from_matrix(_by_scipy(alpha, beta, 0.0).T @ R).as_rotvec()[2]
    return np.array([alpha, beta, gamma])


EXERCISES = (
    Exercise(
        rotation_z,
        lambda alpha: scipy_rotation().from_rotvec([0.0, 0.0, alpha]).as_matrix(),
        _one_angle,
        (
            Slip(
                "transposed",
                "This is the transpose: the rotation by −alpha. The minus belongs to the sine in the first row: the "
                "columns are the turned axes, and x turns towards y.",
                {"[[c, -s, 0.0], [s, c, 0.0]": "[[c, s, 0.0], [-s, c, 0.0]"},
            ),
            Slip(
                "degrees",
                DEGREES,
                {"np.cos(alpha), np.sin(alpha)": "np.cos(np.radians(alpha)), np.sin(np.radians(alpha))"},
            ),
            Slip(
                "sine for cosine",
                "Sine and cosine have changed places: at alpha = 0 the matrix should be the identity, so the cosines, "
                "which are 1 there, stand on the diagonal.",
                {"c, s = np.cos(alpha), np.sin(alpha)": "s, c = np.cos(alpha), np.sin(alpha)"},
            ),
            Slip(
                "no minus",
                "Both sines have the same sign: that is a matrix of determinant cos 2α, no rotation. Put "
                "a minus before the one in the first row.",
                {"-s": "s"},
            ),
            Slip(
                "about x",
                "This turns about x: the axis of the turn is the one whose row and column have the 1. "
                "For z that is the third.",
                {"[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]": "[[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]"},
            ),
            Slip(
                "about y",
                "This turns about y: the axis of the turn is the one whose row and column have the 1. "
                "For z that is the third.",
                {"[[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]": "[[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]"},
            ),
            Slip(
                "no 1 in the corner",
                "The 1 in the last corner is missing: the z axis stays where it is, and its column is (0, 0, 1).",
                {"[0.0, 0.0, 1.0]": "[0.0, 0.0, 0.0]"},
            ),
        ),
    ),
    Exercise(
        zyz,
        _by_scipy,
        _three_angles,
        (
            Slip(
                "fixed for moved axes",
                "You multiply in the order γ, β, α: that turns about the fixed axes. A turn about an axis of the moved "
                "frame is multiplied from the right: R_z(α) R_y(β) R_z(γ).",
                {"turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)": "turn_z(gamma) @ turn_y(beta) @ turn_z(alpha)"},
            ),
            Slip(
                "transposed",
                "This is the transpose of the answer, its inverse: it takes coordinates of S to T and "
                "not of T to S. Check the sign of the sines in your matrices, or leave out a {transpose}.",
                {"return R": "return R.T"},
            ),
            Slip(
                "each transposed",
                "Each of the three matrices is transposed: the angles come out negative, in the right order. Look at "
                "the signs of the sines: in R_z the minus stands in the first row, in R_y in the last.",
                {"turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)": "turn_z(alpha).T @ turn_y(beta).T @ turn_z(gamma).T"},
            ),
            Slip(
                "number by number",
                "You multiply number by number ({times}). Matrices are multiplied with {matmul}.",
                {"turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)": "turn_z(alpha) * turn_y(beta) * turn_z(gamma)"},
            ),
            Slip(
                "YZY",
                "Your turns are about y, z and y: the letters of ZYZ are the axes, in this order.",
                {"turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)": "turn_y(alpha) @ turn_z(beta) @ turn_y(gamma)"},
            ),
            Slip(
                "sign in R_y",
                "The sine of your R_y has its minus in the first row. There it is the other way round "
                "than in R_z: z turns towards x, and the minus stands in the third row.",
                {
                    "[[np.cos(a), 0.0, np.sin(a)]": "[[np.cos(a), 0.0, -np.sin(a)]",
                    "[-np.sin(a), 0.0,": "[np.sin(a), 0.0,",
                },
            ),
            Slip(
                "ZYX",
                "The third turn is about x: those are the ZYX angles (yaw, pitch, roll). ZYZ turns about z again.",
                {
                    "@ turn_z(gamma)": "@ np.array([[1.0, 0.0, 0.0], [0.0, np.cos(gamma), -np.sin(gamma)], "
                    "[0.0, np.sin(gamma), np.cos(gamma)]])"
                },
            ),
            Slip(
                "about x in the middle",
                "The second turn is about x: those are the ZXZ angles. ZYZ turns about y.",
                {
                    "[[np.cos(a), 0.0, np.sin(a)], [0.0, 1.0, 0.0], [-np.sin(a), 0.0, np.cos(a)]]": "[[1.0, 0.0, 0.0], "
                    "[0.0, np.cos(a), -np.sin(a)], [0.0, np.sin(a), np.cos(a)]]"
                },
            ),
            Slip(
                "degrees",
                DEGREES,
                {
                    "turn_z(alpha) @ turn_y(beta) @ turn_z(gamma)": "turn_z(np.radians(alpha)) @ "
                    "turn_y(np.radians(beta)) @ "
                    "turn_z(np.radians(gamma))"
                },
            ),
        ),
    ),
    Exercise(
        zyz_angles,
        _angles_by_the_columns,
        _rotations,
        (
            Slip("acos not clamped", ACOS, {"np.clip(R[2, 2], -1.0, 1.0)": "R[2, 2]"}),
            Slip(
                "alpha and gamma swapped",
                "Alpha and gamma have changed places: the third column (R13, R23) holds alpha, the third "
                "row (R31, R32) gamma.",
                {
                    "[np.arctan2(R[1, 2], R[0, 2]), beta, "
                    "np.arctan2(R[2, 1], -R[2, 0])]": "[np.arctan2(R[2, 1], -R[2, 0]), beta, "
                    "np.arctan2(R[1, 2], R[0, 2])]"
                },
            ),
            Slip(
                "arctan for arctan2",
                "The arctangent of a quotient does not know in which quadrant the angle is: half of the "
                "angles are off by π. Use np.arctan2(y, x), which gets both numbers.",
                {
                    "np.arctan2(R[1, 2], R[0, 2])": "np.arctan(R[1, 2] / R[0, 2])",
                    "np.arctan2(R[2, 1], -R[2, 0])": "np.arctan(-R[2, 1] / R[2, 0])",
                },
            ),
            Slip(
                "arctan and sin β = 0",
                "The arctangent of a quotient does not know in which quadrant the angle is, and divides 0 by 0 where "
                "sin β is 0. Use np.arctan2(y, x), and where sin β is 0 read alpha from the upper left corner.",
                {
                    "np.arctan2(R[1, 2], R[0, 2])": "np.arctan(R[1, 2] / R[0, 2])",
                    "np.arctan2(R[2, 1], -R[2, 0])": "np.arctan(-R[2, 1] / R[2, 0])",
                    "if np.sin(beta) < 1e-6:": "if False:",
                },
            ),
            Slip(
                "sign of R31",
                "R31 is −sin β cos γ: without its minus gamma comes out as π − γ. Write np.arctan2(R[2, 1], -R[2, 0]).",
                {"-R[2, 0]": "R[2, 0]"},
            ),
            Slip(
                "beta = π forgotten",
                "You treat beta = 0, but beta = π has the same problem: sin β is 0, and the third column has only "
                "zeros or rounding. Read alpha from the upper left corner, which is R_z(α − γ) R_y(π) there.",
                {"if np.sin(beta) < 1e-6:": "if beta < 1e-6:"},
            ),
            Slip(
                "beta = 0 forgotten",
                "You treat beta = π, but beta = 0 has the same problem: sin β is 0, and the third column has only "
                "zeros or rounding. Read alpha from the upper left corner, which is R_z(α + γ) there.",
                {"if np.sin(beta) < 1e-6:": "if beta > 3.0:"},
            ),
            Slip(
                "sin β = 0 forgotten",
                "If beta is 0 or π, sin β is 0, and the third column and row have only zeros or rounding. Read alpha "
                "from the upper left corner there, and let gamma be 0.",
                {"if np.sin(beta) < 1e-6:": "if False:"},
            ),
            Slip(
                "alpha from the first column",
                "Your alpha is right at beta = 0, and off by π at beta = π: there the first column is "
                "(−cos α, −sin α, 0). The second column is (−sin α, cos α, 0) in both cases: take alpha from it.",
                {"np.arctan2(-R[0, 1], R[1, 1])": "np.arctan2(R[1, 0], R[0, 0])"},
            ),
            Slip(
                "alpha forgotten",
                "Where sin β is 0, you let both alpha and gamma be 0. By the task gamma alone is 0: alpha is the whole "
                "turn about z. Read it from the upper left corner.",
                {"np.array([np.arctan2(-R[0, 1], R[1, 1]), beta, 0.0])": "np.array([0.0, beta, 0.0])"},
            ),
            Slip(
                "gamma for alpha",
                "Where only alpha + gamma or alpha − gamma is determined, you let alpha be 0. These angles are of the "
                "same rotation, but the task wants gamma to be 0: one convention, so that answers can be compared.",
                {
                    "np.array([np.arctan2(-R[0, 1], R[1, 1]), beta, 0.0])": "np.array([0.0, beta, "
                    "np.arctan2(R[1, 0], R[1, 1])])"
                },
            ),
            Slip(
                "negative beta",
                "Your angles are another triple of the same rotation: (α ± π, −β, γ ± π). The task wants beta from 0 "
                "to π, as arccos gives it.",
                {
                    "[np.arctan2(R[1, 2], R[0, 2]), beta, "
                    "np.arctan2(R[2, 1], -R[2, 0])]": "[np.arctan2(-R[1, 2], -R[0, 2]), -beta, "
                    "np.arctan2(-R[2, 1], R[2, 0])]"
                },
            ),
            Slip(
                "from 0 to 2π",
                "Your alpha and gamma run from 0 to 2π: angles of the same rotation, but the task wants them from −π "
                "to π, as arctan2 gives them.",
                {
                    "np.arctan2(-R[0, 1], R[1, 1])": "np.arctan2(-R[0, 1], R[1, 1]) % (2 * np.pi)",
                    "np.arctan2(R[1, 2], R[0, 2])": "np.arctan2(R[1, 2], R[0, 2]) % (2 * np.pi)",
                    "np.arctan2(R[2, 1], -R[2, 0])": "np.arctan2(R[2, 1], -R[2, 0]) % (2 * np.pi)",
                },
            ),
            Slip(
                "arguments of arctan2 swapped",
                "The arguments of arctan2 have changed places: the sine comes first, arctan2(y, x).",
                {
                    "np.arctan2(-R[0, 1], R[1, 1])": "np.arctan2(R[1, 1], -R[0, 1])",
                    "np.arctan2(R[1, 2], R[0, 2])": "np.arctan2(R[0, 2], R[1, 2])",
                    "np.arctan2(R[2, 1], -R[2, 0])": "np.arctan2(-R[2, 0], R[2, 1])",
                },
            ),
            Slip(
                "arcsine for beta",
                "The arcsine never gives a beta above π/2, and beta goes up to π: the corner R33 is cos β, and arccos "
                "tells the two halves apart.",
                {"np.arccos(np.clip(R[2, 2], -1.0, 1.0))": "np.arcsin(min(1.0, np.hypot(R[0, 2], R[1, 2])))"},
            ),
            Slip(
                "degrees",
                "The angles come out in degrees; everything here is in radians. Leave np.degrees out.",
                {"return np.array(": "return np.degrees("},
            ),
        ),
    ),
)
