"""Changes of an arm's geometry in words: moved or turned axes, and the tool."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..theory.rotations import log as rotation_log
from ..theory.screws import Screw, adjoint, hat, inverse, to_screw

SAME_TOL = 1e-6
"""Smaller differences, below 1 µm and 1e-6 rad, come from rounding in an export, not from a changed description."""

OPPOSITE = 1e-9
"""Unit vectors whose product is nearer than this to -1 are opposite: no least turn takes one to the other."""


def geometry_changes(arm: Arm, screws: Array, home: Array) -> list[str]:
    """The moved axes from base to tip, without those that a moved joint only carries.

    `carried` is the rigid motion that the changes so far give to everything beyond.
    """
    changes = []
    carried = np.eye(4)
    for i, name in enumerate(arm.moving_names):
        before = adjoint(carried) @ screws[:, i:]
        words, motion = _axis_change(before, arm.screws[:, i:], carried @ home, arm.home)
        changes += [f"joint {name} {word}" for word in words]
        carried = motion @ carried
    if np.abs(arm.home - carried @ home).max() > SAME_TOL:
        # The tool's own motion in the home pose, that of what it rides on included.
        words = _shift_words(arm.home[:3, 3] - home[:3, 3]) + _turn_words(arm.home[:3, :3] @ home[:3, :3].T)
        in_all = " in all" if changes else ""
        words = [word + in_all for word in words] or ["is where it was all the same"]
        changes += [f"tool {arm.tip} {word}" for word in words]
    return changes


def _axis_change(before: Array, now: Array, tool: Array, new_tool: Array) -> tuple[list[str], Array]:
    """The change of the first of the axes (6, k) in words, and the rigid motion of what is beyond it.

    It is the least motion that carries the old line to the new. For a line that has turned, it is the tool's motion if
    every axis beyond has made it too. The points of a turned line have moved by different lengths. The words give that
    of the point nearest the tool, independent of the base.
    """
    if np.abs(now[:, 0] - before[:, 0]).max() <= SAME_TOL:
        return [], np.eye(4)
    old, new = to_screw(before[:, 0]), to_screw(now[:, 0])
    turning = bool(np.isfinite(old.pitch) and np.isfinite(new.pitch))
    anchor = _nearest(old, tool[:3, 3]) if turning else tool[:3, 3]
    motion = new_tool @ inverse(tool)
    turned = np.abs(new.axis - old.axis).max() > SAME_TOL
    if turned and np.abs(adjoint(motion) @ before - now).max() <= SAME_TOL:
        return _motion_words(motion, anchor), motion
    cosine = float(old.axis @ new.axis)
    words, turn = [], np.eye(3)
    if cosine < -1 + OPPOSITE:  # the line stays where it is: nothing beyond it has turned
        words.append("is reversed: it turns or slides the other way")
    else:  # the least rotation from one axis to the other
        K = hat(np.cross(old.axis, new.axis))
        turn = np.eye(3) + K + K @ K / (1 + cosine)
    motion = np.eye(4)
    motion[:3, :3] = turn
    motion[:3, 3] = (_nearest(new, anchor) if turning else anchor) - turn @ anchor
    words += _motion_words(motion, anchor)
    if turning and abs(new.pitch - old.pitch) > SAME_TOL:
        words.append(f"changed its pitch from {old.pitch:.6g} to {new.pitch:.6g} m/rad")
    return words, motion


def _nearest(line: Screw, point: Array) -> Array:
    """The point of the line nearest to `point`."""
    return line.point + line.axis * (line.axis @ (point - line.point))


def _motion_words(motion: Array, anchor: Array) -> list[str]:
    """The turn of a line, and its motion at `anchor`, the point nearest to the tool."""
    turned = _turn_words(motion[:3, :3])
    moved = _shift_words(motion[:3, :3] @ anchor + motion[:3, 3] - anchor)
    return turned + [f"{word} where it is nearest the tool" if turned else word for word in moved]


def _turn_words(turn: Array) -> list[str]:
    w = rotation_log(turn)
    angle = float(np.linalg.norm(w))
    return [f"turned by {np.degrees(angle):.3g}° about {_direction(w)}"] if angle > SAME_TOL else []


def _shift_words(shift: Array) -> list[str]:
    distance = float(np.linalg.norm(shift))
    return [f"moved {distance * 1e3:.4g} mm along {_direction(shift)}"] if distance > SAME_TOL else []


def _direction(vector: Array) -> str:
    """`x`, `−z`, or the unit vector in base axes."""
    unit = vector / np.linalg.norm(vector)
    i = int(np.abs(unit).argmax())
    if abs(unit[i]) > 0.9999:
        return ("" if unit[i] > 0 else "−") + "xyz"[i]
    return "(" + ", ".join(f"{x:.2f}" for x in unit) + ")"
