"""Commands and joint states from threads, sockets and pages: the latest counts, for a short while, of one sender."""

from __future__ import annotations

from ..checks import Array
from ..servo import AnyCommand, JogCommand, ServoState
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
        look = self.look(now)
        silent = look.value is None and look.age > self.timeout
        return Reading(look.value, look.age, look.reason, silent and (look.quiet or _is_stop(look.last)))


class StateInbox(Latest[Array]):
    """A feedback that holds one joint state, put there by `put(sender, theta, now)` from any thread. See `Latest`."""

    def __init__(self, timeout: float = FEEDBACK_TIMEOUT) -> None:
        super().__init__(timeout, "joint state")

    def read(self, now: float) -> Measured:
        """The joint state of the one sender, heard before `now` [s], or None and the reason."""
        look = self.look(now)
        return Measured(look.value, now - look.age, look.reason)


def _is_stop(command: AnyCommand | None) -> bool:
    return isinstance(command, JogCommand) and not command.theta_dot.any()
