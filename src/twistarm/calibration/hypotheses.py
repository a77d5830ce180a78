"""The fewest faults that explain a log. A motor is sound, reversed, or has another ratio, zero, or both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import Array
from .fit import one_more, refine
from .model import Wiring

CLEAR = 25.0
"""Reduction of the sum of squares that names a fault: five standard deviations."""

AS_GOOD = 9.0
"""An account with a sum of squares larger by less is equally good: three standard deviations."""

UNEXPLAINED = 9.0
"""A greater mean square residual [standard deviations²] is not noise."""

ACCOUNTS = {
    "sound": (1.0, False, False, 0.0),
    "reversed": (-1.0, False, False, 1.0),
    "zero": (1.0, False, True, 1.5),
    "ratio": (None, True, False, 1.5),
    "reversed, zero": (-1.0, False, True, 2.5),
    "ratio, zero": (None, True, True, 3.0),
}
"""By name: the scale (None: any), whether scale and offset are fitted, and the number of claims."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """An account per motor (names of `ACCOUNTS`), the fitted parameters p (2k,), and the sum of squares.

    `cost` is the sum of squares over `scale`, the residual's variance, plus `CLEAR` per claim.
    """

    accounts: tuple[str, ...]
    p: Array
    total: float
    scale: float

    @property
    def cost(self) -> float:
        """What is to be least."""
        return self.total / self.scale + CLEAR * sum(ACCOUNTS[account][3] for account in self.accounts)

    @property
    def sound(self) -> bool:
        """Nothing is claimed of any motor."""
        return set(self.accounts) == {"sound"}

    @property
    def claims(self) -> int:
        """How many faults are claimed."""
        return sum(map(claims, self.accounts))

    def fits(self, wiring: Wiring) -> bool:
        """Whether what is left is no more than noise."""
        fitted = sum(by_scale + by_offset for _, by_scale, by_offset, _ in map(ACCOUNTS.__getitem__, self.accounts))
        return self.total <= UNEXPLAINED * freedom(wiring, fitted)


def fewest_faults(wiring: Wiring, p: Array, total: float) -> Explanation:
    """The cheapest explanation, found from the best fit p (2k,) by single changes of accounts.

    Several fits may be equally good. The best may be far from the one with the fewest faults. If it claims more than
    one fault, the search also starts from the sound arm and the best single fault. A fit that does not explain the log
    is returned as found.
    """
    k = wiring.k
    scale = max(1.0, total / freedom(wiring, 2 * k))
    best = Explanation(("ratio, zero",) * k, p, total, scale)
    if not best.fits(wiring):
        return best
    sound = explained_by(wiring, wiring.sound, ("sound",) * k, scale)
    if sound.total / scale - total / scale < CLEAR:
        return sound
    found = [sound, _improved(wiring, best)]
    if found[1].claims > 1:
        found += [_improved(wiring, start) for start in (sound, _one_faulty(wiring, scale))]
    return min(found, key=lambda explanation: explanation.cost)


def _one_faulty(wiring: Wiring, scale: float) -> Explanation:
    """The explanation with the least residual that blames one motor, of any scale and zero."""
    sound = ("sound",) * wiring.k
    tried = [
        explained_by(wiring, start, with_account(sound, i, "ratio, zero"), scale)
        for i in range(wiring.k)
        for start in one_more(wiring, wiring.sound, i)
    ]
    return min(tried, key=lambda explanation: explanation.total)


def _improved(wiring: Wiring, best: Explanation) -> Explanation:
    """The least costly that is reached by changing one account at a time."""
    improved = True
    while improved:
        improved = False
        for i in range(wiring.k):
            for other in alternatives(wiring, best, i):
                if other.cost < best.cost - LEAST_GAIN:
                    best, improved = other, True
    return best


def freedom(wiring: Wiring, fitted: int) -> int:
    """Equations beyond the parameters that are fitted, at least 1."""
    return max(len(wiring.residual(wiring.sound)) - fitted, 1)


LEAST_GAIN = 1e-6
"""Costs that differ by less are equal."""


def alternatives(wiring: Wiring, best: Explanation, i: int) -> list[Explanation]:
    """The explanations that differ in the account for motor i."""
    names = [name for name in ACCOUNTS if name != best.accounts[i]]
    return [explained_by(wiring, best.p, with_account(best.accounts, i, name), best.scale) for name in names]


def claims(account: str) -> int:
    """How many faults an account claims."""
    return 0 if account == "sound" else 1 + account.count(",")


def with_account(accounts: tuple[str, ...], i: int, account: str) -> tuple[str, ...]:
    """The accounts with another one for motor i."""
    return (*accounts[:i], account, *accounts[i + 1 :])


def explained_by(wiring: Wiring, near: Array, accounts: tuple[str, ...], scale: float) -> Explanation:
    """The explanation by these accounts, fitted from the parameters p (2k,) near it."""
    k = wiring.k
    p, free = near.copy(), np.zeros(2 * k, dtype=bool)
    for i, account in enumerate(accounts):
        s, free[i], free[k + i], _ = ACCOUNTS[account]
        p[i] = p[i] if s is None else s
        p[k + i] = p[k + i] if free[k + i] else 0.0
    return Explanation(accounts, *refine(wiring, p, free), scale)
