"""Limits, masses, inertias and meshes that no arm has: another unit, no room, no body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...arm.arm import Arm
from ...description.chain import Affine
from ...description.findings import Finding, Place, finding
from ...description.geometry import Body, bodies
from ...description.meshes import UnreadableMeshError, read_mesh
from ...description.tree import Description, Joint, Link
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
TINY_MASS = 1e-6  # [kg]: no part of an arm weighs a milligram; exports write such numbers for "none".
HUGE_MASS = 500.0  # [kg]: no link of an arm weighs as much; in grams most weigh more.
FARTHEST_CENTRE = 3.0  # [m] from the link's frame; in millimetres it is mostly further.
# [m]: √(I/m) is a length inside the body. In kg mm² or g mm² it comes out a thousand times longer and more.
LARGEST_GYRATION = 3.0
SHARE = 0.05  # How far principal moments may miss what physics demands: few exports round as coarsely.
SMALLEST = 1e-9  # [kg m²]: a gram, a millimetre wide; less is the rounding of nothing.
PLACEHOLDERS = 3  # So many links with the very same mass and inertia were not measured.
SHOWN = 6  # Names in one finding before the rest is counted.


def grouped(code: str, description: Description, parts: Sequence[Joint | Link], what: str, remedy: str) -> Finding:
    """One finding about several joints or links: at its place for one, else at the file with their names."""
    if len(parts) == 1:
        return finding(code, description.place(parts[0]), what, remedy)
    names = listed([part.name for part in parts], SHOWN)
    return finding(code, description.place(), f"{names}: {what}", remedy)


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


# -- bodies ------------------------------------------------------------------------------------------------------------

REMEDY = "copy the mass properties from CAD again, in kg, m and kg m²"

TROUBLES = {
    "tiny": ("mass-missing", "nothing, for a frame that is no body; else copy its mass from CAD, in kg"),
    "heavy": ("inertia-implausible", REMEDY),
    "impossible": ("inertia-implausible", REMEDY),
    "wide": ("inertia-implausible", REMEDY),
    "far": ("inertia-implausible", REMEDY),
}
"""The code and the remedy of each trouble with a body."""


def check_inertias(description: Description) -> Iterator[Finding]:
    """One finding for each kind of trouble with bodies. Torques need them; kinematics does not."""
    every = bodies(description)
    found: dict[str, dict[str, str]] = {trouble: {} for trouble in TROUBLES}
    for name, body in every.items():
        for trouble, what in _troubles(body):
            found[trouble][name] = what
    for trouble, links in found.items():
        if links:
            code, remedy = TROUBLES[trouble]
            what = next(iter(links.values()))
            yield grouped(code, description, [description.links[name] for name in links], what, remedy)
    solid = {name: body for name, body in every.items() if name not in found["tiny"]}
    first = next(iter(solid.values()), None)
    alike = first is not None and all(
        body.mass == first.mass and bool((_moments(body) == _moments(first)).all()) for body in solid.values()
    )
    if first is not None and alike and len(solid) >= PLACEHOLDERS:
        what = f"all have the mass {first.mass:g} kg and the same inertia: placeholders; gravity torques mean nothing"
        yield grouped("mass-missing", description, [description.links[name] for name in solid], what, REMEDY)
    moving = (name for name, joint in description.joints.items() if joint.moving)
    moved = {link for name in moving for link in description.beyond(name)}
    weightless = moved - {name for name, body in every.items() if body.mass > 0.0}
    bare = [
        link for name, link in description.links.items() if name in weightless and (link.visuals or link.collisions)
    ]
    if bare:
        what = "a shape and no mass: gravity torques ignore it"
        yield grouped("mass-missing", description, bare, what, "copy its mass from CAD, in kg")


def _troubles(body: Body) -> Iterator[tuple[str, str]]:
    """The troubles with one body, and what they are."""
    if body.mass < TINY_MASS:
        yield "tiny", f"a mass of only {body.mass:g} kg: gravity torques ignore it"
    if body.mass > HUGE_MASS:
        yield "heavy", f"a mass of {body.mass:g} kg: grams?"
    moments = _moments(body)
    slack = max(SHARE * float(np.abs(moments).max()), SMALLEST)
    # Of a distribution of mass no moment is negative, and none is above the sum of the two others.
    if moments[0] < -slack or moments[:2].sum() < moments[2] - slack:
        yield "impossible", f"no body has the principal moments ({', '.join(f'{x:.3g}' for x in moments)}) kg m²"
    elif body.mass >= TINY_MASS and (gyration := math.sqrt(max(moments[2], 0.0) / body.mass)) > LARGEST_GYRATION:
        yield "wide", f"mass and inertia mean a radius of gyration of {gyration:.3g} m: mm²?"
    centre = float(np.linalg.norm(body.centre))
    if body.mass >= TINY_MASS and centre > FARTHEST_CENTRE:
        yield "far", f"a centre of mass {centre:.4g} m off the link's frame: millimetres?"


def _moments(body: Body) -> Array:
    """The principal moments (3,) [kg m²], the least first."""
    return np.asarray(np.linalg.eigvalsh(body.inertia), dtype=np.float64)


TOO_LARGE = 20.0  # Times the arm's own size: no link is as long.
TOO_SMALL = 1.0 / 50.0  # Of the arm's own size: of all its meshes the largest is longer.

Use = tuple[Path, tuple[float, ...]]  # A mesh file, and the scale that one shape uses it at.


def check_meshes(description: Description) -> Iterator[Finding]:
    """Every mesh file once: whether it is one, then the size of what it holds."""

    def found(code: str, paths: Iterable[Path], what: str, remedy: str) -> Finding:
        names = listed(dict.fromkeys(path.name for path in paths), SHOWN)
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
