"""Rival explanations of a log: other faults, signs and swaps that fit as well."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from ..limits.actuators import Actuators
from ..support.checks import Array
from .faults import named_faults
from .fit import refine, sign_patterns
from .hypotheses import ACCOUNTS, AS_GOOD, CLEAR, Explanation, alternatives, claims, explained_by, with_account
from .model import Wiring
from .search import Found, may_fit, swapped


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
