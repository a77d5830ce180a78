"""What an explanation means for each motor: what to correct, or what to move so that the log can tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..actuators import Actuators
from ..checks import Array
from ..errors import listed
from .hypotheses import AS_GOOD, Explanation, alternatives, blamed_on
from .model import Wiring
from .report import MotorVerdict

SMALL_SCALE, SMALL_ANGLE, SMALL_LENGTH = 0.02, np.radians(1.0), 0.005
"""A scale or offset [joint rad, m] that is less off than this is how arms are: no fault, though the log may show it."""

SEEN_SCALE, SEEN_ANGLE, SEEN_LENGTH = 0.05, np.radians(2.0), 0.01
"""With a larger standard deviation than this the log does not show a scale or an offset [joint rad, m]."""

LITTLE_ANGLE, LITTLE_LENGTH = np.radians(15.0), 0.05
"""A motor that moves its joint by less than this [rad, m] has hardly been moved."""

SIGN, RATIO, ZERO, SWAPPED = "flipped sign", "wrong ratio", "zero offset", "swapped"


NOTHING = 1e-9
"""A singular value that is a smaller part of the largest is rounding."""

UNSEEN = 1e-6
"""A smaller share in a direction of which nothing is seen is rounding."""


def verdicts(
    wiring: Wiring, found: Explanation, motors: Actuators, swapped: tuple[int, ...]
) -> tuple[MotorVerdict, ...]:
    """The verdict on each motor; an explanation that does not fit the log proves nothing."""
    evidence = _Evidence(wiring, found, motors, swapped, found.fits(wiring), _standard_deviations(wiring, found))
    return tuple(evidence.verdict(i) for i in range(wiring.k))


def _standard_deviations(wiring: Wiring, found: Explanation) -> Array:
    """Of all parameters (2k,), were all of them fitted: √ diag (AᵀA)⁻¹, inf along what A does not see."""
    _, values, Vt = np.linalg.svd(wiring.slope(found.p), full_matrices=False)
    values = np.where(values > NOTHING * values[0], values, 0.0)
    # Fewer equations than parameters leave rows of Vt out: those directions are not seen either.
    missing = 1.0 - (Vt * Vt).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        variance = np.where(np.abs(Vt) > UNSEEN, (Vt / values[:, None]) ** 2, 0.0).sum(axis=0)
    return np.sqrt(np.where(missing > UNSEEN, np.inf, variance))


@dataclass(frozen=True, eq=False)
class _Evidence:
    """What is known of all motors: `std` (2k,) of the parameters; `swapped`, two of them or none."""

    wiring: Wiring
    found: Explanation
    motors: Actuators
    swapped: tuple[int, ...]
    fits: bool
    std: Array

    def verdict(self, i: int) -> MotorVerdict:
        """Of motor i."""
        wiring, motors, name = self.wiring, self.motors, self.motors.names[i]
        s, e = float(self.found.p[i]), float(self.found.p[wiring.k + i] * wiring.unit[i])
        faults = self._faults(i) if self.fits else ()
        verdict, what, remedy = self._told(i, faults)
        return MotorVerdict(
            name=name,
            verdict=verdict,
            faults=faults,
            scale=s,
            scale_std=float(self.std[i]),
            offset=e,
            offset_std=float(self.std[wiring.k + i] * wiring.unit[i]),
            joint_offset={motors.joint_names[j]: float(wiring.P[j, i] * e) for j in self._joints(i)},
            ratio={joint: float(g / s) for joint, g in zip(motors.joint_names, motors.G[i], strict=True) if g},
            zero=float(motors.offset[i] - e / s),
            what=what,
            remedy=remedy,
        )

    def _told(self, i: int, faults: tuple[str, ...]) -> tuple[str, str, str]:
        """Verdict, what and remedy."""
        unseen = self._unseen(i)
        if faults:
            return "fault", self._in_words(i, faults) + (self._or(i) if unseen else ""), self._correction(i)
        if unseen:
            return "cannot tell", f"the log does not show its {' and '.join(unseen)}", self._advice(i)
        if not self.fits:
            return "cannot tell", "nothing fits the log", ""
        return "sound", "sign, ratio and zero fit the log", ""

    def _faults(self, i: int) -> tuple[str, ...]:
        s, e = self.found.p[i], self.found.p[self.wiring.k + i]
        small = SMALL_LENGTH if self._slides(i) else SMALL_ANGLE
        named = {SWAPPED: i in self.swapped, SIGN: s < 0, RATIO: abs(abs(s) - 1.0) > SMALL_SCALE, ZERO: abs(e) > small}
        return tuple(name for name, there in named.items() if there)

    def _unseen(self, i: int) -> list[str]:
        offset = SEEN_LENGTH if self._slides(i) else SEEN_ANGLE
        named = {"ratio": self.std[i] > SEEN_SCALE, "zero": self.std[self.wiring.k + i] > offset}
        return [name for name, there in named.items() if there]

    def _slides(self, i: int) -> bool:
        """Whether the joint that motor i moves most slides."""
        return self.wiring.arm.units[int(np.abs(self.wiring.P[:, i]).argmax())] == "m"

    def _joints(self, i: int) -> list[int]:
        """The joints that motor i moves, the other motors standing still."""
        moved = np.abs(self.wiring.P[:, i])
        return [int(j) for j in np.flatnonzero(moved > UNSEEN * moved.max())]

    def _in_words(self, i: int, faults: tuple[str, ...]) -> str:
        wiring, names = self.wiring, self.motors.joint_names
        e = self.found.p[wiring.k + i] * wiring.unit[i]
        others = [self.motors.names[j] for j in self.swapped if j != i]
        added = [f"{_amount(wiring.P[j, i] * e, wiring.arm.units[j])} to {names[j]}" for j in self._joints(i)]
        words = {
            SWAPPED: f"it is swapped with {listed(others)}: each has the other's counts",
            SIGN: "its sign is flipped",
            RATIO: f"its ratio is {1.0 / abs(self.found.p[i]):.4g} times the arm.toml's",
            ZERO: f"its zero is off: add {' and '.join(added)}",
        }
        return "; ".join(words[fault] for fault in faults)

    def _correction(self, i: int) -> str:
        """What to change, and the entries of the arm.toml that fit the motor as it is wired."""
        motors, s, e = self.motors, self.found.p[i], self.found.p[self.wiring.k + i] * self.wiring.unit[i]
        steps = ["swap their plugs, or their names in the arm.toml"] if i in self.swapped else []
        if s != 1.0 or e != 0.0:
            ratio = ", ".join(
                f"{name} = {g / s:.6g}" for name, g in zip(motors.joint_names, motors.G[i], strict=True) if g
            )
            entries = f"ratio = {{ {ratio} }}, offset = {motors.offset[i] - e / s:.6g}"
            steps.append(f"as it is wired, [actuators.{motors.names[i]}] has {entries}")
        return "; ".join(steps)

    def _or(self, i: int) -> str:
        """What explains the log as well: another account for the same motor, or another motor."""
        limit, accounts = self.found.cost + AS_GOOD, self.found.accounts
        same = [other.accounts[i] for other in alternatives(self.wiring, self.found, i) if other.cost < limit]
        others = [
            self.motors.names[j]
            for j in range(self.wiring.k)
            if j != i and accounts[i] != "sound" and blamed_on(self.wiring, self.found, i, j) < limit
        ]
        as_well = [f"its {' and '.join(account.split(', '))}" for account in same] + list(map(repr, others))
        return f", or {' or '.join(as_well)}: the log does not tell which; {self._advice(i)}" if as_well else ""

    def _advice(self, i: int) -> str:
        """What to log so that motor i is seen."""
        wiring, slides = self.wiring, self._slides(i)
        joints = " and ".join(self.motors.joint_names[j] for j in self._joints(i))
        travel = float(np.ptp(wiring.y[:, i]) / wiring.unit[i])
        if travel < (LITTLE_LENGTH if slides else LITTLE_ANGLE):
            return f"move it: log {joints} at several places, {'100 mm' if slides else '30°'} apart and more"
        if len(wiring.y) < 2 * wiring.k:
            return f"log more moments, {2 * wiring.k} at least, every joint moved by itself"
        if wiring.rotation is None:
            return "measure the tool's orientation too, or a point of the tool beside its axis"
        return f"log more moments in which {joints} moves by itself"


def _amount(value: float, unit: str) -> str:
    return f"{1000 * value:+.1f} mm" if unit == "m" else f"{np.degrees(value):+.2f}°"
