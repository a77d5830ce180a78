"""Jacobians, screws, singular values and ellipsoids of the present configuration, while a page shows them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...control.servo.settings import ServoSettings
from ...support.checks import Array
from ...support.directions import axis_in_words
from ...theory import poe
from ...theory.manipulability import Manipulability, scaled_jacobian
from ...theory.screws import to_screw
from ..jobs import Memo
from ..messages import Message
from ..scene.arm_drawing import AXIS_HALF, PITCHLESS, anchors, arm_size
from ..scene.drawing import screw_path
from .show import Part, Show

LINEAR = 0.25  # Drawn length [m] of 1 m/s; a screw's v and the axes of the linear ellipsoid are drawn to it.
ANGULAR = 0.13  # Drawn length of 1 rad/s, in sizes of the arm.
# Singular values below this count as singular for a servo with default settings.
BELOW = ServoSettings().singularity_threshold
SLIGHT = 0.05  # A component of a unit direction below this is not mentioned.


class Theory(Part):
    """What the configuration comes to, computed only while some page shows something of it."""

    def __init__(self, arm: Arm) -> None:
        self._axes: Message = {"type": "axes", **axes(arm)}
        self._before: Array | None = None
        self._moved = 0
        self._numbers = Memo(self._computed)

    def messages(self, show: Show) -> Iterator[Message]:
        """The joints' axes; and the numbers, where they are looked at."""
        yield self._axes
        if "theory" in show.needed:
            yield self._numbers(show, show.theta)

    def _computed(self, show: Show, theta: Array) -> Message:
        """`moved`: the coordinate that changed most since the last time that one did."""
        if self._before is not None and not np.array_equal(theta, self._before):
            self._moved = most_moved(show.arm, theta - self._before)
        self._before = theta
        at, rates = show.playback, None
        if at is not None and (at.running or np.array_equal(at.theta(), theta)):
            rates = at.trajectory(at.time, 1)  # of the trajectory, where the arm is on it
        return {"type": "theory", "moved": self._moved, **numbers(show.arm, theta, rates)}


def most_moved(arm: Arm, change: Array) -> int:
    """The coordinate with the largest change or rate (n,), metres divided by the reach."""
    return int(np.argmax(np.abs(change) / np.where(np.array(arm.units) == "m", arm.reach, 1.0)))


def axes(arm: Arm) -> dict[str, Any]:
    """Each moving joint's axis: its node, the arrow's tip in it [m], its pitch [m/rad], null for inf.

    A joint carries its screw, so both are constant: Ad_g keeps the pitch (MLS §2.4.2). The drawing scales are `linear`
    [m] for 1 m/s and `angular` [m] for 1 rad/s. A slide's rate is divided by `length` [m].
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
    }


def numbers(arm: Arm, theta: Array, rates: Array | None = None) -> dict[str, Any]:
    """The numbers at theta (n,) in SI units and radians; matrices are lists of rows.

    g (4, 4): g_st. spatial, body, hybrid (6, n): the Jacobians. columns: each column of J^s as a screw. axes: each
    moving joint's screw, null if equal to the columns. singular_values, condition (null if infinite), rank, yoshikawa,
    smallest, below, standing (in words): of the body Jacobian, with metres divided by `reach`. linear, angular: the
    ellipsoids. motion: V^s = J^s θ̇ for `rates` (n,), as twist and screw, and the tool origin's velocity.
    """
    g, J_b = arm.fk_and_body_jacobian(theta)
    J_s = arm.spatial_jacobian(theta)
    hybrid = (g[:3, :3] @ J_b.reshape(2, 3, -1)).reshape(6, -1)
    motion = None
    if rates is not None and np.any(rates):
        twist, velocity = J_s @ rates, hybrid[:3] @ rates
        motion = {"twist": twist.tolist(), "screw": _screws(twist[:, None]), "velocity": velocity.tolist()}
    return {
        "g": g.tolist(),
        "spatial": J_s.tolist(),
        "body": J_b.tolist(),
        "hybrid": hybrid.tolist(),
        "axes": None
        if np.array_equal(arm.coupling.A, np.eye(arm.n))
        else _screws(poe.spatial_jacobian(arm.screws, arm.coupling.A @ theta)),
        "columns": _screws(J_s),
        "motion": motion,
        **_singularity(arm, theta),
        **_ellipsoids(hybrid, arm.prismatic, arm.reach),
    }


def _singularity(arm: Arm, theta: Array) -> dict[str, Any]:
    found = arm.manipulability(theta)
    values, rank = found.singular_values.tolist(), int(found.rank) if arm.n else 0
    return {
        "singular_values": values,
        "condition": values[0] / values[-1] if 0 < rank == len(values) else None,
        "rank": rank,
        "yoshikawa": float(found.yoshikawa),
        "smallest": values[-1] if values else 0.0,
        "below": BELOW,
        "standing": rank_in_words(found, rank, BELOW),
    }


def _ellipsoids(hybrid: Array, prismatic: Array, length: float) -> dict[str, Any]:
    """Semi-axes (3,), descending, and their directions (3, 3), one a column, in base axes: linear and angular.

    Of the linear [m/s] and of the angular [rad/s] rows of the hybrid Jacobian (6, n): {J θ̇ : ‖θ̇‖ ≤ 1 rad/s}. A slide
    counts 1 m/s as 1/length rad/s. The semi-axes are singular values, 0 where the tool does not move. The directions
    are left singular vectors. Yoshikawa 1985, "Manipulability of robotic mechanisms"; MLS §3.4.4.
    """
    halves = scaled_jacobian(hybrid, prismatic, length).reshape(2, 3, -1)
    # Of fewer than three joints there would be fewer than three directions.
    padded = np.concatenate([halves, np.zeros((2, 3, max(0, 3 - halves.shape[-1])))], axis=-1)
    directions, values, _ = np.linalg.svd(padded, full_matrices=False)
    semi_axes = values * np.array([[length], [1.0]])
    pairs = zip(("linear", "angular"), semi_axes, directions, strict=True)
    return {name: {"semi_axes": long.tolist(), "directions": along.tolist()} for name, long, along in pairs}


def _screws(columns: Array) -> dict[str, list[Any]]:
    """Axis, point [m], pitch [m/rad] and magnitude of each column of (6, k). An infinite pitch is null."""
    screw = to_screw(columns.T)
    pitches = screw.pitch.tolist()
    return {
        "axis": screw.axis.tolist(),
        "point": screw.point.tolist(),
        "pitch": [None if np.isinf(pitch) else pitch for pitch in pitches],
        "magnitude": screw.magnitude.tolist(),
    }


def rank_in_words(found: Manipulability, rank: int, below: float) -> str:
    """The rank, and the directions, in tool axes, of singular values under `below`."""
    values = found.singular_values
    if not len(values):
        return "No joint moves the tool."
    weak = [_in_words(found.axes[:, i]) for i in range(len(values)) if values[i] < below]
    hard = weak[: len(weak) - (len(values) - rank)]
    lost = weak[len(hard) :]
    said = f"Rank {rank} of {len(values)}"
    if lost:
        said += f", singular: the tool cannot {', nor '.join(lost)}"
    if hard:
        said += f"{'; it' if lost else ', nearly singular: the tool'} can hardly {', nor '.join(hard)}"
    return f"{said}."


def _in_words(direction: Array) -> str:
    """A tool twist (v, w), v in units of the length, in words."""
    v, w = direction[:3], direction[3:]
    along, about = (axis_in_words(half / max(float(np.linalg.norm(half)), SLIGHT), "tool") for half in (v, w))
    if np.linalg.norm(w) < SLIGHT:
        return f"move along {along}"
    return f"turn about {about}" if np.linalg.norm(v) < SLIGHT else f"move along {along} while it turns about {about}"
