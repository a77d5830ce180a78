"""Exercises on the manipulator Jacobian."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import body_columns, motion_of, spatial_columns, tool
from .instances import TIMES, chain, chains, own_chain
from .words import ADJOINT_TRANSPOSED, ANGULAR_FIRST, DEGREES, NO_CROSS_TERM


def spatial_jacobian(twists: Array, x: Array) -> Array:
    """The spatial Jacobian (6, m).

    Column i is the twist of joint i, carried by the joints before it: Ad(exp(ξ̂₁x₁) ⋯ exp(ξ̂ᵢ₋₁xᵢ₋₁)) ξᵢ.

    `twists` (6, m) holds the twists (v, ω) at rest, `x` (m,) the joints' values [rad, m]. Use your `adjoint` and
    `twist_exp`, or `screws.adjoint` and `screws.exp` after `from twistarm import screws`.
    """
    from twistarm import screws

    J = np.zeros(twists.shape)
    g = np.eye(4)
    for i in range(len(x)):
        J[:, i] = screws.adjoint(g) @ twists[:, i]
        g = g @ screws.exp(twists[:, i], x[i])
    return J


def body_jacobian(twists: Array, home: Array, x: Array) -> Array:
    """The body Jacobian (6, m): the spatial one seen from the tool, Jᵇ = Ad(g_st⁻¹) Jˢ. `home` (4, 4) is the tool's
    pose at rest.
    """
    from twistarm import screws

    J = np.zeros(twists.shape)
    g = np.eye(4)
    for i in range(len(x)):
        J[:, i] = screws.adjoint(g) @ twists[:, i]
        g = g @ screws.exp(twists[:, i], x[i])
    J_b: Array = screws.adjoint(np.linalg.inv(g @ home)) @ J
    return J_b


def joint_torques(J_b: Array, F_t: Array) -> Array:
    """The torques and forces (m,) of the joints when the tool exerts the wrench `F_t` = (f, τ), (6,).

    The wrench is seen from the tool. `J_b` (6, m) is the body Jacobian. Gravity is left out.
    """
    torques: Array = J_b.T @ F_t
    return torques


def tool_velocity(J_s: Array, p: Array, rates: Array) -> Array:
    """The velocity (3,) of the tool's origin, which is at `p` (3,), in the axes of the base. `J_s` (6, m) is the
    spatial Jacobian, `rates` (m,) are the joints' rates.
    """
    V = J_s @ rates
    velocity: Array = V[:3] + np.cross(V[3:], p)
    return velocity


def _configurations(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for twists, _, x in chains(rng, arm):
        yield twists, x


def _pushing(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for chain_of_arm in chains(rng, arm):
        yield body_columns(*chain_of_arm), rng.normal(size=6)
    yield body_columns(*_of_six(rng)), rng.normal(size=6)


def _of_six(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    while True:
        twists, home, x = chain(rng)
        if len(x) >= 6:
            return twists[:, :6], home, x[:6]


def _moving(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for twists, home, x in [*(chain(rng) for _ in range(TIMES)), own_chain(rng, arm)]:
        yield spatial_columns(twists, x), tool(twists, home, x)[:3, 3], rng.normal(size=len(x))


def _by_power(J_b: Array, F_t: Array) -> Array:
    """Virtual work, joint by joint: torque times rate equals the power of the tool's push."""
    return np.array([F_t[:3] @ column[:3] + F_t[3:] @ column[3:] for column in J_b.T])


def _by_motion(J_s: Array, p: Array, rates: Array) -> Array:
    """By difference: the motion of this twist moves the point for a microsecond, and back."""
    V = (J_s @ rates)[:, None]
    h = np.array([1e-6])
    ahead, behind = (motion_of(V, h * sign) @ np.append(p, 1.0) for sign in (1.0, -1.0))
    return np.array((ahead - behind)[:3] / 2e-6)


EXERCISES = (
    Exercise(
        spatial_jacobian,
        spatial_columns,
        _configurations,
        (
            Slip(
                "columns not moved",
                "Your columns are the twists at rest: the joints before it have carried each of them "
                "along. Column i is Ad(exp(ξ̂₁x₁) ⋯ exp(ξ̂ᵢ₋₁xᵢ₋₁)) ξᵢ.",
                {"screws.adjoint(g) @ twists[:, i]": "twists[:, i]"},
            ),
            Slip(
                "moved by all joints",
                "Each column is moved by all joints, also by those after it. A joint moves only what is beyond it.",
                {
                    "    for i in range(len(x)):\n": "    for i in range(len(x)):\n        g = g @ screws.exp("
                    "twists[:, i], x[i])\n    for i in range(len(x)):\n",
                    "        J[:, i] = screws.adjoint(g) @ twists[:, i]\n        g = g @ "
                    "screws.exp(twists[:, i], x[i])\n": "        J[:, i] = screws.adjoint(g) @ twists[:, i]\n",
                },
            ),
            Slip(
                "order reversed",
                "The motions of the joints are multiplied in the reverse order: exp(ξ̂₁x₁) stands on the left.",
                {"g = g @ screws.exp(twists[:, i], x[i])": "g = screws.exp(twists[:, i], x[i]) @ g"},
            ),
            Slip("no p̂R", NO_CROSS_TERM, {"screws.adjoint(g) @ twists": "np.kron(np.eye(2), g[:3, :3]) @ twists"}),
            Slip(
                "Adjoint transposed", ADJOINT_TRANSPOSED, {"screws.adjoint(g) @ twists": "screws.adjoint(g).T @ twists"}
            ),
            Slip(
                "Adjoint inverted",
                "The columns are carried backwards: it is the Adjoint of the motion, not of its inverse.",
                {"screws.adjoint(g) @ twists": "screws.adjoint(np.linalg.inv(g)) @ twists"},
            ),
            Slip(
                "only by the joint before",
                "Each column is carried along by the one joint before it alone: all before it do so. "
                "Multiply the motions.",
                {"g = g @ screws.exp": "g = screws.exp"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"return J": "return np.roll(J, 3, axis=0)"}),
            Slip("degrees", DEGREES, {"x[i])": "np.radians(x[i]))"}),
        ),
    ),
    Exercise(
        body_jacobian,
        body_columns,
        chains,
        (
            Slip(
                "spatial for body",
                "This is the spatial Jacobian. Seen from the tool it is Ad(g_st⁻¹) Jˢ.",
                {"screws.adjoint(np.linalg.inv(g @ home)) @ J": "J"},
            ),
            Slip(
                "home forgotten",
                "You carry the columns to where the tool has moved from the base, without its home pose: "
                "the tool is at exp(…) g_st(0).",
                {"(g @ home)": "(g)"},
            ),
            Slip(
                "not inverted",
                "You use Ad(g_st), which takes twists from the tool to the base. From the base to the "
                "tool it is Ad(g_st⁻¹).",
                {"np.linalg.inv(g @ home)": "g @ home"},
            ),
            Slip(
                "transposed for inverse",
                "The transpose of an Adjoint is not its inverse: Ad(g)⁻¹ = Ad(g⁻¹).",
                {"screws.adjoint(np.linalg.inv(g @ home))": "screws.adjoint(g @ home).T"},
            ),
            Slip(
                "columns not moved",
                "The columns are the twists at rest, carried to the tool: the joints before each must move it first.",
                {"J[:, i] = screws.adjoint(g) @ twists[:, i]": "J[:, i] = twists[:, i]"},
            ),
            Slip(
                "only turned",
                "You only turn the columns into the tool's axes: without −Rᵀp̂ v is that of the point at the base.",
                {"screws.adjoint(np.linalg.inv(g @ home))": "np.kron(np.eye(2), (g @ home)[:3, :3].T)"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"return J_b": "return np.roll(J_b, 3, axis=0)"}),
            Slip(
                "hybrid",
                "This is the hybrid Jacobian: v is right, the velocity of the tool's origin, but all is in the axes of "
                "the base. Turn both halves into the tool's by Rᵀ.",
                {"return J_b": "R = (g @ home)[:3, :3]\n    return np.kron(np.eye(2), R) @ J_b"},
            ),
            Slip(
                "seen from where the tool was",
                "You use Ad(g_st(0)⁻¹), of the tool's pose at rest: the tool has moved since. It is Ad(g_st⁻¹) of the "
                "pose where it is now.",
                {"np.linalg.inv(g @ home)": "np.linalg.inv(home)"},
            ),
            Slip("degrees", DEGREES, {"x[i])": "np.radians(x[i]))"}),
        ),
    ),
    Exercise(
        joint_torques,
        _by_power,
        _pushing,
        (
            Slip(
                "sign",
                "The sign is reversed: the tool exerts F, and the joints supply Jᵀ F. −Jᵀ F holds what "
                "the world exerts on the tool.",
                {"J_b.T @ F_t": "-J_b.T @ F_t"},
            ),
            Slip(
                "inverse for transpose",
                "You use the (pseudo-)inverse; torques are Jᵀ F: no matrix is inverted, and singularities do no harm.",
                {"J_b.T @ F_t": "np.linalg.pinv(J_b) @ F_t"},
            ),
            Slip(
                "torque first",
                "Your wrench is (τ, f); here the force comes first, (f, τ), as v does in twists.",
                {"J_b.T @ F_t": "J_b.T @ np.roll(F_t, 3)"},
            ),
            Slip(
                "force alone",
                "The torque of the wrench is left out: all six numbers count.",
                {"J_b.T @ F_t": "J_b[:3].T @ F_t[:3]"},
            ),
            Slip(
                "torque alone",
                "The force of the wrench is left out: all six numbers count.",
                {"J_b.T @ F_t": "J_b[3:].T @ F_t[3:]"},
            ),
            Slip(
                "not transposed",
                "You multiply by J itself: that takes joint rates to a twist, and fits only where there are six "
                "joints. Torques are Jᵀ F.",
                {"J_b.T @ F_t": "J_b @ F_t"},
            ),
        ),
    ),
    Exercise(
        tool_velocity,
        _by_motion,
        _moving,
        (
            Slip(
                "spatial for body",
                "You return the v of the spatial twist: that is the velocity of the point of the tool that lies at the "
                "origin of the base. At p it is v + ω × p.",
                {" + np.cross(V[3:], p)": ""},
            ),
            Slip(
                "sign of ω × p",
                "You have p × ω, the other way round: a turning body moves its points with ω × p.",
                {"np.cross(V[3:], p)": "np.cross(p, V[3:])"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"V[:3] + np.cross(V[3:], p)": "V[3:] + np.cross(V[:3], p)"}),
            Slip(
                "turn alone", "You have ω × p alone: add v, what the slides and distant axes do.", {"V[:3] + np": "np"}
            ),
        ),
        tolerance=1e-5,
    ),
)
