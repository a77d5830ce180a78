"""The unmodified description, read by Pinocchio, so our repairs cannot hide from the check."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from ..arm.pinocchio_model import import_pinocchio, model_of
from ..description.tree import Description
from ..support.checks import Array
from ..support.errors import InputError


class AsWritten:
    """Pinocchio's model of an unchanged text. Raises InputError with the reason if it cannot be compared."""

    def __init__(self, description: Description) -> None:
        planar = next((joint.part_of for joint in description.joints.values() if joint.part_of), None)
        if planar is not None:
            raise InputError(f"Pinocchio's parser does not read the axis of the planar joint {planar!r}")
        # The text is UTF-8 from here on, whatever encoding the file declared.
        text = re.sub(r"^\s*<\?xml[^>]*\?>", "", description.text)
        self._pin = import_pinocchio()
        self._model, complaint = model_of(text)
        if complaint:
            raise InputError(f"Pinocchio does not read the unchanged file: {complaint}")
        self._data = self._pin.Data(self._model)

    def link_poses(self, values: Mapping[str, Array], links: Sequence[str], base: str) -> Array:
        """Poses (samples, links, 4, 4) in `base` for the values (samples,) of the joints; others stand at 0.

        Raises InputError for a link that the model does not have.
        """
        model, data, body = self._model, self._data, self._pin.FrameType.BODY
        frames = {str(frame.name): i for i, frame in enumerate(model.frames) if frame.type == body}
        if unknown := [link for link in (*links, base) if link not in frames]:
            raise InputError(f"the unchanged file has no link {unknown[0]!r}")
        poses = np.empty((len(next(iter(values.values()))), len(links), 4, 4))
        for k, pose in enumerate(poses):
            self._pin.framesForwardKinematics(model, data, self._q({name: x[k] for name, x in values.items()}))
            back = data.oMf[frames[base]].inverse()
            pose[:] = [(back * data.oMf[frames[link]]).homogeneous for link in links]
        return poses

    def bounds(self) -> dict[str, tuple[float, float]]:
        """lower, upper of every joint that is one number."""
        model = self._model
        single = ((str(name), model.joints[i]) for i, name in enumerate(model.names) if i and model.joints[i].nq == 1)
        lower, upper = model.lowerPositionLimit, model.upperPositionLimit
        return {name: (float(lower[joint.idx_q]), float(upper[joint.idx_q])) for name, joint in single}

    def _q(self, values: Mapping[str, float]) -> Array:
        """Pinocchio's configuration: an unbounded angle is its cosine and sine, a floating joint stands still."""
        q: Array = self._pin.neutral(self._model)
        for i, name in enumerate(self._model.names):
            joint, value = self._model.joints[i], values.get(str(name), 0.0)
            if i and joint.nq == 1:
                q[joint.idx_q] = value
            elif i and joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        return q
