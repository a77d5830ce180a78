"""Verdicts on each motor and the whole arm: what to correct, or to log, and what explains the log as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array
from .faults import (
    ALL,
    BASE_KNOWN,
    advice,
    correction,
    entries,
    enumerated,
    in_words,
    joint_offset,
    moved,
    named_faults,
    not_shown,
    not_shown_of_all,
    offset_of,
    slides,
)
from .fit import refine, sign_patterns
from .hypotheses import ACCOUNTS, AS_GOOD, CLEAR, Explanation, alternatives, claims, explained_by, with_account
from .model import Wiring
from .report import MotorVerdict
from .search import Found, may_fit, swapped

SEEN_SCALE, SEEN_ANGLE, SEEN_LENGTH = 0.05, np.radians(2.0), 0.01
"""Greatest standard deviations of a visible scale or offset [joint rad, m]."""

ROUNDING = 1e-9
"""Relative singular values below this are rounding."""

NEGLIGIBLE_SHARE = 1e-6
"""A smaller share in an invisible direction is rounding."""

Suspect = tuple[int, Found]
"""A motor, and the explanation that blames it."""


def standard_deviations(found: Found) -> Array:
    """Standard deviations (2k,) with all parameters fitted: √ diag (AᵀA)⁻¹, inf outside the row space of A."""
    _, values, Vt = np.linalg.svd(found.wiring.slope(found.explanation.p), full_matrices=False)
    values = np.where(values > ROUNDING * values[0], values, 0.0)
    # Fewer equations than parameters leave rows of Vt out: those directions are not seen either.
    missing = 1.0 - (Vt * Vt).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = np.where(np.abs(Vt) > NEGLIGIBLE_SHARE, (Vt / values[:, None]) ** 2, 0.0).sum(axis=0)
    return np.sqrt(np.where(missing > NEGLIGIBLE_SHARE, np.inf, variance))


def _visible_offset(wiring: Wiring, i: int) -> float:
    return SEEN_LENGTH if slides(wiring, i) else SEEN_ANGLE


def rivals(found: Found, i: int) -> list[tuple[int, Found]]:
    """Other faults that explain the log as well as those of motor i: each a motor and its explanation.

    A rival claims no more faults. It has another account for motor i, or a smaller one and another motor's fault.
    """
    wiring, best = found.wiring, found.explanation
    faults, claimed = set(named_faults(found, i)), claims(best.accounts[i])
    others = [(i, other) for other in alternatives(wiring, best, i) if 0 < claims(other.accounts[i]) <= claimed]
    for less in (name for name in ACCOUNTS if claims(name) < claimed):
        relieved, spare = replace(best, accounts=with_account(best.accounts, i, less)), claimed - claims(less)
        for j in (j for j in range(wiring.k) if j != i):
            blamed = alternatives(wiring, relieved, j)
            others += [(j, other) for other in blamed if 0 < _added(best, other, j) <= spare]
    as_well = [(j, replace(found, explanation=other)) for j, other in others if found.as_well(other.total)]
    return [
        (j, rival)
        for j, rival in as_well
        if not set(named_faults(rival, i)) >= faults and set(named_faults(rival, j)) - set(named_faults(found, j))
    ]


def _added(best: Explanation, other: Explanation, j: int) -> int:
    return claims(other.accounts[j]) - claims(best.accounts[j])


def unseen_signs(found: Found) -> set[int]:
    """Motors that may also turn the other way: one with another zero, or several at once."""
    wiring, p, k = found.wiring, found.explanation.p, found.wiring.k
    unseen = {i for i in range(k) if found.as_well(_reversed(wiring, p, i))}
    patterns = sign_patterns(k)[:, :k]
    r = wiring.residual(p * np.hstack([patterns, np.ones_like(patterns)]))
    for pattern, total in zip(patterns, (r * r).sum(axis=-1), strict=True):
        flipped = set(np.flatnonzero(pattern < 0).tolist())
        if found.as_well(float(total)) and not flipped & unseen:
            unseen |= flipped
    return unseen


def _reversed(wiring: Wiring, p: Array, i: int) -> float:
    """The least sum of squares with motor i turning the other way, its zero fitted."""
    start, free = p.copy(), np.zeros(len(p), dtype=bool)
    start[i], free[wiring.k + i] = -p[i], True
    return refine(wiring, start, free)[1]


def unseen_swaps(found: Found, motors: Actuators) -> list[tuple[int, int]]:
    """Pairs of motors that may also be swapped, with everything else as found."""
    pairs = [pair for pair in combinations(range(found.wiring.k), 2) if not set(pair) & set(found.swapped)]
    return [pair for pair in pairs if _explained_by_swap(found, swapped(found.wiring, motors, pair))]


def _explained_by_swap(found: Found, other: Wiring) -> bool:
    best = found.explanation
    if not may_fit(other, best.p):
        return False
    total = explained_by(other, best.p, best.accounts, best.scale).total
    if found.as_well(total):
        return True
    # Small deviations, which are no fault, fit one order of the motors better than the other: both get theirs.
    free, other_free = refine(found.wiring, best.p)[1], refine(other, best.p)[1]
    return other_free < free + AS_GOOD * best.scale and total - other_free < CLEAR * best.scale


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a log says of all motors, from an explanation that fits it."""

    found: Found
    motors: Actuators

    @property
    def k(self) -> int:
        """Motors."""
        return self.found.wiring.k

    @cached_property
    def std(self) -> Array:
        """Standard deviations (2k,) of the parameters."""
        return standard_deviations(self.found)

    @cached_property
    def open_faults(self) -> list[list[Suspect]]:
        """Faults that several explanations share: for each the suspects."""
        groups = []
        for i in range(self.k):
            others = rivals(self.found, i) if named_faults(self.found, i) else []
            others += [(j, one) for one in self.found.as_good for j in range(self.k) if named_faults(one, j)]
            others += self._with_base(i) if named_faults(self.found, i) else []
            if named_faults(self.found, i) and (others or self.or_base(i)):
                groups.append(sorted([(i, self.found), *others], key=lambda suspect: suspect[0]))
        return groups

    def or_base(self, i: int) -> str:
        """The base's place in words, if it explains the apparent fault of motor i. Otherwise empty."""
        other = self.found.or_base
        if other is None or named_faults(other, i) == named_faults(self.found, i):
            return ""
        return f"the base is {other.wiring.base_offset(other.explanation.p)}"

    def _with_base(self, i: int) -> list[Suspect]:
        """The other suspects for the fault of motor i, if the base may stand elsewhere."""
        other = self.found.or_base
        if other is None:
            return []
        if not self.or_base(i):
            return rivals(other, i)
        return [(j, other) for j in range(self.k) if set(named_faults(other, j)) - set(named_faults(self.found, j))]

    @cached_property
    def unseen(self) -> list[list[str]]:
        """For each motor what the log does not show: sign, ratio, zero."""
        signs = unseen_signs(self.found)
        offset = [_visible_offset(self.found.wiring, i) for i in range(self.k)]
        rows = [
            {"sign": i in signs, "ratio": self.std[i] > SEEN_SCALE, "zero": self.std[self.k + i] > offset[i]}
            for i in range(self.k)
        ]
        return [[name for name, hidden in row.items() if hidden] for row in rows]

    @cached_property
    def unseen_swaps(self) -> list[tuple[int, int]]:
        """Pairs of motors that may also be swapped, without those that must move first."""
        pairs = unseen_swaps(self.found, self.motors)
        return [pair for pair in pairs if any(moved(self.found.wiring, i) for i in pair)]

    def verdict(self, i: int) -> MotorVerdict:
        """Of motor i."""
        suspects = [suspect for group in self.open_faults if any(j == i for j, _ in group) for suspect in group]
        found = next((one for j, one in suspects if j == i), self.found)
        verdict, what, remedy = self._in_words(i, suspects)
        ratio, zero = (None, None) if suspects else entries(found, self.motors, i)
        return MotorVerdict(
            name=self.motors.names[i],
            verdict=verdict,
            faults=named_faults(found, i),
            unseen=(*self.unseen[i], *(f"swapped with {name}" for name in self._swapped_with(i))),
            scale=float(found.explanation.p[i]),
            scale_std=float(self.std[i]),
            offset=offset_of(found, i),
            offset_std=float(self.std[self.k + i] * self.found.wiring.unit[i]),
            joint_offset=joint_offset(found, self.motors, i),
            ratio=ratio,
            zero=zero,
            what=what,
            remedy=remedy,
        )

    def _in_words(self, i: int, suspects: list[Suspect]) -> tuple[str, str, str]:
        """Verdict, what and remedy."""
        hidden = not_shown(self.unseen[i], self._swapped_with(i))
        if suspects:
            own = [in_words(one, self.motors, j) for j, one in suspects if j == i]
            others = {self.motors.names[j]: None for j, _ in suspects if j != i}
            base = next((words for j, _ in suspects if (words := self.or_base(j))), "")
            told = [*dict.fromkeys(own), *(f"a fault of {name!r}" for name in others), *filter(None, [base])]
            what = f"{', or '.join(told)}: the log does not tell which"
            return "possible fault", what, BASE_KNOWN if base else advice(self.found.wiring, self.motors, i)
        if named_faults(self.found, i):
            what = in_words(self.found, self.motors, i)
            return "fault", f"{what}; {hidden}" if hidden else what, correction(self.found, self.motors, i)
        if hidden:
            remedy = BASE_KNOWN if self._hidden_by_base(i) else advice(self.found.wiring, self.motors, i)
            return "cannot tell", hidden, remedy
        return "sound", "sign, ratio and zero fit the log", ""

    def _hidden_by_base(self, i: int) -> bool:
        """Whether the log hides only the zero of motor i, and an exact base would show it."""
        if self.unseen[i] != ["zero"] or self._swapped_with(i) or self.found.wiring.base_error is None:
            return False
        exact = replace(self.found, wiring=replace(self.found.wiring, base=(0.0, 0.0)))
        return bool(standard_deviations(exact)[self.k + i] <= _visible_offset(self.found.wiring, i))

    def _swapped_with(self, i: int) -> list[str]:
        return [self.motors.names[j] for pair in self.unseen_swaps if i in pair for j in pair if j != i]


Judgement = tuple[str, str, tuple[MotorVerdict, ...]]
"""The verdict, its words, and the motors' verdicts."""


def judged(found: Found, motors: Actuators) -> Judgement:
    """Judge an explanation that fits the log, with the base that it assumes."""
    offset = found.wiring.base_offset(found.explanation.p)
    base = "" if offset is None else f"with the base {offset}, "
    evidence = Evidence(found, motors)
    each = tuple(evidence.verdict(i) for i in range(evidence.k))
    certain = [motor.name for motor in each if motor.verdict == "fault"]
    if certain or evidence.open_faults:
        parts = [f"the log shows what is wrong with {enumerated([*map(repr, certain)])}"] if certain else []
        parts += dict.fromkeys(_ambiguous(group, evidence) for group in evidence.open_faults)
        return "fault", base + "; ".join(parts), each
    hidden, shows = not_shown_of_all(motors.names, evidence.unseen, evidence.unseen_swaps)
    if hidden:
        return "cannot tell", base + hidden + ("; what it does show is sound" if shows else ""), each
    return "sound", f"{base}signs, ratios and zeros fit the log", each


def unmoved(found: Found, motors: Actuators) -> Judgement:
    """Judge a log at one place, which anything explains."""
    what = "no motor was moved, so the log does not show the sign, ratio or zero of any"
    if not found.fits:
        what += "; and the tool was not measured where the arm.toml puts it"
    remedies = [advice(found.wiring, motors, i) for i in range(found.wiring.k)]
    return "cannot tell", what, unjudged(motors, not_shown(ALL, ()), remedies)


def unjudged(motors: Actuators, what: str = "", remedies: Sequence[str] = ()) -> tuple[MotorVerdict, ...]:
    """The verdicts where nothing is known of any motor."""
    told = zip(motors.names, remedies or [""] * len(motors.names), strict=True)
    return tuple(MotorVerdict(name, what=what, remedy=remedy) for name, remedy in told)


def _ambiguous(group: list[Suspect], evidence: Evidence) -> str:
    motors = evidence.motors
    suspects = dict.fromkeys(f"{motors.names[j]!r} ({', '.join(named_faults(found, j))})" for j, found in group)
    base = next((words for j, _ in group if (words := evidence.or_base(j))), "")
    suspects |= dict.fromkeys(filter(None, [base]))
    (first, found), *_ = group
    return (
        f"one thing is wrong and the log does not tell which: {' or '.join(suspects)}; "
        f"{BASE_KNOWN if base else advice(found.wiring, motors, first)}"
    )
