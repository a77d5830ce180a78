"""Mimic and locked joints: every joint value as an affine function of the independent coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..support.checks import Array, as_number
from ..support.errors import UnknownNameError, closest, listed, unknown_name
from ..support.messages import Argument, Text
from .findings import refusal
from .tree import Description


class Affine(NamedTuple):
    """value = multiplier · (value of the independent joint `master`) + offset. Without a master, value = offset."""

    master: str | None
    multiplier: float
    offset: float


def resolve_couplings(description: Description, locked_joints: Mapping[str, float]) -> dict[str, Affine]:
    """For every moving joint of the tree the independent joint that it follows, also through other mimics.

    Raises DescriptionError for a missing master, or for joints that mimic each other in a circle. Raises
    UnknownNameError for an unknown locked joint, InputError for a value that is not a number.
    """
    moving = {joint.name: joint for joint in description.joints.values() if joint.scalar}
    for name in locked_joints:
        if name not in moving:
            if parts := [joint.name for joint in moving.values() if joint.part_of == name]:
                what = f"joint {name!r} of {description.name} is planar"
                raise UnknownNameError(f"{what}; lock its coordinates: {listed(parts)}")
            within = Text("{robot}, for {locked}", robot=description.name, locked=Argument("locked_joints", None))
            raise unknown_name("moving joint", name, moving, within=within, listing=f"{len(moving)} moving joints")
        as_number(locked_joints[name], f"locked_joints[{name!r}]")
    return {name: _follow(description, name, locked_joints) for name in moving}


def coupling_matrix(
    couplings: Mapping[str, Affine], joints: Sequence[str], coordinates: Sequence[str]
) -> tuple[Array, Array]:
    """(A, b) with joint values = A @ theta + b. Masters outside `coordinates` count as 0."""
    A, b = np.zeros((len(joints), len(coordinates))), np.zeros(len(joints))
    column = {name: i for i, name in enumerate(coordinates)}
    for row, name in enumerate(joints):
        affine = couplings[name]
        b[row] = affine.offset
        if affine.master in column:
            A[row, column[affine.master]] = affine.multiplier
    return A, b


def _follow(description: Description, name: str, locked_joints: Mapping[str, float]) -> Affine:
    """Follow the mimic elements to a joint that is independent, locked or fixed."""
    multiplier, offset = 1.0, 0.0
    behind: dict[str, None] = {}
    while True:
        joint = description.joints[name]
        if name in locked_joints:
            return Affine(None, 0.0, multiplier * float(locked_joints[name]) + offset)
        if not joint.moving or multiplier == 0.0:
            return Affine(None, 0.0, offset)
        if joint.mimic is None:
            if not joint.scalar:
                place = description.place(description.joints[next(iter(behind), name)])
                what = f"it mimics {name!r}, which is {joint.type}: its motion is not one number"
                raise refusal("mimic-unusable", place, what, "let it mimic another joint")
            return Affine(name, multiplier, offset)
        if name in behind:
            what = f"joints mimic each other in a circle: {', '.join(behind)}"
            raise refusal("mimic-unusable", description.place(joint), what, "let one of them move by itself")
        behind[name] = None
        offset += multiplier * joint.mimic.offset
        multiplier *= joint.mimic.multiplier
        name = joint.mimic.joint
        if name not in description.joints:
            remedy = f"correct the name{closest(name, description.joints)}"
            what = f"it mimics {name!r}, which does not exist"
            raise refusal("mimic-unusable", description.place(joint), what, remedy)
