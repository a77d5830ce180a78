"""The corrected description: origins of the moved joints, comments and formatting kept, read again and compared."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..description.chain import walk_chain
from ..description.document import Reading
from ..description.packages import package_index
from ..description.source_text import SourceText
from ..description.urdf import build_description
from ..support.checks import Array, require
from ..support.errors import InputError
from ..theory.rotations import to_rpy
from ..theory.screws import exp, inverse_of
from .calibration import Calibration

SAME = 1e-9
"""[m, rad] that the arm of the copy may differ from the corrected one: 16 digits of angles leave less."""


def corrected_urdf(calibration: Calibration, *, zeros: bool = True, here: bool = False) -> str:
    """The text of the arm's URDF with corrected joint origins; that of a xacro file is expanded.

    With `zeros` the joints' zeros are in the origins too, so commands stay as they are; without, they belong into
    arm.toml (`Calibration.motor_offsets`). Base and tool of the measurement are not part of it. The copy is read
    again, and its screws and home must be the corrected ones. With `here` a correction will do that is confirmed only
    where the log was taken (`Calibration.confirmed_here`).

    Raises:
        InputError: The correction is not confirmed, the arm has no description, or joints moved that have no origin
            of their own.
    """
    arm = (
        require(calibration, Calibration, "calibration", "as calibrate makes it")
        .require(here=here)
        .problem.geometry.arm
    )
    if arm.description is None:
        raise InputError(f"{arm.name} has no description: load its URDF, not a baked file or screws")
    p = calibration.unknowns[: calibration.problem.P].copy()
    if not zeros:
        p[12 : 12 + arm.n] = 0.0
    source = SourceText(arm.description.text)
    elements = {joint.get("name"): joint for joint in source.robot.findall("joint")}
    for name, origin in _origins(calibration, p).items():
        if arm.description.joints[name].part_of or name not in elements:
            raise InputError(f"joint {name!r} shares its origin with others: correct it by hand")
        xyz, rpy = (" ".join(map(repr, part.tolist())) for part in (origin[:3, 3], to_rpy(origin[:3, :3])))
        written = elements[name].find("origin")
        if written is None:
            source.insert(elements[name], f'<origin xyz="{xyz}" rpy="{rpy}"/>')
        else:
            source.set(written, xyz=xyz, rpy=rpy, quat_xyzw=None)
    text = source.edited()
    _require_same(calibration, p, text)
    return text


def _origins(calibration: Calibration, p: Array) -> dict[str, Array]:
    """The new origin (4, 4) of each joint that moved: O G⁻¹ D G, where G is its frame at rest and D its motion."""
    arm = calibration.problem.geometry.arm
    assert arm.description is not None
    g, origins = np.eye(4), {}
    values = dict(zip(arm.moving_names, arm.coupling.b, strict=True))
    moved = dict(zip(arm.moving_names, calibration.problem.geometry.displacements(p), strict=True))
    for joint in arm.description.chain(arm.base, arm.tip_link):
        g = g @ joint.origin
        if joint.moving:
            if np.abs(moved[joint.name] - np.eye(4)).max() > 0.0:
                origins[joint.name] = joint.origin @ inverse_of(g) @ moved[joint.name] @ g
            g = g @ exp(joint.twist, values[joint.name])
    return origins


def _require_same(calibration: Calibration, p: Array, text: str) -> None:
    arm = calibration.problem.geometry.arm
    assert arm.description is not None
    path = arm.description.path or Path("corrected.urdf")
    copy = build_description(text, Reading(path, package_index(path)))
    masterless = {name: affine.offset for name, affine in arm.couplings.items() if affine.master is None}
    locked = {name: value for name, value in masterless.items() if copy.joints[name].scalar}
    chain = walk_chain(copy, arm.base, arm.tip_link, arm.tool, locked)
    screws, home = calibration.problem.geometry.corrected(p)
    off = float(max(np.abs(chain.screws - screws).max(), np.abs(chain.home - home).max()))
    if off > SAME:
        raise InputError(
            f"the corrected copy would be another arm, {off:.2g} off; please report it with the description"
        )
