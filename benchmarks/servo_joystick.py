"""Drives by joystick: reversals, releases and changes of mode, and which limits they break."""

from __future__ import annotations

import numpy as np

from twistarm import Arm
from twistarm.control.servo import AnyCommand, JogCommand, PoseCommand, ServoState, TwistCommand, servo_step

from .servo_arms import random, ranges, servo_arm

DT, SECONDS = 0.01, 4.0
ROUNDING = 1e-9
"""Of positions [rad, m] and rates."""


def next_command(arm: Arm, rng: np.random.Generator, last: AnyCommand) -> AnyCommand:
    """Joystick events: release, reversal, new direction; another frame, held components, single joints, a pose."""
    choice = rng.integers(7)
    if choice == 0:
        return TwistCommand(np.zeros(6))
    if choice < 3 and isinstance(last, TwistCommand):
        return TwistCommand(-last.twist, last.frame, last.hold)
    frame = ("tool", "base")[rng.integers(2)]
    if choice == 4:
        return TwistCommand([*0.2 * rng.uniform(-1, 1, 3), 0, 0, 0], frame, "orientation")
    if choice == 5:
        return JogCommand(rng.uniform(-1, 1, arm.n) * (np.arange(arm.n) == rng.integers(arm.n)))
    if choice == 6:
        return PoseCommand(arm.fk(rng.uniform(*ranges(arm))))
    return TwistCommand(rng.uniform(-1, 1, 6) * np.repeat([0.2, 0.8], 3) * (rng.random(6) < 0.4), frame)


def drive(arm: Arm, rng: np.random.Generator) -> tuple[int, int, int]:
    """Cycles in which a limit of position, velocity or acceleration is exceeded."""
    state, command = ServoState.at(arm, rng.uniform(*ranges(arm))), TwistCommand(np.zeros(6))
    theta, rates, until = [state.theta], [state.theta_dot], 0
    for k in range(round(SECONDS / DT)):
        if k == until:
            command = next_command(arm, rng, command)  # type: ignore[assignment]
            until += int(rng.integers(5, 80))
        state, _ = servo_step(arm, state, command, DT)
        theta.append(state.theta)
        rates.append(state.theta_dot)
    x, v, limits = np.array(theta), np.array(rates), arm.limits
    outside = (x < limits.lower - ROUNDING) | (x > limits.upper + ROUNDING) | ~np.isfinite(x)
    fast = np.abs(v) > limits.velocity + ROUNDING
    jumps = np.abs(np.diff(v, axis=0)) > limits.acceleration * DT + ROUNDING
    return int(outside.any(1).sum()), int(fast.any(1).sum()), int(jumps.any(1).sum())


def figures(name: str, count: int, seed: int) -> dict[str, object]:
    arm, rng = servo_arm(name), random(name, "joystick", seed)
    position, velocity, acceleration = np.sum([drive(arm, rng) for _ in range(count)], axis=0).tolist()
    return {"arm": name, "drives": count, "position": position, "velocity": velocity, "acceleration": acceleration}
