"""Stretches: the joint path from stop to stop of a motion, with rounded corners."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from .following import efforts
from .piecewise import JointPath, bernstein, derivative, extremes, rescaled, shifted, side_by_side, through
from .route import PathPart
from .segments import Move
from .within import POSITION_TOL, farthest_outside

BEND_PIECES = 8  # Pieces of a rounded corner. Each has a speed limit.
STRAIGHT_PIECES = 32  # Pieces of a straight joint path where the tool's speed is limited.
SPEED_SAMPLES = 64  # Intervals in each piece of a path, to find the tool's greatest speed.
SAMPLES = 256  # Samples of the tool along a path, to find where it leaves the ball.
REFINED = 3  # How often the interval of the crossing is sampled again, to 2⁻³² of the path.
ROUNDING = 1e-12  # A piece shorter than this part of its path is rounding.
ROOM = 0.9  # Greatest share of a path that rounded corners take together.
# Where the tool moves by less [m], it only turns: a rounded corner would skip its orientation there.
LEAST = 1e-4
# How often a corner shrinks that leaves the ball or the position limits, and by what factor.
SHRINKS, SMALLER = 20, 0.8


class Corner(NamedTuple):
    """Where a path of unit speed is left, the rounding, and where the next path is joined."""

    begins: float
    bend: JointPath
    ends: float


def runs(arm: Arm, parts: list[PathPart], limits: JointLimits) -> Iterator[tuple[list[PathPart], list[Corner]]]:
    """Yield the parts between stops in order, and the corners between them.

    The arm stops where no rounding is wanted or fits, and beside a part without a path.
    """
    paths = [None if part.path is None else _of_unit_speed(part, limits) for part in parts]
    radii = [part.blend if part.path and following.path else 0.0 for part, following in pairwise(parts)]
    shares = [ROOM / 2 if all(ends) else ROOM for ends in pairwise([0.0, *radii, 0.0])]
    run, corners = list[PathPart](), list[Corner]()
    for i, (part, radius) in enumerate(zip(parts, [*radii, 0.0], strict=True)):
        run.append(part)
        before, after = paths[i], paths[i + 1] if radius else None
        corner = _rounded(arm, before, after, radius, shares[i : i + 2], limits) if before and after else None
        if corner is not None:
            corners.append(corner)
            continue
        yield run, corners
        run, corners = [], []


def path_along(
    arm: Arm, run: list[PathPart], corners: list[Corner], limits: JointLimits
) -> tuple[JointPath, Array, Array | None]:
    """One path along moving parts, the end of each part, and the greatest ṡ per piece (m,).

    A rounded part ends in the middle of its corner. Without a limit there is no greatest ṡ.
    """
    at, begins, pieces, ends, caps = 0.0, 0.0, list[JointPath](), list[float](), list[Array]()
    for part, following, corner in zip(run, [*run[1:], None], [*corners, None], strict=True):
        path = _of_unit_speed(part, limits)
        pieces.append(_between(path, begins, path.length if corner is None else corner.begins))
        caps.append(_caps(arm, pieces[-1], part.move, limits))
        at += pieces[-1].length
        if corner is not None and following is not None:
            bend, begins = corner.bend.in_pieces(corner.bend.length / BEND_PIECES)[0], corner.ends
            pieces.append(bend)
            caps.append(np.minimum(_caps(arm, bend, part.move, limits), _caps(arm, bend, following.move, limits)))
            ends.append(at + 0.5 * bend.length)
            at += bend.length
    ends.append(at)
    steps, cap = np.concatenate([np.diff(path.breakpoints) for path in pieces]), np.concatenate(caps)
    breakpoints = np.concatenate([[0.0], np.cumsum(steps)])
    whole = JointPath(breakpoints, side_by_side([path.coefficients for path in pieces]))
    return whole, np.array(ends), cap if np.isfinite(cap).any() else None


def _of_unit_speed(part: PathPart, limits: JointLimits) -> JointPath:
    """Return the part's path by a parameter that counts the least time at full velocity. So corners round evenly.

    A straight path is cut into pieces where the tool's speed is limited.
    """
    path = part.path
    assert path is not None
    points = path(path.breakpoints)
    length = float(efforts(points[:-1], points[1:], limits.velocity).sum()) / path.length
    scaled = JointPath(path.breakpoints * length, rescaled(path.coefficients, 1.0 / length))
    if len(path.breakpoints) > 2 or (part.move.linear_speed is None and part.move.angular_speed is None):
        return scaled
    return scaled.in_pieces(scaled.length / STRAIGHT_PIECES)[0]


def _caps(arm: Arm, path: JointPath, move: Move, limits: JointLimits) -> Array:
    """Return the greatest ṡ on each piece (m,) by the move's speeds of joints and tool."""
    cap = np.full(len(path.breakpoints) - 1, np.inf)
    with np.errstate(divide="ignore"):
        if move.velocity_scaling < 1.0:
            _, rates = extremes(derivative(path.coefficients), np.diff(path.breakpoints))
            cap = move.velocity_scaling / (np.abs(rates) / limits.velocity).max(axis=(0, 2))
        if move.linear_speed is not None or move.angular_speed is not None:
            most = [np.inf if speed is None else speed for speed in (move.linear_speed, move.angular_speed)]
            for speed, greatest in zip(most, greatest_tool_speeds(arm, path), strict=True):
                cap = np.minimum(cap, speed / greatest)
    return cap


def greatest_tool_speeds(arm: Arm, path: JointPath) -> tuple[Array, Array]:
    """Return ‖p'‖ [m] and ‖ω‖ [rad] by s that the tool does not exceed on each piece, (m,) each.

    Between samples a distance d apart, a vector v(s) is within d² max ‖v''‖ / 8 of the chord. The second differences of
    the samples are d² v''. Half as much again allows for its change from sample to sample.
    """
    steps = np.diff(path.breakpoints)
    piece = np.repeat(np.arange(len(steps)), SPEED_SAMPLES + 1)
    sigma = (steps[:, None] * np.linspace(0.0, 1.0, SPEED_SAMPLES + 1)).ravel()
    theta, rate = (path.within(piece, sigma, order) for order in (0, 1))
    twist = (arm.body_jacobian(theta) @ rate[..., None])[..., 0].reshape(len(steps), -1, 2, 3)
    bend = np.linalg.norm(np.diff(twist, 2, axis=1), axis=-1).max(axis=1)
    linear, angular = (np.linalg.norm(twist, axis=-1).max(axis=1) + 1.5 * bend / 8.0).T
    return linear, angular


def _rounded(
    arm: Arm, before: JointPath, after: JointPath, radius: float, shares: Sequence[float], limits: JointLimits
) -> Corner | None:
    """Return the corner inside these shares of two paths. None: no rounding fits, or the tool stays in one place.

    The rounding is a quintic with position and two derivatives of both paths (Lynch & Park §9.2.2.1). So the whole is
    C². It shrinks until it stays inside the ball and the position limits.
    """
    centre = arm.fk(before.end)[:3, 3]
    if any(
        _distance(arm, path, np.linspace(0.0, path.length, SAMPLES), centre).max() < LEAST for path in (before, after)
    ):
        return None
    for scale in SMALLER ** np.arange(SHRINKS):
        left, joined = (before.length * (1.0 - scale * shares[0]), after.length * scale * shares[1])
        begins = _leaves_ball(arm, before, radius * scale, before.length, left)
        ends = _leaves_ball(arm, after, radius * scale, 0.0, joined)
        t = np.array([0.0, before.length - begins + ends])
        states = (np.stack([before(begins, order), after(ends, order)]) for order in range(3))
        bend = JointPath(t, through(t, *states))
        # The Bernstein coefficients bound the bend at once. Near a limit its extremes decide.
        bounds = (values(bend.coefficients, t[1:]) for values in (bernstein, lambda *piece: extremes(*piece)[1]))
        inside = any(farthest_outside(values, limits)[1] <= POSITION_TOL for values in bounds)
        if inside and _distance(arm, bend, np.linspace(0.0, bend.length, SAMPLES), centre).max() <= radius:
            return Corner(begins, bend, ends)
    return None


def _leaves_ball(arm: Arm, path: JointPath, radius: float, begin: float, end: float) -> float:
    """Where the tool first leaves the ball about its place at `begin`, or `end` if it does not."""
    centre = arm.fk(path(begin))[:3, 3]
    for _ in range(1 + REFINED):
        s = np.linspace(begin, end, SAMPLES)
        outside = _distance(arm, path, s, centre) > radius
        if not outside.any():
            break
        first = max(int(outside.argmax()), 1)
        begin, end = float(s[first - 1]), float(s[first])
    return begin if outside.any() else end


def _distance(arm: Arm, path: JointPath, s: Array, centre: Array) -> Array:
    return np.linalg.norm(arm.fk(path(s))[..., :3, 3] - centre, axis=-1)


def _between(path: JointPath, begins: float, ends: float) -> JointPath:
    """Return the path between two values of its parameter, as a path that begins at 0."""
    rounding = ROUNDING * path.length
    inner = path.breakpoints[(path.breakpoints > begins + rounding) & (path.breakpoints < ends - rounding)]
    breakpoints = np.concatenate([[begins], inner, [ends]])
    piece = path.piece_at(0.5 * (breakpoints[1:] + breakpoints[:-1]))
    moved = shifted(path.coefficients[:, piece], breakpoints[:-1] - path.breakpoints[piece])
    return JointPath(breakpoints - begins, moved)
