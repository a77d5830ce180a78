"""An arm as a URDF."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET

import numpy as np

from ..arm.arm import Arm, require_arm
from ..arm.loading.arm_builder import builder_of
from ..checking.doctor.repair import COPY, repaired
from ..description.bounds import LIMIT_NAMES, WIDE
from ..description.capsules import without_capsules
from ..description.geometry import read_origin
from ..description.mesh_paths import resolve_uri
from ..description.packages import package_index
from ..description.source_text import SourceText
from ..description.tree import Joint
from ..description.writing import add_joint, number_text
from ..limits.joint_limits import slides
from ..support.checks import Array
from ..support.errors import InputError
from ..support.files import WRITTEN_XML, as_path, writable
from ..theory.rotations import to_rpy
from ..theory.screws import exp

SUFFIX = ".urdf"


def to_urdf(arm: Arm, folder: str | os.PathLike[str] = ".") -> str:
    """The text of a URDF which loads back as the same arm: `load_arm(FILE, base=arm.base, tip=arm.tip)`.

    Of an arm with a description it is the repaired copy of it, with links, shapes and masses. Locked joints are fixed,
    the limits are the arm's, and the tool is a link. An arm from screws, or a baked one, gives joints and links alone.
    A helical joint becomes a turn and a slide that follows it, and a capsule a cylinder with two spheres. Named poses
    and motors are not in it.

    Args:
        arm: The arm.
        folder: The folder of the file. Relative paths of meshes begin there.

    Raises:
        InputError: There is no such folder. A joint turns or slides by another rate than its coordinate, or follows
            several.
    """
    text = _text(require_arm(arm), folder).rstrip().removesuffix(WRITTEN_XML)
    return f"{text.rstrip()}\n{WRITTEN_XML}\n"


def lost_meshes(text: str, folder: str | os.PathLike[str]) -> list[str]:
    """The mesh URIs of a URDF text for which `load_arm` finds no file from the folder."""
    packages = package_index(as_path(folder) / COPY)
    uris = dict.fromkeys(mesh.get("filename", "") for mesh in ET.fromstring(text).iter("mesh"))
    return [uri for uri in uris if resolve_uri(uri, packages) is None]


def _text(arm: Arm, folder: str | os.PathLike[str]) -> str:
    description = arm.description
    if description is None:
        return builder_of(arm).urdf()
    source = SourceText(repaired(description, writable(as_path(folder) / COPY, over_description=True).parent).text)
    written = {joint.get("name", ""): joint for joint in source.robot.findall("joint")}
    locked = {name: affine.offset for name, affine in arm.couplings.items() if affine.master is None}
    if halves := locked.keys() - written.keys():
        name = min(halves)
        raise InputError(f"{arm.name}: URDF has no half of a planar joint, and {name!r} is locked; load it unlocked")
    for name, joint in written.items():
        read = description.joints.get(name)
        if name in locked and read is not None:
            _fix(source, joint, exp(read.twist, locked[name]))
        elif read is not None and read.scalar:
            limits = [float(getattr(read, field)) for field in LIMIT_NAMES]
            if name in arm.joint_names:
                i = arm.joint_names.index(name)
                limits = [float(getattr(arm.limits, field)[i]) for field in LIMIT_NAMES]
            _limit(source, joint, limits, read)
    if arm.tip not in description.links:
        mount = ET.Element("robot")
        add_joint(mount, f"{arm.tip}_mount", "fixed", (arm.tip_link, arm.tip), arm.tool)
        source.insert(source.robot, "".join(ET.tostring(part, encoding="unicode") for part in mount))
    return without_capsules(source.edited())


def _fix(source: SourceText, joint: ET.Element, moved: Array) -> None:
    """Make a joint fixed where its motion (4, 4) has brought it."""
    origin, g = joint.find("origin"), read_origin(joint) @ moved
    placed = {"xyz": number_text(g[:3, 3]), "rpy": number_text(to_rpy(g[:3, :3]))}
    source.set(joint, type="fixed")
    if origin is None:
        source.insert(joint, ET.tostring(ET.Element("origin", placed), encoding="unicode"))
    else:
        source.set(origin, **placed, quat_xyzw=None)


def _limit(source: SourceText, joint: ET.Element, limits: list[float], read: Joint) -> None:
    """Write the numbers of `LIMIT_NAMES`, if the file has others. `WIDE` stands for none, 0 would be a standstill."""
    finite, limit = bool(np.isfinite(limits[:2]).any()), joint.find("limit")
    same = limits == [getattr(read, field) for field in LIMIT_NAMES]
    if same and (limit is None or np.isfinite(limits[2:]).all()):
        return
    given = {field: repr(float(np.clip(x, -WIDE, WIDE))) for field, x in zip(LIMIT_NAMES, limits, strict=True)}
    if not slides(read.type):
        source.set(joint, type="revolute" if finite else "continuous")
    if limit is None:
        source.insert(joint, ET.tostring(ET.Element("limit", given), encoding="unicode"))
    else:
        source.set(limit, **given)
