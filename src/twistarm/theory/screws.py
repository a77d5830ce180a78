"""Twists, screws and rigid motions: se(3), its exponential and logarithm, and the Adjoint.

A twist is xi = (v, w), linear part first; a pose is a homogeneous g. Every function takes any leading (batch) axes.
InputError names a wrong shape or a number that is not finite. It also names a pose that is not in SE(3), and axes that
do not broadcast.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_floats, as_pose, as_twist, frozen, require_broadcast, require_choice
from ..support.display import Brief
from ..support.errors import InputError
from . import rotations
from .rotations import cross, skew

ALGEBRA_TOL = 1e-4
"""How far, relative to its size, a matrix may be from so(3) or se(3): room for numerical derivatives."""

Twists = Literal["rows", "columns"]

TRANSLATION_TOL = 1e-15
"""A twist with less rotation than this, in rad per metre, is a translation: the rest is rounding."""


# se(3) ------------------------------------------------------------------------------------------------


def hat(xi: ArrayLike) -> Array:
    """ξ̂ = [ŵ, v; 0, 0] (..., 4, 4) of a twist (..., 6), or ŵ (..., 3, 3) of a vector (..., 3).

    The length of the last axis decides. MLS §2.2.1 and §2.3.2.
    """
    xi = as_floats(xi, "xi")
    if xi.ndim == 0 or xi.shape[-1] not in (3, 6):
        raise InputError(f"xi must have shape (..., 6), a twist, or (..., 3), a vector; got {xi.shape}")
    if xi.shape[-1] == 3:
        return skew(xi)
    matrix = np.zeros((*xi.shape[:-1], 4, 4))
    matrix[..., :3, :3] = skew(xi[..., 3:])
    matrix[..., :3, 3] = xi[..., :3]
    return matrix


def vee(matrix: ArrayLike) -> Array:
    """The twist (..., 6) of a matrix (..., 4, 4) in se(3), or the vector (..., 3) of one (..., 3, 3) in so(3).

    The inverse of `hat`. It drops the symmetric part that a numerical derivative leaves. InputError for more than
    `ALGEBRA_TOL` of the matrix's largest entry, or of 1 if that is more.
    """
    matrix = as_floats(matrix, "matrix")
    if matrix.shape[-2:] not in ((3, 3), (4, 4)):
        raise InputError(f"matrix must have shape (..., 4, 4) or (..., 3, 3); got {matrix.shape}")
    W = matrix[..., :3, :3]
    symmetric, last_row = W + np.swapaxes(W, -1, -2), matrix[..., 3:, :]  # so(3) has no last row
    off = np.maximum(*(np.abs(part).max(axis=(-2, -1), initial=0.0) for part in (symmetric, last_row)))
    if (far := off > ALGEBRA_TOL * np.maximum(1.0, np.abs(matrix).max(axis=(-2, -1), initial=0.0))).any():
        space = "so(3), skew-symmetric" if matrix.shape[-1] == 3 else "se(3), [ŵ, v; 0, 0]"
        raise InputError(f"matrix is not in {space}: it is off by {off[far].max():.3g}; build it with hat")
    w = 0.5 * np.stack([W[..., k, j] - W[..., j, k] for j, k in ((1, 2), (2, 0), (0, 1))], axis=-1)
    return w if matrix.shape[-1] == 3 else np.concatenate([matrix[..., :3, 3], w], axis=-1)


def bracket(a: ArrayLike, b: ArrayLike) -> Array:
    """The Lie bracket [a, b] (..., 6) of two twists: the twist of â b̂ − b̂ â. MLS App. A; Lynch & Park §8.2.

    [a, b] = (w_a × v_b − w_b × v_a, w_a × w_b), the derivative of Ad(e^{ât}) b at t = 0.

    Args:
        a: Twists (..., 6).
        b: Twists (..., 6).
    """
    a, b = as_twist(a, "a"), as_twist(b, "b")
    require_broadcast(a=a.shape[:-1], b=b.shape[:-1])
    linear = cross(a[..., 3:], b[..., :3]) - cross(b[..., 3:], a[..., :3])
    return np.concatenate([linear, cross(a[..., 3:], b[..., 3:])], axis=-1)


def from_angular_first(V: ArrayLike, *, twists: Twists | None = None) -> Array:
    """The twist (v, w) of Lynch & Park's (w, v), an array of the same shape. Wrenches too: (f, τ) from (τ, f).

    Args:
        V: Twists (w, v) or wrenches (τ, f): rows (..., 6), or columns (..., 6, n) as in a Jacobian.
        twists: "rows" or "columns"; by default rows. InputError for (..., 6, 6) without it, which may be either.
    """
    return _swapped(V, "V", twists)


def to_angular_first(xi: ArrayLike, *, twists: Twists | None = None) -> Array:
    """Lynch & Park's (w, v) of the twist (v, w), an array of the same shape. Wrenches too: (τ, f) from (f, τ).

    Args:
        xi: Twists (v, w) or wrenches (f, τ): rows (..., 6), or columns (..., 6, n) as in a Jacobian.
        twists: "rows" or "columns"; by default rows. InputError for (..., 6, 6) without it, which may be either.
    """
    return _swapped(xi, "xi", twists)


def _swapped(value: ArrayLike, name: str, twists: Twists | None) -> Array:
    """Twists with their halves swapped: there and back alike."""
    array = as_floats(value, name)
    if twists is None and array.shape[-2:] == (6, 6):
        raise InputError(f'{name} of shape {array.shape} may hold twists either way: say twists="rows" or "columns"')
    if twists is not None and require_choice(twists, ("rows", "columns"), "twists") == "columns":
        if array.ndim < 2 or array.shape[-2] != 6:
            raise InputError(f"{name} must have shape (..., 6, n), a twist in each column; got {array.shape}")
        return np.roll(array, 3, axis=-2)
    if array.ndim > 1 and array.shape[-2] == 6 and array.shape[-1] != 6:
        raise InputError(f'{name} of shape {array.shape} holds twists in its columns: say twists="columns"')
    return np.roll(as_twist(array, name), 3, axis=-1)


# SE(3) ------------------------------------------------------------------------------------------------


def exp(xi: ArrayLike, theta: ArrayLike = 1.0) -> Array:
    """The motion g = e^{ξ̂θ} (..., 4, 4) along the twist xi = (v, w) (..., 6) by θ.

    By Chasles' theorem it turns about a line and slides along it. Let u = w/‖w‖, φ = ‖w‖θ and v = v∥ + v⊥ along and
    across u. The turn is A = hat(v⊥/‖w‖, u) and the slide C = hat(v∥, 0).
    Then e^{ξ̂θ} = I + A sin φ + A² (1 − cos φ) + C θ. Where w = 0, A = 0 and C = hat(v, 0).
    The series end so because A³ = −A and A C = C A = 0.
    This is MLS §2.3.2 (eq. 2.32 and 2.36, there for ‖w‖ = 1) in a form where nothing cancels: accurate to rounding for
    every ‖w‖.

    Args:
        xi: Twists (..., 6), linear part first.
        theta: Multiples (...), which broadcast against the leading axes of xi.
    """
    xi, theta = as_twist(xi, "xi"), as_floats(theta, "theta")
    require_broadcast(xi=xi.shape[:-1], theta=theta.shape)
    return exp_along(*turn_and_slide(xi), theta)


def exp_along(terms: Array, length: Array, theta: Array) -> Array:
    """The motions (..., 4, 4) of `exp` from what `turn_and_slide` computed of the twists, unchecked.

    Args:
        terms: A, A² and C, each flattened, (..., 3, 16).
        length: ‖w‖ (...).
        theta: Multiples (...) of the twists.
    """
    half = 0.5 * length * theta
    sin_half = np.sin(half)
    coefficients = np.empty((*half.shape, 1, 3))
    coefficients[..., 0, 0] = 2.0 * sin_half * np.cos(half)
    coefficients[..., 0, 1] = 2.0 * sin_half**2  # 1 − cos φ, which would cancel near 0
    coefficients[..., 0, 2] = theta
    return (coefficients @ terms).reshape(*half.shape, 4, 4) + np.eye(4)


def turn_and_slide(xi: Array) -> tuple[Array, Array]:
    """A, A² and C of `exp`, each flattened, (..., 3, 16), and ‖w‖ (...), of twists (..., 6), unchecked.

    They do not depend on θ: for `exp_along` at many θ they are computed once.
    """
    v, (u, length) = xi[..., :3], rotations.split(xi[..., 3:])
    turning = (length > 0)[..., None]  # `split` has set the length of tiny w to 0
    along = np.where(turning, u * np.sum(u * v, axis=-1, keepdims=True), v)
    across = (v - along) / np.where(turning, length[..., None], 1.0)
    A = hat(np.concatenate([across, u], axis=-1))
    C = hat(np.concatenate([along, np.zeros_like(u)], axis=-1))
    return np.stack([A, A @ A, C], axis=-3).reshape(*length.shape, 3, 16), length


def log(g: ArrayLike) -> Array:
    """The twist xi = (v, w) (..., 6) with e^ξ̂ = g and ‖w‖ ≤ π; the inverse of `exp`.

    w = log R. With φ = ‖w‖ and p = p∥ + p⊥ along and across w, v = p∥ + (φ/2) cot(φ/2) p⊥ − ½ w × p, and v = p where
    w = 0. MLS §2.3.2 (Prop. 2.9); Lynch & Park §3.3.3. Nothing cancels: accurate to rounding for φ in [0, π].
    At φ = π the first non-zero component of w is positive.
    """
    g = as_pose(g, "pose g")
    w, p = rotations.log_of(g[..., :3, :3]), g[..., :3, 3]
    u, angle = rotations.split(w)
    half = 0.5 * angle
    # (φ/2) cot(φ/2) as cos/sinc is finite at 0 and accurate up to π.
    sinc = np.divide(np.sin(half), half, out=np.ones_like(half), where=half != 0)
    along = u * np.sum(u * p, axis=-1, keepdims=True)
    v = along + (np.cos(half) / sinc)[..., None] * (p - along) - 0.5 * cross(w, p)
    return np.concatenate([v, w], axis=-1)


def inverse(g: ArrayLike) -> Array:
    """The pose g⁻¹ = [Rᵀ, −Rᵀp; 0, 1] (..., 4, 4): g_ba of g_ab. MLS §2.3.1."""
    return inverse_of(as_pose(g, "pose g"))


def adjoint(g: ArrayLike) -> Array:
    """The Adjoint Ad_g = [R, p̂R; 0, R] (..., 6, 6): with g = g_ab, ξ_a = Ad_g ξ_b. MLS §2.4.2.

    Ad_{gh} = Ad_g Ad_h, and g e^ξ̂ g⁻¹ is the exponential of Ad_g ξ. For wrenches see `transform_wrench`.
    """
    return adjoint_of(as_pose(g, "pose g"))


def transform_twist(g_ab: ArrayLike, xi_b: ArrayLike) -> Array:
    """The twist seen from a, ξ_a = Ad_{g_ab} ξ_b (..., 6): (R v + p × R w, R w). MLS §2.4.4.

    Args:
        g_ab: Poses (..., 4, 4) of frame b seen from frame a.
        xi_b: Twists (v, w) (..., 6) seen from b.
    """
    g, xi = as_pose(g_ab, "pose g_ab"), as_twist(xi_b, "xi_b")
    require_broadcast(g_ab=g.shape[:-2], xi_b=xi.shape[:-1])
    v, w = _rotated(g, xi)
    return np.concatenate([v + cross(g[..., :3, 3], w), w], axis=-1)


def transform_wrench(g_ab: ArrayLike, F_b: ArrayLike) -> Array:
    """The wrench seen from a, F_a = Ad_{g_ba}ᵀ F_b (..., 6): (R f, R τ + p × R f). MLS §2.5.1.

    Power does not depend on the frame: F_a · ξ_a = F_b · ξ_b.

    Args:
        g_ab: Poses (..., 4, 4) of frame b seen from frame a.
        F_b: Wrenches (f, τ) (..., 6) seen from b.
    """
    g, F = as_pose(g_ab, "pose g_ab"), as_twist(F_b, "F_b")  # a wrench has the shape of a twist
    require_broadcast(g_ab=g.shape[:-2], F_b=F.shape[:-1])
    f, torque = _rotated(g, F)
    return np.concatenate([f, torque + cross(g[..., :3, 3], f)], axis=-1)


def inverse_of(g: Array) -> Array:
    """`inverse` of a pose already checked."""
    Rt = np.swapaxes(g[..., :3, :3], -1, -2)
    result = np.zeros_like(g)
    result[..., :3, :3] = Rt
    result[..., :3, 3] = -(Rt @ g[..., :3, 3, None])[..., 0]
    result[..., 3, 3] = 1.0
    return result


def adjoint_of(g: Array) -> Array:
    """`adjoint` of a pose already checked."""
    R = g[..., :3, :3]
    Ad = np.zeros((*g.shape[:-2], 6, 6))
    Ad[..., :3, :3] = Ad[..., 3:, 3:] = R
    Ad[..., :3, 3:] = skew(g[..., :3, 3]) @ R
    return Ad


def _rotated(g: Array, halves: Array) -> tuple[Array, Array]:
    """Both halves (..., 3) of a twist or wrench, rotated by g."""
    R = g[..., :3, :3]
    return (R @ halves[..., :3, None])[..., 0], (R @ halves[..., 3:, None])[..., 0]


# screws -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class Screw(Brief):
    """The geometry of a twist: turning about a line while sliding along it (Chasles). MLS §2.3.3.

    axis: unit vector (..., 3); zero for the zero twist.
    point: the point of the line nearest the origin (..., 3) [m]; the origin for a pure translation.
    pitch: slide per radian (...) [m/rad]; inf for a pure translation.
    magnitude: ‖w‖ (...) [rad], or ‖v‖ [m] for a pure translation.
    """

    axis: Array
    point: Array
    pitch: Array
    magnitude: Array

    def __post_init__(self) -> None:
        for name in ("axis", "point", "pitch", "magnitude"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def twist(self) -> Array:
        """The twist (..., 6) it came from: w = M u, v = M (q × u + h u); w = 0, v = M u where h is inf."""
        pure = np.isinf(self.pitch)[..., None]
        slide = np.where(pure, 0.0, self.pitch[..., None]) * self.axis
        v = np.where(pure, self.axis, cross(self.point, self.axis) + slide)
        w = np.where(pure, 0.0, self.axis)
        return np.concatenate([v, w], axis=-1) * self.magnitude[..., None]


def to_screw(xi: ArrayLike) -> Screw:
    """The screw of a twist (..., 6): axis w/‖w‖, point (w × v)/‖w‖², pitch wᵀv/‖w‖², magnitude ‖w‖.

    A pure translation, w = 0 or no more than the rounding of v (`TRANSLATION_TOL`): axis v/‖v‖, point 0,
    pitch inf, magnitude ‖v‖. `Screw.twist` leads back. MLS §2.3.3.
    """
    xi = as_twist(xi, "xi")
    (v_axis, speed), (w_axis, rate) = rotations.split(xi[..., :3]), rotations.split(xi[..., 3:])
    pure = rate <= TRANSLATION_TOL * speed
    per_radian = xi[..., :3] / np.where(pure, 1.0, rate)[..., None]
    point = np.where(pure[..., None], 0.0, cross(w_axis, per_radian))
    pitch = np.where(pure, np.inf, np.sum(w_axis * per_radian, axis=-1))
    return Screw(np.where(pure[..., None], v_axis, w_axis), point, pitch, np.where(pure, speed, rate))
