"""The servo: held twists that end in shaking, and the time of a step beside forward kinematics of the same arm.

Its arms have the same velocity and acceleration limits; tests/control drives them too.
"""

from __future__ import annotations

import argparse
import os
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import Arm, JointLimits, arm_from_screws, joints, load_arm
from twistarm.control.servo import ServoState, TwistCommand, servo_step

NAMED = (
    "rover_arm", "rover_arm_6dof", "scara", "stanford", "elbow", "ur5", "panda", "so101", "so100", "xarm7", "z1"
)  # fmt: skip
"""Arms that load by name, where example-robot-data is there."""

MODELS: dict[str, tuple[str, dict[str, Any]]] = {
    "slider": ("robojackets_slider_arm/cartesian_controller_simulation/urdf/arm_gazebo.urdf.xacro", {"tip": "tool0"}),
    "walli": ("robojackets_walliiarmv3/urc_gazebo/urdf/WalliiArmV3.urdf", {"tip": "claw"}),
    "ar4": ("annin_ar4_description/urdf/ar.urdf.xacro", {"tip": "ee_link", "xacro_args": {"ar_model": "mk3"}}),
    "gen3": ("kortex_description/robots/gen3.xacro", {"tip": "tool_frame", "xacro_args": {"dof": "7"}}),
    "gen3_lite": ("kortex_description/robots/gen3_lite.urdf", {"tip": "tool_frame"}),
}
"""Arms below the folder that the environment variable TWISTARM_MODELS names."""

VELOCITY, ACCELERATION, OF_SLIDES = 1.5, 3.0, 0.3  # Limits [rad/s, rad/s²], and what of them slides get [m].

Array = np.ndarray[Any, np.dtype[np.float64]]


def four_joints() -> Arm:
    """A turning base and three pitches, as the OpenMANIPULATOR-X has."""
    x, y, z = np.zeros(3), np.eye(3)[1], np.eye(3)[2]
    points = ([0.012, 0, 0.077], [0.036, 0, 0.205], [0.16, 0, 0.205])
    screws = [joints.revolute(z, x), *(joints.revolute(y, point) for point in points)]
    return _made("four_joints", screws, [0.286, 0, 0.205], [-3.1, -1.5, -1.5, -1.7], [3.1, 1.5, 1.4, 1.97])


def slide_and_pitches() -> Arm:
    """A slide and three pitches."""
    y = np.eye(3)[1]
    pitches = (joints.revolute(y, [x, 0, 0.2]) for x in (0.0, 0.3, 0.55))
    half = [0.4, 2.0, 2.4, 2.0]
    return _made("slide_and_pitches", [joints.prismatic(y), *pitches], [0.7, 0, 0.2], -np.array(half), half)


def _made(name: str, screws: list[Any], tip: Any, lower: Any, upper: Any) -> Arm:
    home, free = np.eye(4), np.full(len(screws), np.inf)
    home[:3, 3] = tip
    limits = JointLimits(np.array(lower), np.array(upper), free, free, free, free)
    return arm_from_screws(np.column_stack(screws), home, limits=limits, name=name)


MADE: dict[str, Callable[[], Arm]] = {"four_joints": four_joints, "slide_and_pitches": slide_and_pitches}


def names() -> list[str]:
    """All that can be asked for here."""
    return [*NAMED, *MADE, *(MODELS if os.environ.get("TWISTARM_MODELS") else ())]


def servo_arm(name: str, accelerating: bool = True) -> Arm:
    """The arm of that name with the limits of this module, without acceleration limits if not `accelerating`."""
    if name in MADE:
        arm = MADE[name]()
    elif name in MODELS:
        file, arguments = MODELS[name]
        arm = load_arm(Path(os.environ.get("TWISTARM_MODELS", "")) / file, **arguments)
    else:
        arm = load_arm(name)
    unit = np.where(np.array(arm.units) == "m", OF_SLIDES, 1.0)
    most = ACCELERATION * unit if accelerating else np.full(arm.n, np.inf)
    return replace(arm, limits=replace(arm.limits, velocity=VELOCITY * unit, acceleration=most))


def random(name: str, what: str, seed: int) -> np.random.Generator:
    """Random numbers for an arm and a purpose. They do not depend on the other arms of the run."""
    return np.random.default_rng([seed, zlib.crc32(f"{name} {what}".encode())])


def ranges(arm: Arm) -> tuple[Array, Array]:
    """Where joints start: their limits, or half a turn (m) to both sides."""
    lower, upper = arm.limits.lower, arm.limits.upper
    return np.where(np.isfinite(lower), lower, -np.pi), np.where(np.isfinite(upper), upper, np.pi)


def scaled_jacobian(arm: Arm, theta: Array) -> Array:
    """The hybrid Jacobian with metres measured in the arm's reach, slides too."""
    rows = np.repeat([1 / arm.reach, 1.0], 3)[:, None]
    return arm.hybrid_jacobian(theta) * rows * np.where(np.array(arm.units) == "m", arm.reach, 1.0)


def least_singular_value(arm: Arm, theta: Array) -> float:
    return float(np.linalg.svd(scaled_jacobian(arm, theta), compute_uv=False)[min(6, arm.n) - 1])


def least(arm: Arm, cost: Callable[[Array], float], start: Array, rng: np.random.Generator, steps: int = 300) -> Array:
    """Downhill from `start` within the limits, by random steps that grow shorter."""
    lower, upper = ranges(arm)
    best, lowest = start, cost(start)
    for size in np.geomspace(0.5, 1e-4, steps):
        tried = np.clip(best + size * rng.normal(size=arm.n), lower, upper)
        if (now := cost(tried)) < lowest:
            best, lowest = tried, now
    return best


def stretched(arm: Arm, rng: np.random.Generator) -> Array:
    return least(arm, lambda theta: -float(np.linalg.norm(arm.fk(theta)[:3, 3])), rng.uniform(*ranges(arm)), rng)


def singular(arm: Arm, rng: np.random.Generator) -> Array:
    return least(arm, lambda theta: least_singular_value(arm, theta), rng.uniform(*ranges(arm)), rng)


def at_limits(arm: Arm, rng: np.random.Generator) -> Array:
    """One or two joints at a limit, the others anywhere."""
    both = np.array(ranges(arm))
    theta = rng.uniform(*both)
    held = rng.choice(arm.n, rng.integers(1, 3), replace=False)
    theta[held] = both[rng.integers(2, size=len(held)), held]
    return theta


# Seconds of a step, of a held twist, and at its end, in which nothing may shake.
DT, SECONDS, JUDGED = 0.01, 8.0, 4.0
TURNING, REVERSALS = 1e-3, 2.0  # Rates [rad/s, m/s] that count, and how often a second a joint may turn round.
# Changes of rate per cycle that count, and how often a second the acceleration may change its sign.
CHANGING, CHANGES = 2e-4, 5.0
STEADY = 1e-3  # How much scale and the lost twist may vary while the arm rests.

KINDS = ("random", "at limits", "stretched", "singular")


@dataclass(frozen=True)
class Case:
    """Where an arm starts, and the twist that is held."""

    kind: str
    theta: Array
    twist: Array
    frame: str


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


def step_times(arm: Arm, calls: int = 2000) -> tuple[float, float]:
    """Medians of one step under a twist that swings to and fro, and of one `arm.fk`, in turn [µs]."""
    state, steps, fk = ServoState.at(arm, arm.ready), [], []
    for k in range(calls):
        command = TwistCommand([0.1 if k // 50 % 2 else -0.1, 0, 0, 0, 0.2, 0])
        begin = time.perf_counter_ns()
        state, _ = servo_step(arm, state, command, DT)
        middle = time.perf_counter_ns()
        arm.fk(state.theta)
        steps.append(middle - begin)
        fk.append(time.perf_counter_ns() - middle)
    return float(np.median(steps)) / 1e3, float(np.median(fk)) / 1e3


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.servo", description=__doc__)
    parser.add_argument("--arms", nargs="+", choices=names(), default=names(), metavar="ARM", help=", ".join(names()))
    parser.add_argument("--count", type=int, default=200, metavar="N", help="held twists of an arm; 200")
    parser.add_argument("--seed", type=int, default=1, help="of the cases; 1")
    given = parser.parse_args(arguments)
    print("arm: held twists that shake, with limits of acceleration and without; µs of a step and of arm.fk")
    for name in given.arms:
        shaking = []
        for accelerating in (True, False):
            arm, rng = servo_arm(name, accelerating), random(name, "held", given.seed)
            cases = [case(arm, rng, number) for number in range(given.count)]
            verdicts = [judged(*held(arm, one.theta, TwistCommand(one.twist, one.frame))) for one in cases]
            shaking.append(sum(verdict.shakes or verdict.unsteady > STEADY for verdict in verdicts))
        step, fk = step_times(servo_arm(name))
        print(f"  {name:18s} {shaking[0]} and {shaking[1]} of {given.count}   {step:.1f} and {fk:.1f}", flush=True)


if __name__ == "__main__":
    main()
