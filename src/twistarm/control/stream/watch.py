"""The watch on the joint state: fresh, plausible, and near the setpoints."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED
from ...support.checks import Array, as_floats, as_theta
from ...support.errors import InputError, shown
from ...support.messages import Quantity, Text
from .protocols import Measured


def one_or_each(given: ArrayLike, n: int, name: str) -> Array:
    """Positive numbers (n,), one for each joint in its unit, from one number or n. Raises InputError otherwise."""
    values = as_floats(given, name)
    if values.shape not in ((), (n,)) or not (values > 0.0).all():
        raise InputError(f"{name} must be one positive number or {n}; got {shown(given)}")
    return np.broadcast_to(values, (n,))


class FeedbackWatch:
    """Whether the measurement is usable and the arm follows.

    timeout [s]: older joint states are stale. tolerance (n,) or one number [rad, m]: the allowed distance of a joint
    from all setpoints of the last `timeout`. A shorter lag is no deviation. `returned`: whether the last joint state
    was the first after a gap longer than `timeout`.
    """

    def __init__(self, arm: Arm, timeout: float, tolerance: ArrayLike) -> None:
        self._arm = arm
        self._timeout = timeout
        self._tolerance = one_or_each(tolerance, arm.n, "tolerance")
        self._heard = inf
        self.returned = False
        self._since = -inf
        self._now: tuple[Array, Array] | None = None
        self._before: tuple[Array, Array] | None = None

    def look(self, measured: Measured | None, now: float) -> tuple[Array | None, str]:
        """theta (n,) at `now` [s], or None and why the joint state cannot be used."""
        self.returned = False
        if measured is None:
            return None, "no joint state has arrived"
        if measured.theta is None:
            return None, measured.reason or "the joint state is unknown"
        age = now - measured.time
        if not age <= self._timeout:
            return None, f"the last joint state is {age:.3g} s old (timeout {self._timeout:g} s)"
        if age < -self._timeout:  # less is a thread that heard it while the loop waited for its turn
            return None, f"the joint state is {-age:.3g} s from the future: its clock is another, or went back"
        try:
            theta = as_theta(measured.theta, self._arm.n, "the joint state", self._arm.joint_names)
        except InputError as error:
            return None, str(error)
        if theta.ndim != 1 or not (np.abs(theta) < AS_GOOD_AS_UNBOUNDED).all():
            return None, f"the joint state is no position of {self._arm.name}: {theta.tolist()}"
        self.returned = measured.time - self._heard > self._timeout
        self._heard = measured.time
        return theta, ""

    def forget(self) -> None:
        """Forget all setpoints, because the servo restarts at the measured position."""
        self._before = self._now = None

    def follow(self, theta: Array, now: float) -> None:
        """Note where the commanded arm is. Two boxes are kept, each over a timeout: what comes and goes costs O(1)."""
        if not 0.0 <= now - self._since <= self._timeout or self._now is None:
            self._before, self._now, self._since = self._now, (theta, theta), now
        else:
            lower, upper = self._now
            self._now = np.minimum(lower, theta), np.maximum(upper, theta)

    def error(self, theta: Array) -> Array | None:
        """Each joint's distance (n,) from all setpoints of the last timeout. None before the first."""
        if self._now is None:
            return None
        lower, upper = self._now
        if self._before is not None:
            lower, upper = np.minimum(lower, self._before[0]), np.maximum(upper, self._before[1])
        return np.maximum(np.maximum(lower - theta, theta - upper), 0.0)

    def deviation(self, theta: Array) -> str:
        """The joint that is too far from its setpoints and its distance; "" for none."""
        away = self.error(theta)
        if away is None or not (away > self._tolerance).any():
            return ""
        j = int(np.argmax(away / self._tolerance))
        unit = self._arm.units[j]
        return Text(
            "joint {joint} is {away} from where it was commanded to be (tolerance {tolerance}): see why it did not "
            "follow, and start again from where it is",
            joint=self._arm.joint_names[j],
            away=Quantity(away[j], unit, 3),
            tolerance=Quantity(self._tolerance[j], unit),
        )
