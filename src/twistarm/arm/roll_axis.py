"""The tool axis: the axis about which the last joint rolls the tool."""

from __future__ import annotations

import numpy as np

from ..support.checks import Array, frozen
from ..theory.rotations import cross

Z = frozen([0.0, 0.0, 1.0])
"""Where no joint rolls the tool: by the usual convention it points along its z axis."""

ALIGNED = 1e-3
"""Sine and share of the reach below which axes are parallel, and a point lies on an axis: CAD exports round."""

DECIMALS = 12
"""Of the axis: what lies beyond is the rounding of a product of matrices, which differs from machine to machine."""

DECISIVE = 0.5
"""Some component of every unit vector is at least 1/√3."""


def roll_axis(body_screws: Array, coupling: Array, reach: float) -> Array:
    """The unit vector (3,) in tool axes about which the last turning joint rolls the tool; z without a roll.

    It follows from the columns (v, w) of `body_screws` (6, m) at rest and the rows of `coupling` (m, n); a locked
    joint's row is zero. Joints beyond the last turning one only slide, so its axis w is fixed in the tool. It is a roll
    if the turning joint before it is not parallel and the tool is ahead along it: seen from the wrist (the point of the
    axis nearest to that joint's axis), the tool's origin is within 45° of ±w, or at the wrist. Without a joint before
    it, the tool's origin must be on its axis. A last joint that pitches is no roll.

    Its sense is outward, from the wrist to the tool's origin. If both coincide, or nothing turns before it, the first
    decisive component of z, x, y is positive.
    """
    turning = np.flatnonzero((np.linalg.norm(body_screws[3:], axis=0) > 0.5) & coupling.any(axis=1))
    if not len(turning):
        return Z
    v, w = body_screws[:3].T, body_screws[3:].T
    last = w[turning[-1]]
    near = cross(last, v[turning[-1]])  # of the axis, nearest to the tool's origin
    aside, out = float(np.linalg.norm(near)), 0.0
    if len(turning) > 1:
        before = turning[-2]
        across = cross(w[before], last)
        if across @ across < ALIGNED**2:
            return Z
        # Along the common perpendicular of the two lines: from the foot on the last axis to the tool's origin.
        apart = cross(w[before], v[before]) - near
        out = float(cross(apart, w[before]) @ across) / float(across @ across)
    if aside > max(abs(out), ALIGNED * reach):
        return Z
    sense = np.sign(out) if abs(out) > ALIGNED * reach else _usual_sense(last)
    return frozen(np.round(sense * last, DECIMALS) + 0.0)


def _usual_sense(axis: Array) -> float:
    decisive = next(value for value in axis[[2, 0, 1]] if abs(value) >= DECISIVE)
    return float(np.sign(decisive))
