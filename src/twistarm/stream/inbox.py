"""Commands and joint states from threads, sockets and pages: the latest counts, for a short while, of one sender."""

from __future__ import annotations

from ..checks import Array
from ..servo import AnyCommand, ServoState
from .latest import Latest
from .protocols import Measured, Reading

COMMAND_TIMEOUT = 0.2
"""Seconds that a command holds: five messages at 25 Hz, which pages and game pads manage."""

FEEDBACK_TIMEOUT = 0.2
"""Seconds that a joint state holds: most drives report at 50 Hz or faster."""


class Inbox(Latest[AnyCommand]):
    """A source that holds one command, put there by `put(sender, command, now)` from any thread. See `Latest`."""

    def __init__(self, timeout: float = COMMAND_TIMEOUT) -> None:
        super().__init__(timeout, "command")

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command of the one commander at `now` [s], or None and the reason."""
        return Reading(*self.look(now))


class StateInbox(Latest[Array]):
    """A feedback that holds one joint state, put there by `put(sender, theta, now)` from any thread. See `Latest`."""

    def __init__(self, timeout: float = FEEDBACK_TIMEOUT) -> None:
        super().__init__(timeout, "joint state")

    def read(self, now: float) -> Measured:
        """The joint state of the one sender, heard before `now` [s], or None and the reason."""
        theta, age, reason = self.look(now)
        return Measured(theta, now - age, reason)
