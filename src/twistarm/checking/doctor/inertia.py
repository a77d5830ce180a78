"""Masses and inertias that no body has. Torques need them; kinematics does not."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...description.findings import Finding
from ...description.inertial import Body, bodies
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


def check_inertias(description: Description) -> Iterator[Finding]:
    """One finding for each kind of trouble, naming the links."""
    every = bodies(description)
    solid = {name: body for name, body in every.items() if body.mass >= TINY_MASS}
    possible = {name: body for name, body in every.items() if _is_possible(_moments(body))}
    tiny = {name: body for name, body in every.items() if name not in solid}
    heavy = {name: body for name, body in every.items() if body.mass > HUGE_MASS}
    impossible = {name: body for name, body in every.items() if name not in possible}
    wide = {n: body for n, body in solid.items() if n in possible and _gyration(body) > LARGEST_GYRATION}
    far = {name: body for name, body in solid.items() if np.linalg.norm(body.centre) > FARTHEST_CENTRE}
    weightless = "a mass of only {mass:g} kg: gravity torques ignore it"
    troubles = (
        ("mass-missing", tiny, weightless, _NO_BODY),
        ("inertia-implausible", heavy, "a mass of {mass:g} kg: grams?", _REMEDY),
        ("inertia-implausible", impossible, "no body has the principal moments {moments} kg m²", _REMEDY),
        ("inertia-implausible", wide, "mass and inertia mean a radius of gyration of {gyration:.3g} m: mm²?", _REMEDY),
        ("inertia-implausible", far, "a centre of mass {centre:.4g} m off the link's frame: millimetres?", _REMEDY),
    )
    for code, found, what, remedy in troubles:
        if found:
            links = [description.links[name] for name in found]
            yield grouped(code, description, links, _filled(what, next(iter(found.values()))), remedy)
    yield from _placeholders(description, solid)
    if bare := _without_mass(description, {name for name, body in every.items() if body.mass > 0.0}):
        what = "a shape and no mass: gravity torques ignore it"
        yield grouped("mass-missing", description, bare, what, "copy its mass from CAD, in kg")


def _moments(body: Body) -> Array:
    """The principal moments (3,) [kg m²], the least first."""
    return np.asarray(np.linalg.eigvalsh(body.inertia), dtype=np.float64)


def _is_possible(moments: Array) -> bool:
    """Whether some distribution of mass has these moments: none negative, none above the sum of the others."""
    slack = max(SHARE * float(np.abs(moments).max()), SMALLEST)
    return bool(moments[0] >= -slack and moments[:2].sum() >= moments[2] - slack)


def _gyration(body: Body) -> float:
    """The largest radius of gyration √(I/m) [m]; infinite without a mass."""
    return float(np.sqrt(max(_moments(body)[2], 0.0) / body.mass)) if body.mass else np.inf


def _without_mass(description: Description, heavy: set[str]) -> list[Link]:
    """The links with shapes that joints move and that are not `heavy`."""
    moving = (name for name, joint in description.joints.items() if joint.moving)
    moved = {link for name in moving for link in description.beyond(name)} - heavy
    return [link for link in description.links.values() if link.name in moved and (link.visuals or link.collisions)]


def _filled(what: str, body: Body) -> str:
    moments = "(" + ", ".join(f"{moment:.3g}" for moment in _moments(body)) + ")"
    centre = float(np.linalg.norm(body.centre))
    return what.format(mass=body.mass, moments=moments, centre=centre, gyration=_gyration(body))


def _placeholders(description: Description, solid: dict[str, Body]) -> Iterator[Finding]:
    first = next(iter(solid.values()), None)
    if first is None or len(solid) < PLACEHOLDERS:
        return
    if all(body.mass == first.mass and (_moments(body) == _moments(first)).all() for body in solid.values()):
        what = f"all have the mass {first.mass:g} kg and the same inertia: placeholders; gravity torques mean nothing"
        yield grouped("mass-missing", description, [description.links[name] for name in solid], what, _REMEDY)
