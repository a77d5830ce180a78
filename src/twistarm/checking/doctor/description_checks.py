"""Checks of a description: limits and meshes that no arm has, by another unit, no room or no body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...arm.arm import Arm
from ...description.chain import Affine
from ...description.findings import Finding, Place, finding
from ...description.meshes import UnreadableMeshError, read_mesh
from ...description.tree import MOST_NAMES, Description, Joint
from ...limits.joint_limits import AS_GOOD_AS_UNBOUNDED, unit_of
from ...support.checks import Array
from ...support.errors import listed
from ...support.files import is_file

LONGEST_REACH = 20.0  # [m]; in millimetres every arm is longer.
# Two turns each way: a joint that turns further has a slip ring or limits in degrees. And no arm's rail is as long.
WIDEST = {"rad": 13.0, "m": 10.0}
WIDEST_DEGREES = 720.0  # Beyond this, limits make no sense in degrees either.
FASTEST = {"rad": 50.0, "m": 10.0}  # Eight turns a second, and 10 m/s: joints of arms are slower by far.
TINY = {"rad": 0.01, "m": 1e-4}  # Half a degree, and a tenth of a millimetre: less is no motion.
SLACK = 1e-3  # [rad, m]: limits that were rounded miss each other by less.
# The unit that implausible numbers are probably in, and its size.
OTHER = {"rad": ("degrees", math.radians(1.0)), "m": ("millimetres", 1e-3)}


# -- limits ------------------------------------------------------------------------------------------------------------


def check_limits(description: Description, arm: Arm | None) -> Iterator[Finding]:
    """Bounds and velocities of each joint, as the arm has them, those given beside the description included."""
    joints = dict(description.joints)
    if arm is not None:
        for i, name in enumerate(arm.joint_names):
            lower, upper, velocity = (float(x[i]) for x in (arm.limits.lower, arm.limits.upper, arm.limits.velocity))
            joints[name] = replace(joints[name], lower=lower, upper=upper, velocity=velocity)
    for joint in (joint for joint in joints.values() if joint.scalar):
        unit, place = unit_of(joint.type), _place(description, arm, joint, "lower", "upper")
        other, factor = OTHER[unit]
        bounds = {"lower": joint.lower, "upper": joint.upper}
        finite = {name: bound for name, bound in bounds.items() if abs(bound) < AS_GOOD_AS_UNBOUNDED}
        largest = max(map(abs, finite.values()), default=0.0)
        limits = f"its limits [{joint.lower:g}, {joint.upper:g}] {unit}"
        if largest > WIDEST[unit] and (unit == "m" or largest <= WIDEST_DEGREES):
            values = ", ".join(f"{name} {factor * bound:.6g}" for name, bound in finite.items())
            yield finding("unit-doubtful", place, f"{limits} look like {other}", f"if so, write {values}")
        elif 0.0 < joint.upper - joint.lower < TINY[unit]:
            remedy = "angles are in radians and slides in metres; make it a fixed joint if it should not move"
            yield finding("limit-incomplete", place, f"{limits} allow hardly any motion", remedy)
        if joint.mimic is None and FASTEST[unit] < joint.velocity < AS_GOOD_AS_UNBOUNDED:
            what = f"a velocity limit of {joint.velocity:g} {unit}/s, faster than any arm's joint; planning uses it"
            remedy = f"write {factor * joint.velocity:.4g} if it is in {other} per second, else the figure of the motor"
            yield finding("unit-doubtful", _place(description, arm, joint, "velocity"), what, remedy)


def _place(description: Description, arm: Arm | None, joint: Joint, *fields: str) -> Place:
    """The joint in the file that gives these limits: the arm.toml if they are not those of the description."""
    written = description.joints[joint.name]
    if arm is None or all(getattr(joint, field) == getattr(written, field) for field in fields):
        return description.place(written)
    drives = any(other.mimic is not None and other.mimic.joint == joint.name for other in description.joints.values())
    if drives and written.lower <= joint.lower and joint.upper <= written.upper:
        return description.place(written)  # followers have narrowed it
    return Place(Path(arm.source).name, element="joint", name=joint.name)


def check_mimics(
    description: Description, couplings: Mapping[str, Affine], chain: tuple[str, ...]
) -> Iterator[Finding]:
    """A follower's range of motion against its limits. The walk has checked those in the chain."""
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


TOO_LARGE = 20.0  # Times the arm's own size: no link is as long.
TOO_SMALL = 1.0 / 50.0  # Of the arm's own size: of all its meshes the largest is longer.

Use = tuple[Path, tuple[float, ...]]  # A mesh file, and the scale that one shape uses it at.


def check_meshes(description: Description) -> Iterator[Finding]:
    """Every mesh file once: whether it is one, then the size of what it holds."""

    def found(code: str, paths: Iterable[Path], what: str, remedy: str) -> Finding:
        names = listed(dict.fromkeys(path.name for path in paths), MOST_NAMES)
        return finding(code, description.place(), f"{names}: {what}", remedy)

    shapes = [shape for link in description.links.values() for shape in (*link.visuals, *link.collisions)]
    uses: dict[Use, None] = {(shape.mesh, shape.size): None for shape in shapes if shape.mesh and is_file(shape.mesh)}
    broken: dict[tuple[str, str], list[Path]] = {}
    lengths: dict[Path, float] = {}
    for path in dict.fromkeys(path for path, _ in uses):
        try:
            lengths[path] = read_mesh(path).length
        except UnreadableMeshError as error:  # noqa: PERF203
            why = f"{error.reason}; simple shapes are drawn instead", error.remedy
            broken.setdefault(why, []).append(path)
    for (what, remedy), paths in broken.items():
        yield found("mesh-unreadable", paths, what, remedy)
    if flat := [path for path, scale in uses if not all(scale)]:
        remedy = 'write scale="1 1 1" in <mesh>, or what makes metres of the unit it was exported in'
        yield found("unit-doubtful", flat, "a scale of 0 leaves nothing of it to see", remedy)
    sized = {(p, scale): lengths[p] * max(map(abs, scale)) for p, scale in uses if all(scale) and lengths.get(p)}
    points: Array = np.stack([g[:3, 3] for g in description.link_poses({}).values()])
    size = float(np.ptp(points, axis=0).max()) or 1.0  # of the arm at zero [m]; 1 if all frames coincide
    if large := {use: length for use, length in sized.items() if length > TOO_LARGE * size}:
        what = f"{max(large.values()):.4g} m long, on an arm of {size:.3g} m: likely in millimetres"
        yield found("unit-doubtful", (path for path, _ in large), what, _rescaled(large, 1e-3))
    elif sized and max(sized.values()) < TOO_SMALL * size and size < LONGEST_REACH:
        longest = max(sized, key=lambda use: sized[use])
        what = f"{sized[longest]:.2g} m long at most, on an arm of {size:.3g} m: scaled down twice"
        yield found("unit-doubtful", (path for path, _ in sized), what, _rescaled([longest], 1e3))


def _rescaled(uses: Iterable[Use], factor: float) -> str:
    """The scale to write for meshes with one scale, or the factor for several."""
    scales = {scale for _, scale in uses}
    if len(scales) > 1:
        return f"multiply their scales in <mesh> by {factor:g}"
    numbers = " ".join(f"{scale * factor:.6g}" for scale in scales.pop())
    return f'write scale="{numbers}" in <mesh>'
