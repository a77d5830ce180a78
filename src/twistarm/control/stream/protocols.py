"""Interfaces and options of the loop: sources of commands, sinks, feedback from joints, clocks, the interlock.

Any object with these methods works. An object that must be closed is a context manager, closed by its opener. A device
that fails raises OSError or a TwistarmError. A sink without a listener raises `UndeliveredError`.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from ...arm.arm import Arm
from ...support.checks import Array, as_flag, as_floats, as_positive, as_reals, require, require_choice, require_radians
from ...support.display import Brief
from ...support.errors import InputError, TwistarmError, one_line, quote
from ..servo import AnyCommand, ServoOutput, ServoState

# Seconds that a command or a joint state is valid: five messages at 25 Hz, which pages and game pads manage. Most
# drives report at 50 Hz or faster.
MESSAGE_TIMEOUT = 0.2
TOLERANCE = 0.2  # Allowed distance of a joint from the command [rad, m]. An operator corrects it.
LATEST = 1e12  # Seconds (30,000 years) beyond any clock, except one that counts nanoseconds.

ENABLED, STOPPED, EMERGENCY_STOP = "enabled", "stopped", "emergency stop"

STATES = (ENABLED, STOPPED, EMERGENCY_STOP)  # States of an interlock, and those that a robot may report.
WORDS = ("enable", "stop", "emergency stop", "clear")  # Words that messages may send to an interlock.
LONGEST_REASON = 200  # Most characters of a reason. It may come from outside and is in every message.


@dataclass(frozen=True, eq=False, repr=False)
class Reading(Brief):
    """The state of a source: a command and its age [s], or None and the reason.

    `idle`: there was no command yet, or the last one was a stop. Silence is then normal.
    """

    command: AnyCommand | None
    age: float
    reason: str = ""
    idle: bool = False

    def __post_init__(self) -> None:
        _check(self.reason, age=self.age)


@dataclass(frozen=True, eq=False, repr=False)
class Measured(Brief):
    """The joint positions theta (n,) [rad, m] and their time [s]. If unknown, None and a reason."""

    theta: Array | None
    time: float
    reason: str = ""

    def __post_init__(self) -> None:
        _check(self.reason, time=self.time)


@dataclass(frozen=True, eq=False, repr=False)
class Setpoint(Brief):
    """Rates theta_dot (n,) until the next setpoint, and positions theta (n,) then.

    `time` [s] is the clock's at the computation. `number` counts from 0. `interlock` is the `Interlock`'s word.
    """

    number: int
    time: float
    theta: Array
    theta_dot: Array
    output: ServoOutput
    interlock: str = ENABLED


def _check(reason: Any, **seconds: Any) -> None:
    """InputError for a reason that is no text, or seconds that are no number."""
    for name, value in seconds.items():
        if type(value) is not float and (value is None or as_reals(value, name, "seconds").ndim):
            raise InputError(f"{name} must be seconds, one number; got {quote(value)}")
    require(reason, str, "reason", "such as 'no joint state has arrived'")


class UndeliveredError(TwistarmError):
    """A setpoint was not delivered, but a later one may be. It is counted, and the stream continues."""


class Source(Protocol):
    """Where commands come from."""

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The command at `now` [s] without waiting, or None and the reason.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.
        """


class Sink(Protocol):
    """Where setpoints go."""

    def write(self, setpoint: Setpoint) -> None:
        """Send the setpoint without waiting. Raises `UndeliveredError` without a listener."""


class Feedback(Protocol):
    """Where the joint state comes from."""

    def read(self, now: float) -> Measured | None:
        """The latest joint state at `now` [s], without waiting; None where none ever arrived."""


class Clock(Protocol):
    """Time that only goes forward [s], and waiting."""

    def now(self) -> float:
        """Seconds since some fixed moment."""

    def sleep_until(self, moment: float) -> None:
        """Return at that moment, at once where it has passed."""


def require_time(value: Any, name: str = "now") -> float:
    """`value`, a number of seconds; a broken clock's NaN is one too."""
    if not isinstance(value, float) and not (isinstance(value, int) and abs(value) < LATEST):
        raise InputError(f"{name} must be seconds of a clock, below {LATEST:g}; got {quote(value)}")
    return float(value)


class MonotonicClock:
    """The system's clock that is never set."""

    def now(self) -> float:
        """Seconds since some fixed moment."""
        return time.monotonic()

    def sleep_until(self, moment: float) -> None:
        """Return at that moment, at once where it has passed."""
        left = require_time(moment, "moment") - time.monotonic()
        if left > 0.0:
            time.sleep(left)


class Interlock:
    """Whether an arm may move, set by operators, messages and programs. Thread-safe.

    It starts enabled unless `enabled` is False. If it forbids motion, `run` brings the arm to rest within its
    acceleration limits. The stream continues. An emergency stop is latched: `enable` has no effect before `clear`,
    which moves nothing (ISO 13850, 4.1.4). This is software and does not replace hardware.
    """

    def __init__(self, *, enabled: bool = True) -> None:
        self._lock = threading.Lock()
        self._now = (ENABLED, "") if as_flag(enabled, "enabled") else (STOPPED, "it waits to be enabled")

    def enable(self) -> bool:
        """Let the arm move. Returns whether it may now; an emergency stop must be cleared first."""
        return self._change(ENABLED, "", (STOPPED,)) == ENABLED

    def stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `enable`; an emergency stop stays one."""
        self._change(STOPPED, reason, (ENABLED, STOPPED))

    def emergency_stop(self, reason: str = "") -> None:
        """Bring the arm to rest until `clear` and then `enable`. The first reason stays until then."""
        self._change(EMERGENCY_STOP, reason, (ENABLED, STOPPED))

    def clear(self) -> None:
        """End an emergency stop. The arm is then stopped and waits for `enable`."""
        self._change(STOPPED, "the emergency stop was cleared; it waits to be enabled", (EMERGENCY_STOP,))

    def _change(self, word: str, reason: str, only_from: tuple[str, ...]) -> str:
        new = word, one_line(require(reason, str, "reason", "in words"), LONGEST_REASON)
        with self._lock:
            if self._now[0] in only_from:
                self._now = new
            return self._now[0]

    def obey(self, word: str, reason: str = "", fresh: bool = True) -> None:
        """Obey a message.

        Args:
            word: One of `WORDS`.
            reason: Why, for the report.
            fresh: Whether it is new. A late message may stop the arm, but not enable it.
        """
        if require_choice(word, WORDS, "word") in ("stop", "emergency stop"):
            (self.stop if word == "stop" else self.emergency_stop)(reason)
        elif fresh:
            self.clear() if word == "clear" else self.enable()

    def mirror(self, state: str | None, who: str) -> None:
        """Stop if a robot reports that it may not move.

        Args:
            state: One of `STATES`, or None. "enabled" and None change nothing.
            who: The robot's name in the reason.
        """
        if state is not None and require_choice(state, STATES, "state") != ENABLED:
            emergency = state == EMERGENCY_STOP
            (self.emergency_stop if emergency else self.stop)(f"{who} is {'in ' * emergency}{state}")

    @property
    def allows_motion(self) -> bool:
        """Whether the arm may move."""
        return self._now[0] == ENABLED

    @property
    def word(self) -> str:
        """One of "enabled", "stopped" and "emergency stop"."""
        return self._now[0]

    @property
    def reason(self) -> str:
        """Why it is stopped; "" without a reason or if enabled."""
        return self._now[1]

    @property
    def barrier(self) -> str:
        """Why the arm may not move, the word and its reason; "" where it may."""
        word, reason = self._now
        return "" if word == ENABLED else ": ".join(filter(None, (word, reason)))


@runtime_checkable
class Interlocked(Protocol):
    """A source or feedback with interlock messages. The stream sets its interlock here."""

    interlock: Interlock


def one_or_each(given: ArrayLike, n: int, name: str) -> Array:
    """Positive numbers (n,), one for each joint in its unit, from one number or n. Raises InputError otherwise."""
    values = as_floats(given, name)
    if values.shape not in ((), (n,)) or not (values > 0.0).all():
        raise InputError(f"{name} must be one positive number or {n}; got {quote(given)}")
    return np.broadcast_to(values, (n,))


def joint_tolerances(given: ArrayLike, arm: Arm, name: str) -> Array:
    """The same for tolerances of an arm's joints. InputError also for degrees of a joint that turns."""
    values = one_or_each(given, arm.n, name)
    require_radians(float(values[np.array(arm.units) == "rad"].max(initial=0.0)), name)
    return values


@dataclass(frozen=True, eq=False)
class LoopOptions:
    """Options that all loops share. `StreamOptions` and `FollowOptions` have more.

    rate [Hz]: cycles per second. A period may not exceed the servo's longest step (`ServoSettings.max_dt`).

    feedback_timeout [s]: greatest age of the joint state.

    tolerance [rad, m]: greatest distance of a joint from what was commanded, one number or (n,).

    velocity_mode: whether the robot takes rates alone.

    interlock: the switch that allows motion. None: a new one, enabled.

    Raises InputError for a rate or timeout that is not positive, or a value of another type.
    """

    rate: float = 100.0
    feedback_timeout: float = MESSAGE_TIMEOUT
    tolerance: ArrayLike = TOLERANCE
    velocity_mode: bool = False
    interlock: Interlock | None = None

    def __post_init__(self) -> None:
        for name in ("rate", "feedback_timeout"):
            object.__setattr__(self, name, as_positive(getattr(self, name), name))
        as_flag(self.velocity_mode, "velocity_mode")
        if self.interlock is not None:
            require(self.interlock, Interlock, "interlock", "as Interlock() is")
