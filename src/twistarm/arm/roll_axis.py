"""The axis of the tool about which the last joint of an arm rolls it."""

from __future__ import annotations

import numpy as np

from ..support.checks import Array, frozen
from ..theory.rotations import cross

Z = frozen([0.0, 0.0, 1.0])
"""The axis if no joint rolls the tool. By convention a tool points along z."""

ALIGNED = 1e-3
"""Sine below which axes are parallel, and share of the reach below which a point lies on an axis."""

DECIMALS = 12
"""Decimals of the axis. Further digits are rounding, which differs between machines."""

DECISIVE = 0.5
"""Some component of every unit vector is at least 1/√3."""


def roll_axis(body_screws: Array, coupling: Array, reach: float) -> Array:
    """The unit vector (3,) in tool axes about which the last turning joint rolls the tool, or z.

    The columns (v, w) of `body_screws` (6, m) are the screws at rest. The row of a locked joint in `coupling` (m, n) is
    zero. Joints after the last turning joint only slide, so its axis w is fixed in the tool.

    The wrist is the point of that axis nearest to the axis of the turning joint before it. The last joint is a roll
    if the two axes are not parallel, and the tool's origin is at the wrist or within 45° of ±w seen from there. With
    one turning joint only, it is a roll if the tool's origin lies on its axis. A last joint that pitches gives z.

    The axis points outward, from the wrist to the tool's origin. If the two coincide, or only one joint turns, the
    first component of z, x, y of at least 0.5 in size is positive.
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
    decisive = next(value for value in last[[2, 0, 1]] if abs(value) >= DECISIVE * np.linalg.norm(last))
    sense = np.sign(out if abs(out) > ALIGNED * reach else decisive)
    return frozen(np.round(sense * last, DECIMALS) + 0.0)
