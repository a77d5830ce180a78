"""PathError: how far a path can be followed, why no farther, and what would help."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..arm.arm import Arm
from ..ik.answer import StopReason
from ..ik.solution import IKResult
from ..ik.solve import solve_ik
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import TwistarmError
from ..support.messages import Posture, Quantity, Text
from ..support.units import length_hint
from .configurations import LONGEST_JUMP, branches
from .following import Blocked, Node, climb, follow, way
from .piecewise import JointPath

AT_LIMIT = 0.01  # A joint nearer to its limit than this [rad, m] at the end of a path is at the limit.
MORE_ROOM = 0.5  # Extra room [rad, m] for a joint, to see whether its limit blocks the path.
# A configuration is nearly singular below this least singular value, with metres divided by the arm's reach.
SINGULAR = 0.05

CERTAIN = "; no configuration inside the limits meets it farther on, that is certain"

MAX_OTHER_STARTS = 2  # Other configurations from which the path may be followed that are tried.


class PathError(TwistarmError):
    """A path that the arm cannot follow to its end.

    `share`: the part of the segment that it can follow, in [0, 1); of a curve that of the tool's path, also to a
    collision. It is 0 if no free path was found. `theta` (n,): the configuration there. `reason`: "limit",
    "leap" (to another configuration), "singular", "out of reach" or "impossible direction". In a scene it may be
    "collision", or "not kept" if start or goal does not meet a `Keep`. `joint`: the joint at its limit, or None.
    `start` (n,): another configuration from which the whole path can be followed, or None. `segment`: the index of the
    segment in the motion, with `place` in words. `detail`: the message without the place.
    """

    def __init__(
        self,
        message: str,
        share: float = 0.0,
        theta: Array | None = None,
        reason: str = "",
        joint: str | None = None,
        start: Array | None = None,
        segment: int | None = None,
        place: str = "",
    ) -> None:
        super().__init__(Text("{place}: {message}", place=place, message=message) if place else message)
        self.detail, self.share, self.theta, self.reason = message, share, theta, reason
        self.joint, self.start, self.segment, self.place = joint, start, segment, place

    def __reduce__(self) -> tuple[type[PathError], tuple[Any, ...]]:
        known = self.share, self.theta, self.reason, self.joint, self.start, self.segment, self.place
        return type(self), (self.detail, *known)


def refusal(arm: Arm, limits: JointLimits, blocked: Blocked, segment: int, place: str, *, others: bool) -> PathError:
    """Return the error for a blocked path. With `others`, other configurations are tried as a remedy too."""
    node, moving = blocked.node, blocked.node.moving
    beyond = None  # the nearest solution farther on, if the path ends because there is none
    if not blocked.leap:
        beyond = solve_ik(arm, moving.at(blocked.ahead), node.theta, **moving.tolerances.keywords)
    certain = beyond is not None and beyond.certain
    reason, joint, why = _why(arm, blocked, beyond)
    start = _other_start(arm, limits, blocked) if others and not certain else None
    remedy = "make it shorter, or move its ends"
    if reason == "impossible direction":
        remedy = f"leave rotations free by an Approach, a TolerancedPose or a Position; or {remedy}"
    if start is not None:
        posture = Posture(tuple(start.tolist()), arm.units)
        remedy = Text(
            "begin it in another configuration, {posture}, from which all of it can be followed", posture=posture
        )
    curve = moving.curve
    whole, unit = (curve.length, "m") if curve.length >= 1e-9 else (curve.angle, "rad")
    hint = length_hint(float(np.linalg.norm(curve(np.array(1.0))[:3, 3])), arm.reach)
    what = Text(
        "the tool follows the path for {part} of {whole} ({percent} %) and no farther: {why}{certain}{hint}: {remedy}",
        part=Quantity(node.s * whole, unit, 3),
        whole=Quantity(whole, unit, 3),
        percent=min(round(100.0 * node.s), 99),
        why=why,
        certain=CERTAIN * certain,
        hint=f" ({hint})" if hint else "",
        remedy=remedy,
    )
    return PathError(what, node.s, node.theta, reason, joint, start, segment, place)


def _why(arm: Arm, blocked: Blocked, beyond: IKResult | None) -> tuple[str, str | None, str]:
    """Return reason, joint and words. The reason is a limit if the arm could go on with more room at that joint."""
    theta, limits = blocked.node.theta, arm.limits
    room = np.minimum(theta - limits.lower, limits.upper - theta)
    tight = [int(j) for j in np.argsort(room) if room[j] < AT_LIMIT]
    for held in [*([j] for j in tight), *([tight] if len(tight) > 1 else [])]:
        if _goes_on(arm, blocked, held):
            j, name = held[0], arm.joint_names[held[0]]
            side = "lower" if theta[j] - limits.lower[j] < limits.upper[j] - theta[j] else "upper"
            limit = Quantity(float(getattr(limits, side)[j]), arm.units[j])
            words = Text("joint {joint!r} comes to its {side} limit {limit}", joint=name, side=side, limit=limit)
            return "limit", name, words
    if beyond is None or beyond.converged:
        leap = "the arm would have to leap to another configuration"
        if float(arm.manipulability(theta).singular_values[-1]) < SINGULAR:
            return "singular", None, f"at a singular configuration, {leap}"
        return "leap", None, leap
    if beyond.stop is StopReason.BLOCKED_BY_LIMITS:
        return "limit", None, "the limits of the joints leave no configuration that meets it farther on"
    if beyond.stop is StopReason.IMPOSSIBLE_DIRECTION:
        return "impossible direction", None, beyond.stop.value
    return "out of reach", None, "the path leaves the arm's reach there"


def _goes_on(arm: Arm, blocked: Blocked, joints: list[int]) -> bool:
    """Tell whether the arm would follow the path farther if these joints had more room."""
    node, more = blocked.node, np.zeros(arm.n)
    more[joints] = MORE_ROOM
    roomy = replace(arm.limits, lower=arm.limits.lower - more, upper=arm.limits.upper + more)
    target, tolerances = node.moving.at(blocked.ahead), node.moving.tolerances.keywords
    beyond = solve_ik(replace(arm, limits=roomy), target, node.theta, **tolerances, restarts=1)
    return beyond.converged and float(np.abs(beyond.theta - node.theta).max()) <= LONGEST_JUMP


def _other_start(arm: Arm, limits: JointLimits, blocked: Blocked) -> Array | None:
    """Return another configuration at the beginning from which the arm can follow the whole path."""
    moving = blocked.node.moving
    starts = branches(arm, moving.at(0.0), blocked.start, moving.tolerances)
    found = climb(arm, limits, [Node(moving, 0.0, theta, 0.0) for theta in starts]) if len(starts) else []
    ways = [] if isinstance(found, Blocked) else [way(node) for node in found[:MAX_OTHER_STARTS]]
    return next((nodes[0].theta for nodes in ways if isinstance(follow(arm, nodes), JointPath)), None)
