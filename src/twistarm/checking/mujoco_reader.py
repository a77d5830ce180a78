"""Poses of an MJCF's bodies and sites by MuJoCo's own kinematics."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..description.mjcf.translation import TURNS
from ..support.checks import Array
from ..support.errors import InputError, missing_extra
from ..theory.rotations import exp

KEPT = {
    "mujoco": ("compiler", "default", "worldbody", "equality"),
    "worldbody": ("body", "frame", "site"),
    "body": ("body", "frame", "site", "joint", "freejoint"),
    "frame": ("body", "frame", "site", "joint"),
    "default": ("default", "joint", "site", "equality"),
    "equality": ("joint",),
}
"""The elements that kinematics needs. MuJoCo refuses missing meshes and what refers to them."""


def mujoco_poses(text: str, values: Mapping[str, Array]) -> dict[str, Array]:
    """The pose (samples, 4, 4) of each named body and site in the world, for joint values (samples,).

    MuJoCo's kinematics ignores `equality`. Followers are set by the numbers that MuJoCo has compiled. Raises
    MissingExtraError without MuJoCo, and InputError with the reason if it refuses the text.
    """
    try:
        import mujoco
    except ImportError as error:
        raise missing_extra("the comparison with MuJoCo", "mujoco", "mjcf") from error
    try:
        model = mujoco.MjModel.from_xml_string(_skeleton(text))
    except ValueError as error:
        raise InputError(f"MuJoCo does not read it: {' '.join(str(error).split())}") from error
    data, samples = mujoco.MjData(model), len(next(iter(values.values())))
    kinds = ((model.nbody, model.body, data.xpos, data.xmat), (model.nsite, model.site, data.site_xpos, data.site_xmat))
    named = [(name, p[i], R[i]) for count, get, p, R in kinds for i in range(count) if (name := get(i).name)]
    poses = {name: np.tile(np.eye(4), (samples, 1, 1)) for name, *_ in named}
    for k in range(samples):
        data.qpos[:] = _qpos(mujoco, model, {name: float(x[k]) for name, x in values.items()})
        mujoco.mj_kinematics(model, data)
        for name, p, R in named:
            poses[name][k, :3] = np.column_stack([R.reshape(3, 3), p])
    return poses


def _qpos(mujoco: Any, model: Any, values: Mapping[str, float]) -> Array:
    """MuJoCo's coordinates: a ball is a quaternion, and free bodies stand where the file puts them."""
    qpos: Array = model.qpos0.copy()
    for i, at in enumerate(model.jnt_qposadr):
        name = model.joint(i).name
        if name in values:
            qpos[at] = values[name]
        elif name + TURNS[0] in values:
            z, y, x = (exp(axis, values[name + end]) for axis, end in zip(np.eye(3)[::-1], TURNS, strict=True))
            mujoco.mju_mat2Quat(qpos[at : at + 4], (z @ y @ x).ravel())
    kept = [i for i in range(model.neq) if model.eq_active0[i]]
    for _ in kept:  # a follower may lead another
        before = qpos.copy()
        for i in kept:
            one, other = model.jnt_qposadr[model.eq_obj1id[i]], model.eq_obj2id[i]
            way = 0.0 if other < 0 else qpos[model.jnt_qposadr[other]] - model.qpos0[model.jnt_qposadr[other]]
            qpos[one] = model.qpos0[one] + model.eq_data[i, :2] @ (1.0, way)
        if np.array_equal(qpos, before):
            break
    return qpos


def _skeleton(text: str) -> str:
    """The MJCF without shapes and masses. MuJoCo wants a mass in each body that moves."""
    root = ET.fromstring(text)
    for element in list(root.iter()):
        element[:] = [part for part in element if part.tag in KEPT.get(element.tag, ())]
        element.attrib.pop("material", None)
        if element.tag == "body":
            ET.SubElement(element, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        elif element.tag == "compiler":
            element.set("inertiafromgeom", "false")
    return ET.tostring(root, encoding="unicode")
