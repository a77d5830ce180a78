"""The report of a stream: cycles and lateness, stale inputs, and why it ended."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import Enum

from ...support.display import told
from ...support.messages import joined
from ..servo import ServoReason


class Ending(Enum):
    """Why a stream ended."""

    DURATION = "the time was over"
    DONE = "it was told to end"
    INTERRUPTED = "it was interrupted"
    ARRIVED = "the motion is done"
    STOPPED = "it was stopped on its way"
    ELSEWHERE = "the arm is not where the motion begins"
    STRAYED = "the arm is not where it was commanded to be"
    SOURCE_FAILED = "the source of commands failed"
    FEEDBACK_FAILED = "the feedback failed"
    SINK_FAILED = "the sink failed"
    SERVO_FAILED = "the servo failed"


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
        return told("StreamReport", named)

    @property
    def ok(self) -> bool:
        """Whether it ended on request, at rest, after at least one watched motion."""
        return self.ending in ON_REQUEST and self.started and self.at_rest and self.delivered and not self.failures

    @property
    def started(self) -> bool:
        """Whether a joint state ever arrived, so that the servo could begin."""
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
        statuses = ", ".join(f"{status} {count}" for status, count in self.statuses.items())
        reasons = ", ".join(f"{reason.name} {count}" for reason, count in self.reasons.items())
        spans = (
            (self.waited, "waited for the first joint state", self.blind_reason if not self.started else ""),
            (self.blind, "had no fresh joint state", self.blind_reason),
            (self.uncommanded, "had no command", self.uncommanded_reason),
            (self.barred, "was not allowed to move", self.barred_reason),
        )
        lines = [
            joined(": ", filter(None, [f"ended: {self.ending.value}", self.reason])),
            f"{self.cycles} cycles in {self.duration:.2f} s at {self.rate:g} Hz, {self.missed} missed",
            f"cycles began late by {self.late_mean * 1e3:.3f} ms (mean), {self.late_max * 1e3:.3f} ms (most)",
            f"status: {statuses}" if statuses else "the arm was never moved: no joint state arrived",
            *([f"reasons: {reasons}"] if reasons else []),
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
