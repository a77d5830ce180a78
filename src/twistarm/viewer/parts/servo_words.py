"""Servo status for the pages: status, joint and reason, or nothing while it idles."""

from __future__ import annotations

from typing import Any

from ...control.servo import AnyCommand, PoseCommand, ServoOutput
from ...control.stream import Cycle
from ...support.checks import require

SILENT: dict[str, Any] = {"status": None, "joint": None, "reason": "", "share": None}


def servo_words(answer: Cycle | ServoOutput) -> dict[str, Any]:
    """The answer of a servo or its loop in words.

    {"status": status of a ServoOutput or null, "joint": name or null, "reason": text, "share": executed share of the
    command from 0 to 1, or null}.
    """
    if isinstance(answer, ServoOutput):
        return _words(answer, True)
    require(answer, Cycle, "answer", "as stream.run hands to on_cycle, or a ServoOutput, or None")
    if answer.setpoint is None or not answer.delivered:
        return {**SILENT, "reason": answer.reason}
    reading = answer.reading
    idle = reading is not None and reading.idle and reading.reason == answer.reason
    return SILENT if idle else _words(answer.setpoint.output, reading is not None and _moves(reading.command))


def _words(output: ServoOutput, asked: bool) -> dict[str, Any]:
    valid = asked and output.status != "STALE"
    return {
        "status": output.status,
        "joint": output.joint,
        "reason": output.explain(),
        "share": round(output.share, 2) if valid else None,  # whole percents: pages get only changes
    }


def _moves(command: AnyCommand | None) -> bool:
    """Whether a command asks for a motion: a stop is no share of anything."""
    return command is not None and (isinstance(command, PoseCommand) or bool(command.numbers.any()))
