"""The watch on the joint state, and the report of a stream: cycles, lateness, stale inputs, its end."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import Enum
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED
from ...support.checks import Array, as_theta
from ...support.display import short_repr
from ...support.errors import InputError
from ...support.messages import Quantity, Text, joined
from ..servo import ServoReason
from .protocols import TOLERANCE, Measured, joint_tolerances


class Ending(Enum):
    """Why a stream ended."""

    DURATION = "the time was over"
    DONE = "the program ended it"
    INTERRUPTED = "it was interrupted"
    ARRIVED = "the motion is done"
    STOPPED = "it was stopped on its way"
    ELSEWHERE = "the arm is not where the motion begins"
    BEYOND_LIMITS = "the measured arm is beyond its position limits"
    STRAYED = "the arm is not where it was commanded to be"
    SOURCE_FAILED = "the source of commands failed"
    FEEDBACK_FAILED = "the feedback failed"
    SINK_FAILED = "the sink failed"
    SERVO_FAILED = "the servo failed"


# A resting joint that moves farther [rad, m] is moved by others. Noise and the last of a motion are below.
MOVED = 0.01

ON_REQUEST = (Ending.DURATION, Ending.DONE, Ending.INTERRUPTED, Ending.ARRIVED, Ending.STOPPED)


@dataclass(kw_only=True, repr=False)
class Tally:
    """The counts of a stream until now, in bounded memory.

    cycles: begun ones, and `missed` ones of the grid, at `rate` [Hz]. late_mean, late_max [s]: how late cycles
    began, on average and at most. statuses, reasons: cycles of each.

    waited, blind, uncommanded [s]: time before the first joint state, with a stale one later, and without command. Each
    has its last reason. barred [s]: time without permission of the interlock, with the last reason.

    undelivered: why setpoints were lost, and how many. delivered: whether the last one arrived, as far as known.
    failures: errors while the arm came to rest. assumed: the limits that the arm lacked and their replacements, or "".
    """

    rate: float
    assumed: str = ""
    cycles: int = 0
    missed: int = 0
    late_mean: float = 0.0
    late_max: float = 0.0
    statuses: Counter[str] = field(default_factory=Counter)
    reasons: Counter[ServoReason] = field(default_factory=Counter)
    waited: float = 0.0
    blind: float = 0.0
    blind_reason: str = ""
    uncommanded: float = 0.0
    uncommanded_reason: str = ""
    barred: float = 0.0
    barred_reason: str = ""
    undelivered: Counter[str] = field(default_factory=Counter)
    delivered: bool = True
    failures: Counter[str] = field(default_factory=Counter)

    def begin(self, late: float) -> None:
        """Note that the next cycle begins `late` [s]. The first one sets the grid."""
        self.late_mean += (late - self.late_mean) / max(self.cycles, 1)
        self.late_max = max(late, self.late_max)

    def count(self, *, blind: str = "", uncommanded: str = "", barred: str = "") -> None:
        """Count a cycle and its reasons: no fresh joint state, no command, no permission."""
        self.blind += bool(blind) / self.rate
        self.uncommanded += bool(uncommanded) / self.rate
        self.barred += bool(barred) / self.rate
        self.uncommanded_reason = uncommanded or self.uncommanded_reason
        self.barred_reason = barred or self.barred_reason


@dataclass(kw_only=True, repr=False)
class StreamReport(Tally):
    """The result of a stream: its counts, as in `Tally`, and its end.

    ending and reason: why it ended. duration [s]: the time since the start. at_rest: whether the commanded arm was at
    rest at the end. interlock: its final word.
    """

    ending: Ending
    reason: str
    duration: float
    at_rest: bool
    interlock: str

    def __repr__(self) -> str:
        named = {name: getattr(self, name) for name in ("cycles", "missed", "duration", "ending", "reason")}
        return short_repr("StreamReport", named)

    @property
    def ok(self) -> bool:
        """Whether it ended on request, at rest, after at least one watched motion."""
        return self.ending in ON_REQUEST and self.started and self.at_rest and self.delivered and not self.failures

    @property
    def started(self) -> bool:
        """Whether the servo began: a joint state arrived that can be used."""
        return bool(self.statuses)

    @property
    def at_the_end(self) -> str:
        """How the arm was left at the end, and whether the last setpoint got through."""
        if not self.started:
            return "never moved"
        lost = "" if self.delivered else "; the last setpoint did not get through"
        if not self.at_rest:
            return f"stopped at once, before it had come to rest along its limits{lost}"
        return f"commanded to rest{lost}" if lost else "at rest"

    def explain(self) -> str:
        """The report in lines."""
        counts = [", ".join(f"{status} {count}" for status, count in self.statuses.items())]
        counts += [", ".join(f"{reason.name} {count}" for reason, count in self.reasons.items())]
        spans = (
            (self.waited, "waited for the first joint state", "" if self.started else self.blind_reason),
            (self.blind, "had no fresh joint state", self.blind_reason),
            (self.uncommanded, "had no command", self.uncommanded_reason),
            (self.barred, "was not allowed to move", self.barred_reason),
        )
        lines = [
            joined(": ", filter(None, [f"ended: {self.ending.value}", self.reason])),
            f"{self.cycles} cycles in {self.duration:.2f} s at {self.rate:g} Hz, {self.missed} missed",
            f"cycles began late by {self.late_mean * 1e3:.3f} ms (mean), {self.late_max * 1e3:.3f} ms (most)",
            *(f"{name}: {count}" for name, count in zip(("status", "reasons"), counts, strict=True) if count),
            *filter(None, [self.assumed]),
            *(
                f"{what} for {seconds:.3f} s{', at last because: ' if why else ''}{why}"
                for seconds, what, why in spans
                if seconds > 0.0
            ),
            *(f"setpoints did not get through: {text}" for text in with_counts(self.undelivered)),
            *(f"while it came to rest: {failure}" for failure in with_counts(self.failures)),
            f"at the end: {self.at_the_end}",
        ]
        return joined("\n", lines)


def with_counts(texts: Counter[str]) -> list[str]:
    """Each text, with how often it occurred."""
    return [f"{text} ({count} times)" if count > 1 else text for text, count in texts.items()]


class FeedbackWatch:
    """Whether the measurement is usable and the arm follows.

    timeout [s]: older joint states are stale. tolerance (n,) or one number [rad, m]: the allowed distance of a joint
    from all setpoints of the last `timeout`, and from where their rates lead until the next one. It is also that of the
    first joint state from the position limits. A shorter lag is no deviation. `returned`: whether the last joint state
    was the first after a gap longer than `timeout`.
    """

    def __init__(self, arm: Arm, timeout: float, tolerance: ArrayLike) -> None:
        self._arm = arm
        self._timeout = timeout
        self._tolerance = joint_tolerances(tolerance, arm, "tolerance")
        self._heard = inf
        self._arrived = self.returned = False
        self._since = -inf
        self._now: tuple[Array, Array] | None = None
        self._before: tuple[Array, Array] | None = None
        self._rest_began = inf
        self._rest_distance: Array | None = None  # of the measured arm from its setpoint, once it rests

    def look(self, measured: Measured | None, now: float) -> tuple[Array | None, str]:
        """theta (n,) at `now` [s], or None and why the joint state cannot be used."""
        self.returned = False
        if measured is None:
            return None, "the feedback has lost the joint state" if self._arrived else "no joint state has arrived"
        if measured.theta is None:
            return None, measured.reason or "the joint state is unknown"
        self._arrived = True
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

    def rest(self, distance: Array | None, now: float) -> bool:
        """Note the distance (n,) of the resting arm from its setpoint; None: it moves. Whether it is at rest.

        Under a load an arm rests off its setpoint. The distance after a timeout at rest is the usual one.
        """
        if distance is None:
            self._rest_began, self._rest_distance = inf, None
            return False
        self._rest_began = min(self._rest_began, now)
        at_rest = now - self._rest_began >= self._timeout
        if at_rest and self._rest_distance is None:
            self._rest_distance = distance
        return at_rest

    def moved_by_others(self, distance: Array) -> bool:
        """Whether others have moved the resting arm, which is now so far (n,) from its setpoint."""
        return self._rest_distance is not None and bool((np.abs(distance - self._rest_distance) > MOVED).any())

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
        return self._worst(
            away,
            "joint {joint} is {away} from where it was commanded to be (tolerance {tolerance}): see why it did not "
            "follow, and start again from where it is",
        )

    def beyond_limits(self, theta: Array) -> str:
        """The joint that is beyond its position limit by more than the tolerance; "" for none.

        A servo that began there would move the arm by all of it. Joint states in degrees look so.
        """
        limits, turns = self._arm.limits, np.array(self._arm.units) == "rad"
        as_given, as_degrees = (
            np.maximum(limits.lower - x, x - limits.upper) for x in (theta, np.where(turns, np.radians(theta), theta))
        )
        if not (as_given > self._tolerance).any():
            return ""
        far = (as_given > np.maximum(self._tolerance, TOLERANCE)).any()  # nearer, it is rather a zero that is off
        in_degrees = far and not (as_degrees > self._tolerance).any()
        remedy = "in degrees it would be inside, so send radians" if in_degrees else "see its units and its zero"
        return self._worst(as_given, "joint {joint} is {away} beyond its limit (tolerance {tolerance}): " + remedy)

    def _worst(self, away: Array, template: str) -> str:
        j = int(np.argmax(away / self._tolerance))
        unit = self._arm.units[j]
        return Text(
            template,
            joint=self._arm.joint_names[j],
            away=Quantity(away[j], unit, 3),
            tolerance=Quantity(self._tolerance[j], unit),
        )
