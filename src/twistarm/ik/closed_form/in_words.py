"""Families and what misses one, in words."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...arm.almost_exact import angle_in_words
from ...arm.arm import Arm
from .chain import JointAxis
from .families import DECOUPLED, SPHERICAL, FittedFamily

PARALLEL = 1e-6
"""Sines below this are those of parallel axes: their distance is measured across them."""

Joints = Sequence[int]
"""For each axis of a chain its place in the arm; what a target leaves free has places behind the arm's joints."""


def family_in_words(arm: Arm, fitted: FittedFamily, joints: Joints) -> str:
    """The group of joints, and what makes it one."""
    group = fitted.family.group
    if fitted.family.kind == DECOUPLED:
        return "the joints that turn follow from the rotation alone, those that slide from the position"
    names = _names(arm, [joints[i] for i in group])
    if min(joints[i] for i in group) >= arm.n:
        return "the joints place a point, and the target leaves the turns about it free"
    if len(group) == 1:
        return f"the other joints place a point of the axis of {names}"
    if fitted.family.kind == SPHERICAL:
        return f"the axes of {names} meet in a point"
    slides = any(axis.slides for axis in fitted.axes[fitted.family.first : fitted.family.last])
    return f"{names} turn and slide in parallel planes" if slides else f"the axes of {names} are parallel"


def off_in_words(fitted: FittedFamily) -> str:
    """How much the axes miss the family: `0.4 mm`."""
    return _length(fitted.off) if fitted.family.kind == SPHERICAL else angle_in_words(fitted.off)


def missed_in_words(arm: Arm, fitted: FittedFamily, axes: Sequence[JointAxis], joints: Joints) -> str:
    """The two axes of the group that are farthest from making it one."""
    group = fitted.family.group
    spherical = fitted.family.kind == SPHERICAL
    between = _distance if spherical else _from_parallel
    pairs = itertools.combinations(group, 2)
    far, i, j = max(((between(axes[i], axes[j]), i, j) for i, j in pairs), default=(0.0, 0, 0))
    names = _names(arm, [joints[i], joints[j]])
    if spherical and far > fitted.off:
        return f"the axes of {names} pass at {_length(far)}"
    if spherical:  # each two of them meet, but not all three
        return f"the axes of {_names(arm, [joints[i] for i in group])} pass a common point at {_length(fitted.off)}"
    kind = "square" if axes[i].slides != axes[j].slides else "parallel"
    return f"the axes of {names} are {angle_in_words(far)} from {kind}"


def _distance(a: JointAxis, b: JointAxis) -> float:
    normal, apart = np.cross(a.w, b.w), b.o - a.o
    sine = float(np.linalg.norm(normal))
    return abs(float(normal @ apart)) / sine if sine > PARALLEL else float(np.linalg.norm(np.cross(a.w, apart)))


def _from_parallel(a: JointAxis, b: JointAxis) -> float:
    """The angle [rad] by which they are not parallel, or not square if one slides."""
    sine, cosine = float(np.linalg.norm(np.cross(a.w, b.w))), abs(float(a.w @ b.w))
    if a.slides != b.slides:
        return float(np.arctan2(cosine, sine))
    return 0.0 if a.slides else float(np.arctan2(sine, cosine))


def _names(arm: Arm, joints: Joints) -> str:
    names = [arm.joint_names[i] for i in joints if i < arm.n]
    names += ["the turns that the target leaves free"] * (len(names) < len(joints))
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def _length(metres: float) -> str:
    return f"{1e3 * metres:.3g} mm" if metres >= 1e-5 else f"{1e6 * metres:.2g} µm"
