"""Twists that lead out of a singular configuration or off a limit: the time until the arm moves as commanded."""

from __future__ import annotations

import numpy as np

from twistarm import Arm
from twistarm.control.servo import ServoState, TwistCommand, servo_step

from .servo_arms import Array, at_limits, least, least_singular_value, random, ranges, scaled_jacobian, servo_arm

DT, SECONDS, FULL = 0.01, 3.0, 0.95
"""The step [s], the longest wait [s], and the share of the command that counts as all of it."""

SIZE = 0.1
"""Of the commanded twist [reach/s, rad/s]."""

EXACT, RISING, ROOM = 1e-3, 0.05, 0.05
"""Singular value that counts as singular, its rise along the way out, and a joint's distance from its limits."""


def from_singular(arm: Arm, rng: np.random.Generator) -> tuple[Array, Array] | None:
    """A singular configuration with room around it, and the missing twist on the side where the arm can leave it."""
    lower, upper = ranges(arm)
    start = rng.uniform(lower + 0.1 * (upper - lower), upper - 0.1 * (upper - lower))
    theta = least(arm, lambda x: least_singular_value(arm, x), start, rng, 600)
    if least_singular_value(arm, theta) > EXACT or ((theta < lower + ROOM) | (theta > upper - ROOM)).any():
        return None
    J, last, h = scaled_jacobian(arm, theta), min(6, arm.n) - 1, 1e-4
    left, _, right = np.linalg.svd(J)
    u, v = left[:, last], right[last]
    unit = np.where(np.array(arm.units) == "m", arm.reach, 1.0)
    rise = u @ (scaled_jacobian(arm, theta + h * unit * v) - J) @ v / h
    return (theta, SIZE * np.sign(rise) * u) if abs(rise) > RISING else None


def from_limits(arm: Arm, rng: np.random.Generator) -> tuple[Array, Array] | None:
    """A configuration at limits, away from singularities, and the twist of rates that lead off them."""
    theta = at_limits(arm, rng)
    if least_singular_value(arm, theta) < 0.15:
        return None
    lower, upper = ranges(arm)
    rates = rng.normal(size=arm.n)
    rates = np.where(theta == lower, abs(rates), np.where(theta == upper, -abs(rates), rates))
    twist = scaled_jacobian(arm, theta) @ rates
    return theta, SIZE * twist / np.linalg.norm(twist)


def time_to_leave(arm: Arm, theta: Array, twist: Array) -> float:
    """Seconds until the tool has FULL of the commanded twist (metres in reaches), inf for never."""
    state, scale = ServoState.at(arm, theta), np.repeat([arm.reach, 1.0], 3)
    command = TwistCommand(scale * twist, "base")
    for k in range(round(SECONDS / DT)):
        done = arm.hybrid_jacobian(state.theta) @ state.theta_dot / scale
        if done @ twist >= FULL * (twist @ twist):
            return k * DT
        state, _ = servo_step(arm, state, command, DT)
    return float("inf")


def figures(name: str, count: int, seed: int) -> dict[str, object]:
    """Median and slowest seconds, and how many never get there."""
    arm, row = servo_arm(name), {"arm": name}
    result: dict[str, object] = dict(row)
    for kind, pick in (("singular", from_singular), ("limits", from_limits)):
        rng, times = random(name, f"leaving {kind}", seed), []
        for _ in range(10 * count):
            if len(times) < count and (found := pick(arm, rng)):
                times.append(time_to_leave(arm, *found))
        there = [time for time in times if np.isfinite(time)]
        result |= {kind: len(times), f"{kind} never": len(times) - len(there)}
        if there:
            result |= {f"{kind} median": float(np.median(there)), f"{kind} worst": max(there)}
    return result
