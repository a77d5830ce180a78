"""Twists held for long: does the arm shake at the end, and is the servo's answer steady at rest?"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from twistarm import Arm
from twistarm.control.servo import ServoState, TwistCommand, servo_step

from .servo_arms import Array, at_limits, random, ranges, servo_arm, singular, stretched
from .servo_plain import plain_rates

DT, SECONDS, JUDGED = 0.01, 8.0, 4.0
"""Seconds of a step, of a held twist, and at its end, in which nothing may shake."""

TURNING, REVERSALS = 1e-3, 2.0
"""Rates [rad/s, m/s] that count, and how often a second a joint may turn round."""

CHANGING, CHANGES = 2e-4, 5.0
"""Changes of rate per cycle that count, and how often a second the acceleration may change its sign."""

STEADY = 1e-3
"""How much scale and the lost twist may vary while the arm rests."""

KINDS = ("random", "at limits", "stretched", "singular")


@dataclass(frozen=True)
class Case:
    """Where an arm starts, and the twist that is held."""

    kind: str
    theta: Array
    twist: Array
    frame: str

    def as_lists(self) -> dict[str, object]:
        return asdict(self) | {"theta": self.theta.tolist(), "twist": self.twist.tolist()}


@dataclass(frozen=True)
class Verdict:
    """The worst joint's reversals and acceleration changes per second, and the answer's changes at rest."""

    reversals: float
    changes: float
    unsteady: float

    @property
    def shakes(self) -> bool:
        return self.reversals >= REVERSALS or self.changes >= CHANGES


def case(arm: Arm, rng: np.random.Generator, number: int) -> Case:
    kind = KINDS[number % 4]
    if kind == "random":
        theta = rng.uniform(*ranges(arm))
    else:
        theta = {"at limits": at_limits, "stretched": stretched, "singular": singular}[kind](arm, rng)
    return Case(kind, theta, _twist(rng, number // 4), ("base", "tool")[rng.integers(2)])


def _twist(rng: np.random.Generator, number: int) -> Array:
    """Along one axis; about one axis; random and linear; random with six dimensions."""
    speed, turning = rng.choice([0.05, 0.1, 0.2]), 0.4
    kind = number % 4
    if kind < 2:
        twist = np.zeros(6)
        twist[3 * kind + rng.integers(3)] = (speed, turning)[kind] * rng.choice([-1, 1])
        return twist
    linear = rng.normal(size=3)
    if kind == 2:
        return np.r_[speed * linear / np.linalg.norm(linear), 0, 0, 0]
    return np.r_[speed * linear, turning * rng.normal(size=3)]


def held(arm: Arm, start: Array, command: TwistCommand, seconds: float = SECONDS) -> tuple[Array, Array, list[str]]:
    """The joints' rates cycle by cycle, what was said beside (scale, lost twist), and the status."""
    state, rates, said, status = ServoState.at(arm, start), [], [], []
    for _ in range(round(seconds / DT)):
        state, output = servo_step(arm, state, command, DT)
        rates.append(state.theta_dot)
        said.append([output.scale, *output.lost_twist])
        status.append(output.status)
    return np.array(rates), np.array(said), status


def judged(rates: Array, said: Array, status: list[str]) -> Verdict:
    rest = slice(-round(1.0 / DT), None)
    unsteady = 0.0
    if np.abs(rates[rest]).max() < TURNING:
        unsteady = 1.0 if len(set(status[rest])) > 1 else float(np.ptp(said[rest], axis=0).max())
    return Verdict(*turns(rates), unsteady)


def turns(rates: Array) -> tuple[float, float]:
    """How often a second the worst joint turns round, and its acceleration, in what is judged."""
    last = rates[-round(JUDGED / DT) :]
    return sign_changes(last, TURNING) / JUDGED, sign_changes(np.diff(last, axis=0), CHANGING) / JUDGED


def sign_changes(signals: Array, floor: float) -> int:
    """Of the worst column, values below the floor aside."""
    counts = [np.count_nonzero(np.diff(np.sign(x[np.abs(x) > floor]))) for x in signals.T]
    return int(max(counts))


def figures(name: str, count: int, seed: int) -> dict[str, object]:
    """How many of the held twists end in shaking, with and without limits of acceleration, and which.

    plain: how many do by a damped pseudo-inverse with clipping.
    """
    row: dict[str, object] = {"arm": name, "held": 2 * count, "unsteady": 0, "plain": 0}
    found: list[dict[str, object]] = []
    for accelerating, title in ((True, "shaking"), (False, "unlimited")):
        arm, rng, shaking = servo_arm(name, accelerating), random(name, "held", seed), 0
        for number in range(count):
            one = case(arm, rng, number)
            verdict = judged(*held(arm, one.theta, TwistCommand(one.twist, one.frame)))
            plain = Verdict(*turns(plain_rates(arm, one.theta, one.twist, one.frame, DT, SECONDS)), 0.0)
            shaking += verdict.shakes
            row["plain"] += plain.shakes
            row["unsteady"] += verdict.unsteady > STEADY
            if verdict.shakes or verdict.unsteady > STEADY:
                found.append({"acceleration limits": accelerating, **one.as_lists(), **asdict(verdict)})
        row |= {"joints": arm.n, title: shaking}
    return row | {"cases": found}
