"""Masses and inertias that no body of an arm has, and bodies without one."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ..support.checks import Array
from .findings import Finding
from .geometry import Body, bodies
from .tree import Description, grouped

TINY_MASS = 1e-6  # [kg]: no part of an arm weighs a milligram; exports write such numbers for "none".
HUGE_MASS = 500.0  # [kg]: no link of an arm weighs as much; in grams most weigh more.
FARTHEST_CENTRE = 3.0  # [m] from the link's frame; in millimetres it is mostly further.
# [m]: √(I/m) is a length inside the body. In kg mm² or g mm² it comes out a thousand times longer and more.
LARGEST_GYRATION = 3.0
SHARE = 0.05  # How far principal moments may miss what physics demands: few exports round as coarsely.
SMALLEST = 1e-9  # [kg m²]: a gram, a millimetre wide; less is the rounding of nothing.
PLACEHOLDERS = 3  # So many links with the very same mass and inertia were not measured.

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
