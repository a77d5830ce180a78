"""Interfaces and options of the loop: sources of commands, sinks for setpoints, feedback from joints, clocks.

Any object with these methods works. An object that must be closed is a context manager, closed by its opener. A device
that fails raises OSError or a TwistarmError. A sink without a listener raises `UndeliveredError`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import ArrayLike

from ...support.checks import Array, as_flag, as_positive, as_reals, require
from ...support.display import Brief
from ...support.errors import InputError, TwistarmError, shown
from ..servo import AnyCommand, ServoOutput, ServoState
from .interlock import ENABLED, Interlock

COMMAND_TIMEOUT = 0.2
"""Seconds that a command is valid: five messages at 25 Hz, which pages and game pads manage."""

FEEDBACK_TIMEOUT = 0.2
"""Seconds that a joint state is valid. Most drives report at 50 Hz or faster."""

LATEST = 1e12
"""Seconds (30,000 years) beyond any clock, except one that counts nanoseconds."""


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
            raise InputError(f"{name} must be seconds, one number; got {shown(value)}")
    require(reason, str, "reason", "such as 'no joint state has arrived'")


class UndeliveredError(TwistarmError):
    """A setpoint was not delivered, but a later one may be. It is counted, and the stream continues."""


class Source(Protocol):
    """Where commands come from."""

    def read(self, now: float, state: ServoState | None) -> Reading:
        """The command at `now` [s], without waiting.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
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
        raise InputError(f"{name} must be seconds of a clock, below {LATEST:g}; got {shown(value)}")
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


@dataclass(frozen=True, eq=False)
class StreamOptions:
    """Options of `run`, `Streaming`, `follow` and `Following`.

    rate [Hz]: cycles per second. A period may not exceed the servo's longest step (`ServoSettings.max_dt`).

    feedback_timeout [s]: greatest age of the joint state.

    tolerance [rad, m]: greatest distance of a joint from what was commanded, one number or (n,). None: 0.2 for the
    servo, where an operator corrects, and 0.1 for a trajectory.

    velocity_mode: whether the robot takes rates alone.

    interlock: the switch that allows motion. None: a new one, enabled.

    Raises InputError for a rate or timeout that is not positive, or a value of another type.
    """

    rate: float = 100.0
    feedback_timeout: float = FEEDBACK_TIMEOUT
    tolerance: ArrayLike | None = None
    velocity_mode: bool = False
    interlock: Interlock | None = None

    def __post_init__(self) -> None:
        for name in ("rate", "feedback_timeout"):
            object.__setattr__(self, name, as_positive(getattr(self, name), name))
        as_flag(self.velocity_mode, "velocity_mode")
        if self.interlock is not None:
            require(self.interlock, Interlock, "interlock", "as Interlock() is")


USUAL = StreamOptions()
