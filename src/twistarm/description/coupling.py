"""Mimic and locked joints: every joint value as an affine function of the independent coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..checks import Array
from ..errors import DescriptionError, closest, unknown_name
from .tree import Description, Joint


class Affine(NamedTuple):
    """value = multiplier · (value of the independent joint `master`) + offset; no master: the value is the offset."""

    master: str | None
    multiplier: float
    offset: float


def resolve_couplings(description: Description, locked: Mapping[str, float]) -> dict[str, Affine]:
    """For every moving joint of the tree the independent joint it follows, a mimic of a mimic included.

    Raises DescriptionError for a master that does not exist, or for joints that mimic each other in a circle;
    UnknownNameError for a locked joint that does not exist.
    """
    moving = {joint.name: joint for joint in description.joints.values() if joint.moving}
    for name in locked:
        if name not in moving:
            listing = f"{len(moving)} moving joints"
            raise unknown_name("moving joint", name, moving, within=f"{description.name}, for locked=", listing=listing)
    return {name: _follow(description, name, locked, ()) for name in moving}


def coupling_matrix(
    couplings: Mapping[str, Affine], joints: Sequence[str], coordinates: Sequence[str]
) -> tuple[Array, Array]:
    """(A, b) with joint values = A @ theta + b; a joint whose master is not among `coordinates` stands at master 0."""
    A, b = np.zeros((len(joints), len(coordinates))), np.zeros(len(joints))
    column = {name: i for i, name in enumerate(coordinates)}
    for row, name in enumerate(joints):
        affine = couplings[name]
        b[row] = affine.offset
        if affine.master in column:
            A[row, column[affine.master]] = affine.multiplier
    return A, b


def _follow(description: Description, name: str, locked: Mapping[str, float], behind: tuple[str, ...]) -> Affine:
    joint = description.joints[name]
    if name in locked:
        return Affine(None, 0.0, float(locked[name]))
    if not joint.moving:
        return Affine(None, 0.0, 0.0)
    if joint.mimic is None:
        return Affine(name, 1.0, 0.0)
    if name in behind:
        raise DescriptionError(f"{description.path}: joints mimic each other in a circle: {', '.join(behind)}")
    master = _follow(description, _master(description, joint), locked, (*behind, name))
    k = joint.mimic.multiplier
    if master.master is None or k == 0.0:
        return Affine(None, 0.0, k * master.offset + joint.mimic.offset)
    return Affine(master.master, k * master.multiplier, k * master.offset + joint.mimic.offset)


def _master(description: Description, joint: Joint) -> str:
    assert joint.mimic is not None
    if joint.mimic.joint not in description.joints:
        raise DescriptionError(
            f"{description.path}: joint {joint.name!r} mimics {joint.mimic.joint!r}, which does not exist"
            f"{closest(joint.mimic.joint, description.joints)}"
        )
    return joint.mimic.joint
