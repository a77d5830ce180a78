"""What a caller hands in, checked once at the door: shape, finite, orthonormal."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

Array = NDArray[np.float64]

ORTHONORMAL_TOL = 1e-6
"""How far RᵀR may be from I: beyond the rounding of printed and single-precision poses, it is a mistake."""

CLEAN_TOL = 1e-14
"""Below this a rotation is left as it is: its error is already that of double precision."""


def as_floats(value: ArrayLike, name: str) -> Array:
    """`value` as a float64 array of finite numbers."""
    try:
        array = np.asarray(value)
        if array.dtype.kind == "c":
            raise ValueError("complex numbers")
        array = np.asarray(array, dtype=np.float64)
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{name} must be an array of real numbers; got {_short(value)} ({error})") from error
    if not np.isfinite(array).all():
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name} must be finite; it holds {array[index]} at index {list(index)}")
    return array


def as_number(value: ArrayLike, name: str) -> float:
    """`value` as one finite number."""
    array = as_floats(value, name)
    if array.ndim:
        raise InputError(f"{name} must be one number; got shape {array.shape}")
    return float(array)


def as_positive(value: ArrayLike, name: str) -> float:
    """`value` as one finite number above 0."""
    number = 0.0
    with suppress(InputError):
        number = as_number(value, name)
    if not number > 0.0:
        raise InputError(f"{name} must be a positive number; got {value!r}")
    return number


def as_vector(value: ArrayLike, name: str, size: int = 3) -> Array:
    """`value` as finite (..., size)."""
    array = as_floats(value, name)
    if array.ndim == 0 or array.shape[-1] != size:
        raise InputError(f"{name} must have shape (..., {size}); got {array.shape}")
    return array


def as_direction(value: ArrayLike, name: str) -> Array:
    """`value` as unit vectors (..., 3); a zero vector has no direction and is refused."""
    array = as_vector(value, name)
    # hypot does not overflow where the sum of squares would.
    norm = np.hypot.reduce(array, axis=-1, keepdims=True)
    if not (norm > 1e-12).all():
        raise InputError(f"{name} must not be the zero vector: it has no direction")
    unit: Array = array / norm
    return unit


def as_twist(value: ArrayLike, name: str = "twist") -> Array:
    """`value` as twists or wrenches (..., 6), linear part first."""
    return as_vector(value, name, 6)


def as_rotation(value: ArrayLike, name: str = "rotation") -> Array:
    """`value` as rotation matrices (..., 3, 3).

    Up to `ORTHONORMAL_TOL` off, the nearest rotation is returned (polar factor); further off, or a reflection,
    is refused.
    """
    R = as_floats(value, name)
    if R.shape[-2:] != (3, 3):
        raise InputError(f"{name} must have shape (..., 3, 3); got {R.shape}")
    off = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if off > ORTHONORMAL_TOL:
        raise InputError(
            f"{name} is not in SO(3): RᵀR is {off:.3g} away from the identity (allowed {ORTHONORMAL_TOL:g}); "
            "build it with twistarm.rotations"
        )
    if not (np.linalg.det(R) > 0).all():
        raise InputError(f"{name} is not in SO(3): its determinant is −1, a reflection; swap or negate one axis")
    if off <= CLEAN_TOL:
        return R
    U, _, Vt = np.linalg.svd(R)
    nearest: Array = U @ Vt
    return nearest


def as_pose(value: ArrayLike, name: str = "pose") -> Array:
    """`value` as homogeneous poses (..., 4, 4) in SE(3), the rotation cleaned as by `as_rotation`."""
    g = as_floats(value, name)
    if g.shape[-2:] != (4, 4):
        raise InputError(f"{name} must have shape (..., 4, 4); got {g.shape}")
    if not np.abs(g[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).max(initial=0.0) <= ORTHONORMAL_TOL:
        raise InputError(f"{name} is not in SE(3): its last row must be 0 0 0 1; got {_short(g[..., 3, :])}")
    clean = np.zeros(g.shape)
    clean[..., :3, :3] = as_rotation(g[..., :3, :3], f"rotation of the {name}")
    clean[..., :3, 3] = g[..., :3, 3]
    clean[..., 3, 3] = 1.0
    return clean


def as_theta(value: ArrayLike, n: int, name: str = "theta", names: tuple[str, ...] = ()) -> Array:
    """`value` as joint coordinates (..., n), one number per degree of freedom, base to tip."""
    array = as_floats(value, name)
    if array.ndim == 0 or array.shape[-1] != n:
        order = f": {', '.join(names)}" if names else ""
        raise InputError(f"{name} must have shape (..., {n}){order}; got {array.shape}")
    return array


def require_broadcast(**leading: tuple[int, ...]) -> None:
    """InputError unless the leading axes of the named arguments broadcast against each other."""
    try:
        np.broadcast_shapes(*leading.values())
    except ValueError as error:
        shapes = " and ".join(f"{name} {shape}" for name, shape in leading.items())
        raise InputError(f"leading axes do not match: {shapes}; they must be equal, 1 or missing") from error


def frozen(array: ArrayLike) -> Array:
    """A read-only float64 copy, row by row: what an object with identity stores."""
    copy = np.array(array, dtype=np.float64, order="C")
    copy.flags.writeable = False
    return copy


def _short(value: Any) -> str:
    text = " ".join(str(value).split())
    return text if len(text) <= 60 else text[:57] + "…"
