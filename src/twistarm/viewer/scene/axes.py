"""The joints' screws as arrows along their axes, and the arm as rods between axes."""

from __future__ import annotations

import numpy as np

from ...arm.arm import Arm
from ...limits.joint_limits import slides
from ...support.checks import Array
from ...theory import poe
from ...theory.screws import to_screw
from . import drawing
from .drawing import STICK, Colour, rod_path, screw_path

KIND_COLOURS: dict[str, Colour] = {
    "revolute": (0.85, 0.15, 0.58, 1.0),
    "prismatic": (0.05, 0.60, 0.65, 1.0),
    "helical": (0.78, 0.57, 0.06, 1.0),
}
"""Colours of screws: without pitch, of infinite pitch (a slide), any other. The page's legend repeats them."""

AXIS_HALF = 0.18
"""Half the arrow along an axis, in sizes of the arm."""

PITCHLESS = 1e-9
"""A pitch below this share of the arm's size counts as 0."""


def arm_size(arm: Arm) -> float:
    """A length [m] that scales axes and frames: the reach, or the tool's distance without turning joints."""
    far = max(arm.reach, float(np.linalg.norm(arm.home[:3, 3])))
    return far if far > 1e-6 else 1.0


def anchors(arm: Arm, theta: Array | None = None) -> Array:
    """A point (m, 3) on each moving joint's axis at theta (n,), 0 by default.

    It is the origin of the joint's link. Without a description it is the point of the axis nearest to the last one.
    """
    x = np.zeros(arm.n) if theta is None else theta
    if arm.description is not None:
        poses = arm.poses(x)
        return np.array([poses[arm.description.joints[name].child][:3, 3] for name in arm.moving_names])
    points: list[Array] = []
    last: Array = np.zeros(3)
    for xi in poe.spatial_jacobian(arm.screws, arm.coupling.A @ x).T:
        screw = to_screw(xi)
        if np.isfinite(screw.pitch):
            last = screw.point + screw.axis * (screw.axis @ (last - screw.point))
        points.append(last)
    return np.array(points)


def screw_kinds(arm: Arm) -> list[str]:
    """`revolute`, `prismatic` or `helical` for each moving joint, by the pitch of its screw."""
    size = arm_size(arm)
    pitches = [float(to_screw(xi).pitch) for xi in arm.screws.T]
    return ["prismatic" if np.isinf(h) else "revolute" if abs(h) < PITCHLESS * size else "helical" for h in pitches]


def draw_screws(arm: Arm) -> list[bytes]:
    """An arrow along each axis at theta = 0. The joint's partial product carries it."""
    drawn: list[bytes] = []
    size = arm_size(arm)
    for i, (xi, anchor, kind) in enumerate(zip(arm.screws.T, anchors(arm), screw_kinds(arm), strict=True)):
        half = AXIS_HALF * size * to_screw(xi).axis
        drawn += drawing.arrow(f"{screw_path(i)}/axis", anchor - half, anchor + half, 0.0055 * size, KIND_COLOURS[kind])
    return drawn


def draw_rods(arm: Arm) -> list[bytes]:
    """Rods between axes at theta = 0, each in its joint's node, and a rail under each slide."""
    size = arm_size(arm)
    points = [np.zeros(3), *anchors(arm), arm.home[:3, 3]]
    paths = ["/arm/rod:base", *(rod_path(i) for i in range(arm.screws.shape[1]))]
    drawn: list[bytes] = []
    for path, start, end in zip(paths, points[:-1], points[1:], strict=True):
        drawn.append(drawing.sphere(f"{path}/origin", 0.02 * size, STICK, drawing.at(start)))
        if np.linalg.norm(end - start) > 1e-3 * size:
            drawn.append(drawing.rod(f"{path}/rod", start, end, 0.012 * size, STICK))
    lower, upper = (np.clip(arm.coupling.A @ bound, -size, size) for bound in arm.sampling_bounds)
    for i, kind in enumerate(screw_kinds(arm)):
        if slides(kind):
            axis = to_screw(arm.screws[:, i]).axis
            ends = points[i + 1] + lower[i] * axis, points[i + 1] + upper[i] * axis
            drawn.append(drawing.rod(f"{paths[i]}/rail", *ends, 0.006 * size, STICK))
    return drawn
