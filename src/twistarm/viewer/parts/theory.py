"""Jacobians, screws, singular values and ellipsoids of the present configuration, while a page shows them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory.screws import to_screw
from ..protocol.messages import Message
from ..scene.axes import AXIS_HALF, PITCHLESS, anchors, arm_size
from ..scene.nodes import screw_path
from .part import Part, Show
from .theory_numbers import numbers

SHOWN = ("numbers", "screw", "spatial_columns", "body_columns", "linear_ellipsoid", "angular_ellipsoid")
"""The layers that need these numbers."""

LINEAR = 0.25
"""Drawn length [m] of 1 m/s; a screw's v and the axes of the linear ellipsoid are drawn to it."""

ANGULAR = 0.13
"""Drawn length of 1 rad/s, in sizes of the arm."""


class Theory(Part):
    """What the configuration comes to, computed only while some page shows something of it."""

    def __init__(self, arm: Arm) -> None:
        self._axes: Message = {"type": "axes", **axes(arm)}
        self._theta: Array | None = None
        self._moved = 0
        self._numbers: Message = {}

    def messages(self, show: Show) -> Iterator[Message]:
        """The joints' axes; and the numbers, where they are looked at."""
        yield self._axes
        if any(show.visible[layer] for layer in SHOWN):
            if show.theta is not self._theta:
                self._moved = self._which_moved(show)
                self._theta = show.theta
                self._numbers = {"type": "theory", "moved": self._moved, **numbers(show.arm, *_motion(show))}
            yield self._numbers

    def _which_moved(self, show: Show) -> int:
        """The coordinate that changed most, with metres divided by the arm's reach."""
        if self._theta is None or np.array_equal(show.theta, self._theta):
            return self._moved
        length = np.where(np.array(show.arm.units) == "m", show.arm.reach, 1.0)
        return int(np.argmax(np.abs(show.theta - self._theta) / length))


def axes(arm: Arm) -> dict[str, Any]:
    """Each moving joint's axis: its node, the arrow's tip in it [m], its pitch [m/rad], null for inf.

    A joint carries its screw, so both are constant: Ad_g keeps the pitch (MLS §2.4.2). The drawing scales are `linear`
    [m] for 1 m/s and `angular` [m] for 1 rad/s. A slide's rate is divided by `length` [m].
    """
    size = arm_size(arm)
    screws = [to_screw(xi) for xi in arm.screws.T]
    tips = [anchor + AXIS_HALF * size * screw.axis for anchor, screw in zip(anchors(arm), screws, strict=True)]
    pitches = [_plain_pitch(float(screw.pitch), size) for screw in screws]
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
    }


def _motion(show: Show) -> tuple[Array, Array | None]:
    """The configuration on show and its rates (n,) on the trajectory, if it plays."""
    playback = show.playback
    if playback is None or not (playback.running or np.array_equal(playback.theta(), show.theta)):
        return show.theta, None
    return show.theta, playback.trajectory(playback.time, 1)


def _plain_pitch(pitch: float, size: float) -> float | None:
    if np.isinf(pitch):
        return None
    return 0.0 if abs(pitch) < PITCHLESS * size else pitch
