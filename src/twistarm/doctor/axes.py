"""Axes of neighbouring joints that are parallel, square or meeting but for a little: CAD exports round.

The angle and the distance between neighbouring axes are constants of the arm. Closed forms of inverse kinematics need
them exact: an arm with rpy="1.5708" has none of the special geometries it was drawn with.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..description.findings import Finding, finding
from ..model.arm import Arm
from ..support.checks import Array
from .source_text import SourceText
from .wording import place_of

EXACT_ANGLE, EXACT_DISTANCE = 1e-9, 1e-9
"""[rad], [m]: numbers written in full are nearer."""

ALMOST_ANGLE, ALMOST_DISTANCE = math.radians(0.5), 2e-3
"""[rad], [m]: further apart is on purpose."""

SHOWN = 4
"""Kinds of deviation named before the rest is counted."""

SHOWN_WORDS = 3
"""Rounded angles named, for each exact one, before the rest is counted."""


@dataclass(frozen=True)
class Near:
    """Something that almost holds for some joints: what, by how much, and how far that moves the tool [m], roughly.

    `apart`: it is a distance that misses, not an angle.
    """

    joints: str
    what: str
    moves: float
    apart: bool = False


def check_axes(arm: Arm) -> Iterator[Finding]:
    """One finding for all neighbouring axes, and the three of a wrist, that are almost but not quite special."""
    found = almost_special(arm)
    if not found:
        return
    yield finding(
        "axes-almost-exact",
        place_of(arm.description, arm.name),
        f"{_listed(found)}; taken as exact, the tool is off by some {_length(sum(near.moves for near in found))}",
        rewriting(arm, apart=any(near.apart for near in found)),
    )


def _listed(found: list[Near]) -> str:
    """What almost holds, each with the joints it holds for."""
    joints: dict[str, list[str]] = {}
    for near in found:
        joints.setdefault(near.what, []).append(near.joints)
    parts = [f"{', '.join(names)} {what}" for what, names in joints.items()]
    more = f"; and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
    return "; ".join(parts[:SHOWN]) + more


def almost_special(arm: Arm) -> list[Near]:
    """Neighbouring axes first, base to tip, then the wrist."""
    v, w = arm.screws[:3].T, arm.screws[3:].T
    turning = np.linalg.norm(w, axis=1) > 0.5
    axes = np.where(turning[:, None], w, v)
    points = np.cross(w, v)
    found: list[Near] = []
    for i, j in pairwise(range(len(axes))):
        both = bool(turning[i] and turning[j])
        names = f"{arm.moving_names[i]}–{arm.moving_names[j]}"
        near = _pair(axes[i], axes[j], points[j] - points[i] if both else None, arm.reach)
        found += [Near(names, *one) for one in near]
    return found + _wrist(arm, axes, points, turning)


def _pair(a: Array, b: Array, offset: Array | None, reach: float) -> Iterator[tuple[str, float, bool]]:
    """What almost holds for two axes, how far off the tool is if it is meant, and whether it is a distance.

    `offset` lies between turning ones.
    """
    sine, cosine = float(np.linalg.norm(np.cross(a, b))), abs(float(a @ b))
    for what, angle in (("parallel", math.atan2(sine, cosine)), ("square", math.atan2(cosine, sine))):
        if EXACT_ANGLE < angle < ALMOST_ANGLE:
            yield f"are {what} but for {_angle(angle)}", angle * reach, False
    if offset is None:
        return
    parallel = math.atan2(sine, cosine) < ALMOST_ANGLE
    distance = float(np.linalg.norm(np.cross(offset, a))) if parallel else abs(float(offset @ np.cross(a, b))) / sine
    if EXACT_DISTANCE < distance < ALMOST_DISTANCE:
        yield f"{'coincide' if parallel else 'meet'} but for {_length(distance)}", distance, True


def _wrist(arm: Arm, axes: Array, points: Array, turning: Array) -> list[Near]:
    """Whether the last three axes, all turning, meet in almost one point while each neighbouring pair meets exactly."""
    if len(axes) < 3 or not turning[-3:].all():
        return []
    across = np.eye(3) - axes[-3:, :, None] * axes[-3:, None, :]
    total = across.sum(axis=0)
    if np.linalg.eigvalsh(total)[0] < ALMOST_ANGLE**2:
        return []
    centre = np.linalg.solve(total, np.einsum("kij,kj->i", across, points[-3:]))
    distance = float(np.linalg.norm(np.einsum("kij,kj->ki", across, centre - points[-3:]), axis=1).max())
    if not EXACT_DISTANCE < distance < ALMOST_DISTANCE:
        return []
    what = f"are a spherical wrist but for {_length(distance)}"
    return [Near("–".join(arm.moving_names[-3:]), what, distance, apart=True)]


def rewriting(arm: Arm, *, apart: bool) -> str:
    """The rounded angles of the chain's origins, as they are written, with what to write instead, if there are such."""
    rounded: dict[str, list[str]] = {}
    for word in _rounded_words(arm):
        exact = abs(_quarter_turns(float(word)) or 0.0)
        rounded.setdefault(f"{exact!r}" if exact else "0", []).append(word)
    if not rounded:
        return "if the drawing says so, write the chain's origins and axes with 16 digits"
    given = "; ".join(f"{exact} for {_shown(words)}" for exact, words in rounded.items())
    left = "; a distance that is left then stands in <origin xyz>, or is meant" if apart else ""
    return f"write {given} in <origin rpy>{left}"


def _shown(words: list[str]) -> str:
    more = len(words) - SHOWN_WORDS
    return ", ".join(words[:SHOWN_WORDS]) + (f" and {more} more as near to it" if more > 0 else "")


def _rounded_words(arm: Arm) -> list[str]:
    """Each word of the chain's rpy that is a multiple of a quarter turn but for rounding, once and without its sign."""
    if arm.description is None:
        return []
    chain = {joint.name for joint in arm.description.chain(arm.base, arm.tip_link)}
    joints = SourceText(arm.description.text).robot.findall("joint")
    origins = [joint.find("origin") for joint in joints if joint.get("name") in chain]
    words = [word for origin in origins if origin is not None for word in origin.get("rpy", "").split()]
    return list(dict.fromkeys(word.lstrip("+-") for word in words if _quarter_turns(float(word)) is not None))


def _quarter_turns(angle: float) -> float | None:
    """The multiple of a quarter turn that `angle` is but for rounding."""
    near = round(angle / (math.pi / 2)) * (math.pi / 2)
    return near if EXACT_ANGLE < abs(angle - near) < ALMOST_ANGLE else None


def _angle(radians: float) -> str:
    return f"{math.degrees(radians):.2g}°" if radians > 1e-4 else f"{radians:.1e} rad"


def _length(metres: float) -> str:
    return f"{1e3 * metres:.2g} mm" if metres >= 1e-5 else f"{1e6 * metres:.2g} µm" if metres >= 1e-8 else "nothing"
