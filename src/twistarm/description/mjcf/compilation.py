"""An MJCF compiled by MuJoCo, with the meshes that count and without those that are missing."""

from __future__ import annotations

import re
import warnings
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...support.checks import Array
from ...support.errors import DescriptionError, missing_extra
from ...support.interrupts import ending_at_once
from ...theory.rotations import from_quaternion_wxyz
from .files import Mjcf

TETRAHEDRON = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
FACES = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
"""The mesh in place of one that MuJoCo need not weigh, or cannot read."""


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
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = from_quaternion_wxyz(quaternion), position
    return g


def _refused(mjcf: Mjcf, error: ValueError) -> DescriptionError:
    """MuJoCo's own reason, at the element whose line it names."""
    text = " ".join(str(error).split()).removeprefix("XML Error: ").removeprefix("Error: ")
    found = re.search(r",? line (\d+)", text)
    if found is None or mjcf.models:  # the line may be that of an attached model
        return mjcf.error(mjcf.root, f"MuJoCo refuses it: {text}")
    return mjcf.error(mjcf.at_line(int(found[1])), f"MuJoCo refuses it: {text.replace(found[0], '')}")


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
