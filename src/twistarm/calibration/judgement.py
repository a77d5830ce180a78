"""The verdict on the whole arm in a sentence, with the fault or the gap first."""

from __future__ import annotations

from collections.abc import Sequence

from ..limits.actuators import Actuators
from .advice import ALL, BASE_KNOWN, advice, enumerated, not_shown, not_shown_of_all
from .faults import named_faults
from .report import MotorVerdict
from .search import Found
from .verdicts import Evidence, Suspect

Judgement = tuple[str, str, tuple[MotorVerdict, ...]]
"""The verdict, what it says, and the motors'."""


def judged(found: Found, motors: Actuators) -> Judgement:
    """The verdict for an explanation that fits the log, and for its base."""
    verdict, what, each = _of_motors(found, motors)
    offset = found.wiring.base_offset(found.explanation.p)
    return verdict, what if offset is None else f"with the base {offset}, {what}", each


def _of_motors(found: Found, motors: Actuators) -> Judgement:
    evidence = Evidence(found, motors)
    each = tuple(evidence.verdict(i) for i in range(evidence.k))
    certain = [motor.name for motor in each if motor.verdict == "fault"]
    if certain or evidence.open_faults:
        parts = [f"the log shows what is wrong with {enumerated([*map(repr, certain)])}"] if certain else []
        parts += dict.fromkeys(_one_of(group, evidence) for group in evidence.open_faults)
        return "fault", "; ".join(parts), each
    hidden, shows = not_shown_of_all(motors.names, evidence.unseen, evidence.unseen_swaps)
    if hidden:
        return "cannot tell", f"{hidden}; what it does show is sound" if shows else hidden, each
    return "sound", "signs, ratios and zeros fit the log", each


def unmoved(found: Found, motors: Actuators) -> Judgement:
    """Of a log at one place, which anything explains."""
    what = "no motor was moved, so the log does not show the sign, ratio or zero of any"
    if not found.fits:
        what += "; and the tool was not measured where the arm.toml puts it"
    remedies = [advice(found.wiring, motors, i) for i in range(found.wiring.k)]
    return "cannot tell", what, unjudged(motors, not_shown(ALL, ()), remedies)


def unjudged(motors: Actuators, what: str = "", remedies: Sequence[str] = ()) -> tuple[MotorVerdict, ...]:
    """Where nothing is known of any motor."""
    told = zip(motors.names, remedies or [""] * len(motors.names), strict=True)
    return tuple(MotorVerdict(name, what=what, remedy=remedy) for name, remedy in told)


def _one_of(group: list[Suspect], evidence: Evidence) -> str:
    motors = evidence.motors
    suspects = dict.fromkeys(f"{motors.names[j]!r} ({', '.join(named_faults(found, j))})" for j, found in group)
    base = next((words for j, _ in group if (words := evidence.or_base(j))), "")
    suspects |= dict.fromkeys(filter(None, [base]))
    (first, found), *_ = group
    return (
        f"one thing is wrong and the log does not tell which: {' or '.join(suspects)}; "
        f"{BASE_KNOWN if base else advice(found.wiring, motors, first)}"
    )
