"""Axes of an arm that are almost parallel, square or meeting, because CAD exports round.

The angle and the distance between neighbouring axes are constants of the arm. Closed forms of inverse kinematics need
them exact. An arm with rpy="1.5708" loses the special geometry of its drawing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..support.checks import Array
from ..support.directions import angle_in_words, length_in_words
from ..theory.lines import meeting_point

EXACT_ANGLE, EXACT_DISTANCE = 1e-9, 1e-9  # [rad], [m]: closer than this counts as exact.
ALMOST_ANGLE, ALMOST_DISTANCE = math.radians(0.5), 2e-3  # [rad], [m]: more is intended.


@dataclass(frozen=True)
class Near:
    """A relation that almost holds for some joints, and roughly how far it moves the tool [m]."""

    joints: str
    what: str
    moves: float


def almost_exact(screws: Array, home: Array, joints: Sequence[str], reach: float) -> list[Near]:
    """The relations that almost hold for the axes of screws (6, m): neighbours, the wrist, then base and tool frame.

    The first axis is compared with the axes of the base, the last with the axes of the tool in `home` (4, 4).
    """
    v, w = screws[:3].T, screws[3:].T
    turning = np.linalg.norm(w, axis=1) > 0.5
    axes = np.where(turning[:, None], w, v)
    points = np.cross(w, v)
    found: list[Near] = []
    for i, j in pairwise(range(len(axes))):
        offset = points[j] - points[i] if turning[i] and turning[j] else None
        found += [Near(f"{joints[i]}–{joints[j]}", *pair) for pair in _pair(axes[i], axes[j], offset, reach)]
    found += _wrist(joints, axes, points, turning)
    found += [Near(f"base–{joints[0]}", *pair) for pair in _among(axes[0], np.eye(3), reach)]
    return found + [Near(f"{joints[-1]}–tool", *pair) for pair in _among(axes[-1], home[:3, :3].T, reach)]


def _among(axis: Array, frame: Array, reach: float) -> list[tuple[str, float]]:
    """The relations of an axis with the rows of a frame (3, 3): almost parallel to one, else almost square to some."""
    along = int(np.abs(frame @ axis).argmax())
    if np.linalg.norm(np.cross(axis, frame[along])) < ALMOST_ANGLE:
        return [*_pair(axis, frame[along], None, reach)]
    return [pair for other in frame for pair in _pair(axis, other, None, reach)]


def _pair(a: Array, b: Array, offset: Array | None, reach: float) -> Iterator[tuple[str, float]]:
    """The relations that almost hold for two axes, and how far each moves the tool.

    `offset` is the vector between two turning axes.
    """
    sine, cosine = float(np.linalg.norm(np.cross(a, b))), abs(float(a @ b))
    for what, angle in (("parallel", math.atan2(sine, cosine)), ("square", math.atan2(cosine, sine))):
        if EXACT_ANGLE < angle < ALMOST_ANGLE:
            yield f"are {what} to within {angle_in_words(angle)}", angle * reach
    if offset is None:
        return
    parallel = math.atan2(sine, cosine) < ALMOST_ANGLE
    distance = float(np.linalg.norm(np.cross(offset, a))) if parallel else abs(float(offset @ np.cross(a, b))) / sine
    if EXACT_DISTANCE < distance < ALMOST_DISTANCE:
        yield f"{'coincide' if parallel else 'meet'} to within {length_in_words(distance)}", distance


def _wrist(joints: Sequence[str], axes: Array, points: Array, turning: Array) -> list[Near]:
    """The relation of the last three axes if all turn and almost meet in one point."""
    if len(axes) < 3 or not turning[-3:].all():
        return []
    if np.linalg.norm(np.linalg.svd(axes[-3:], compute_uv=False)[1:]) < ALMOST_ANGLE:
        return []  # almost parallel axes have no one point
    _, distance = meeting_point(axes[-3:], points[-3:])
    if not EXACT_DISTANCE < distance < ALMOST_DISTANCE:
        return []
    what = f"are almost a spherical wrist, off by {length_in_words(distance)}"
    return [Near("–".join(joints[-3:]), what, distance)]
