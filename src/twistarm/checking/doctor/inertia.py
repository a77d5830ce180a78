"""Masses and inertias that no body has. Torques need them; kinematics does not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...description.findings import Finding
from ...description.inertial import bodies
from ...description.tree import Description, Link
from ...support.checks import Array
from .wording import grouped

TINY_MASS = 1e-6
"""[kg]: no part of an arm weighs a milligram; exports write such numbers for "none"."""

HUGE_MASS = 500.0
"""[kg]: no link of an arm weighs as much; in grams most weigh more."""

FARTHEST_CENTRE = 3.0
"""[m] from the link's frame; in millimetres it is mostly further."""

LARGEST_GYRATION = 3.0
"""[m]: √(I/m) is a length inside the body. In kg mm² or g mm² it comes out a thousand times longer and more."""

SHARE = 0.05
"""How far principal moments may miss what physics demands: few exports round as coarsely."""

SMALLEST = 1e-9
"""[kg m²]: a gram, a millimetre wide; less is the rounding of nothing."""

PLACEHOLDERS = 3
"""So many links with the very same mass and inertia were not measured."""

_NO_BODY = "nothing, for a frame that is no body; else copy its mass from CAD, in kg"
_REMEDY = "copy the mass properties from CAD again, in kg, m and kg m²"


@dataclass(frozen=True)
class Body:
    """A link's mass [kg], distance of its centre from the link's frame [m], principal moments [kg m²] in order."""

    link: Link
    mass: float
    centre: float
    moments: Array

    @property
    def possible(self) -> bool:
        """Whether some distribution of mass has these moments: none negative, none above the sum of the others."""
        slack = max(SHARE * float(np.abs(self.moments).max()), SMALLEST)
        return bool(self.moments[0] >= -slack and self.moments[:2].sum() >= self.moments[2] - slack)

    @property
    def gyration(self) -> float:
        """The largest radius of gyration √(I/m) [m]."""
        return float(np.sqrt(max(self.moments[2], 0.0) / self.mass))


def check_inertias(description: Description) -> Iterator[Finding]:
    """One finding for each kind of trouble, naming the links."""
    bodies = _bodies(description)
    light = [body for body in bodies if body.mass < TINY_MASS]
    heavy = [body for body in bodies if body.mass > HUGE_MASS]
    solid = [body for body in bodies if body not in light]
    impossible = [body for body in bodies if not body.possible]
    wide = [body for body in solid if body.possible and body.gyration > LARGEST_GYRATION]
    far = [body for body in solid if body.centre > FARTHEST_CENTRE]
    weightless = "a mass of only {mass:g} kg: gravity torques ignore it"
    troubles = (
        ("mass-tiny", light, weightless, _NO_BODY),
        ("mass-implausible", heavy, "a mass of {mass:g} kg: grams?", _REMEDY),
        ("inertia-impossible", impossible, "no body has the principal moments {moments} kg m²", _REMEDY),
        ("inertia-implausible", wide, "mass and inertia mean a radius of gyration of {gyration:.3g} m: mm²?", _REMEDY),
        ("centre-of-mass-far", far, "a centre of mass {centre:.4g} m off the link's frame: millimetres?", _REMEDY),
    )
    for code, found, what, remedy in troubles:
        if found:
            yield grouped(code, description, [body.link for body in found], _filled(what, found[0]), remedy)
    yield from _placeholders(description, solid)
    if bare := _without_mass(description, {body.link.name for body in bodies if body.mass > 0.0}):
        what = "a shape and no mass: gravity torques ignore it"
        yield grouped("mass-missing", description, bare, what, "copy its mass from CAD, in kg")


def _without_mass(description: Description, heavy: set[str]) -> list[Link]:
    """The links with shapes that joints move and that are not `heavy`."""
    moving = (name for name, joint in description.joints.items() if joint.moving)
    moved = {link for name in moving for link in description.beyond(name)} - heavy
    return [link for link in description.links.values() if link.name in moved and (link.visuals or link.collisions)]


def _filled(what: str, body: Body) -> str:
    moments = "(" + ", ".join(f"{moment:.3g}" for moment in body.moments) + ")"
    numbers = {"mass": body.mass, "moments": moments, "centre": body.centre}
    return what.format(**numbers, gyration=body.gyration if body.mass else np.inf)


def _placeholders(description: Description, bodies: list[Body]) -> Iterator[Finding]:
    first = bodies[0] if len(bodies) >= PLACEHOLDERS else None
    if first is not None and all(_same(body, first) for body in bodies):
        yield grouped(
            "inertia-placeholder",
            description,
            [body.link for body in bodies],
            f"all have the mass {first.mass:g} kg and the same inertia: placeholders; gravity torques mean nothing",
            _REMEDY,
        )


def _same(body: Body, other: Body) -> bool:
    return body.mass == other.mass and bool((body.moments == other.moments).all())


def _bodies(description: Description) -> list[Body]:
    found = []
    for name, body in bodies(description).items():
        moments: Array = np.linalg.eigvalsh(body.inertia).astype(np.float64)
        found.append(Body(description.links[name], body.mass, float(np.linalg.norm(body.centre)), moments))
    return found
