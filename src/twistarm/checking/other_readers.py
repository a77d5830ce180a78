"""Poses of links by other readers of the unmodified description, so our repairs cannot hide: Pinocchio, yourdfpy."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..arm.pinocchio_model import import_pinocchio, model_of
from ..description.source_text import SourceText
from ..description.tree import Description
from ..description.writing import replace_capsules
from ..limits.joint_limits import slides
from ..support.checks import Array
from ..support.errors import InputError, missing_extra

Bounds = dict[str, tuple[float, float]]

LINKS = 100  # The most links for yourdfpy: it takes minutes for a longer chain.
UNIT_TOL = 1e-12  # A larger difference of an axis from a unit vector scales the way of a slide.


def as_written(description: Description, values: Mapping[str, Array], base: str) -> tuple[Array, Bounds]:
    """Poses (samples, links, 4, 4) in `base` for joint values (samples,), and each joint's lower and upper limit.

    Joints without values are at 0. Limits are those of joints that are one number. Raises InputError with the reason
    if the text cannot be compared.
    """
    planar = next((joint.part_of for joint in description.joints.values() if joint.part_of), None)
    if planar is not None:
        raise InputError(f"Pinocchio's parser does not read the axis of the planar joint {planar!r}")
    model, complaint = model_of(_undeclared(description))
    if complaint:
        raise InputError(f"Pinocchio does not read the unchanged file: {complaint}")
    pin, links = import_pinocchio(), list(description.links)
    data = pin.Data(model)
    frames = {str(frame.name): i for i, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}
    if unknown := [link for link in (*links, base) if link not in frames]:
        raise InputError(f"the unchanged file has no link {unknown[0]!r}")
    poses = np.empty((len(next(iter(values.values()))), len(links), 4, 4))
    for k, pose in enumerate(poses):
        pin.framesForwardKinematics(model, data, _q(pin, model, {name: x[k] for name, x in values.items()}))
        back = data.oMf[frames[base]].inverse()
        pose[:] = [(back * data.oMf[frames[link]]).homogeneous for link in links]
    single = ((str(name), model.joints[i]) for i, name in enumerate(model.names) if i and model.joints[i].nq == 1)
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    return poses, {name: (float(lower[joint.idx_q]), float(upper[joint.idx_q])) for name, joint in single}


def _undeclared(description: Description) -> str:
    """The text without an encoding: from here on it is UTF-8."""
    return re.sub(r"^\s*<\?xml[^>]*\?>", "", description.text)


def _q(pin: Any, model: Any, values: Mapping[str, float]) -> Array:
    """Pinocchio's configuration: an unbounded angle is its cosine and sine, a floating joint is fixed."""
    q: Array = pin.neutral(model)
    for i, name in enumerate(model.names):
        joint, value = model.joints[i], values.get(str(name), 0.0)
        if i and joint.nq == 1:
            q[joint.idx_q] = value
        elif i and joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
    return q


def yourdfpy_poses(description: Description, values: Mapping[str, Array], base: str) -> Array:
    """Every link's pose (samples, links, 4, 4) in `base` for the values (samples,) of the joints.

    Raises MissingExtraError without yourdfpy, and any error of its reader.
    """
    text = _undeclared(description)
    if "<capsule" in text:  # which yourdfpy refuses
        tree = SourceText(text).robot
        replace_capsules(tree)
        text = ET.tostring(tree, "unicode")
    with _quiet():
        content = io.BytesIO(text.encode("utf-8"))
        robot = require_yourdfpy().URDF.load(content, load_meshes=False, build_scene_graph=True)
        samples, links = len(next(iter(values.values()))), list(description.links)
        poses = np.empty((samples, len(links), 4, 4))
        for k in range(samples):
            robot.update_cfg({name: float(values[name][k]) for name in robot.actuated_joint_names if name in values})
            for i, link in enumerate(links):
                poses[k, i] = robot.get_transform(link, base)
    return poses


def beyond_yourdfpy(arm: Arm) -> str:
    """Why yourdfpy cannot be asked about this arm. Empty if it can."""
    assert arm.description is not None
    joints = arm.description.joints
    if len(arm.description.links) > LINKS:
        return f"yourdfpy takes minutes for {len(arm.description.links)} links"
    if "quat_xyzw=" in arm.description.repaired:
        return "yourdfpy does not read quat_xyzw"
    for joint in joints.values():
        misread = {
            "planar": bool(joint.part_of),
            "floating": joint.type == "floating",
            "a mimic of a mimic": joint.mimic is not None and joints[joint.mimic.joint].mimic is not None,
            "a locked mimic": joint.mimic is not None and arm.couplings[joint.name].master is None,
            "a slide whose axis is no unit vector": slides(joint.type) and abs(joint.axis_length - 1.0) > UNIT_TOL,
        }
        if found := next((what for what, true in misread.items() if true), ""):
            return f"yourdfpy reads the joint {(joint.part_of or joint.name)!r} otherwise: it is {found}"
    return ""


def require_yourdfpy() -> Any:
    """The module, or the error with the command that installs it."""
    try:
        import yourdfpy
    except ImportError as error:
        raise missing_extra("the comparison with yourdfpy", "yourdfpy", "check") from error
    return yourdfpy


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence its log and the NumPy warnings of its shapes, because our findings cover them."""
    import logging

    logger = logging.getLogger("yourdfpy.urdf")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        with np.errstate(all="ignore"):
            yield
    finally:
        logger.setLevel(level)
