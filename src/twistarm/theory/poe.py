"""The product of exponentials: forward kinematics and Jacobians of a serial chain from (screws, home).

`screws` (6, m) are the space twists of the m moving joints, base to tip, linear part first. `home` (4, 4) is g_st.
Both hold at theta = 0. `x` (..., m) are the joint values [rad or m]: theta, or `A @ theta` for a chain with mimic
joints. InputError names another shape, a number that is not finite, or a home that is not in SE(3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_floats, as_pose, as_theta, require_one
from ..support.errors import InputError
from .rotations import cross
from .screws import adjoint_of, exp, inverse_of


def fk(screws: ArrayLike, home: ArrayLike, x: ArrayLike) -> Array:
    """g_st(x) = e^{ξ̂₁x₁} ⋯ e^{ξ̂ₘxₘ} g_st(0), (..., 4, 4). MLS §3.2.2, eq. 3.3.

    Args:
        screws: Space twists (6, m).
        home: The tool's pose at rest (4, 4).
        x: Joint values (..., m) [rad, m].
    """
    S, home = _as_screws(screws), _as_home(home)
    return _motion(motions(S, x)) @ home


def fk_body(body_screws: ArrayLike, home: ArrayLike, x: ArrayLike) -> Array:
    """g_st(x) = g_st(0) e^{B̂₁x₁} ⋯ e^{B̂ₘxₘ}, (..., 4, 4), from `body_screws`. Lynch & Park §4.1.3.

    Args:
        body_screws: Twists (6, m) in the tool frame at rest.
        home: The tool's pose at rest (4, 4).
        x: Joint values (..., m) [rad, m].
    """
    B, home = _as_screws(body_screws, "body_screws"), _as_home(home)
    return home @ _motion(motions(B, x))


def body_screws(screws: ArrayLike, home: ArrayLike) -> Array:
    """The joint twists in the tool frame, at theta = 0: B_i = Ad(g_st(0)⁻¹) ξ_i, (6, m).

    Args:
        screws: Space twists (6, m).
        home: The tool's pose at rest (4, 4).
    """
    return adjoint_of(inverse_of(_as_home(home))) @ _as_screws(screws)


def spatial_jacobian(screws: ArrayLike, x: ArrayLike) -> Array:
    """J^s (..., 6, m) with V^s = J^s dx/dt: column i is Ad(e^{ξ̂₁x₁} ⋯ e^{ξ̂ᵢ₋₁xᵢ₋₁}) ξ_i. MLS §3.4.1.

    Column i is the twist of joint i at x. With mimic joints, V^s = J^s A dtheta/dt.

    Args:
        screws: Space twists (6, m).
        x: Joint values (..., m) [rad, m].
    """
    S = _as_screws(screws)
    return columns(motions(S, x), S)


def body_jacobian(screws: ArrayLike, home: ArrayLike, x: ArrayLike) -> Array:
    """J^b (..., 6, m) with V^b = J^b dx/dt: J^b = Ad(g_st(x)⁻¹) J^s. MLS §3.4.1.

    Args:
        screws: Space twists (6, m).
        home: The tool's pose at rest (4, 4).
        x: Joint values (..., m) [rad, m].
    """
    S, home = _as_screws(screws), _as_home(home)
    moved = motions(S, x)
    return adjoint_of(inverse_of(_motion(moved) @ home)) @ columns(moved, S)


def motions(S: Array, x: ArrayLike) -> Array:
    """The motion of each joint, (..., m, 4, 4): e^{ξ̂₁x₁}, e^{ξ̂₁x₁} e^{ξ̂₂x₂}, … The last is that of the tool.

    Args:
        S: Space twists (6, m), already checked.
        x: Joint values (..., m) [rad, m].
    """
    return products(exp(S.T, as_theta(x, S.shape[1], "x")))


def products(factors: Array) -> Array:
    """The running products g₁, g₁ g₂, … of motions (..., m, 4, 4), which they replace in the given array."""
    for i in range(1, factors.shape[-3]):  # each product is the next one's first factor, so in place
        factors[..., i, :, :] = factors[..., i - 1, :, :] @ factors[..., i, :, :]
    return factors


def _motion(moved: Array) -> Array:
    """The last of the motions (..., 4, 4). The identity for a chain without joints."""
    if moved.shape[-3] == 0:
        return np.broadcast_to(np.eye(4), (*moved.shape[:-3], 4, 4))
    return moved[..., -1, :, :]


def columns(moved: Array, S: Array) -> Array:
    """J^s (..., 6, m): each twist of S carried along. Ad(e^{ξ̂ᵢxᵢ}) ξᵢ = ξᵢ, so a joint's own motion may count too.

    Args:
        moved: The joints' motions (..., m, 4, 4), as `motions` gives them.
        S: Space twists (6, m).
    """
    J = np.empty((*moved.shape[:-3], *S.shape))
    v, w = np.moveaxis(moved[..., :3, :3] @ S.T.reshape(-1, 2, 3).swapaxes(1, 2), -1, 0)
    J[..., :3, :] = np.swapaxes(v + cross(moved[..., :3, 3], w), -1, -2)
    J[..., 3:, :] = np.swapaxes(w, -1, -2)
    return J


def _as_screws(value: ArrayLike, name: str = "screws") -> Array:
    S = as_floats(value, name)
    if S.ndim != 2 or S.shape[0] != 6:
        raise InputError(f"{name} must have shape (6, m), one column per moving joint; got {S.shape}")
    return S


def _as_home(value: ArrayLike) -> Array:
    return require_one(as_pose(value, "home pose"), "home pose", 2)
