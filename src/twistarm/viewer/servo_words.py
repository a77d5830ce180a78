"""What the pages show of a servo: its status, the joint concerned, the reason; nothing while it idles."""

from __future__ import annotations

from typing import Any

from ..servo import AnyCommand, JogCommand, ServoOutput
from ..stream import Cycle
from ..stream.inbox import COMMAND_TIMEOUT

SILENT: dict[str, Any] = {"status": None, "joint": None, "reason": ""}


class ServoWords:
    """Puts what a servo or the loop around it answers into words, one answer after the other."""

    def __init__(self) -> None:
        self._last: AnyCommand | None = None

    def of(self, answer: Cycle | ServoOutput) -> dict[str, Any]:
        """{"status": a ServoStatus's name or null, "joint": name or null, "reason": text}."""
        if isinstance(answer, ServoOutput):
            return _words(answer)
        if answer.reading is not None and answer.reading.command is not None:
            self._last = answer.reading.command
        if answer.setpoint is None:
            return {**SILENT, "reason": answer.reason}
        return SILENT if self._idle(answer) else _words(answer.setpoint.output)

    def _idle(self, cycle: Cycle) -> bool:
        """Whether nobody commands because nobody wants to: silence after a stop, or from the beginning."""
        reading = cycle.reading
        if reading is None or reading.reason != cycle.reason or reading.age <= COMMAND_TIMEOUT:
            return False
        return self._last is None or (isinstance(self._last, JogCommand) and not self._last.theta_dot.any())


def _words(output: ServoOutput) -> dict[str, Any]:
    return {"status": output.status.name, "joint": output.joint, "reason": output.reason}
