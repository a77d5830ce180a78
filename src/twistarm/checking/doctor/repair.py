"""A repaired copy of a description: only changes that leave the arm unchanged, each listed and proven.

Comments and formatting stay. The owner decides on swapped limits, limits in degrees and names.
"""

from __future__ import annotations

import math
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from ...arm.pinocchio_model import model_of, why_no_pinocchio
from ...description.document import Reading, floats
from ...description.inertial import inertial_problem
from ...description.mesh_paths import plain
from ...description.packages import package_index, package_name
from ...description.source_text import SourceText
from ...description.tree import Description, Joint
from ...description.urdf import build_description
from ...support.errors import InputError
from ...support.files import is_file, writable

UNIT = 1e-9
"""An axis whose length is off by more is written anew."""

SAMPLES = 20
"""Random joint values at which every link's pose is compared."""

SAME = 1e-12
"""[m, rad], for each metre that the robot is large: the numbers are written in full."""

COPY = "copy.urdf"

_FIND = re.compile(r"^\$\(find\s+([^)\s]+)\)/?")
_SCHEME = re.compile(r"^\w+://")


@dataclass(frozen=True)
class Repair:
    """The text of the copy, its changes in words, and the message of Pinocchio's parser (empty is good)."""

    text: str
    changes: tuple[str, ...]
    complaint: str


def repair(description: Description, output: str | os.PathLike[str]) -> Repair:
    """The repaired text of a description, for the file `output`; a xacro source is expanded.

    The copy is read again and must be the same robot: names, types, limits, and every link's pose at random joint
    values. Raises InputError otherwise, and for an output that is no .urdf file or is the source.
    """
    target = writable(output, over_description=True)
    if target.suffix != ".urdf":
        raise InputError(f"the repaired copy is plain URDF: name it *.urdf; got {target.name!r}")
    if description.path is not None and target.exists() and os.path.samefile(target, description.path):
        raise InputError(f"{target} is the description itself, which stays unchanged: give another name")
    return repaired(description, target.parent)


def repaired(description: Description, folder: Path) -> Repair:
    """The repaired text for a file in `folder`, where relative paths of meshes begin."""
    source = SourceText(description.text)
    changes = [
        *(change for joint in source.robot.findall("joint") for change in _joint(source, joint, description)),
        *(change for link in source.robot.findall("link") for change in _inertials(source, link)),
        *(change for mesh in source.robot.iter("mesh") for change in _mesh(source, mesh, description, folder)),
    ]
    text = source.edited()
    copy = build_description(text, Reading(folder / COPY, package_index(folder / COPY)))
    problem = difference(description, copy)
    if problem:
        raise InputError(f"the repaired copy would be another robot: {problem}; please report it with the description")
    return Repair(text, tuple(dict.fromkeys(changes)), why_no_pinocchio() or model_of(text)[1])


def _joint(source: SourceText, joint: ET.Element, description: Description) -> Iterator[str]:
    kind, name = joint.get("type", ""), joint.get("name", "")
    axis = joint.find("axis")
    if axis is not None:
        yield from _axis(source, axis, f"joint {name!r}", kind)
    if kind in ("revolute", "continuous", "prismatic"):
        yield from _limit(source, joint, description.joints[name])


def _axis(source: SourceText, axis: ET.Element, joint: str, kind: str) -> Iterator[str]:
    written, moving = axis.get("xyz", "1 0 0"), kind not in ("fixed", "floating")
    try:
        vector = np.array(floats(written, 3))
    except ValueError:
        vector = np.zeros(3)
    norm = float(np.linalg.norm(vector))
    if not moving and norm < UNIT:
        source.remove(axis)
        yield f"{joint}: the axis {written!r} of a {kind} joint taken out"
    elif moving and abs(norm - 1.0) > UNIT:
        unit = " ".join(repr(float(x)) for x in vector / norm)
        source.set(axis, xyz=unit)
        yield f"{joint}: axis {written} normalised"


def _limit(source: SourceText, joint: ET.Element, read: Joint) -> Iterator[str]:
    """A revolute joint without bounds becomes continuous; rates become numbers that every parser reads."""
    limit, name = joint.find("limit"), f"joint {read.name!r}"
    changes: dict[str, str | None] = {}
    if read.type == "revolute" and math.isinf(read.lower) and math.isinf(read.upper) and read.lower < read.upper:
        source.set(joint, type="continuous")
        changes |= {bound: None for bound in ("lower", "upper") if limit is not None and bound in limit.attrib}
        yield f"{name}: revolute without bounds made continuous, as twistarm reads it"
    if limit is None:
        return
    for rate in ("velocity", "effort"):
        text = limit.get(rate)
        if text is None or not 0 <= float(text) < math.inf:
            changes[rate] = "0"
            yield f"{name}: {rate} {'absent' if text is None else text} made 0, which is read as not given"
    if changes:
        source.set(limit, **changes)


def _inertials(source: SourceText, link: ET.Element) -> Iterator[str]:
    for inertial in link.findall("inertial"):
        problem = inertial_problem(inertial)
        if problem:
            source.remove(inertial)
            yield f"link {link.get('name')!r}: its <inertial> {problem}; taken out"


def _mesh(source: SourceText, mesh: ET.Element, description: Description, folder: Path) -> Iterator[str]:
    changes: dict[str, str | None] = {}
    written = mesh.get("filename", "").strip()
    uri, scale = plain(written), (mesh.get("scale") or "1 1 1").split()
    moved = _moved_uri(uri, description, folder)
    if moved != written:
        changes["filename"] = moved
        yield f"mesh path {written!r} made {moved!r}"
    if len(scale) == 1:
        changes["scale"] = " ".join(scale * 3)
        yield f"mesh scale {scale[0]!r} made {changes['scale']!r}"
    if changes:
        source.set(mesh, **changes)


def _moved_uri(uri: str, description: Description, folder: Path) -> str:
    """The URI as a package's, or relative to the copy's folder for a path beside the original."""
    found = _FIND.match(uri)
    if found:
        return f"package://{found.group(1)}/{uri[found.end() :]}"
    home = description.path.parent if description.path else folder
    if uri.startswith("file://") or os.path.isabs(uri):
        return _without_root(Path(unquote(uri.removeprefix("file://").removeprefix("localhost"))), folder)
    if _SCHEME.match(uri) or home == folder or not is_file(home / uri):
        return uri
    return Path(os.path.relpath(home / uri, folder)).as_posix()


def _without_root(file: Path, folder: Path) -> str:
    """The URI of a mesh with an absolute path: in its package, or relative to `folder`; for a missing file its name."""
    if not is_file(file):
        return file.name
    for package in file.parents:
        if name := package_name(package):
            return f"package://{name}/{file.relative_to(package).as_posix()}"
    return Path(os.path.relpath(file, folder)).as_posix()


def difference(one: Description, other: Description) -> str:
    """The first difference in links, joints, limits, couplings or poses, in words; empty if there is none."""
    for what in ("links", "joints"):
        ours, theirs = getattr(one, what), getattr(other, what)
        if list(ours) != list(theirs):
            return f"its {what} are others"
    for joint in one.joints.values():
        changed = _joint_difference(joint, other.joints[joint.name])
        if changed:
            return f"joint {joint.name!r} has another {changed}"
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(-1.0, 1.0, SAMPLES) for name, joint in one.joints.items() if joint.scalar}
    ours, theirs = one.link_poses(values), other.link_poses(values)
    worst = max(float(np.abs(ours[link] - theirs[link]).max()) for link in ours)
    size = max(float(np.abs(g).max()) for g in ours.values())
    return "" if worst <= SAME * size else f"its links stand {worst:.2g} off"


def _joint_difference(one: Joint, other: Joint) -> str:
    """The field in which two joints differ; a turning joint without bounds is one kind, whatever it is called."""
    names = ("parent", "child", "lower", "upper", "velocity", "effort", "acceleration", "jerk", "mimic")
    for name in names:
        if getattr(one, name) != getattr(other, name):
            return name
    kinds = {joint.type.replace("continuous", "revolute") for joint in (one, other)}
    return "type" if len(kinds) > 1 else ""
