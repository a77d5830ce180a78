"""Commands from threads, sockets and pages. The latest of a single sender counts, for a timeout."""

from __future__ import annotations

from ....support.errors import InputError
from ...servo import AnyCommand, JogCommand, ServoState, TwistCommand
from ...servo.step import COMMANDS
from ..protocols import Reading
from .latest import Latest

COMMAND_TIMEOUT = 0.2
"""Seconds that a command holds: five messages at 25 Hz, which pages and game pads manage."""

FEEDBACK_TIMEOUT = 0.2
"""Seconds that a joint state holds: most drives report at 50 Hz or faster."""


class Inbox(Latest[AnyCommand]):
    """A source that holds one command, put there by `put(sender, command)` from any thread. See `Latest`."""

    def __init__(self, timeout: float = COMMAND_TIMEOUT) -> None:
        super().__init__(timeout, "command")

    def put(self, sender: str, value: AnyCommand, now: float | None = None, number: int | None = None) -> None:
        """Put in a command, which holds for `timeout`: repeat it. InputError for what is no command.

        Args:
            sender: The sender's name: the commands of one alone count.
            value: `TwistCommand`, `JogCommand` or `PoseCommand`; six numbers are a twist in tool axes.
            now: The time of arrival [s]; by default that of `MonotonicClock`, the loop's own.
            number: The sender's own counter, where it counts.
        """
        if not isinstance(value, COMMANDS):
            try:
                value = TwistCommand(value)
            except InputError as error:
                raise InputError(
                    f"a command is a TwistCommand, JogCommand, PoseCommand or six numbers: {error}"
                ) from error
        super().put(sender, value, now, number)

    def read(self, now: float, state: ServoState | None = None) -> Reading:
        """The command of the one commander at `now` [s], or None and the reason.

        Args:
            now: The clock's time [s].
            state: The commanded arm's state, or None before it is known.

        Returns:
            The `Reading`: a command, or None and the reason.
        """
        look = self.look(now)
        silent = look.value is None and look.age > self.timeout
        return Reading(look.value, look.age, look.reason, silent and (look.quiet or _is_stop(look.last)))


def _is_stop(command: AnyCommand | None) -> bool:
    return isinstance(command, JogCommand) and not command.theta_dot.any()
