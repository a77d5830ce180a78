"""Interfaces of the loop: sources of commands, sinks for setpoints, feedback from joints, clocks.

Any object with these methods works. An object that must be closed is a context manager, closed by its opener. A device
that fails raises OSError or a TwistarmError. A sink without a listener raises `UndeliveredError`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from ...support.checks import Array, as_reals, require
from ...support.display import Brief
from ...support.errors import InputError, TwistarmError, shown
from ..servo import AnyCommand, ServoOutput, ServoState
from .interlock import ENABLED


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
