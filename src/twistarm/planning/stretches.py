"""Stretches: what lies between two stops of a motion, as one joint path with rounded corners."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arm.arm import Arm
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError
from .cartesian.tool_derivatives import greatest_tool_speeds
from .corners import joined, part, rounded
from .joint_path import JointPath
from .piecewise import derivative, extremes
from .route import Leg, path_effort
from .segments import Move, place

BEND_PIECES = 8
"""Of a rounded corner: each has its own greatest speed."""

STRAIGHT_PIECES = 32
"""A straight joint path is cut into so many where the tool's speed is limited."""


@dataclass(frozen=True, eq=False)
class Stretch:
    """What lies between two stops: legs `first` to `last`, their paths and roundings one after the other.

    `ends` (last − first + 1,): where on the path each leg ends, a rounded one in the middle of its rounding. `ceiling`
    (m,) is the greatest ṡ on each piece, None where there is none.
    """

    first: int
    last: int
    path: JointPath
    ends: Array
    ceiling: Array | None


def runs(legs: list[Leg]) -> Iterator[list[Leg]]:
    """The legs from one stop that was asked for to the next, in order; about one that goes nowhere the arm stops."""
    i = 0
    while i < len(legs):
        run = [legs[i]]
        while isinstance(run[-1].segment, Move) and run[-1].segment.blend and run[-1].path is not None:
            if legs[i + len(run)].path is None:
                break
            run.append(legs[i + len(run)])
        yield run
        i += len(run)


def stretch_along(arm: Arm, run: list[Leg], limits: JointLimits) -> Stretch:
    """The stretch along legs with the corners between them rounded; InputError where a blend does not fit."""
    first, last = run[0].index, run[-1].index
    if run[0].path is None and len(run) == 1:
        return Stretch(first, last, JointPath(np.zeros(2), run[0].end[None, None]), np.zeros(1), None)
    paths = [_of_unit_speed(leg, limits) for leg in run]
    begins, parts, ends, caps = 0.0, [], [], []
    at = 0.0
    for k, (leg, path) in enumerate(zip(run, paths, strict=True)):
        segment = leg.segment
        assert isinstance(segment, Move)
        bend = None
        finishes = path.length
        if k + 1 < len(run):
            bend = rounded(arm, path, paths[k + 1], segment.blend, limits)
            if bend is None or bend[0] <= begins:
                raise InputError(_too_large(arm, leg, path, paths[k + 1], begins))
            finishes = bend[0]
        own = part(path, begins, finishes)
        parts.append(own)
        caps.append(_caps(arm, own, segment, limits))
        at += own.length
        if bend is not None:
            following = run[k + 1].segment
            assert isinstance(following, Move)
            bend = bend[0], bend[1].in_pieces(bend[1].length / BEND_PIECES)[0], bend[2]
            parts.append(bend[1])
            caps.append(np.minimum(_caps(arm, bend[1], segment, limits), _caps(arm, bend[1], following, limits)))
            ends.append(at + 0.5 * bend[1].length)
            at += bend[1].length
            begins = bend[2]
    ends.append(at)
    cap = np.concatenate(caps)
    return Stretch(first, last, joined(parts), np.array(ends), cap if np.isfinite(cap).any() else None)


def _too_large(arm: Arm, leg: Leg, path: JointPath, following: JointPath, begins: float) -> str:
    """The words for a corner that finds no room on the paths beside it."""
    segment = leg.segment
    assert isinstance(segment, Move)
    corner = arm.fk(path.end)[:3, 3]
    room = min(float(np.linalg.norm(arm.fk(each)[:3, 3] - corner)) for each in (path(begins), following.end))
    return (
        f"the blend of {place(leg.index, segment)}, {segment.blend:g} m, does not fit between its "
        f"neighbours: the tool is at most {room:.3g} m from that corner on the paths beside it: make it smaller, or 0 "
        "to stop there"
    )


def _of_unit_speed(leg: Leg, limits: JointLimits) -> JointPath:
    """The leg's path with a parameter that counts the least time at the greatest velocities, so that corners round
    evenly; a straight one is cut into pieces where the tool's speed is limited.
    """
    path, segment = leg.path, leg.segment
    if path is None:
        raise InputError(f"{place(leg.index, segment)} does not move: there is no corner to blend")
    assert isinstance(segment, Move)
    length = path_effort(path, limits) / path.length
    powers = np.arange(len(path.coefficients) - 1, -1, -1.0)
    scaled = JointPath(path.breakpoints * length, path.coefficients / length ** powers[:, None, None])
    if len(path.breakpoints) > 2 or (segment.tool_speed is None and segment.turn_speed is None):
        return scaled
    return scaled.in_pieces(scaled.length / STRAIGHT_PIECES)[0]


def _caps(arm: Arm, path: JointPath, segment: Move, limits: JointLimits) -> Array:
    """The greatest ṡ on each piece (m,) by the segment's share of joint velocities and its speeds of the tool."""
    cap = np.full(len(path.breakpoints) - 1, np.inf)
    with np.errstate(divide="ignore"):
        if segment.speed < 1.0:
            _, rates = extremes(derivative(path.coefficients), np.diff(path.breakpoints))
            cap = segment.speed / (np.abs(rates) / limits.velocity).max(axis=(0, 2))
        if segment.tool_speed is not None or segment.turn_speed is not None:
            most = [np.inf if speed is None else speed for speed in (segment.tool_speed, segment.turn_speed)]
            for speed, greatest in zip(most, greatest_tool_speeds(arm, path, limits, *most), strict=True):
                cap = np.minimum(cap, speed / greatest)
    return cap
