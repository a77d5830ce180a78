"""Limits that look like degrees or millimetres, leave no room, exclude the zero pose, or stop a follower."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...arm.arm import Arm
from ...description.companions.toml_entries import toml_key
from ...description.coupling import Affine
from ...description.findings import Finding, Place, finding
from ...description.tree import Description, Joint
from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED, unit_of
from .wording import SHOWN, grouped, place_of

UNITS = {"inches": 0.0254, "centimetres": 0.01, "millimetres": 0.001}
"""[m], the largest first: what lengths are exported in."""

USUAL = ("millimetres", "inches", "centimetres")
"""The most usual first."""

LONGEST_REACH = 20.0
"""[m]; in millimetres every arm is longer, in inches most."""

ARMS = (0.15, 3.2)
"""[m]: reaches of most arms."""

SMALLEST_SUSPECT = 4.0
"""[m]: longer arms are rare; of them one whose lengths are round in inches alone is in inches."""

ROUND = 5e-3
"""[mm], or parts of 1/16 inch: what a length may be off a whole number."""

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

SLACK = 1e-3
"""[rad, m]: limits that were rounded miss each other by less."""


def check_limits(description: Description, arm: Arm | None) -> Iterator[Finding]:
    """What each joint's limits look like, those given beside the description included."""
    joints = [joint for joint in _with_given(description, arm) if joint.scalar]
    reach = description.extent if arm is None else arm.reach
    unit = next(iter(likely_units(description, reach)), "millimetres")
    for joint in joints:
        yield from _range(description, joint, _given_in(description, arm, joint, ("lower", "upper")), unit)
    fast: dict[tuple[str, float], list[Joint]] = {}
    for joint in joints:
        if joint.mimic is None and FASTEST[unit_of(joint.type)] < joint.velocity < AS_GOOD_AS_UNBOUNDED:
            given = _given_in(description, arm, joint, ("velocity",))
            if given is None:
                fast.setdefault((unit_of(joint.type), joint.velocity), []).append(joint)
            else:
                yield finding("velocity-implausible", given, *_fast_words(joint, given, unit))
    for those in fast.values():
        yield grouped("velocity-implausible", description, those, *_fast_words(those[0], None, unit))


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
                "mimic-outside-limits",
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
    units = () if arm.description is None else likely_units(arm.description, arm.reach)
    if units or arm.reach > LONGEST_REACH:
        unit, *others = units or ["millimetres"]
        also = " or ".join(f"by {UNITS[other]:g} for {other}" for other in others)
        what = f"its reach is {arm.reach:.4g} m: lengths in {unit} look like that"
        remedy = f"write every <origin xyz> in metres: multiply by {UNITS[unit]:g}" + (f" (or {also})" if also else "")
        yield finding("reach-implausible", place_of(arm.description, arm.name), what, remedy)


def likely_units(description: Description, reach: float) -> list[str]:
    """The likely units of an arm's lengths, likeliest first; none if they may be metres.

    They give a usual reach; the unit with most round numbers comes first.
    """
    lengths = np.abs([x for joint in description.joints.values() for x in joint.origin[:3, 3] if x])
    rounds = {unit: _rounds(lengths, unit) for unit in USUAL}
    odd = reach > SMALLEST_SUSPECT and rounds["inches"] > max(2, len(lengths) / 2) and not _rounds(lengths, "metres")
    if not (reach > LONGEST_REACH or odd):
        return []
    fitting = [unit for unit in USUAL if ARMS[0] <= reach * UNITS[unit] <= ARMS[1]]
    fitting = fitting or (["inches"] if odd else ["millimetres"])
    return sorted(fitting, key=lambda unit: -rounds[unit])


def _rounds(lengths: np.ndarray, unit: str) -> int:
    """How many are whole millimetres, or whole sixteenths of an inch, in that unit."""
    whole = [lengths * UNITS.get(unit, 1.0) * 1e3] + ([lengths * 16.0] if unit == "inches" else [])
    return max(int((np.abs(x - np.round(x)) <= ROUND).sum()) for x in whole)


def _with_given(description: Description, arm: Arm | None) -> list[Joint]:
    """The joints with the limits that hold: the arm's own for those of its chain."""
    joints = dict(description.joints)
    if arm is not None:
        for i, name in enumerate(arm.joint_names):
            lower, upper, velocity = (float(x[i]) for x in (arm.limits.lower, arm.limits.upper, arm.limits.velocity))
            joints[name] = replace(joints[name], lower=lower, upper=upper, velocity=velocity)
    return list(joints.values())


def _given_in(description: Description, arm: Arm | None, joint: Joint, fields: tuple[str, ...]) -> Place | None:
    """The source of these limits beside the description (an arm.toml, the caller), or None."""
    written = description.joints[joint.name]
    differ = [field for field in fields if getattr(joint, field) != getattr(written, field)]
    if arm is None or not differ:
        return None
    drives = any(other.mimic is not None and other.mimic.joint == joint.name for other in description.joints.values())
    inside = written.lower <= joint.lower and joint.upper <= written.upper and joint.velocity <= written.velocity
    if drives and inside:
        return None  # followers have narrowed it
    return Place(Path(arm.source).name, element="joint", name=joint.name)


def _range(description: Description, joint: Joint, given: Place | None, lengths: str) -> Iterator[Finding]:
    """`lengths`: the unit of those that cannot be metres."""
    unit = unit_of(joint.type)
    place = given or description.place(joint)
    bounds = [bound for bound in (joint.lower, joint.upper) if abs(bound) < AS_GOOD_AS_UNBOUNDED]
    largest = max(map(abs, bounds), default=0.0)
    shown = f"its limits [{joint.lower:g}, {joint.upper:g}] {unit}"
    if unit == "rad" and TOO_WIDE < largest <= WIDEST_DEGREES:
        what = f"{shown} allow {_turns(joint, largest):.3g} turns; they look like degrees"
        remedy = _bounds_remedy(joint, given, np.radians([joint.lower, joint.upper]))
        yield finding("limits-look-like-degrees", place, what, remedy)
    elif unit == "m" and largest > LONGEST_SLIDE:
        remedy = _bounds_remedy(joint, given, np.array([joint.lower, joint.upper]) * UNITS[lengths])
        yield finding("limits-look-like-millimetres", place, f"{shown} look like {lengths}", remedy)
    elif 0.0 < joint.upper - joint.lower < TINY[unit]:
        what = f"{shown} leave {joint.upper - joint.lower:.2g} {unit}: it can hardly move"
        remedy = "angles are in radians and slides in metres; make it a fixed joint if it is meant to stand still"
        yield finding("limit-range-tiny", place, what, remedy)


def _turns(joint: Joint, largest: float) -> float:
    """The number of turns between the bounds, or from zero to the only one."""
    width = joint.upper - joint.lower
    return (width if width < AS_GOOD_AS_UNBOUNDED else largest) / math.tau


def _bounds_remedy(joint: Joint, given: Place | None, bounds: np.ndarray) -> str:
    return _remedy(joint, given, {n: x for n, x in zip(("lower", "upper"), bounds, strict=True) if np.isfinite(x)})


def _remedy(joint: Joint, given: Place | None, values: Mapping[str, float]) -> str:
    """The text to write, in the words of its file."""
    if given is None:
        return "write " + " ".join(f'{name}="{x:.6g}"' for name, x in values.items())
    entries = ", ".join(f"{name} = {x:.6g}" for name, x in values.items())
    if given.file.endswith(".toml"):
        return f"write {entries} in limits.{toml_key(joint.name)} of {given.file}"
    return f"give {entries} where the arm is loaded"


def _fast_words(joint: Joint, given: Place | None, lengths: str) -> tuple[str, str]:
    """What is wrong with an impossible velocity, and the remedy."""
    unit, velocity = unit_of(joint.type), joint.velocity
    converted, small = (velocity * UNITS[lengths], lengths) if unit == "m" else (math.radians(velocity), "degrees")
    remedy = _remedy(joint, given, {"velocity": float(f"{converted:.4g}")})
    return (
        f"a velocity limit of {velocity:g} {unit}/s, faster than any arm's joint; planning takes it at its word",
        f"{remedy} if it is in {small} per second, else the figure of the motor",
    )
