"""An arm as a URDF."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.loading.arm_builder import builder_of
from ..checking.doctor.repair import COPY, repaired
from ..description.bounds import LIMIT_NAMES, NO_LIMIT
from ..description.geometry import read_origin
from ..description.packages import package_index, resolve_uri
from ..description.source_text import SourceText
from ..description.tree import Description
from ..description.writing import add_joint, add_origin, replace_capsules
from ..limits.joint_limits import slides
from ..support.errors import InputError
from ..support.files import WRITTEN_XML, as_path, writable
from ..theory.screws import exp

SUFFIX = ".urdf"


def to_urdf(arm: Arm, folder: str | os.PathLike[str] = ".") -> str:
    """The text of a URDF which loads back as the same arm: `load_arm(FILE, base=arm.base, tip=arm.tip)`.

    Of an arm with a description it is the repaired copy of it, with links, shapes and masses. Locked joints are fixed,
    the limits are the arm's, and the tool is a link. An arm from screws, or a baked one, gives joints and links alone.
    A helical joint becomes a turn and a slide that follows it, and a capsule a cylinder with two spheres. Motors
    and named configurations are not in it.

    Args:
        arm: The arm.
        folder: The folder of the file. Relative paths of meshes begin there.

    Raises:
        InputError: There is no such folder. A joint turns or slides by another rate than its coordinate, or follows
            several.
    """
    description = require_arm(arm).description
    if description is None:
        robot = ET.fromstring(builder_of(arm).urdf())
    else:
        folder = writable(as_path(folder) / COPY, over_description=True).parent
        robot = SourceText(repaired(description, folder).text).robot  # which takes prefixes as they are
        _write_joints(robot, arm, description)
        if arm.tip not in description.links:
            add_joint(robot, f"{arm.tip}_mount", "fixed", (arm.tip_link, arm.tip), arm.tool)
        replace_capsules(robot)
    ET.indent(robot)
    return f"{ET.tostring(robot, 'unicode')}\n{WRITTEN_XML}\n"


def lost_meshes(text: str, folder: str | os.PathLike[str]) -> list[str]:
    """The mesh URIs of a URDF text for which `load_arm` finds no file from the folder."""
    packages = package_index(as_path(folder) / COPY)
    uris = dict.fromkeys(mesh.get("filename", "") for mesh in SourceText(text).robot.iter("mesh"))
    return [uri for uri in uris if resolve_uri(uri, packages) is None]


def _write_joints(robot: ET.Element, arm: Arm, description: Description) -> None:
    """Fix the locked joints at their values, and write the arm's limits.

    `NO_LIMIT` replaces infinity, because 0 would be a standstill. A joint of the URDF that has the same limits stays.
    """
    written = {joint.get("name", ""): joint for joint in robot.findall("joint")}
    # A joint without a master never moves: its value is the offset.
    locked = {name: affine.offset for name, affine in arm.couplings.items() if affine.master is None}
    if halves := locked.keys() - written.keys():
        name = min(halves)
        raise InputError(f"{arm.name}: URDF cannot lock one coordinate of a planar joint; load {name!r} unlocked")
    for name, joint in written.items():
        read = description.joints.get(name)
        if name in locked and read is not None:
            g = read_origin(joint) @ exp(read.twist, locked[name])
            joint.set("type", "fixed")
            for origin in joint.findall("origin"):
                joint.remove(origin)
            add_origin(joint, g)
        elif read is not None and read.scalar:
            own = limits = [float(getattr(read, field)) for field in LIMIT_NAMES]
            if name in arm.joint_names:
                i = arm.joint_names.index(name)
                limits = [float(getattr(arm.limits, field)[i]) for field in LIMIT_NAMES]
            limit = joint.find("limit")
            if limits == own and (limit is None or np.isfinite(limits[2:]).all()):
                continue
            if not slides(read.type):
                joint.set("type", "revolute" if np.isfinite(limits[:2]).any() else "continuous")
            limit = ET.SubElement(joint, "limit") if limit is None else limit
            limit.attrib.update(
                zip(LIMIT_NAMES, (repr(float(np.clip(x, -NO_LIMIT, NO_LIMIT))) for x in limits), strict=True)
            )
