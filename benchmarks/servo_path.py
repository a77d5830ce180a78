"""Straight lines in free space with late and lossy drives: how far the tool strays, and how soon it stops."""

from __future__ import annotations

from collections import deque

import numpy as np

from twistarm import Arm
from twistarm.control.servo import ServoState, TwistCommand, servo_step

from .servo_arms import Array, least_singular_value, random, ranges, servo_arm

DT, DRIVING, STOPPING = 0.01, 1.5, 1.0
"""Seconds of a step, of a line, and after its release."""

SPEED, STANDING = 0.08, 2e-3
"""Of the tool [m/s], and below which it stands."""

SUBSTEPS, GAIN = 10, 40.0
"""Cycles of the drives' position loops in a step: they run at 1 kHz. An error falls to a third in 25 ms."""

DELAY, LOSS, RATE_GAIN, COUNT = 0.08, 0.15, 1.03, 2 * np.pi / 4096
"""Dead time [s], share of lost setpoints, the drives' rate over the commanded one, an encoder's count [rad]."""

FREE = 0.1
"""Least singular value, and distance to a limit as a share of its range, on a line in free space."""


class Drives:
    """Position drives at `theta` that close their loop on the encoders and rest within one count."""

    def __init__(self, theta: Array, rng: np.random.Generator) -> None:
        self.theta, self.rng = theta.copy(), rng
        self.target, self.rates = theta.copy(), np.zeros_like(theta)
        self.way: deque[tuple[Array, Array]] = deque([(self.target, self.rates)] * round(DELAY / DT))

    def step(self, target: Array, rates: Array) -> None:
        self.way.append((target, rates))
        arrived = self.way.popleft()
        if self.rng.random() >= LOSS:
            self.target, self.rates = arrived
        for k in range(SUBSTEPS):
            error = self.target + self.rates * (k * DT / SUBSTEPS) - COUNT * np.round(self.theta / COUNT)
            error = np.sign(error) * np.maximum(np.abs(error) - COUNT, 0.0)
            self.theta += DT / SUBSTEPS * (RATE_GAIN * self.rates + GAIN * error)


def line(arm: Arm, rng: np.random.Generator) -> tuple[float, float, float] | None:
    """The largest distance of setpoints and tool from the line [m], and the seconds to a stop; None if not free."""
    lower, upper = ranges(arm)
    reserve = FREE * (upper - lower)
    start, along = rng.uniform(lower + 2 * reserve, upper - 2 * reserve), rng.normal(size=3)
    along /= np.linalg.norm(along)
    if least_singular_value(arm, start) < 1.5 * FREE:
        return None
    drives, state, zero = Drives(start, rng), ServoState.at(arm, start), arm.fk(start)[:3, 3]
    forward, release = TwistCommand([*SPEED * along, 0, 0, 0], "base"), TwistCommand(np.zeros(6), "base")
    told, kept = [], []
    for k in range(round((DRIVING + STOPPING) / DT)):
        state, output = servo_step(arm, state, forward if k * DT < DRIVING else release, DT)
        if output.lost_share > 1e-3 and k * DT < DRIVING and arm.n >= 6:
            return None
        drives.step(state.theta, state.theta_dot)
        told.append(arm.fk(state.theta)[:3, 3] - zero)
        kept.append(arm.fk(drives.theta)[:3, 3] - zero)
    if least_singular_value(arm, state.theta) < FREE or not _inside(state.theta, lower + reserve, upper - reserve):
        return None
    speed = np.linalg.norm(np.diff(kept[round(DRIVING / DT) :], axis=0), axis=1) / DT
    moving = np.flatnonzero(speed > STANDING)
    return off(np.array(told), along), off(np.array(kept), along), (DT * (moving[-1] + 1) if len(moving) else 0.0)


def _inside(theta: Array, lower: Array, upper: Array) -> bool:
    return bool(((theta >= lower) & (theta <= upper)).all())


def off(points: Array, along: Array) -> float:
    return float(np.linalg.norm(points - np.outer(points @ along, along), axis=1).max())


def figures(name: str, count: int, seed: int) -> dict[str, object]:
    """Figures in mm and s over lines in free space. Arms that cannot move in every direction have fewer or none."""
    arm, rng, found = servo_arm(name), random(name, "path", seed), []
    if np.linalg.matrix_rank(arm.hybrid_jacobian(arm.ready)[:3], tol=1e-6) < 3:
        return {"arm": name, "lines": 0}
    for _ in range(20 * count):
        if len(found) < count and (one := line(arm, rng)):
            found.append(one)
    row: dict[str, object] = {"arm": name, "lines": len(found)}
    if found:
        told, kept, stop = np.array(found).T
        row |= {"told median": 1e3 * np.median(told), "told worst": 1e3 * told.max()}
        row |= {"median": 1e3 * np.median(kept), "worst": 1e3 * kept.max(), "stop": np.median(stop)}
        row["stop worst"] = stop.max()
    return {key: float(value) if isinstance(value, np.floating) else value for key, value in row.items()}
