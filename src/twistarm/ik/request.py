"""Checked arguments of a solver besides the target, and the deadline that follows from them."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..support.checks import (
    LARGEST_ANGLE_TOL,
    Array,
    as_number,
    as_positive,
    as_seed,
    as_whole,
    frozen,
    require_radians,
)
from ..support.errors import InputError, listed, quote
from .task_space import Tolerances

T = TypeVar("T")
Options = tuple[float, float, int, Any, float | None]  # Tolerances [m], [rad], restarts, rng and max_time of a call.

LEAST_TOLERANCE = 1e-12  # Smaller tolerances need more digits than forward kinematics has.

MAX_RESTARTS = 1_000_000

# A start beyond this [rad, m] is a mistake in the units. Whole turns toward it would cost the answer its digits.
FARTHEST_START = 1e6

POSTURES = ("theta0", "middle")


@dataclass(frozen=True, eq=False)
class Request:
    """How to solve: start theta0 and preferred `posture`, both (n,), in a batch also (N, n)."""

    theta0: Array
    posture: Array | None
    tolerances: Tolerances
    restarts: int
    seed: int
    max_time: float

    @property
    def options(self) -> Options:
        """The arguments of the compiled core between the start and the posture."""
        seconds = None if math.isinf(self.max_time) else self.max_time
        return self.tolerances.position, self.tolerances.orientation, self.restarts, self.seed, seconds


def named(arm: Arm, given: Any, start: Any = None) -> Any:
    """The named configuration: one of the arm's or, given the start, of POSTURES.

    Anything else comes back unchanged, unknown names too.
    """
    if isinstance(given, str):
        if start is not None and given in POSTURES:
            return start if given == "theta0" else arm.middle
        if given in arm.configurations:
            return arm.configurations[given]
    return given


def checked(
    arm: Arm,
    theta0: ArrayLike | None,
    posture: ArrayLike | str | None,
    position_tol: float,
    orientation_tol: float,
    restarts: int,
    rng: int | np.random.Generator,
    max_time: float | None,
    count: int | None = None,
) -> Request:
    """The arguments of a call as a `Request`. InputError for an unusable start, posture, tolerance or count.

    `count`: the size of a batch. It has one start for all (n,), or one for each (count, n).
    """
    searches = as_whole(restarts, "restarts", 1, MAX_RESTARTS)
    start = _start(arm, theta0, count)
    return Request(
        theta0=start,
        posture=_posture(arm, posture, start, count),
        tolerances=Tolerances(as_tolerance(position_tol, "position_tol [m]"), as_orientation_tol(orientation_tol)),
        restarts=searches,
        seed=as_seed(rng),
        max_time=math.inf if max_time is None else as_positive(max_time, "max_time [s]"),
    )


def _start(arm: Arm, theta0: ArrayLike | None, count: int | None) -> Array:
    if theta0 is None:
        return arm.ready
    given = arm.theta_from(theta0, name="theta0")
    if np.abs(given).max(initial=0.0) > FARTHEST_START:
        far = np.unravel_index(int(np.abs(given).argmax()), given.shape)
        raise InputError(
            f"theta0 holds {given[far]:g} for {arm.joint_names[far[-1]]}, beyond {FARTHEST_START:g} rad or m: "
            "whole turns that far lose the digits of the answer"
        )
    return _of_batch(arm, given, "theta0 must be one configuration of shape", count)


def _of_batch(arm: Arm, given: Array, must: str, count: int | None) -> Array:
    """One configuration (n,) or, in a batch, one for each target (count, n), read-only."""
    if given.ndim == 1 or (count is not None and given.shape == (count, arm.n)):
        return frozen(given)
    batch = "" if count is None else f" or one for each target ({count}, {arm.n})"
    raise InputError(f"{must} ({arm.n},){batch}; got {given.shape}")


def _posture(arm: Arm, posture: ArrayLike | str | None, start: Array, count: int | None) -> Array | None:
    """The preferred configuration of a redundant arm."""
    if posture is None:
        return None
    known = named(arm, posture, start)
    if isinstance(known, str):
        names = listed((*POSTURES, *arm.configurations))
        raise InputError(f"posture must be one of {names} or a configuration ({arm.n},); got {quote(posture)}")
    given = start if known is start else arm.theta_from(known, name="posture")
    return _of_batch(arm, given, "posture must be 'theta0', 'middle' or one configuration", count)


def as_tolerance(value: float, name: str) -> float:
    """A tolerance. InputError for a value that is not a number, or is too small."""
    return as_number(value, name, LEAST_TOLERANCE)


def as_orientation_tol(value: float, name: str = "orientation_tol [rad]") -> float:
    """The same for a rotation. InputError also for a value that must be in degrees."""
    return require_radians(as_tolerance(value, name), name.removesuffix(" [rad]"))


def in_radians(orientation_tol: object) -> bool:
    """Whether the core may take this tolerance, which it does not compare with `LARGEST_ANGLE_TOL`."""
    return type(orientation_tol) is float and orientation_tol <= LARGEST_ANGLE_TOL


@dataclass(frozen=True)
class Deadline:
    """A moment on the monotonic clock [s] after which no new work begins."""

    moment: float = math.inf

    @classmethod
    def after(cls, seconds: float | None) -> Deadline:
        """`seconds` from now. Never for infinity and None."""
        return cls(math.inf if seconds is None else time.monotonic() + seconds)

    @property
    def passed(self) -> bool:
        """Whether the moment has come."""
        return time.monotonic() >= self.moment

    @property
    def left(self) -> float | None:
        """Seconds left, as a solver's `max_time`: at least a microsecond, None for infinity."""
        # A solver refuses a time of 0 or less; with a microsecond it ends at once and says why.
        return None if math.isinf(self.moment) else max(1e-6, self.moment - time.monotonic())

    def until(self, items: Iterable[T]) -> Iterator[T]:
        """The items, until the moment has come."""
        for item in items:
            if self.passed:
                return
            yield item
