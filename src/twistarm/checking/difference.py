"""The difference of two arms in words: an arm and its golden file, a baked arm or another description."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.baking import BAKED, SUFFIX, unsealed
from ..arm.loading.load import arm_of, load_arm
from ..collision import Scene
from ..collision.survey import collision_shares
from ..description.inertial import Body
from ..support.errors import ComparisonError, InputError
from ..support.files import as_path
from .changes import SAME_TOL, limit_changes, mass_changes, motor_changes, name_changes
from .geometry_changes import geometry_changes
from .golden_file import COLLISION_SAMPLES, GOLDEN, bodies_of, read_bodies

SAMPLES = 100
"""Random configurations at which poses and Jacobians are compared."""

SAME_SHARE = 0.001
"""Shares that differ by less are the same: rounding moves few configurations into or out of a collision."""

NO_MASSES = "masses were not compared: what it is compared with holds none; a golden file that is written now does"
"""Of an arm without a description."""


@dataclass(frozen=True)
class Difference:
    """What has changed, one sentence each; empty for the same arm. `pose_error` and `jacobian_error` are the worst.

    `notes` say what could not be compared.
    """

    arm: str
    changes: tuple[str, ...]
    pose_error: float = 0.0
    jacobian_error: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def same(self) -> bool:
        """Nothing has changed."""
        return not self.changes

    def require(self) -> Difference:
        """Itself, or ComparisonError with every change."""
        if self.changes:
            raise ComparisonError(f"{self.arm} has changed: " + "; ".join(self.changes))
        return self


def compare(arm: Arm, against: Arm | str | os.PathLike[str]) -> Difference:
    """The differences between an arm and another one in words: "was" is the other one, "is" the arm.

    Args:
        arm: The arm as it is now.
        against: A golden file that `freeze` wrote, a baked arm.json, or another arm: an `Arm` or anything that
            `load_arm` takes. A description is loaded without options.

    Returns:
        The `Difference`: names, types, limits, motors, axes, tool, and the mass, centre and inertia of each link.
        Shapes, meshes, named poses and the SRDF are not compared, but the collisions of links are if the golden file
        has them. Differences below 1 µm, 1e-6 rad or 1e-5 of a mass
        count as none, because an export rounds that much.

    Raises:
        DescriptionError: `against` cannot be read, or is no golden file, no baked arm and no description.
    """
    require_arm(arm)
    then, masses, collisions = _other(against)
    changes = [
        f"{role} was {was!r}, is {now!r}"
        for role, was, now in (("base", then.base, arm.base), ("tip", then.tip, arm.tip))
        if was != now
    ]
    changes += _joint_changes(then, arm)
    changes += motor_changes(then.actuators, arm.actuators)
    notes: tuple[str, ...] = ()
    now = bodies_of(arm)
    if masses is None and now:
        notes = (NO_MASSES,)
    elif masses is not None and now is not None:
        changes += mass_changes(masses, now)
    if collisions is not None and now is not None and then.joint_names == arm.joint_names:
        changes += _collision_changes(collisions, then, arm)
    if then.joint_names != arm.joint_names or then.screws.shape != arm.screws.shape:
        return Difference(arm.name, tuple(changes or ["the joints that follow others are different ones"]), notes=notes)
    moved = geometry_changes(arm, then.screws, then.home)
    if max(np.abs(was - now).max() for was, now in zip(then.coupling, arm.coupling, strict=True)) > SAME_TOL:
        moved.append("the coupling of mimic or locked joints is different")
    theta = then.random_theta(0, SAMPLES)
    g, spatial, body = (
        float(np.abs(was - now).max())
        for was, now in zip(then.by_exponentials(theta), arm.by_exponentials(theta), strict=True)
    )
    return Difference(arm.name, (*changes, *moved), g, max(spatial, body), notes)


def _other(against: Arm | str | os.PathLike[str]) -> tuple[Arm, Mapping[str, Body] | None, Mapping[str, Any] | None]:
    """The arm to compare with, and what is known of the masses and the collisions of its links."""
    if not isinstance(against, (Arm, str, os.PathLike)):
        raise InputError(f"against must be an Arm, a file or a name that load_arm takes; got {type(against).__name__}")
    if not isinstance(against, Arm):
        path = as_path(str(os.fspath(against)))
        if path.suffix == SUFFIX:
            content = unsealed(path, GOLDEN, BAKED)
            return arm_of(content), read_bodies(content), content.get("collisions")
        against = load_arm(against)
    return against, bodies_of(against), None


def _joint_changes(then: Arm, arm: Arm) -> list[str]:
    changes = name_changes("joint", then.joint_names, arm.joint_names)
    for i, (name, kind) in enumerate(zip(then.joint_names, then.joint_types, strict=True)):
        if name in arm.joint_names:
            j = arm.joint_names.index(name)
            if kind != arm.joint_types[j]:
                changes.append(f"joint {name} was {kind}, is {arm.joint_types[j]}")
            changes += limit_changes(name, arm.units[j], then.limits, i, arm.limits, j)
    return changes


def _collision_changes(entry: Mapping[str, Any], then: Arm, arm: Arm) -> Iterator[str]:
    """The pairs of links that collide more or less often than at the time of `entry`, at the same configurations."""
    before = {(a, b): share for a, b, share in entry["shares"]}
    now = collision_shares(Scene(arm, exact=entry["exact"]), then.random_theta(0, COLLISION_SAMPLES))
    for pair in sorted({*before, *now}):
        was, share = (100.0 * shares.get(pair, 0.0) for shares in (before, now))
        if abs(share - was) > 100.0 * SAME_SHARE:
            yield f"links {pair[0]} and {pair[1]} collide in {share:.3g} % of random configurations; it was {was:.3g} %"
