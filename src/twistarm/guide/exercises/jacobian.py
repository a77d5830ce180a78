"""Exercises on the manipulator Jacobian."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import body_columns, motion_of, spatial_columns, tool
from .instances import TIMES, chain, chains, own_chain
from .words import ADJOINT_TRANSPOSED, ANGULAR_FIRST, NO_CROSS_TERM


def spatial_jacobian(screws: Array, x: Array) -> Array:
    """The spatial Jacobian (6, m): column i is the twist of joint i where the joints before it have brought it,
    Ad(e^{ξ̂₁x₁} ⋯ e^{ξ̂ᵢ₋₁xᵢ₋₁}) ξᵢ.

    `screws` (6, m) holds the twists (v, ω) at rest, `x` (m,) the joints' values [rad, m].
    """
    from twistarm.theory.screws import adjoint, exp

    J = np.zeros(screws.shape)
    g = np.eye(4)
    for i in range(len(x)):
        J[:, i] = adjoint(g) @ screws[:, i]
        g = g @ exp(screws[:, i], x[i])
    return J


def body_jacobian(screws: Array, home: Array, x: Array) -> Array:
    """The body Jacobian (6, m): the spatial one seen from the tool, J^b = Ad(g_st⁻¹) J^s. `home` (4, 4) is the tool's
    pose at rest.
    """
    from twistarm.theory.screws import adjoint, exp

    J = np.zeros(screws.shape)
    g = np.eye(4)
    for i in range(len(x)):
        J[:, i] = adjoint(g) @ screws[:, i]
        g = g @ exp(screws[:, i], x[i])
    J_b: Array = adjoint(np.linalg.inv(g @ home)) @ J
    return J_b


def joint_torques(J_b: Array, F_t: Array) -> Array:
    """The torques and forces (m,) that the joints must supply so that the tool exerts the wrench `F_t` = (f, τ), (6,),
    seen from the tool. `J_b` (6, m) is the body Jacobian. Gravity is left out.
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


def _postures(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for screws, _, x in chains(rng, arm):
        yield screws, x


def _pushing(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for each in chains(rng, arm):
        yield body_columns(*each), rng.normal(size=6)
    yield body_columns(*_of_six(rng)), rng.normal(size=6)


def _of_six(rng: np.random.Generator) -> tuple[Array, Array, Array]:
    while True:
        screws, home, x = chain(rng)
        if len(x) >= 6:
            return screws[:, :6], home, x[:6]


def _moving(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for screws, home, x in [*(chain(rng) for _ in range(TIMES)), own_chain(rng, arm)]:
        yield spatial_columns(screws, x), tool(screws, home, x)[:3, 3], rng.normal(size=len(x))


def _by_power(J_b: Array, F_t: Array) -> Array:
    """Virtual work, joint by joint: the torque times a joint's rate is the power of the tool's push."""
    return np.array([F_t[:3] @ column[:3] + F_t[3:] @ column[3:] for column in J_b.T])


def _by_motion(J_s: Array, p: Array, rates: Array) -> Array:
    """By difference: where the motion of this twist brings the point in a millionth of a second, and back."""
    V = (J_s @ rates)[:, None]
    h = np.array([1e-6])
    ahead, behind = (motion_of(V, h * sign) @ np.append(p, 1.0) for sign in (1.0, -1.0))
    return np.array((ahead - behind)[:3] / 2e-6)


EXERCISES = (
    Exercise(
        spatial_jacobian,
        spatial_columns,
        _postures,
        (
            Slip(
                "columns not moved",
                "Your columns are the twists at rest: the joints before it have carried each of them "
                "along. Column i is Ad(e^{ξ̂₁x₁} ⋯ e^{ξ̂ᵢ₋₁xᵢ₋₁}) ξᵢ.",
                {"adjoint(g) @ screws[:, i]": "screws[:, i]"},
            ),
            Slip(
                "moved by all joints",
                "Each column is carried along by all joints, also by those after it: a joint moves nothing that stands "
                "before it.",
                {
                    "    for i in range(len(x)):\n": "    for i in range(len(x)):\n        g = g @ exp(screws[:, i], "
                    "x[i])\n    for i in range(len(x)):\n",
                    "        J[:, i] = adjoint(g) @ screws[:, i]\n        g = g @ "
                    "exp(screws[:, i], x[i])\n": "        J[:, i] = adjoint(g) @ screws[:, i]\n",
                },
            ),
            Slip(
                "order reversed",
                "The motions of the joints are multiplied in the reverse order: e^{ξ̂₁x₁} stands on the left.",
                {"g = g @ exp(screws[:, i], x[i])": "g = exp(screws[:, i], x[i]) @ g"},
            ),
            Slip("no p̂R", NO_CROSS_TERM, {"adjoint(g) @ screws": "np.kron(np.eye(2), g[:3, :3]) @ screws"}),
            Slip("Adjoint transposed", ADJOINT_TRANSPOSED, {"adjoint(g) @ screws": "adjoint(g).T @ screws"}),
            Slip(
                "Adjoint inverted",
                "The columns are carried backwards: it is the Adjoint of the motion, not of its inverse.",
                {"adjoint(g) @ screws": "adjoint(np.linalg.inv(g)) @ screws"},
            ),
            Slip(
                "only by the joint before",
                "Each column is carried along by the one joint before it alone: all before it do so. "
                "Multiply the motions.",
                {"g = g @ exp": "g = exp"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"return J": "return np.roll(J, 3, axis=0)"}),
        ),
    ),
    Exercise(
        body_jacobian,
        body_columns,
        chains,
        (
            Slip(
                "spatial for body",
                "This is the spatial Jacobian. Seen from the tool it is Ad(g_st⁻¹) J^s.",
                {"adjoint(np.linalg.inv(g @ home)) @ J": "J"},
            ),
            Slip(
                "home forgotten",
                "You carry the columns to where the tool has moved from the base, without its home pose: "
                "the tool is at e^{…} g_st(0).",
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
                {"adjoint(np.linalg.inv(g @ home))": "adjoint(g @ home).T"},
            ),
            Slip(
                "columns not moved",
                "The columns are the twists at rest, carried to the tool: the joints before each must move it first.",
                {"J[:, i] = adjoint(g) @ screws[:, i]": "J[:, i] = screws[:, i]"},
            ),
            Slip(
                "only turned",
                "You only turn the columns into the tool's axes: without −Rᵀp̂ v is that of the point at the base.",
                {"adjoint(np.linalg.inv(g @ home))": "np.kron(np.eye(2), (g @ home)[:3, :3].T)"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"return J_b": "return np.roll(J_b, 3, axis=0)"}),
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
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"V[:3] + np.cross(V[3:], p)": "V[3:] + np.cross(V[:3], p)"},
            ),
            Slip(
                "turn alone",
                "You have ω × p alone: add v, what the slides and distant axes do.",
                {"V[:3] + np": "np"},
            ),
        ),
        tolerance=1e-5,
    ),
)
