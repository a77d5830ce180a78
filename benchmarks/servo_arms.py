"""The servo's arms, with the same velocity and acceleration limits, and their configurations."""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import Arm, JointLimits, arm_from_screws, joints, load_arm

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

VELOCITY, ACCELERATION, OF_SLIDES = 1.5, 3.0, 0.3
"""Limits [rad/s, rad/s²], and what of them slides get [m]."""

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
