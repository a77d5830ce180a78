"""Checks of arguments and fields: numbers, choices, names; arrays by shape; orthonormal rotations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from math import degrees, inf, nan, pi
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import QUOTED, InputError, RoundedPoseWarning, closest, one_line, quote, warn
from .messages import Argument, Quantity, Text

Array = NDArray[np.float64]

RealArray = NDArray[np.floating[Any]] | NDArray[np.integer[Any]]
# Numbers in a row, as a caller may write them; unlike NumPy's `ArrayLike`, a text is none.
Row = RealArray | Sequence[float]
Matrix = RealArray | Sequence[Row]  # Rows of numbers, as a caller may write them.

Given = ArrayLike | Matrix

Progress = Callable[[float], object]  # Called with the fraction done, in (0, 1].

T = TypeVar("T")

SEEDS = 2**64

NO_NUMBERS = {"c": "complex numbers", "U": "text", "S": "text"}  # Kinds of NumPy's types, in words.
LARGEST = 1e300  # Numbers beyond are no quantity of this world, and sums of them overflow.
LARGEST_WHOLE = 2**53 - 1  # Up to here every reader's numbers are whole.
LONGEST_NUMBER = 400  # Characters of a written number.
LARGEST_ANGLE_TOL = 0.5 * pi  # Of a tolerance [rad]. More is no tolerance, but an angle in degrees.
LARGEST_ARRAY = 10**9  # More along one axis is a mistake.
# How far a matrix may be from a rotation: as far as three printed decimals bring it. Farther, it is a mistake.
ORTHONORMAL_TOL = 1e-3
ROUNDED_TOL = 1e-6  # Beyond this more than single precision was lost: a RoundedPoseWarning.
LAST_ROW_TOL = 1e-6  # How far a pose's last row may be from 0 0 0 1.
CLEAN_TOL = 1e-14  # Below this a rotation is left as it is: its error is already that of double precision.


def as_floats(value: Given, name: str, what: str = "an array of real numbers") -> Array:
    """`value` as a float64 array of finite numbers."""
    if value is None:  # to NumPy a NaN
        raise InputError(f"{name} must be {what}; got None")
    array = as_reals(value, name, what)
    if not np.isfinite(array).all():
        if not array.ndim:
            raise InputError(f"{name} must be finite; got {array}")
        index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InputError(f"{name} must be finite; it holds {array[index]} at index {list(index)}")
    return array


def as_reals(value: Given, name: str, what: str = "an array of real numbers") -> Array:
    """`value` as a float64 array of numbers, which may be infinite or NaN."""
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "biufO":
            raise ValueError(NO_NUMBERS.get(array.dtype.kind, f"of type {array.dtype}"))
        if np.any(getattr(value, "mask", False)):
            raise ValueError("some are masked")
        return np.asarray(array, dtype=np.float64)
    except Exception as error:  # an object's own conversion may raise anything, as that of a tensor with a gradient
        why = one_line(str(error), QUOTED)
        raise InputError(f"{name} must be {what}; got {quote(value)} ({why})") from error


def as_given(value: Any) -> Any:
    """Real numbers in a list, a tuple or an array as float64, row by row: what the core takes. Others unchanged."""
    try:
        array = np.asarray(value) if type(value) in (list, tuple) else value
    except Exception:  # an object's own conversion may raise anything
        return value
    if type(array) is np.ndarray and array.dtype.kind in "iuf":
        return np.asarray(array, dtype=np.float64, order="C")
    return value


def as_number(value: Any, name: str, least: float = -LARGEST, most: float = LARGEST, unit: str = "") -> float:
    """`value` as one number in [least, most], infinite only where these are. NaN, booleans and texts are refused."""
    one = value.item() if isinstance(value, (np.ndarray, np.generic)) and not value.ndim else value
    real = nan
    if isinstance(one, (int, float)) and not isinstance(one, bool):
        with suppress(OverflowError):  # an integer may be beyond the floats
            real = float(one)
    return _within(real, value, name, least, most, unit)


def number_in(text: str, name: str, least: float = -LARGEST, most: float = LARGEST, unit: str = "") -> float:
    """The number that a text of XML or CSV holds, as `as_number`.

    Python's 1_000 and digits of other scripts, which other readers refuse, are refused.
    """
    real = nan
    if text.isascii() and "_" not in text and len(text) <= LONGEST_NUMBER:
        with suppress(ValueError):
            real = float(text)
    return _within(real, text, name, least, most, unit)


def _within(real: float, given: Any, name: str, least: float, most: float, unit: str) -> float:
    if least <= real <= most:  # False for NaN
        return real
    size = f", {least:g} or more" if least > -LARGEST else ""
    if most < LARGEST:
        size = f" from {least:g} to {most:g}" if size else f", {most:g} or less"
    of_unit = f" [{unit}]" if unit else ""
    kind = "a number" if least == -inf or most == inf else "a finite number"
    point = "; decimals have a point" if isinstance(given, str) and given.count(",") == 1 else ""
    raise InputError(f"{name} must be {kind}{size}{of_unit}; got {quote(given)}{point}")


def as_positive(value: Any, name: str, most: float = LARGEST, unit: str = "") -> float:
    """`value` as one number above 0."""
    real = as_number(value, name, -LARGEST, most, unit)
    if real <= 0.0:
        raise InputError(f"{name} must be above 0; got {quote(value)}")
    return real


def require_radians(number: float, name: str, most: float = LARGEST_ANGLE_TOL) -> float:
    """`number`, a tolerance [rad], or InputError where it is beyond `most`, as degrees are."""
    if number > most:
        given, allowed = Argument(name, Quantity(number, "rad", 4)), Quantity(most, "rad", 4)
        turn = f"{degrees(number):.3g}°"
        raise InputError(Text("{given} is {turn}: give at most {allowed}", given=given, turn=turn, allowed=allowed))
    return number


def as_whole(value: Any, name: str, least: int = 0, most: int = LARGEST_WHOLE) -> int:
    """`value` as a whole number in [least, most]."""
    if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or not least <= value <= most:
        raise InputError(f"{name} must be a whole number, at least {least}, at most {most}; got {quote(value)}")
    return int(value)


def as_flag(value: Any, name: str) -> bool:
    """`value` as True or False."""
    if not isinstance(value, (bool, np.bool_)):
        raise InputError(f"{name} must be True or False; got {quote(value)}")
    return bool(value)


def as_seed(rng: Any) -> int:
    """A seed from an integer in [0, 2⁶⁴), or drawn from a NumPy Generator."""
    if isinstance(rng, np.random.Generator):
        return int(rng.integers(2**63))
    if isinstance(rng, (int, np.integer)) and not isinstance(rng, bool) and 0 <= rng < SEEDS:
        return int(rng)
    raise InputError(f"rng must be a seed, an integer from 0 to 2^64 − 1, or a numpy Generator; got {quote(rng)}")


def require(value: Any, kind: type[T], name: str, how: str) -> T:
    """`value`, or InputError where it is no `kind`. `how` says where one comes from."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIO" else "a"
        raise InputError(f"{name} must be {article} {kind.__name__}, {how}; got {quote(value)}")
    return value


def require_choice(value: Any, choices: Collection[str], name: str) -> str:
    """`value`, or InputError if it is not one of the texts `choices`."""
    if not isinstance(value, str) or value not in choices:
        allowed = " or ".join(", ".join(map(repr, choices)).rsplit(", ", 1))
        raise InputError(f"{name} must be {allowed}; got {quote(value)}{closest(value, choices)}")
    return value


def require_mapping(value: Any, name: str, example: str) -> Mapping[str, Any]:
    """`value`, or InputError where it maps no names to anything."""
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise InputError(f"{name} must be a mapping such as {example}; got {quote(value)}")
    return value


def require_names(values: Any, name: str) -> tuple[str, ...]:
    """`values`, a sequence of texts, as a tuple. Raises InputError for a single text or anything else."""
    with suppress(TypeError):  # of what is no sequence
        names = tuple(values)
        if not isinstance(values, str) and all(isinstance(entry, str) for entry in names):
            return tuple(map(str, names))  # NumPy has texts of its own
    raise InputError(f"{name} must be a sequence of names; got {quote(values)}")


def require_callback(value: Any, name: str, arguments: str) -> Callable[..., object] | None:
    """`value`, or InputError where it is neither a function nor None."""
    if value is not None and not callable(value):
        raise InputError(f"{name} must be a function of {arguments}, or None; got {quote(value)}")
    return value


def reporting(progress: Any) -> Progress:
    """What is called with the fraction done: `progress`, or nothing for None. InputError where it is no function."""
    return require_callback(progress, "progress", "(fraction)") or (lambda fraction: None)


def require_clock(value: Any, name: str) -> Callable[[], Any]:
    """`value`, or InputError where it is no function."""
    if not callable(value):
        raise InputError(f"{name} must be a function that returns the time; got {quote(value)}")
    return value


def require_method(value: T, name: str, method: str) -> T:
    """`value`, or InputError where it has no such method."""
    if isinstance(value, type) or not callable(getattr(value, method, None)):
        raise InputError(f"{name} must be an object with a method {method}; got {quote(value)}")
    return value


def as_vector(value: ArrayLike, name: str, size: int = 3) -> Array:
    """`value` as finite (..., size)."""
    array = as_floats(value, name)
    if array.ndim == 0 or array.shape[-1] != size:
        raise InputError(f"{name} must have shape (..., {size}); got {array.shape}")
    return array


def as_direction(value: ArrayLike, name: str) -> Array:
    """`value` as unit vectors (..., 3). A zero vector has no direction and is refused."""
    array = as_vector(value, name)
    # hypot does not overflow where the sum of squares would.
    norm = np.hypot.reduce(array, axis=-1, keepdims=True)
    if not (norm > 1e-12).all():  # shorter is the rounding of zero, from points metres away
        raise InputError(f"{name} must not be the zero vector: it has no direction")
    return array / norm


def as_twist(value: ArrayLike, name: str = "twist") -> Array:
    """`value` as twists or wrenches (..., 6), linear part first."""
    return as_vector(value, name, 6)


def as_rotation(value: ArrayLike, name: str = "rotation") -> Array:
    """`value` as rotation matrices (..., 3, 3).

    The error of a matrix is max |RᵀR − I| / 2: how far its columns are from square unit vectors. Up to
    `ORTHONORMAL_TOL` the nearest rotation is returned, beyond `ROUNDED_TOL` with a RoundedPoseWarning. Raises
    InputError for a larger error or a reflection.
    """
    R = as_floats(value, name)
    if R.shape[-2:] != (3, 3):
        raise InputError(f"{name} must have shape (..., 3, 3); got {R.shape}")
    off = 0.5 * np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max(initial=0.0)
    if off > ORTHONORMAL_TOL:
        raise InputError(
            f"{name} is not in SO(3): its columns are {off:.2g} away from square unit vectors "
            f"(allowed {ORTHONORMAL_TOL:g}); if it is a noisy rotation, take twistarm.rotations.nearest of it"
        )
    if not (np.linalg.det(R) > 0).all():
        raise InputError(f"{name} is not in SO(3): its determinant is −1, a reflection; swap or negate one axis")
    if off <= CLEAN_TOL:
        return R
    if off > ROUNDED_TOL:
        what = f"{name} is {off:.1g} away from a rotation, as rounded numbers are: the nearest rotation is used"
        warn(what, RoundedPoseWarning)
    return nearest_rotation(R)[0]


def nearest_rotation(A: Array) -> tuple[Array, Array]:
    """The rotations nearest to matrices (..., 3, 3), and how definite each is: σ₂ ± σ₃. See `rotations.nearest`."""
    U, sigma, Vt = np.linalg.svd(A)
    sense = np.sign(np.linalg.det(U @ Vt))
    U[..., :, 2] *= sense[..., None]
    R = U @ Vt
    # One step toward RᵀR = I takes the rounding of the decomposition away.
    R = 1.5 * R - 0.5 * R @ (np.swapaxes(R, -1, -2) @ R)
    return R, sigma[..., 1] + sense * sigma[..., 2]


def as_pose(value: Given, name: str = "pose") -> Array:
    """`value` as homogeneous poses (..., 4, 4) in SE(3), the rotation cleaned as by `as_rotation`."""
    g = as_floats(value, name)
    if g.shape[-2:] != (4, 4):
        raise InputError(f"{name} must have shape (..., 4, 4); got {g.shape}")
    if not np.abs(g[..., 3, :] - [0.0, 0.0, 0.0, 1.0]).max(initial=0.0) <= LAST_ROW_TOL:
        raise InputError(f"{name} is not in SE(3): its last row must be 0 0 0 1; got {quote(g[..., 3, :])}")
    clean = np.zeros(g.shape)
    clean[..., :3, :3] = as_rotation(g[..., :3, :3], f"rotation of the {name}")
    clean[..., :3, 3] = g[..., :3, 3]
    clean[..., 3, 3] = 1.0
    return clean


def pose_of(R: ArrayLike, p: ArrayLike) -> Array:
    """The pose [R, p; 0, 1] (4, 4) of a rotation (3, 3) and a place (3,), or 0 for its origin, unchecked."""
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, p
    return g


def as_frame(value: Given, name: str = "g") -> Array:
    """`value` as one matrix (4, 4) of finite numbers, which need not be a pose."""
    g = as_floats(value, name)
    if g.shape != (4, 4):
        raise InputError(f"{name} must be one pose of shape (4, 4); got {g.shape}")
    return g


def require_one(array: Array, name: str, ndim: int) -> Array:
    """`array`, or InputError if it holds several arrays of `ndim` axes."""
    if array.ndim != ndim:
        shape = array.shape[-ndim:]
        what = {(4, 4): "pose", (3, 3): "rotation", (6,): "twist"}.get(shape, "vector")
        raise InputError(f"{name} must be one {what} {shape}; got {array.shape}")
    return array


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
