"""An MJCF compiled by MuJoCo, which gets texts and bytes of its files and never a path; meshes only if they count."""

from __future__ import annotations

import os
import re
import warnings
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...support.checks import Array, pose_of
from ...support.errors import DescriptionError, missing_extra
from ...support.files import is_file, read_bounded
from ...support.interrupts import ending_at_once
from ...theory.rotations import from_quaternion_wxyz
from ..document import MAX_NESTING, Reading, Refused, parse_xml, read_inside, real_inside
from ..findings import refusal
from ..packages import resolve_uri

# What kinematics, masses and shapes without pictures do not need. A `<size>` can ask for any amount of memory.
UNUSED = ("size", "statistic", "visual", "sensor", "custom", "extension", "texture", "hfield", "skin", "layer", "pair")

NOT_READ = ("composite", "flexcomp", "plugin", "deformable", "flex", "flexvert", "flexstrain")

# Settings of `<compiler>` that have no effect any more, or lose bodies and shapes.
FOLDERS = ("meshdir", "texturedir", "assetdir", "strippath", "fusestatic", "discardvisual")
MOST_BYTES = 200_000_000  # A mesh that MuJoCo weighs.


@dataclass
class Mjcf:
    """One MJCF: its root with includes in place, and the other files that MuJoCo may ask for.

    `models` are the texts of attached models, and `meshes` the paths of meshes as written, both by the names that
    MuJoCo gets. `notes` are parts left out, by the code of their finding.
    """

    root: ET.Element
    readings: list[Reading]
    models: dict[str, bytes] = field(default_factory=dict)
    meshes: dict[str, str] = field(default_factory=dict)
    notes: dict[str, dict[str, None]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._prepare(self.root, self.readings[0], ())
        for element in self.root.iter():
            element.text = element.tail = None
        ET.indent(self.root, "")  # one tag in each line
        self.text = ET.tostring(self.root, "unicode")

    def note(self, code: str, part: str) -> None:
        """Note a part that is left out, once."""
        self.notes.setdefault(code, {})[part] = None

    def error(self, element: ET.Element, what: str, remedy: str = "correct it there") -> DescriptionError:
        """The error for an unusable element, with its file and line."""
        reading = next((part for part in self.readings if element in part.lines), self.readings[0])
        return refusal("mjcf-unusable", reading.place(element), what, remedy)

    def mesh_bytes(self, name: str) -> bytes | None:
        """The content of a mesh's file. None if there is none inside the folders, or none small enough."""
        path = resolve_uri(self.meshes[name], self.readings[0].packages)
        try:
            return None if path is None else read_bounded(real_inside(path, self.readings[0].packages), MOST_BYTES)
        except (OSError, Refused):
            return None

    def _prepare(self, root: ET.Element, reading: Reading, around: tuple[Path, ...]) -> None:
        """Make one model ready for MuJoCo, inside the files `around` that attach it."""
        self._place_includes(root, reading)
        compiler: dict[str, str] = {}
        for element in root.findall("compiler"):
            compiler |= element.attrib
            for word in FOLDERS:
                element.attrib.pop(word, None)
        for parent in list(root.iter()):
            parent[:] = [part for part in parent if self._is_used(part, parent)]
            parent.attrib.pop("texture", None)
            parent.attrib.pop("hfield", None)
        if "mjcf-part-not-read" in self.notes and root.find("keyframe") is not None:
            self.note("mjcf-part-not-read", "the keyframes")  # MuJoCo refuses the file for a key of another length
            root[:] = [section for section in root if section.tag != "keyframe"]
        for asset in root.findall("asset"):
            for element in asset.findall("mesh"):
                self._rename_mesh(element, compiler, reading)
            for element in asset.findall("model"):
                self._attach(element, reading, (*around, reading.path))

    def _is_used(self, element: ET.Element, parent: ET.Element) -> bool:
        """Whether an element stays. What the arm may miss is noted."""
        if element.tag in UNUSED or parent.tag == "default":
            return element.tag not in UNUSED
        if element.tag in NOT_READ or element.get("type") == "sdf" or element.find("plugin") is not None:
            name = element.get("name") or element.get("prefix", "")
            self.note("mjcf-part-not-read", f"<{element.tag}> {name}".rstrip())
            return False
        if element.get("hfield") or element.get("type") == "hfield":
            self.note("mjcf-scenery-left-out", "a shape of type hfield")
            return False
        return True

    def _place_includes(self, parent: ET.Element, reading: Reading, deep: int = 1) -> None:
        if deep > MAX_NESTING:
            raise self.error(parent, f"elements are nested more than {MAX_NESTING} deep")
        waiting, parent[:] = list(reversed(parent)), []
        while waiting:
            element = waiting.pop()
            if element.tag == "include":
                root, _ = self._opened(element, reading, once=True)
                waiting += reversed(root)
            else:
                parent.append(element)
                self._place_includes(element, reading, deep + 1)

    def _opened(self, element: ET.Element, main: Reading, *, once: bool) -> tuple[ET.Element, Reading]:
        """The root of the file that an element names. It is beside the main file or beside the element's own."""
        name = element.get("file", "").strip()[:200]
        own = next((part.path for part in self.readings if element in part.lines), main.path)
        file = main.path.parent / name
        try:
            path, text = read_inside(str(file if is_file(file) else own.parent / name), main.packages)
        except Refused as refused:
            raise refusal(refused.code, main.place(element), refused.what, refused.remedy) from refused
        except OSError as error:
            why = f"its file {name!r} cannot be read: {error.strerror}"
            raise self.error(element, why, "correct the path") from error
        if once and any(path == part.path for part in self.readings):
            raise self.error(element, f"its file {name!r} is included already", "include each file once")
        self.readings.append(Reading(path, main.packages))
        return parse_xml(text, self.readings[-1]), self.readings[-1]

    def _rename_mesh(self, mesh: ET.Element, compiler: dict[str, str], reading: Reading) -> None:
        """Give a mesh the name that it has by default, and its file a name without a folder."""
        file = mesh.attrib.pop("file", "")
        if not file:
            return
        last = re.split(r"[/\\]", file)[-1]
        mesh.set("name", mesh.get("name") or last.rpartition(".")[0] or last)
        file = last if compiler.get("strippath") == "true" else file
        own = os.path.relpath(reading.path.parent, self.readings[0].path.parent)
        path = os.path.join("" if own == "." else own, compiler.get("meshdir") or compiler.get("assetdir", ""), file)
        name = f"{len(self.meshes)}{Path(last).suffix}"
        mesh.set("file", name)
        self.meshes[name] = path

    def _attach(self, element: ET.Element, reading: Reading, around: tuple[Path, ...]) -> None:
        """Prepare the model of an `<asset>` and put its text among the models."""
        root, own = self._opened(element, reading, once=False)
        if own.path in around:
            raise self.error(element, "the model attaches itself", "attach another model")
        self._prepare(root, own, around)
        name = f"{len(self.models)}.xml"
        self.models[name] = ET.tostring(root)
        element.set("file", name)


TETRAHEDRON = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
# The mesh in place of one that MuJoCo need not weigh, or cannot read.
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)


class Mesh(NamedTuple):
    """A mesh of a compiled model: its path as written, its scale (3,), and its file's frame (4, 4) in the geom's."""

    path: str
    scale: Array
    frame: Array


class Compiled(NamedTuple):
    """A compiled model. `meshes` by their index; the mass of the bodies `unweighed` is not known."""

    mujoco: Any
    model: Any
    meshes: dict[int, Mesh]
    unweighed: frozenset[int]


def compiled(mjcf: Mjcf) -> Compiled:
    """The model that MuJoCo makes of an MJCF. A file that MuJoCo refuses only for its meshes loads without them.

    Raises MissingExtraError without MuJoCo, and DescriptionError with its reason if it refuses the file.
    """
    try:
        import mujoco
    except ImportError as error:
        raise missing_extra("an MJCF", "mujoco", "mjcf") from error
    with ending_at_once(), _silent(mujoco):
        try:
            return _compiled(mujoco, mjcf, with_meshes=True)
        except ValueError as error:
            reason = error
        try:
            found = _compiled(mujoco, mjcf, with_meshes=False)
        except ValueError as error:
            raise _refused(mjcf, error) from error
    mjcf.note("mjcf-part-not-read", f"the meshes ({' '.join(str(reason).split())})")
    return found


def _compiled(mujoco: Any, mjcf: Mjcf, *, with_meshes: bool) -> Compiled:
    spec = mujoco.MjSpec.from_string(mjcf.text, include=mjcf.models)
    spec.compiler.fusestatic = spec.compiler.discardvisual = 0
    shapes, assets, paths, unweighed = defaultdict(list), {}, {}, []
    for geom in spec.geoms:
        shapes[geom.meshname].append(geom)
    for mesh in spec.meshes:
        if not mesh.file:
            continue
        paths[mesh.name] = mjcf.meshes[mesh.file]
        counting = [geom for geom in shapes[mesh.name] if _counts(mujoco, spec, geom)]
        data = mjcf.mesh_bytes(mesh.file) if counting and with_meshes else None
        if data is not None:
            assets[mesh.file] = data
            continue
        mesh.file, mesh.uservert, mesh.userface = "", TETRAHEDRON, FACES
        for geom in counting:
            geom.type, geom.mass = mujoco.mjtGeom.mjGEOM_MESH, 1.0
            unweighed.append(geom.parent)
    if unweighed and spec.compiler.settotalmass > 0:
        mjcf.note("mjcf-part-not-read", "settotalmass of <compiler>")
        spec.compiler.settotalmass = -1
    spec.assets = assets
    model, meshes = spec.compile(), {}
    for mesh in spec.meshes:
        if mesh.name in paths:
            i = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_MESH, mesh.name)
            written = pose(mesh.refpos * mesh.scale, mesh.refquat)  # what the file's vertices are seen from
            frame = np.linalg.inv(written @ pose(model.mesh_pos[i], model.mesh_quat[i]))
            meshes[i] = Mesh(paths[mesh.name], np.array(mesh.scale), np.asarray(frame, dtype=float))
    return Compiled(mujoco, model, meshes, frozenset(body.id for body in unweighed))


def _counts(mujoco: Any, spec: Any, geom: Any) -> bool:
    """Whether the vertices of its mesh change what is read: the size of a fitted shape, or the mass of a body."""
    if geom.type != mujoco.mjtGeom.mjGEOM_MESH:
        return True
    rule, (low, high) = spec.compiler.inertiafromgeom, spec.compiler.inertiagrouprange
    if geom.parent.name == "world" or rule == 0 or (rule == 2 and geom.parent.explicitinertial):
        return False
    return bool(low <= geom.group <= high and geom.mass != 0 and (geom.density != 0 or geom.mass > 0))


def pose(position: ArrayLike, quaternion: ArrayLike) -> Array:
    """The pose (4, 4) of MuJoCo's position and quaternion."""
    return pose_of(from_quaternion_wxyz(quaternion), position)


def _refused(mjcf: Mjcf, error: ValueError) -> DescriptionError:
    """MuJoCo's own reason, at the element of the line that it names."""
    text = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
    found = re.search(r",? line (\d+)", text)
    if found is None or mjcf.models:  # the line may be that of an attached model
        return mjcf.error(mjcf.root, f"MuJoCo refuses it: {text}")
    begun = [tag for tag in mjcf.text.splitlines()[: int(found[1])] if not tag.startswith("</")]
    element = list(mjcf.root.iter())[len(begun) - 1]
    return mjcf.error(element, f"MuJoCo refuses it: {text.replace(found[0], '')}")


@contextmanager
def _silent(mujoco: Any) -> Iterator[None]:
    """Keep warnings back, which MuJoCo else prints and writes into a file in the working folder."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        mujoco.set_mju_user_warning(before)
