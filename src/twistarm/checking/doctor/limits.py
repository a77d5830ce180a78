"""Limits and lengths that look like another unit, leave no room, exclude the zero pose, or stop a follower."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from ...arm.arm import Arm
from ...description.coupling import Affine
from ...description.findings import Finding, Place, finding
from ...description.tree import Description, Joint
from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED, unit_of
from .wording import SHOWN, place_of

MILLIMETRE = 1e-3
"""[m]: the unit that lengths of a CAD export are in most often, if not in metres."""

LONGEST_REACH = 20.0
"""[m]; in millimetres every arm is longer."""

WIDEST = {"rad": 13.0, "m": 10.0}
"""Two turns each way: a joint that turns further has a slip ring or limits in degrees. And no arm's rail is as long."""

WIDEST_DEGREES = 720.0
"""Beyond this, limits make no sense in degrees either."""

FASTEST = {"rad": 50.0, "m": 10.0}
"""Eight turns a second, and 10 m/s: joints of arms are slower by far."""

TINY = {"rad": 0.01, "m": 1e-4}
"""Half a degree, and a tenth of a millimetre: less is no motion."""

SLACK = 1e-3
"""[rad, m]: limits that were rounded miss each other by less."""

_OTHER = {"rad": ("degrees", math.radians(1.0)), "m": ("millimetres", MILLIMETRE)}
"""The unit that implausible numbers are probably in, and its size."""


def check_limits(description: Description, arm: Arm | None) -> Iterator[Finding]:
    """Bounds and velocities of each joint, as the arm has them, those given beside the description included."""
    for joint in _with_given(description, arm):
        if joint.scalar:
            yield from _bounds(description, joint, arm)
            if joint.mimic is None:
                yield from _velocity(description, joint, arm)


def check_mimics(
    description: Description, couplings: Mapping[str, Affine], chain: tuple[str, ...]
) -> Iterator[Finding]:
    """A follower's range of motion against its limits; the walk has checked those in the chain."""
    for name, affine in couplings.items():
        follower = description.joints[name]
        if name in chain or affine.master in (None, name):
            continue
        master = description.joints[str(affine.master)]
        low, high = sorted(affine.multiplier * bound + affine.offset for bound in (master.lower, master.upper))
        if low < follower.lower - SLACK or high > follower.upper + SLACK:
            yield finding(
                "outside-limits",
                description.place(follower),
                f"{master.name} drives it through [{low:.4g}, {high:.4g}], beyond its own limits "
                f"[{follower.lower:.4g}, {follower.upper:.4g}], which are not kept",
                "make both joints' limits fit the mimic's multiplier and offset",
            )


def check_zero(arm: Arm) -> Iterator[Finding]:
    """Whether the zero pose, which so many programs start from, lies inside the limits."""
    outside = [
        f"{name} [{lower:.4g}, {upper:.4g}]"
        for name, lower, upper in zip(arm.joint_names, arm.limits.lower, arm.limits.upper, strict=True)
        if not lower <= 0.0 <= upper
    ]
    if outside:
        more = f" and {len(outside) - SHOWN} more" if len(outside) > SHOWN else ""
        what = f"the zero pose is outside the limits of {', '.join(outside[:SHOWN])}{more}"
        remedy = "do not command zeros: start from the ready pose"
        yield finding("zero-outside-limits", place_of(arm.description, arm.name), what, remedy)


def check_reach(arm: Arm) -> Iterator[Finding]:
    """Whether the arm's lengths can be metres."""
    if arm.reach > LONGEST_REACH:
        what = f"its reach is {arm.reach:.4g} m: its lengths look like another unit"
        remedy = f"write every <origin xyz> in metres: multiply by {MILLIMETRE:g} if they are millimetres"
        yield finding("unit-doubtful", place_of(arm.description, arm.name), what, remedy)


def _with_given(description: Description, arm: Arm | None) -> list[Joint]:
    """The joints with the limits that hold: the arm's own for those of its chain."""
    joints = dict(description.joints)
    if arm is not None:
        for i, name in enumerate(arm.joint_names):
            lower, upper, velocity = (float(x[i]) for x in (arm.limits.lower, arm.limits.upper, arm.limits.velocity))
            joints[name] = replace(joints[name], lower=lower, upper=upper, velocity=velocity)
    return list(joints.values())


def _place(description: Description, arm: Arm | None, joint: Joint, *fields: str) -> Place:
    """The joint in the file that gives these limits: the arm.toml if they are not those of the description."""
    written = description.joints[joint.name]
    if arm is None or all(getattr(joint, field) == getattr(written, field) for field in fields):
        return description.place(written)
    drives = any(other.mimic is not None and other.mimic.joint == joint.name for other in description.joints.values())
    if drives and written.lower <= joint.lower and joint.upper <= written.upper:
        return description.place(written)  # followers have narrowed it
    return Place(Path(arm.source).name, element="joint", name=joint.name)


def _bounds(description: Description, joint: Joint, arm: Arm | None) -> Iterator[Finding]:
    unit, place = unit_of(joint.type), _place(description, arm, joint, "lower", "upper")
    finite = {
        name: bound
        for name, bound in (("lower", joint.lower), ("upper", joint.upper))
        if abs(bound) < AS_GOOD_AS_UNBOUNDED
    }
    largest = max(map(abs, finite.values()), default=0.0)
    shown = f"its limits [{joint.lower:g}, {joint.upper:g}] {unit}"
    if largest > WIDEST[unit] and (unit == "m" or largest <= WIDEST_DEGREES):
        other, factor = _OTHER[unit]
        values = ", ".join(f"{name} {factor * bound:.6g}" for name, bound in finite.items())
        yield finding("unit-doubtful", place, f"{shown} look like {other}", f"if so, write {values}")
    elif 0.0 < joint.upper - joint.lower < TINY[unit]:
        remedy = "angles are in radians and slides in metres; make it a fixed joint if it is meant to stand still"
        yield finding("limit-zero-range", place, f"{shown} leave it hardly any room", remedy)


def _velocity(description: Description, joint: Joint, arm: Arm | None) -> Iterator[Finding]:
    unit = unit_of(joint.type)
    if FASTEST[unit] < joint.velocity < AS_GOOD_AS_UNBOUNDED:
        other, factor = _OTHER[unit]
        what = f"a velocity limit of {joint.velocity:g} {unit}/s, faster than any arm's joint; planning uses it"
        remedy = f"write {factor * joint.velocity:.4g} if it is in {other} per second, else the figure of the motor"
        yield finding("unit-doubtful", _place(description, arm, joint, "velocity"), what, remedy)
