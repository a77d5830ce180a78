"""The report of a stream: cycles and jitter, stale inputs, and why it ended."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import TypeVar

from ...support.display import told
from ...support.messages import joined
from ..servo import ServoReason, ServoStatus
from .metronome import Lateness


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


@dataclass(frozen=True, repr=False)
class StreamReport:
    """The result of a stream.

    cycles: begun ones, and `missed` ones of the grid, at `rate` [Hz] over `duration` [s]. late_p50, late_p99, late_max
    [s]: the lateness of cycles, the jitter. statuses, reasons: cycles of each.

    waited, blind, uncommanded [s]: time before the first joint state, with a stale one later, and without command. Each
    has its last reason. barred [s]: time without permission of the interlock, with the last reason. interlock: its
    final word.

    ending and reason: why it ended. at_rest: whether the commanded arm was at rest at the end. undelivered: why
    setpoints were lost. delivered: whether the last one arrived, as far as known. failures: errors while it came to
    rest. assumed: the limits that the arm lacked and their replacements, or "".
    """

    cycles: int
    missed: int
    rate: float
    duration: float
    late_p50: float
    late_p99: float
    late_max: float
    statuses: Mapping[ServoStatus, int]
    reasons: Mapping[ServoReason, int]
    waited: float
    blind: float
    uncommanded: float
    blind_reason: str
    uncommanded_reason: str
    barred: float
    barred_reason: str
    interlock: str
    ending: Ending
    reason: str
    at_rest: bool
    undelivered: tuple[str, ...]
    delivered: bool
    failures: tuple[str, ...]
    assumed: str

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
        """What the arm was told at the end, and whether that got through."""
        if not self.started:
            return "never moved"
        lost = "" if self.delivered else "; the last setpoint did not get through"
        if not self.at_rest:
            return f"stopped at once, before it had come to rest along its limits{lost}"
        return f"commanded to rest{lost}" if lost else "at rest"

    def explain(self) -> str:
        """The report in lines."""
        counts = names_counted(self.statuses)
        lines = [
            joined(": ", filter(None, [f"ended: {self.ending.value}", self.reason])),
            f"{self.cycles} cycles in {self.duration:.2f} s at {self.rate:g} Hz, {self.missed} missed",
            f"cycles began late by {self.late_p50 * 1e3:.3f} ms (median), {self.late_p99 * 1e3:.3f} ms (99 %), "
            f"{self.late_max * 1e3:.3f} ms (most)",
            f"status: {counts}" if counts else "the arm was never moved: no joint state arrived",
            *([f"reasons: {names_counted(self.reasons)}"] if counts else []),
            *filter(None, [self.assumed]),
            *self._stale(),
            *(f"setpoints did not get through: {text}" for text in self.undelivered),
            *(f"while it came to rest: {failure}" for failure in self.failures),
            f"at the end: {self.at_the_end}",
        ]
        return joined("\n", lines)

    def _stale(self) -> list[str]:
        spans = (
            (self.waited, "waited for the first joint state", self.blind_reason if not self.started else ""),
            (self.blind, "had no fresh joint state", self.blind_reason),
            (self.uncommanded, "had no command", self.uncommanded_reason),
            (self.barred, "was not allowed to move", self.barred_reason),
        )
        return [
            f"{what} for {seconds:.3f} s{', at last because: ' if why else ''}{why}"
            for seconds, what, why in spans
            if seconds > 0.0
        ]


class Tally:
    """The counts of a running stream for its report, in bounded memory."""

    def __init__(self, rate: float, assumed: str = "") -> None:
        self.rate, self.assumed = rate, assumed
        self.cycles = self.missed = 0
        self.waited = self.blind = self.uncommanded = self.barred = 0
        self.statuses: Counter[ServoStatus] = Counter()
        self.reasons: Counter[ServoReason] = Counter()
        self.lateness = Lateness()
        self.blind_reason = self.uncommanded_reason = self.barred_reason = ""
        self.undelivered: Counter[str] = Counter()
        self.delivered = True
        self.failures: Counter[str] = Counter()

    def count(self, *, blind: str = "", uncommanded: str = "", barred: str = "") -> None:
        """Count a cycle and its reasons: no fresh joint state, no command, no permission."""
        self.blind += bool(blind)
        self.uncommanded += bool(uncommanded)
        self.uncommanded_reason = uncommanded or self.uncommanded_reason
        self.barred += bool(barred)
        self.barred_reason = barred or self.barred_reason

    def report(self, ending: Ending, reason: str, duration: float, at_rest: bool, interlock: str) -> StreamReport:
        """The report of a stream that ended after `duration` [s]."""
        late, seconds = self.lateness, 1.0 / self.rate
        return StreamReport(
            cycles=self.cycles, missed=self.missed, rate=self.rate, duration=duration,
            late_p50=late.percentile(50.0), late_p99=late.percentile(99.0), late_max=late.largest,
            statuses=_counts(self.statuses, ServoStatus), reasons=_counts(self.reasons, ServoReason),
            waited=seconds * self.waited, blind=seconds * self.blind, uncommanded=seconds * self.uncommanded,
            blind_reason=self.blind_reason, uncommanded_reason=self.uncommanded_reason,
            barred=seconds * self.barred, barred_reason=self.barred_reason, interlock=interlock,
            ending=ending, reason=reason, at_rest=at_rest, undelivered=counted(self.undelivered),
            delivered=self.delivered, failures=counted(self.failures), assumed=self.assumed,
        )  # fmt: skip


E = TypeVar("E", bound=Enum)


def _counts(counter: Counter[E], kinds: type[E]) -> Mapping[E, int]:
    """What occurred, in the order of its kinds."""
    return MappingProxyType({kind: counter[kind] for kind in kinds if counter[kind]})


def names_counted(counts: Mapping[E, int]) -> str:
    """Each name with how often it occurred: "OK 120, STALE 3"."""
    return ", ".join(f"{kind.name} {count}" for kind, count in counts.items())


def counted(texts: Counter[str]) -> tuple[str, ...]:
    """Each text, with how often it was said."""
    return tuple(f"{text} ({count} times)" if count > 1 else text for text, count in texts.items())
