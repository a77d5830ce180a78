"""Joint limits of each degree of freedom, infinite where not given, and the unit of its coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import LARGEST_ARRAY, Array, as_number, as_reals, as_theta, as_whole, frozen, require_names
from ..support.display import short_repr
from ..support.errors import InputError, quote, unknown_name

FIELDS = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
RATES = FIELDS[2:]

# Types whose coordinate is a length; every other one is an angle, a helical joint's too.
SLIDING = frozenset({"prismatic"})
AS_GOOD_AS_UNBOUNDED = 1e4  # Greatest position [rad, m]. Files write larger numbers for "no limit".


@dataclass(frozen=True, repr=False)
class JointLimits:
    """Limits of n degrees of freedom: arrays (n,) in rad or m, their rates, N m or N.

    `lower`, `upper` are ∓inf where not given. `velocity`, `acceleration`, `jerk`, `effort` are inf where not given. A
    zero in them reads as inf, because descriptions write it for "not given".

    Raises InputError for unequal lengths, NaN, a negative rate or `lower > upper`.
    """

    lower: Array
    upper: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    effort: Array

    def __post_init__(self) -> None:
        n = as_reals(self.lower, "limits.lower").size
        for name in FIELDS:
            values = frozen(as_reals(getattr(self, name), f"limits.{name}"))
            if values.shape != (n,) or np.isnan(values).any():
                raise InputError(f"limits.{name} must be {n} numbers without NaN; got {values.tolist()}")
            if name in RATES and (values < 0).any():
                raise InputError(f"limits.{name} must not be negative; got {values.tolist()}")
            if name in RATES:
                values = frozen(np.where(values == 0, np.inf, values))
            object.__setattr__(self, name, values)
        if (self.lower > self.upper).any():
            i = int(np.argmax(self.lower > self.upper))
            raise InputError(f"limits of joint {i} are swapped: lower {self.lower[i]:g} > upper {self.upper[i]:g}")

    def __repr__(self) -> str:
        given = {name: getattr(self, name) for name in FIELDS if not np.isinf(getattr(self, name)).all()}
        return short_repr("JointLimits", given or {"unbounded": self.lower.size})

    @classmethod
    def unbounded(cls, n: int) -> JointLimits:
        """Return limits that limit nothing."""
        inf = np.full(as_whole(n, "n", 0, LARGEST_ARRAY), np.inf)
        return cls(-inf, inf, inf, inf, inf, inf)

    def __reduce__(self) -> tuple[type[JointLimits], tuple[Array, ...]]:
        return type(self), tuple(getattr(self, name) for name in FIELDS)  # pickled arrays would be writeable

    def contains(self, theta: ArrayLike, tol: float = 0.0) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Whether theta (..., n) is inside the position limits, or beyond by at most `tol` [rad, m].

        Args:
            theta: Configurations (..., n) [rad, m].
            tol: Tolerance [rad, m].

        Returns:
            Booleans (...).

        Raises:
            InputError: theta has another shape, or a number is not finite.
        """
        x, tol = as_theta(theta, self.lower.size), as_number(tol, "tol")
        return np.asarray(((x >= self.lower - tol) & (x <= self.upper + tol)).all(-1))

    def sampling_bounds(self, half: Array) -> tuple[Array, Array]:
        """Return lower and upper (n,) to draw configurations from, ±`half` (n,) where unbounded. See `usual_range`."""
        return usual_range(self.lower, self.upper, as_theta(half, self.lower.size, "half"))

    def middle(self) -> Array:
        """Return the middle between the bounds (n,). Without two bounds the allowed value nearest to 0."""
        bounded = (self.lower > -AS_GOOD_AS_UNBOUNDED) & (self.upper < AS_GOOD_AS_UNBOUNDED)
        lower, upper = np.where(bounded, self.lower, 0.0), np.where(bounded, self.upper, 0.0)
        return np.clip((lower + upper) / 2, self.lower, self.upper)

    def with_(self, changes: Mapping[str, Any], names: Sequence[str]) -> JointLimits:
        """Return a copy with `changes`: {"velocity": 1.0} for every joint, or {"velocity": {"elbow": 1.0}} by name.

        Args:
            changes: {field: number}, or {field: {joint: number}}.
            names: The n joint names, base to tip.

        Returns:
            A new `JointLimits`. This one does not change.

        Raises:
            InputError: A value cannot be used, or a lower limit exceeds the upper one.
            UnknownNameError: No such field or joint.
        """
        if not isinstance(changes, Mapping):
            wanted = "a JointLimits or a mapping such as {'velocity': 1.0}"
            raise InputError(f"limits must be {wanted}; got {quote(changes)}")
        names = require_names(names, "names")
        if len(names) != self.lower.size:
            raise InputError(f"names must be those of {self.lower.size} joints; got {len(names)}")
        updated = {field: getattr(self, field).copy() for field in FIELDS}
        for field, value in changes.items():
            if field not in FIELDS:
                raise unknown_name("limit", field, FIELDS, within="JointLimits", listing=", ".join(FIELDS))
            updated[field] = _merged(updated[field], value, field, names)
        for name, lower, upper in zip(names, updated["lower"], updated["upper"], strict=True):
            if lower > upper:
                raise InputError(f"limits of {name} are swapped or disjoint: lower {lower:g} > upper {upper:g}")
        return replace(self, **updated)


def slides(kind: str) -> bool:
    """Whether the coordinate of a joint of this type is a length."""
    return kind in SLIDING


def unit_of(kind: str) -> str:
    """Return `m` or `rad`."""
    return "m" if slides(kind) else "rad"


def by_field(limits: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """Return limits by field and joint, as `JointLimits.with_` takes them, of limits by joint and field."""
    changes: dict[str, dict[str, float]] = {}
    for joint, values in limits.items():
        for field, value in values.items():
            changes.setdefault(field, {})[joint] = value
    return changes


def usual_half(kind: str) -> float:
    """Return half the range of an unbounded joint: π rad, or 1 m for a slide."""
    return 1.0 if slides(kind) else float(np.pi)


def usual_range(lower: ArrayLike, upper: ArrayLike, half: ArrayLike) -> tuple[Array, Array]:
    """Return the given bounds. A missing one is ±`half` about zero, or that far from the other bound.

    A bound beyond `AS_GOOD_AS_UNBOUNDED` counts as missing, but is kept.
    """
    least, most, span = (np.asarray(values, dtype=np.float64) for values in (lower, upper, half))
    low = np.where(least > -AS_GOOD_AS_UNBOUNDED, least, np.minimum(-span, most - span))
    high = np.where(most < AS_GOOD_AS_UNBOUNDED, most, np.maximum(span, low + span))
    return np.maximum(low, least), np.minimum(high, most)


def _merged(values: Array, change: Any, field: str, names: Sequence[str]) -> Array:
    if isinstance(change, Mapping):
        for name, value in change.items():
            if name not in names:
                raise unknown_name("joint", str(name), names, within=f"limits['{field}']", listing="base to tip")
            values[list(names).index(name)] = as_number(value, f"limits['{field}']", -np.inf, np.inf)
        return values
    stacked = isinstance(change, np.ndarray) and change.ndim > 0
    if not stacked and (isinstance(change, str) or not isinstance(change, Sequence)):
        return np.full(len(names), as_number(change, f"limits['{field}']", -np.inf, np.inf))
    listed = np.array([as_number(value, f"limits['{field}']", -np.inf, np.inf) for value in change])
    if listed.shape != (len(names),):
        raise InputError(f"limits['{field}'] must be one number, {len(names)} numbers or a mapping by joint name")
    return listed
