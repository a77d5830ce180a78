"""Rotations in space: SO(3) as matrices, and its parametrisations by angles, quaternions, axis and angle.

Matrices act on columns, `p_a = R_ab @ p_b`. Every function takes any leading (batch) axes. InputError names a matrix
that is no rotation or a wrong shape. It also names a number that is not finite, and axes that do not broadcast.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_direction, as_floats, as_rotation, as_vector, nearest_rotation, require_broadcast
from ..support.errors import InputError, quote

HALF_TURN_TOL = 5e-16
"""A quaternion's scalar part below this is rounding: a half turn, for which Q and −Q are equally good."""

GIMBAL_LOCK_TOL = 1e-14
"""Below this the sine that separates the first Euler angle from the third is rounding."""

INDEFINITE = 1e-12
"""Where σ₂ ± σ₃ of a matrix scaled to 1 is no more than this, rounding alone decides which rotation is nearest."""

TINY = 1e-200
"""A vector shorter than this has no direction: its quotients would lose digits to underflow."""


# so(3) and its exponential ----------------------------------------------------------------------------


def skew(w: ArrayLike) -> Array:
    """The matrix ŵ (..., 3, 3) with ŵ q = w × q, of w (..., 3). MLS §2.2.1."""
    w = as_vector(w, "w")
    matrix = np.zeros((*w.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return matrix


def exp(w: ArrayLike, theta: ArrayLike = 1.0) -> Array:
    """The rotation R = e^{ŵθ} (..., 3, 3) about w (..., 3) by ‖w‖θ [rad], w of any length.

    Rodrigues' formula, MLS §2.2.2 (eq. 2.14), holds for unit vectors. With u = w/‖w‖ and φ = ‖w‖θ it is
    R = I + û sin φ + û² (1 − cos φ), and R = I where w = 0. Accurate to rounding for every φ.

    Args:
        w: Rotation vectors (..., 3).
        theta: Multiples (...), which broadcast against the leading axes of w.
    """
    w, theta = as_vector(w, "w"), as_floats(theta, "theta")
    require_broadcast(w=w.shape[:-1], theta=theta.shape)
    u, length = split(w)
    half = 0.5 * length * theta
    return _rodrigues(u, np.sin(half), np.cos(half))


def log(R: ArrayLike) -> Array:
    """The shortest w (..., 3) [rad] with e^ŵ = R, ‖w‖ ≤ π. The inverse of `exp`.

    w = 2 atan2(‖q‖, q₀) q/‖q‖ from the quaternion (q₀, q), which is accurate near 0 and near π alike. At ‖w‖ = π, w and
    −w give the same R. The first non-zero component of w is then positive.
    """
    return log_of(as_rotation(R))


def log_of(R: Array) -> Array:
    """`log` of a rotation already checked."""
    axis, angle = _axis_angle(R)
    return axis * angle[..., None]


def nearest(A: ArrayLike) -> Array:
    """The rotation R (..., 3, 3) nearest to a matrix A (..., 3, 3): the least ‖R − A‖ in the Frobenius norm.

    A = U Σ Vᵀ has the singular values σ₁ ≥ σ₂ ≥ σ₃. With s = det U Vᵀ = ±1 it is R = U diag(1, 1, s) Vᵀ. Where s = 1,
    that is the orthogonal factor of the polar decomposition. A positive factor of A changes nothing, and a rotation is
    its own nearest. InputError unless σ₂ + s σ₃ > 0. A matrix of rank 1 or 0, or a reflection with σ₂ = σ₃, is equally
    near to many rotations.

    Source: Kabsch 1976, "A solution for the best rotation to relate two sets of vectors". Golub & Van Loan, Matrix
    Computations, §6.4.1 (the orthogonal Procrustes problem).
    """
    A = as_floats(A, "A")
    if A.shape[-2:] != (3, 3):
        raise InputError(f"A must have shape (..., 3, 3); got {A.shape}")
    # Scaled first, so that nothing overflows.
    size = np.abs(A).max(axis=(-2, -1), keepdims=True)
    R, definite = nearest_rotation(A / np.where(size > 0.0, size, 1.0))
    if not (definite > INDEFINITE).all():
        raise InputError("A has no one nearest rotation: it flattens space to a line, or mirrors it alike in a plane")
    return R


def angle_between(R1: ArrayLike, R2: ArrayLike) -> Array:
    """The angle (...) in [0, π] [rad] of R1ᵀ R2, which takes R1 to R2. Accurate near 0 and near π.

    Args:
        R1: Rotations (..., 3, 3).
        R2: Rotations (..., 3, 3).
    """
    R1, R2 = as_rotation(R1, "R1"), as_rotation(R2, "R2")
    require_broadcast(R1=R1.shape[:-2], R2=R2.shape[:-2])
    return _axis_angle(np.swapaxes(R1, -1, -2) @ R2)[1]


def split(w: Array) -> tuple[Array, Array]:
    """(u, ‖w‖): direction (..., 3) and length (...) of w (..., 3), both zero where ‖w‖ ≤ `TINY`."""
    length: Array = np.hypot(np.hypot(w[..., 0], w[..., 1]), w[..., 2])  # squares would overflow, or underflow
    nonzero = length > TINY
    return w / np.where(nonzero, length, np.inf)[..., None], np.where(nonzero, length, 0.0)


def cross(a: Array, b: Array) -> Array:
    """The cross product a × b (..., 3), as `numpy.cross`, unchecked and three times as fast for single vectors.

    Args:
        a: Vectors (..., 3).
        b: Vectors (..., 3).
    """
    result = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        result[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return result


def _rodrigues(u: Array, sin_half: Array, cos_half: Array) -> Array:
    """I + û sin φ + û² (1 − cos φ) for a unit vector u, or I for u = 0.

    The half angle keeps 1 − cos φ = 2 sin² φ/2 accurate near 0.
    """
    u_hat = skew(u)
    sin, versine = 2.0 * sin_half * cos_half, 2.0 * sin_half**2
    return sin[..., None, None] * u_hat + versine[..., None, None] * (u_hat @ u_hat) + np.eye(3)


# axis and angle ---------------------------------------------------------------------------------------


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """The rotation (..., 3, 3) by `angle` (...) [rad] about `axis` (..., 3).

    Args:
        axis: Axes (..., 3), of any length but 0.
        angle: Angles (...) [rad].
    """
    axis, angle = as_direction(axis, "axis"), as_floats(angle, "angle")
    require_broadcast(axis=axis.shape[:-1], angle=angle.shape)
    return exp(axis, angle)


def to_axis_angle(R: ArrayLike) -> tuple[Array, Array]:
    """(axis, angle): the unit axis (..., 3) and the angle (...) in [0, π] [rad] of R (..., 3, 3).

    At angle 0 the axis is z. At π the axis's first non-zero component is positive.
    """
    return _axis_angle(as_rotation(R))


def _axis_angle(R: Array) -> tuple[Array, Array]:
    Q = _quaternion(R)
    axis, sin_half = split(Q[..., 1:])
    axis = np.where(sin_half[..., None] == 0, [0.0, 0.0, 1.0], axis)
    angle: Array = 2.0 * np.arctan2(sin_half, Q[..., 0])
    return axis, angle


# quaternions ------------------------------------------------------------------------------------------


def from_quaternion_wxyz(Q: ArrayLike) -> Array:
    """The rotation (..., 3, 3) p ↦ Q p Q⁻¹ of Q = (q₀, q) (..., 4), scalar first. MLS §2.2.3.

    Q need not have length 1: every multiple of Q, −Q among them, is the same rotation. InputError for Q = 0.
    """
    Q, _ = _unit_quaternion(Q)
    axis, sin_half = split(Q[..., 1:])
    return _rodrigues(axis, sin_half, Q[..., 0])


def to_quaternion_wxyz(R: ArrayLike) -> Array:
    """The unit quaternion (q₀, q) (..., 4) of R (..., 3, 3), scalar first. Of the two, the one with q₀ ≥ 0.

    At a half turn q₀ = 0, and the first non-zero component is positive.
    """
    return _quaternion(as_rotation(R))


def from_xyzw(Q: ArrayLike) -> Array:
    """`from_quaternion_wxyz` for the scalar-last order of ROS, SciPy and Pinocchio."""
    return from_quaternion_wxyz(np.roll(as_vector(Q, "quaternion", 4), 1, axis=-1))


def to_xyzw(R: ArrayLike) -> Array:
    """`to_quaternion_wxyz` in the scalar-last order of ROS, SciPy and Pinocchio."""
    return np.roll(to_quaternion_wxyz(R), -1, axis=-1)


def quaternion_product_wxyz(P: ArrayLike, Q: ArrayLike) -> Array:
    """P Q = (p₀q₀ − p·q, p₀q + q₀p + p × q) (..., 4), scalar first: Q turns first, then P. MLS §2.2.3.

    Args:
        P: Quaternions (..., 4), scalar first.
        Q: Quaternions (..., 4), scalar first.
    """
    P, Q = as_vector(P, "P", 4), as_vector(Q, "Q", 4)
    require_broadcast(P=P.shape[:-1], Q=Q.shape[:-1])
    p0, p, q0, q = P[..., :1], P[..., 1:], Q[..., :1], Q[..., 1:]
    scalar = p0 * q0 - np.sum(p * q, axis=-1, keepdims=True)
    return np.concatenate([scalar, p0 * q + q0 * p + cross(p, q)], axis=-1)


def quaternion_inverse_wxyz(Q: ArrayLike) -> Array:
    """Q⁻¹ = Q*/‖Q‖² (..., 4), scalar first, for Q of any length; ‖Q‖² = Q Q*. InputError for Q = 0."""
    unit, length = _unit_quaternion(Q)
    return unit * [1.0, -1.0, -1.0, -1.0] / length


def _unit_quaternion(Q: ArrayLike) -> tuple[Array, Array]:
    Q = as_vector(Q, "quaternion", 4)
    length = np.hypot.reduce(Q, axis=-1, keepdims=True)
    if not (length > TINY).all():
        raise InputError("quaternion must not be zero: it is no rotation (the identity has scalar part 1)")
    return Q / length, length


def _quaternion(R: Array) -> Array:
    """`to_quaternion_wxyz` of a rotation already checked.

    The entries of R give the sixteen products 4 QQᵀ. The row with the largest diagonal is 4 q_i Q, where nothing
    cancels (Shepperd, Quaternion from rotation matrix, 1978).
    """
    products = _quaternion_products(R)
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    row = np.take_along_axis(products, largest[..., None, None], axis=-2)[..., 0, :]  # nothing cancels in it
    Q = row / np.linalg.norm(row, axis=-1, keepdims=True)
    Q = np.where((np.arange(4) == 0) & (np.abs(Q) <= HALF_TURN_TOL), 0.0, Q)
    first = np.argmax(np.abs(Q) > HALF_TURN_TOL, axis=-1)  # beyond rounding: it is made positive
    sign = np.sign(np.take_along_axis(Q, first[..., None], axis=-1))
    return Q * sign + 0.0  # + 0.0 turns −0 into 0


def _quaternion_products(R: Array) -> Array:
    """4 QQᵀ (..., 4, 4), scalar first."""
    transpose = np.swapaxes(R, -1, -2)
    diagonal = np.diagonal(R, axis1=-2, axis2=-1)
    trace = diagonal.sum(axis=-1)
    products = np.empty((*R.shape[:-2], 4, 4))
    products[..., 1:, 1:] = R + transpose
    for i in range(3):
        products[..., i + 1, i + 1] = 1.0 + 2.0 * diagonal[..., i] - trace
        j, k = (i + 1) % 3, (i + 2) % 3
        products[..., 0, i + 1] = products[..., i + 1, 0] = R[..., k, j] - R[..., j, k]
    products[..., 0, 0] = 1.0 + trace
    return products


# Euler angles -----------------------------------------------------------------------------------------


_MOVING = tuple("".join(axes) for axes in product("XYZ", repeat=3) if axes[0] != axes[1] != axes[2])
EULER_ORDERS = (*_MOVING, *(order.lower() for order in _MOVING))
"""The 24 orders: capitals turn about the moving axes ('ZYZ'), small letters about the fixed ones ('xyz')."""


def from_euler(order: str, angles: ArrayLike) -> Array:
    """The rotation (..., 3, 3) of three angles (..., 3) [rad], listed as the letters of the order are. MLS §2.2.3.

    Capitals turn about the moving axes: 'ZYZ' is R_Z(α) R_Y(β) R_Z(γ). Small letters turn about the fixed axes: 'xyz'
    is R_z(γ) R_y(β) R_x(α).

    Args:
        order: One of the 24 `EULER_ORDERS`.
        angles: Angles (..., 3) [rad].
    """
    axes, angles = _left_to_right(order, angles)
    first, second, third = (exp(np.eye(3)[axis], angles[..., n]) for n, axis in enumerate(axes))
    return first @ second @ third


def to_euler(order: str, R: ArrayLike) -> Array:
    """The angles (..., 3) [rad] with `from_euler(order, angles) == R`, for any of the 24 orders.

    The middle angle lies in [0, π] if the outer two turn about the same axis, else in [−π/2, π/2]. The outer two lie in
    (−π, π]. Gimbal lock is at the ends of the middle one's range. Only the sum or difference of the outer two is
    determined there. The last of the list is then 0.

    R = R_i(a) R_j(b) R_k(c). Its column R e_k = R_i(a) R_j(b) e_k gives a and b. The row (R_i(a) e_j)ᵀ R = e_jᵀ R_k(c)
    then gives c. So the angles meet R even for a badly determined a.

    Args:
        order: One of the 24 `EULER_ORDERS`.
        R: Rotations (..., 3, 3).
    """
    (i, j, k), fixed = _euler_axes(order)
    R = as_rotation(R)
    proper = i == k
    start = _third(i, j) if proper else k
    side = _third(i, start)
    lean = _sign(j, k) if proper else 1.0
    height, radius = R[..., i, k], np.hypot(R[..., start, k], R[..., side, k])
    locked = radius <= GIMBAL_LOCK_TOL
    a = np.arctan2(lean * _sign(i, start) * R[..., side, k], lean * R[..., start, k])
    a = np.where(locked, 0.0, a)
    b = np.arctan2(radius, height) if proper else np.arctan2(_sign(j, k) * height, radius)
    # From a, not from R alone: an error of a, large near the lock, is made good by c.
    row = np.cos(a)[..., None] * R[..., j, :] + (_sign(i, j) * np.sin(a))[..., None] * R[..., _third(i, j), :]
    c = np.arctan2(-_sign(k, j) * row[..., _third(j, k)], row[..., j])
    if fixed:  # a is the last of the list, and 0 at the lock already
        return np.stack([c, b, a], axis=-1)
    return np.stack([np.where(locked, np.sign(height) * c, a), b, np.where(locked, 0.0, c)], axis=-1)


def euler_rate_map(order: str, angles: ArrayLike) -> Array:
    """The map B (..., 3, 3) with ω = B(angles) d(angles)/dt, ω the angular velocity in the fixed axes.

    Its columns are the three axes of rotation at these angles. At gimbal lock two of them coincide, det B = 0, and
    `numpy.linalg.cond(B)` grows without bound.

    Args:
        order: One of the 24 `EULER_ORDERS`.
        angles: Angles (..., 3) [rad].
    """
    (i, j, k), angles = _left_to_right(order, angles)
    first = exp(np.eye(3)[i], angles[..., 0])
    second = first @ exp(np.eye(3)[j], angles[..., 1])
    columns = [np.broadcast_to(np.eye(3)[i], angles.shape), first[..., :, j], second[..., :, k]]
    return np.stack(columns[::-1] if order.islower() else columns, axis=-1)


def from_rpy(rpy: ArrayLike) -> Array:
    """R = R_z(yaw) R_y(pitch) R_x(roll) of (roll, pitch, yaw) (..., 3) [rad]: URDF's fixed-axis XYZ."""
    return from_euler("xyz", as_vector(rpy, "rpy"))


def to_rpy(R: ArrayLike) -> Array:
    """(roll, pitch, yaw) (..., 3) [rad] of R, pitch in [−π/2, π/2]; yaw = 0 at gimbal lock."""
    return to_euler("xyz", R)


def _left_to_right(order: str, angles: ArrayLike) -> tuple[tuple[int, int, int], Array]:
    """Axes and angles in the order of the factors of R, from left to right."""
    axes, fixed = _euler_axes(order)
    angles = as_vector(angles, "angles")
    return axes, angles[..., ::-1] if fixed else angles


def _euler_axes(order: str) -> tuple[tuple[int, int, int], bool]:
    """The axes of the factors of R from left to right, and whether the order lists them backwards."""
    if not isinstance(order, str) or order not in EULER_ORDERS:
        raise InputError(
            f"no Euler order {quote(order)}: give three letters of XYZ (about the moving axes) or xyz (about the "
            "fixed axes), neighbours different, for example 'ZYZ', 'ZYX' or 'xyz'"
        )
    fixed = order.islower()
    i, j, k = ("xyz".index(letter) for letter in (reversed(order) if fixed else order.lower()))
    return (i, j, k), fixed


def _third(i: int, j: int) -> int:
    return 3 - i - j


def _sign(i: int, j: int) -> float:
    """The sign in e_i × e_j = ± e_k."""
    return 1.0 if (j - i) % 3 == 1 else -1.0
