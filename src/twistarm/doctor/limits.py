"""Limits that look like degrees or millimetres, leave no room to move, or leave the zero pose out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..arm import Arm
from ..description.findings import Finding, finding
from ..description.tree import Description, Joint
from ..limits import AS_GOOD_AS_UNBOUNDED
from .wording import SHOWN, grouped, place_of

TOO_WIDE = 13.0
"""Two turns each way [rad]: a joint that turns further has a slip ring or limits in degrees."""

WIDEST_DEGREES = 720.0
"""Beyond this, limits make no sense in degrees either."""

LONGEST_SLIDE = 10.0
"""No arm's rail is as long [m]; in millimetres most are longer."""

FASTEST = {"rad": 50.0, "m": 10.0}
"""Eight turns a second, and 10 m/s: joints of arms are slower by far."""

TINY = {"rad": 0.01, "m": 1e-4}
"""Half a degree, and a tenth of a millimetre: less is no motion."""

LONGEST_REACH = 20.0
"""[m]; in millimetres every arm is longer."""


def check_limits(description: Description, arm: Arm | None) -> Iterator[Finding]:
    """What each joint's limits look like, those given beside the description included."""
    joints = [joint for joint in _with_given(description, arm) if joint.scalar]
    for joint in joints:
        yield from _range(description, joint)
    yield from _velocities(description, [joint for joint in joints if joint.mimic is None])


def check_zero(arm: Arm) -> Iterator[Finding]:
    """Whether the zero pose, which so many programs start from, lies inside the limits."""
    outside = [
        f"{name} [{lower:.4g}, {upper:.4g}]"
        for name, lower, upper in zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True)
        if not lower <= 0.0 <= upper
    ]
    if outside:
        yield finding(
            "zero-outside-limits",
            place_of(arm.description, arm.name),
            f"the zero pose is outside the limits of {', '.join(outside[:SHOWN])}"
            + (f" and {len(outside) - SHOWN} more" if len(outside) > SHOWN else ""),
            "do not command zeros: start from the ready pose",
        )


def check_reach(arm: Arm) -> Iterator[Finding]:
    """Whether the arm's lengths can be metres."""
    if arm.reach > LONGEST_REACH:
        yield finding(
            "reach-implausible",
            place_of(arm.description, arm.name),
            f"its reach is {arm.reach:.4g} m: lengths in millimetres look like that",
            "write every <origin xyz> in metres",
        )


def _with_given(description: Description, arm: Arm | None) -> list[Joint]:
    """The joints with the limits that hold: the arm's own for those of its chain."""
    joints = dict(description.joints)
    if arm is not None:
        for i, name in enumerate(arm.joint_names):
            lower, upper, velocity = (float(x[i]) for x in (arm.limits.lower, arm.limits.upper, arm.limits.velocity))
            joints[name] = replace(joints[name], lower=lower, upper=upper, velocity=velocity)
    return list(joints.values())


def _range(description: Description, joint: Joint) -> Iterator[Finding]:
    unit = "m" if joint.type == "prismatic" else "rad"
    bounds = [bound for bound in (joint.lower, joint.upper) if abs(bound) < AS_GOOD_AS_UNBOUNDED]
    largest = max(map(abs, bounds), default=0.0)
    shown = f"its limits [{joint.lower:g}, {joint.upper:g}] {unit}"
    if unit == "rad" and TOO_WIDE < largest <= WIDEST_DEGREES:
        yield finding(
            "limits-look-like-degrees",
            description.place(joint),
            f"{shown} allow {largest / math.tau:.0f} turns; they look like degrees",
            f"write {_attributes(np.radians([joint.lower, joint.upper]))}",
        )
    elif unit == "m" and largest > LONGEST_SLIDE:
        yield finding(
            "limits-look-like-millimetres",
            description.place(joint),
            f"{shown} look like millimetres",
            f"write {_attributes(np.array([joint.lower, joint.upper]) / 1e3)}",
        )
    elif 0.0 < joint.upper - joint.lower < TINY[unit]:
        yield finding(
            "limit-range-tiny",
            description.place(joint),
            f"{shown} leave {joint.upper - joint.lower:.2g} {unit}: it can hardly move",
            "angles are in radians and slides in metres; make it a fixed joint if it is meant to stand still",
        )


def _attributes(bounds: np.ndarray) -> str:
    names = [f'{name}="{x:.6g}"' for name, x in zip(("lower", "upper"), bounds, strict=True) if np.isfinite(x)]
    return " ".join(names)


def _velocities(description: Description, joints: list[Joint]) -> Iterator[Finding]:
    """One finding for all joints with the same impossible velocity."""
    fast: dict[tuple[str, float], list[Joint]] = {}
    for joint in joints:
        unit = "m" if joint.type == "prismatic" else "rad"
        if FASTEST[unit] < joint.velocity < AS_GOOD_AS_UNBOUNDED:
            fast.setdefault((unit, joint.velocity), []).append(joint)
    for (unit, velocity), those in fast.items():
        converted, small = (velocity / 1e3, "mm") if unit == "m" else (math.radians(velocity), "degrees")
        yield grouped(
            "velocity-implausible",
            description,
            those,
            f"a velocity limit of {velocity:g} {unit}/s, faster than any arm's joint; planning takes it at its word",
            f'write velocity="{converted:.4g}" if it is in {small} per second, else the figure of the motor',
        )
