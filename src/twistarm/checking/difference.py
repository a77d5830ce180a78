"""The difference of two arms in words: an arm and its golden file, a baked arm or another description."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.loading.load import load_arm
from ..description.inertial import bodies
from ..support.errors import ComparisonError, InputError
from ..support.files import as_path
from .changes import SAME_TOL, limit_changes, mass_changes, motor_changes, name_changes
from .crosscheck import by_exponentials
from .geometry_changes import geometry_changes
from .golden_file import golden_content, read_golden

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
        Shapes, meshes, named poses and the SRDF are not compared. Differences below 1 µm, 1e-6 rad or 1e-5 of a mass
        count as none, because an export rounds that much.

    Raises:
        DescriptionError: `against` cannot be read, or is no golden file, no baked arm and no description.
    """
    return _compare(require_arm(arm), against_content(against))


def against_content(against: Arm | str | os.PathLike[str]) -> dict[str, Any]:
    """What an arm is compared with, as a golden file has it."""
    if isinstance(against, Arm):
        return golden_content(against)
    if not isinstance(against, (str, os.PathLike)):
        raise InputError(f"against must be an Arm, a file or a name that load_arm takes; got {type(against).__name__}")
    path = as_path(str(os.fspath(against)))
    golden = read_golden(path) if path.suffix == ".json" else None
    return golden_content(load_arm(against)) if golden is None else golden


def _compare(arm: Arm, golden: dict[str, Any]) -> Difference:
    changes = [
        f"{role} was {golden[role]!r}, is {getattr(arm, role)!r}"
        for role in ("base", "tip")
        if golden[role] != getattr(arm, role)
    ]
    changes += _joint_changes(arm, golden)
    changes += motor_changes(golden["actuators"], arm.actuators)
    notes: tuple[str, ...] = ()
    now = {} if arm.description is None else bodies(arm.description)
    if golden["bodies"] is None and now:
        notes = (NO_MASSES,)
    elif golden["bodies"] is not None and arm.description is not None:
        changes += mass_changes(golden["bodies"], now)
    then = [joint["name"] for joint in golden["joints"]]
    if then != list(arm.joint_names) or golden["screws"].shape != arm.screws.shape:
        return Difference(arm.name, tuple(changes or ["the joints that follow others are different ones"]), notes=notes)
    moved = geometry_changes(arm, golden["screws"], golden["home"])
    if max(np.abs(golden[k] - v).max() for k, v in zip("Ab", arm.coupling, strict=True)) > SAME_TOL:
        moved.append("the coupling of mimic or locked joints is different")
    theta = golden["theta"]
    g, spatial, body = by_exponentials(arm, theta)
    pose_error = float(np.abs(g - golden["fk"]).max())
    jacobian_error = max(
        float(np.abs(spatial - golden["spatial_jacobian"]).max()),
        float(np.abs(body - golden["body_jacobian"]).max()),
    )
    if max(pose_error, jacobian_error) > 10 * SAME_TOL and not moved:
        moved.append(
            f"poses differ by up to {pose_error:.2g} and Jacobians by {jacobian_error:.2g} "
            f"over {len(theta)} configurations"
        )
    return Difference(arm.name, (*changes, *moved), pose_error, jacobian_error, notes)


def _joint_changes(arm: Arm, golden: dict[str, Any]) -> list[str]:
    then, now = [joint["name"] for joint in golden["joints"]], list(arm.joint_names)
    changes = name_changes("joint", then, now)
    for i, joint in enumerate(golden["joints"]):
        name = joint["name"]
        if name in now:
            j = now.index(name)
            if joint["type"] != arm.joint_types[j]:
                changes.append(f"joint {name} was {joint['type']}, is {arm.joint_types[j]}")
            changes += limit_changes(name, arm.units[j], golden["limits"], i, arm.limits, j)
    return changes
