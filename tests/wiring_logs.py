"""Logs for the wiring check as strangers write them: their arms, faults, noise, and a base that is not where they say.

What is planted is known, so a report is judged without the check's own mathematics: poses come from Pinocchio.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from catalogue import load
from twistarm import Actuators, Arm
from twistarm.calibration import Measurements, WiringReport
from twistarm.support.checks import Array
from twistarm.theory.rotations import exp

FAULTS = ("none", "flipped sign", "zero offset", "wrong ratio", "swapped")
NOISE, BASE_NOISE = (0.002, np.radians(1.0)), (0.01, np.radians(2.0))
"""The log's and the base's, of position [m] and orientation [rad], that the check assumes."""


@dataclass(frozen=True)
class Planted:
    """A log, the motors (none of a sound arm) and the fault that it holds, and how well it shows that [σ]."""

    arm: Arm
    log: Measurements
    fault: str
    motors: tuple[str, ...]
    shown: float
    words: str


def planted(names: Sequence[str], seed: int, *, fault: str, poses: bool, base: tuple[float, float]) -> Planted:
    """One log; `base` is how far [m, rad], in a random direction, the base was from where it was measured to be."""
    rng = np.random.default_rng(seed)
    arm = geared(load(str(rng.choice(list(names)))), rng)
    motors = arm.actuators
    assert motors is not None
    theta = _postures(arm, rng)
    G, offset, order = motors.G.copy(), motors.offset.copy(), np.arange(len(motors.names))
    i, j = (int(motor) for motor in rng.permutation(len(order))[:2])
    turn = 1.0 / np.abs(np.linalg.inv(G)[:, i]).max()
    if fault == "flipped sign":
        G[i] *= -1.0
    elif fault == "zero offset":
        slides = arm.units[int(np.abs(np.linalg.inv(G)[:, i]).argmax())] == "m"
        added = rng.uniform(0.03, 0.2) if slides else np.radians(rng.uniform(4.0, 90.0))
        offset[i] += rng.choice([-1.0, 1.0]) * added * turn
    elif fault == "wrong ratio":
        G[i] *= rng.choice([0.25, 0.5, 0.8, 1.25, 2.0, 4.0])
    elif fault == "swapped":
        order[[i, j]] = j, i
    true = replace(motors, G=G, offset=offset)
    counts = true.to_counts(true.to_motor(theta))[:, order]
    if rng.random() < 0.5:
        counts = np.round(counts, 3)
    position, angle = rng.uniform(0.001, 0.005), np.radians(rng.uniform(0.3, 1.5))
    exact = _base(rng, base) @ arm.by_pinocchio(theta)[0]
    seen = exact.copy()
    seen[:, :3, 3] += rng.normal(scale=position, size=(len(theta), 3))
    seen[:, :3, :3] = seen[:, :3, :3] @ exp(rng.normal(scale=angle, size=(len(theta), 3)))
    noise = max(position, NOISE[0]), max(angle, NOISE[1]) if poses else np.inf
    away = 0.0 if fault == "none" else how_clear(arm, counts, exact, fault, i, noise)
    blamed = {"none": (), "swapped": (motors.names[i], motors.names[j])}.get(fault, (motors.names[i],))
    words = f"{arm.name} {fault} {blamed} rows {len(theta)} noise {1000 * position:.1f} mm"
    return Planted(arm, measured(counts, seen, poses), fault, blamed, away, words)


def measured(counts: Array, g: Array, poses: bool) -> Measurements:
    """A log of counts with measured poses (K, 4, 4), or with their positions."""
    return Measurements(counts, g[:, :3, 3], g[:, :3, :3] if poses else np.empty(0))


def how_clear(arm: Arm, counts: Array, exact: Array, fault: str, i: int, noise: tuple[float, float]) -> float:
    """How far exact poses (K, 4, 4) are from the nearest that an arm without the fault could have [σ].

    Its zeros and ratios are what they may be, but for the faulty one of motor i. Signs and plugs are as configured, and
    the base stands about where it was measured.
    """
    motors = arm.actuators
    assert motors is not None
    k, turn = len(motors.names), 1.0 / np.abs(np.linalg.inv(motors.G)).max(axis=0)
    readings = motors.from_counts(counts) - motors.offset
    free = np.ones(6 + 2 * k, dtype=bool)
    free[{"zero offset": [6 + i], "wrong ratio": [6 + k + i]}.get(fault, [])] = False

    def residual(some: Array) -> Array:
        x = np.zeros(len(free))
        x[free] = some
        stands = np.eye(4)
        stands[:3, :3], stands[:3, 3] = exp(BASE_NOISE[1] * x[3:6]), BASE_NOISE[0] * x[:3]
        motor = readings * np.exp(np.clip(x[6 + k :], -5.0, 5.0)) + turn * x[6 : 6 + k]  # no sign changes
        off = (stands @ arm.fk(motors.to_theta(motor + motors.offset)) - exact)[:, :3]
        return np.r_[(off[..., 3] / noise[0]).ravel(), (off[..., :3] / noise[1] / np.sqrt(2.0)).ravel(), x[:6]]

    fit = least_squares(residual, np.zeros(free.sum()), x_scale="jac", max_nfev=100)
    return float(np.sqrt(2.0 * fit.cost))


def geared(arm: Arm, rng: np.random.Generator) -> Arm:
    """A gear of its own on each joint, in one of two arms a differential at the wrist, counting in all units."""
    n = arm.n
    G = np.diag(rng.choice([-1.0, 1.0], n) * rng.choice([30.0, 50.0, 80.0, 100.0, 160.0], n))
    turning = all(unit == "rad" for unit in arm.units[-2:])
    if n > 3 and turning and rng.random() < 0.5:
        G[n - 2 :, n - 2 :] = [[60.0, 60.0], [60.0, -60.0]]
    names = tuple(f"m{i}" for i in range(n))
    units = tuple(rng.choice(["rad", "tick", "deg", "turn"], n).tolist())
    motors = Actuators(names, arm.joint_names, G, rng.uniform(-3.0, 3.0, n), units, np.full(n, 4096.0))
    return replace(arm, actuators=motors)


def logged(
    arm: Arm, true: Actuators, theta: Array | int, seed: int, *, poses: bool = True, turned: float = 0.0
) -> Measurements:
    """Counts of the true motors at theta or at so many random postures, the tool by Pinocchio, measured to 1 mm."""
    rng = np.random.default_rng(seed)
    theta = arm.random_theta(rng, theta) if isinstance(theta, int) else theta
    g = arm.by_pinocchio(theta)[0].copy()
    g[:, :3, 3] += rng.normal(scale=0.001, size=(len(theta), 3))
    g[:, :3, :3] = g[:, :3, :3] @ exp(rng.normal(scale=turned, size=(len(theta), 3)))
    return measured(true.to_counts(true.to_motor(theta)), g, poses)


def faults(report: WiringReport) -> dict[str, tuple[str, ...]]:
    """The faults that are named, by motor."""
    return {motor.name: motor.faults for motor in report.motors if motor.faults}


def _postures(arm: Arm, rng: np.random.Generator) -> Array:
    """All over the joints' ranges, or near a posture: each joint some tens of degrees."""
    rows = int(rng.integers(8, 41))
    theta: Array = arm.random_theta(rng, rows)
    if rng.random() < 0.5:
        theta = theta[0] + rng.uniform(0.15, 0.4) * (theta - theta[0])
    return theta


def _base(rng: np.random.Generator, off: tuple[float, float]) -> Array:
    way, axis = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = exp(off[1] * axis), off[0] * way
    return g


def outcome(case: Planted, report: WiringReport) -> str:
    """What the report is: "named", "left open", "missed" or, of a sound motor, "accused"."""
    certain = {motor.name for motor in report.motors if case.fault in motor.faults}
    if {motor.name for motor in report.motors if motor.faults} - set(case.motors):
        return "accused"
    if set(case.motors) <= certain:
        return "named"
    return "left open" if report.verdict != "sound" else "missed"
