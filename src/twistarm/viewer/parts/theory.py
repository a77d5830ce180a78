"""What the pages need beside the arm to compute and draw Jacobians, screws, singular values and ellipsoids."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...control.servo.settings import ServoSettings
from ...theory.screws import to_screw
from ..messages import Message
from ..scene.arm_drawing import AXIS_HALF, PITCHLESS, anchors, arm_size
from ..scene.drawing import screw_path
from .show import Part, Show

LINEAR = 0.25  # Drawn length [m] of 1 m/s; a screw's v and the axes of the linear ellipsoid are drawn to it.
ANGULAR = 0.13  # Drawn length of 1 rad/s, in sizes of the arm.
# Singular values below this count as singular for a servo with default settings.
BELOW = ServoSettings().singularity_threshold


class Theory(Part):
    """The axes of an arm, which are constant. The pages compute what depends on its configuration."""

    def __init__(self, arm: Arm) -> None:
        self._axes: Message = {"type": "axes", **axes(arm)}

    def messages(self, show: Show) -> list[Message]:
        """The joints' axes."""
        return [self._axes]


def axes(arm: Arm) -> dict[str, Any]:
    """The axis of each moving joint: node, tip of its arrow [m], pitch [m/rad] or null for inf.

    A joint carries its screw, so both are constant: Ad_g keeps the pitch (MLS §2.4.2). The drawing scales are `linear`
    [m] for 1 m/s and `angular` [m] for 1 rad/s. A slide's rate is divided by `length` [m]. Singular values
    under `below` are nearly 0.
    """
    size = arm_size(arm)
    screws = [to_screw(xi) for xi in arm.screws.T]
    tips = [anchor + AXIS_HALF * size * screw.axis for anchor, screw in zip(anchors(arm), screws, strict=True)]
    # Rounding leaves a turning joint a pitch that is not quite 0.
    plain = [0.0 if abs(screw.pitch) < PITCHLESS * size else float(screw.pitch) for screw in screws]
    pitches = [None if np.isinf(pitch) else pitch for pitch in plain]
    joints = zip(arm.moving_names, tips, pitches, strict=True)
    return {
        "joints": [
            {"name": name, "node": screw_path(i), "tip": tip.tolist(), "pitch": pitch}
            for i, (name, tip, pitch) in enumerate(joints)
        ],
        "linear": LINEAR,
        "angular": ANGULAR * size,
        "length": arm.reach,
        "size": size,
        "below": BELOW,
    }
