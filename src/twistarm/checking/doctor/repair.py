"""A repaired copy of a description: only changes that leave the arm unchanged, each listed and proven.

Comments and formatting stay. The owner decides on swapped limits, limits in degrees and names.
"""

from __future__ import annotations

import math
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from urllib.parse import unquote

import numpy as np

from ...arm.pinocchio_model import model_of, why_no_pinocchio
from ...description.document import Reading, floats
from ...description.geometry import inertial_problem
from ...description.packages import package_index, package_name
from ...description.source_text import SourceText
from ...description.tree import Description
from ...description.urdf import build_description
from ...support.errors import InputError
from ...support.files import is_file, writable

UNIT = 1e-9  # An axis whose length is off by more is written anew.
SAMPLES = 20  # Random joint values at which every link's pose is compared.
SAME = 1e-12  # [m, rad], for each metre that the robot is large: the numbers are written in full.
# Of a joint.
SAME_FIELDS = ("parent", "child", "lower", "upper", "velocity", "effort", "acceleration", "jerk", "mimic")

COPY = "copy.urdf"

_FIND = re.compile(r"^\$\(find\s+([^)\s]+)\)/?")
_SCHEME = re.compile(r"^\w+://")
_SLASHES = re.compile(r"(?<=[^:/\\])[/\\]+")


@dataclass(frozen=True)
class Repair:
    """The text of the copy, its changes in words, and the message of Pinocchio's parser (empty is good)."""

    text: str
    changes: tuple[str, ...]
    complaint: str


def repair(description: Description, output: str | os.PathLike[str]) -> Repair:
    """The repaired text of a description, for the file `output`. A xacro source is expanded.

    The copy is read again and must be the same robot. Names, types and limits must agree, and poses of all links at
    random joint values. Raises InputError otherwise, and for an output that is no .urdf file or is the source.
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
        change
        for path, mend in REPAIRS.items()
        for element in source.robot.findall(path)
        for change in mend(source, element, description, folder)
    ]
    text = source.edited()
    copy = build_description(text, Reading(folder / COPY, package_index(folder / COPY)))
    problem = difference(description, copy)
    if problem:
        raise InputError(f"the repaired copy would be another robot: {problem}; please report it with the description")
    return Repair(text, tuple(dict.fromkeys(changes)), why_no_pinocchio() or model_of(text)[1])


def _mend_axis(source: SourceText, joint: ET.Element, *_: object) -> Iterator[str]:
    """A unit vector. None for a joint that does not move."""
    axis, kind, name = joint.find("axis"), joint.get("type", ""), f"joint {joint.get('name', '')!r}"
    if axis is None:
        return
    written, moving = axis.get("xyz", "1 0 0"), kind not in ("fixed", "floating")
    try:
        vector = np.array(floats(written, 3))
    except ValueError:
        vector = np.zeros(3)
    norm = float(np.linalg.norm(vector))
    if not moving and norm < UNIT:
        source.remove(axis)
        yield f"{name}: the axis {written!r} of a {kind} joint removed"
    elif moving and abs(norm - 1.0) > UNIT:
        source.set(axis, xyz=" ".join(repr(float(x)) for x in vector / norm))
        yield f"{name}: axis {written} normalised"


def _mend_limit(source: SourceText, joint: ET.Element, description: Description, _: Path) -> Iterator[str]:
    """A revolute joint without bounds becomes continuous. Rates become numbers that every parser reads."""
    if joint.get("type") not in ("revolute", "continuous", "prismatic"):
        return
    limit, read = joint.find("limit"), description.joints[joint.get("name", "")]
    changes: dict[str, str | None] = {}
    if read.type == "revolute" and math.isinf(read.lower) and math.isinf(read.upper) and read.lower < read.upper:
        source.set(joint, type="continuous")
        changes |= {bound: None for bound in ("lower", "upper") if limit is not None and bound in limit.attrib}
        yield f"joint {read.name!r}: revolute without bounds made continuous, as twistarm reads it"
    if limit is None:
        return
    for rate in ("velocity", "effort"):
        text = limit.get(rate)
        if text is None or not 0 <= float(text) < math.inf:
            changes[rate] = "0"
            yield f"joint {read.name!r}: {rate} {'absent' if text is None else text} made 0, which is read as not given"
    if changes:
        source.set(limit, **changes)


def _mend_inertial(source: SourceText, link: ET.Element, *_: object) -> Iterator[str]:
    """No inertia where it is unusable."""
    for inertial in link.findall("inertial"):
        if problem := inertial_problem(inertial):
            source.remove(inertial)
            yield f"link {link.get('name')!r}: its <inertial> {problem}; removed"


def _mend_mesh(source: SourceText, mesh: ET.Element, description: Description, folder: Path) -> Iterator[str]:
    """A path that is found from `folder`, and three scales."""
    changes: dict[str, str | None] = {}
    written = mesh.get("filename", "").strip()
    moved, scale = _moved_uri(_SLASHES.sub("/", written), description, folder), (mesh.get("scale") or "1 1 1").split()
    if moved != written:
        changes["filename"] = moved
        yield f"mesh path {written!r} made {moved!r}"
    if len(scale) == 1:
        changes["scale"] = " ".join(scale * 3)
        yield f"mesh scale {scale[0]!r} made {changes['scale']!r}"
    if changes:
        source.set(mesh, **changes)


REPAIRS: dict[str, Callable[[SourceText, ET.Element, Description, Path], Iterator[str]]] = {
    "joint": lambda *given: chain(_mend_axis(*given), _mend_limit(*given)),
    "link": _mend_inertial,
    ".//mesh": _mend_mesh,
}
"""Elements, and what mends them and says what it has changed."""


def _moved_uri(uri: str, description: Description, folder: Path) -> str:
    """The URI as a package's, or relative to the copy's folder for a path beside the original."""
    found = _FIND.match(uri)
    if found:
        return f"package://{found.group(1)}/{uri[found.end() :]}"
    if uri.startswith("file://") or os.path.isabs(uri):
        file = Path(unquote(uri.removeprefix("file://").removeprefix("localhost")))
        if not is_file(file):
            return file.name
        for package in file.parents:
            if name := package_name(package):
                return f"package://{name}/{file.relative_to(package).as_posix()}"
        return Path(os.path.relpath(file, folder)).as_posix()
    home = description.path.parent if description.path else folder
    if _SCHEME.match(uri) or home == folder or not is_file(home / uri):
        return uri
    return Path(os.path.relpath(home / uri, folder)).as_posix()


def difference(one: Description, other: Description) -> str:
    """The first difference in links, joints, limits, couplings or poses, in words. Empty if there is none.

    A turning joint without bounds is one kind, by any name.
    """
    for what in ("links", "joints"):
        if list(getattr(one, what)) != list(getattr(other, what)):
            return f"its {what} are others"
    for joint, copy in zip(one.joints.values(), other.joints.values(), strict=True):
        changed = [field for field in SAME_FIELDS if getattr(joint, field) != getattr(copy, field)]
        if joint.type.replace("continuous", "revolute") != copy.type.replace("continuous", "revolute"):
            changed.append("type")
        if changed:
            return f"joint {joint.name!r} has another {changed[0]}"
    rng = np.random.default_rng(0)
    values = {name: rng.uniform(-1.0, 1.0, SAMPLES) for name, joint in one.joints.items() if joint.scalar}
    ours, theirs = one.link_poses(values), other.link_poses(values)
    worst = max(float(np.abs(ours[link] - theirs[link]).max()) for link in ours)
    size = max(float(np.abs(g).max()) for g in ours.values())
    return "" if worst <= SAME * size else f"its links are {worst:.2g} off"
