"""Exercises on velocities: the Adjoint, twists of a moving body, wrenches."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import conjugated, inverted, twist_matrix
from .instances import TIMES, pose
from .words import ADJOINT_TRANSPOSED, ANGULAR_FIRST, NO_CROSS_TERM


def adjoint(g: Array) -> Array:
    """The Adjoint (6, 6) of a pose `g` = g_st (4, 4).

    It takes a twist (v, ω) seen from T to the same twist seen from S.
    """
    R, p = g[:3, :3], g[:3, 3]
    P = np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])
    return np.block([[R, P @ R], [np.zeros((3, 3)), R]])


def body_twist(g: Array, g_dot: Array) -> Array:
    """The body twist (v, ω), (6,), of a body at the pose `g` (4, 4) with the rate of change `g_dot` (4, 4)."""
    V = np.linalg.inv(g) @ g_dot
    return np.array([*V[:3, 3], V[2, 1], V[0, 2], V[1, 0]])


def spatial_twist(g: Array, V_b: Array) -> Array:
    """The spatial twist (v, ω), (6,), of a body at `g` (4, 4) with the body twist `V_b` = (v, ω)."""
    R, p = g[:3, :3], g[:3, 3]
    w = R @ V_b[3:]
    return np.concatenate([R @ V_b[:3] + np.cross(p, w), w])


def wrench_seen_from_base(g_st: Array, F_t: Array) -> Array:
    """The wrench (f, τ), (6,), seen from frame S.

    `F_t` = (f, τ) is the same wrench seen from T. The torque is about the other origin.
    """
    R, p = g_st[:3, :3], g_st[:3, 3]
    f = R @ F_t[:3]
    return np.concatenate([f, R @ F_t[3:] + np.cross(p, f)])


def _poses(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng),) for _ in range(TIMES))


def _moving(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        g = pose(rng)
        yield g, g @ twist_matrix(rng.normal(size=6))


def _with_six(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng), rng.normal(size=6)) for _ in range(TIMES))


def _body_twist(g: Array, g_dot: Array) -> Array:
    """Velocity of the origin and turn, both brought into the body's axes."""
    R = g[:3, :3]
    S = R.T @ g_dot[:3, :3]
    return np.array([*(R.T @ g_dot[:3, 3]), S[2, 1], S[0, 2], S[1, 0]])


def _by_power(g: Array, F: Array) -> Array:
    """The wrench with the same power for every twist; conjugation moves the twists."""
    back = inverted(g)
    return np.array([F @ conjugated(back, e) for e in np.eye(6)])


EXERCISES = (
    Exercise(
        adjoint,
        lambda g: np.column_stack([conjugated(g, e) for e in np.eye(6)]),
        _poses,
        (
            Slip("no p̂R", NO_CROSS_TERM, {"P @ R": "np.zeros((3, 3))"}),
            Slip(
                "transposed",
                ADJOINT_TRANSPOSED,
                {
                    "return np.block([[R, P @ R], [np.zeros((3, "
                    "3)), R]])": "return np.block([[R, P @ R], [np.zeros((3, 3)), R]]).T"
                },
            ),
            Slip(
                "R p̂",
                "The corner is p̂R and not Rp̂: ω is turned first, then p × ω is taken in the axes of S.",
                {"P @ R": "R @ P"},
            ),
            Slip(
                "angular first",
                "Your p̂R stands in the lower left corner. That is the Adjoint for twists (ω, v), as in Modern "
                "Robotics, or Ad(g⁻¹)ᵀ, which takes wrenches from T to S. For (v, ω) the corner is the upper right "
                "one.",
                {"[[R, P @ R], [np.zeros((3, 3)), R]]": "[[R, np.zeros((3, 3))], [P @ R, R]]"},
            ),
            Slip(
                "inverse",
                "This is the Adjoint of the inverse: it takes twists seen from S to T.",
                {"    R, p = g[:3, :3], g[:3, 3]\n": "    g = np.linalg.inv(g)\n    R, p = g[:3, :3], g[:3, 3]\n"},
            ),
            Slip("p̂ alone", "The corner is p̂R; yours is p̂ alone, without the rotation.", {"P @ R": "P"}),
            Slip(
                "sign of p̂",
                "Your corner is −p̂R. In p̂ the number p₁ stands in row 3, column 2, and −p₁ in row 2, column 3.",
                {"P @ R": "-P @ R"},
            ),
            Slip(
                "both corners",
                "Your matrix has p̂R in both corners. A shift does not change the angular velocity: the lower left "
                "corner is 0.",
                {"[np.zeros((3, 3)), R]": "[P @ R, R]"},
            ),
            Slip(
                "number by number",
                "You multiply p̂ and R number by number: it is the product of matrices.",
                {"P @ R": "P * R"},
            ),
        ),
    ),
    Exercise(
        body_twist,
        _body_twist,
        _moving,
        (
            Slip(
                "spatial for body",
                "This is the spatial twist, ġ g⁻¹. The body twist has the inverse on the left: g⁻¹ ġ.",
                {"np.linalg.inv(g) @ g_dot": "g_dot @ np.linalg.inv(g)"},
            ),
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"[*V[:3, 3], V[2, 1], V[0, 2], V[1, 0]]": "[V[2, 1], V[0, 2], V[1, 0], *V[:3, 3]]"},
            ),
            Slip(
                "skew read transposed",
                "ω has the wrong sign: in ω̂ the number ω₁ stands in row 3, column 2, and −ω₁ in row 2, column 3.",
                {"V[2, 1], V[0, 2], V[1, 0]": "V[1, 2], V[2, 0], V[0, 1]"},
            ),
            Slip(
                "velocity in space",
                "Your v is ṗ, the origin's velocity in the axes of space. Seen from the body it is Rᵀṗ.",
                {"*V[:3, 3]": "*g_dot[:3, 3]"},
            ),
            Slip(
                "hybrid",
                "You return ṗ and the angular velocity in the axes of space: the hybrid velocity. In the axes of the "
                "body they are Rᵀṗ and Rᵀω.",
                {"V = np.linalg.inv(g) @ g_dot\n": "V = g_dot @ np.linalg.inv(g)\n    V[:3, 3] = g_dot[:3, 3]\n"},
            ),
            Slip(
                "ω in space",
                "Your v is right. Your ω is in the axes of space, ω̂ = ṘRᵀ. In those of the body it is ω̂ = RᵀṘ.",
                {
                    "V = np.linalg.inv(g) @ g_dot\n": "V = g_dot @ np.linalg.inv(g)\n    V[:3, 3] = "
                    "g[:3, :3].T @ g_dot[:3, 3]\n"
                },
            ),
            Slip(
                "rate for twist",
                "You read the numbers off ġ itself. The twist stands in g⁻¹ ġ.",
                {"np.linalg.inv(g) @ g_dot": "g_dot"},
            ),
        ),
    ),
    Exercise(
        spatial_twist,
        conjugated,
        _with_six,
        (
            Slip(
                "body for spatial",
                "You return the body twist as it is: seen from space both halves are turned by R, and p × ω is added.",
                {"    w = R @ V_b[3:]\n": "    return V_b\n    w = R @ V_b[3:]\n"},
            ),
            Slip(
                "only turned",
                "You only turn both halves into the axes of space. This is the hybrid velocity, of the body's own "
                "origin. The spatial v is that of the point at the origin of space: add p × ω.",
                {" + np.cross(p, w)": ""},
            ),
            Slip(
                "sign of p × ω",
                "You have ω × p where p × ω belongs: the upper right corner of the Adjoint is p̂R.",
                {"np.cross(p, w)": "np.cross(w, p)"},
            ),
            Slip(
                "the other way",
                "This takes a spatial twist to the body: the inverse. From body to space it is Ad_g.",
                {"    R, p = g[:3, :3], g[:3, 3]\n": "    g = np.linalg.inv(g)\n    R, p = g[:3, :3], g[:3, 3]\n"},
            ),
            Slip(
                "turn not turned",
                "In p × ω you use the body's ω: turn it into the axes of space first.",
                {"np.cross(p, w)": "np.cross(p, V_b[3:])"},
            ),
            Slip(
                "ω not turned",
                "Your ω is the body's, as it was given. Seen from space it is R ω.",
                {"np.cross(p, w), w]": "np.cross(p, w), V_b[3:]]"},
            ),
            Slip("transposed", ADJOINT_TRANSPOSED, {"    w = R @": "    return adjoint(g).T @ V_b\n    w = R @"}),
            Slip(
                "angular first",
                "Your p × … stands in ω and not in v. Either your twist is (ω, v), as in Modern Robotics, or you "
                "carry it as a wrench, by Ad(g⁻¹)ᵀ. For twists (v, ω) it is Ad = [R, p̂R; 0, R].",
                {
                    "    R, p = g[:3, :3], g[:3, 3]\n": "    V_b = np.roll(V_b, 3)\n    R, p = g[:3, :3], g[:3, 3]\n",
                    "[R @ V_b[:3] + np.cross(p, w), w]": "[w, R @ V_b[:3] + np.cross(p, w)]",
                },
            ),
        ),
    ),
    Exercise(
        wrench_seen_from_base,
        _by_power,
        _with_six,
        (
            Slip(
                "carried as a twist",
                "Your p × … stands in f and not in τ. Either you carry the wrench by the Adjoint, as a twist, or your "
                "wrench is (τ, f). Of a wrench the torque changes with the origin, not the force: f stays R f, and τ "
                "gets p × f.",
                {"[f, R @ F_t[3:] + np.cross(p, f)]": "[f + np.cross(p, R @ F_t[3:]), R @ F_t[3:]]"},
            ),
            Slip(
                "only turned",
                "The torque about the other origin has the lever arm p: add p × f.",
                {" + np.cross(p, f)": ""},
            ),
            Slip(
                "sign of p × f",
                "The lever arm comes first: p × f. Yours is f × p.",
                {"np.cross(p, f)": "np.cross(f, p)"},
            ),
            Slip(
                "Ad_gab transposed",
                "You use Ad(g_st)ᵀ, which takes a wrench seen from S to T. For the other way it is Ad(g_ts)ᵀ = "
                "Ad(g_st⁻¹)ᵀ.",
                {
                    "    R, p = g_st[:3, :3], g_st[:3, 3]\n": "    g_st = np.linalg.inv(g_st)\n    R, p = "
                    "g_st[:3, :3], g_st[:3, 3]\n"
                },
            ),
            Slip(
                "force not turned",
                "In p × f you use the force in the axes of T: turn it into those of S first.",
                {"np.cross(p, f)": "np.cross(p, F_t[:3])"},
            ),
            Slip(
                "not turned",
                "Force and torque keep the numbers that they have in the axes of T: turn both by R.",
                {"f = R @ F_t[:3]": "f = F_t[:3]", "R @ F_t[3:]": "F_t[3:]"},
            ),
            Slip(
                "unchanged",
                "You return the wrench as it is seen from T: turn both halves by R, and add p × f to the torque.",
                {"    f = R @": "    return F_t\n    f = R @"},
            ),
            Slip(
                "inverse of the Adjoint",
                "You use Ad(g_st)⁻¹, which takes twists from S to T. A wrench takes its transpose, Ad(g_st⁻¹)ᵀ.",
                {"    f = R @": "    return np.linalg.inv(adjoint(g_st)) @ F_t\n    f = R @"},
            ),
        ),
    ),
)
