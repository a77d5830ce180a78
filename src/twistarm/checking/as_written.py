"""The unmodified description, read by Pinocchio, so our repairs cannot hide from the check."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..arm.pinocchio_model import import_pinocchio, model_of
from ..description.tree import Description
from ..support.checks import Array
from ..support.errors import InputError

Bounds = dict[str, tuple[float, float]]


def as_written(description: Description, values: Mapping[str, Array], base: str) -> tuple[Array, Bounds]:
    """Poses (samples, links, 4, 4) in `base` for joint values (samples,), and each joint's lower and upper limit.

    Joints without values stand at 0. Limits are those of joints that are one number. Raises InputError with the reason
    if the text cannot be compared.
    """
    planar = next((joint.part_of for joint in description.joints.values() if joint.part_of), None)
    if planar is not None:
        raise InputError(f"Pinocchio's parser does not read the axis of the planar joint {planar!r}")
    # The text is UTF-8 from here on, whatever encoding the file declared.
    model, complaint = model_of(re.sub(r"^\s*<\?xml[^>]*\?>", "", description.text))
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


def _q(pin: Any, model: Any, values: Mapping[str, float]) -> Array:
    """Pinocchio's configuration: an unbounded angle is its cosine and sine, a floating joint stands still."""
    q: Array = pin.neutral(model)
    for i, name in enumerate(model.names):
        joint, value = model.joints[i], values.get(str(name), 0.0)
        if i and joint.nq == 1:
            q[joint.idx_q] = value
        elif i and joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
    return q
