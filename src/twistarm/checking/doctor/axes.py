"""Axes that are almost exact, or nearly have a closed form, with the rounded numbers of the file."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...arm.almost_exact import (
    ALMOST_ANGLE,
    EXACT_ANGLE,
    ORIENTATION_ROUNDING,
    POSITION_ROUNDING,
    Near,
    almost_exact,
    length_in_words,
)
from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...description.source_text import SourceText
from ...ik import closed_form_of
from .wording import place_of

SHOWN = 4
"""Kinds of deviation named before the rest is counted."""

SHOWN_WORDS = 3
"""Rounded angles named, for each exact one, before the rest is counted."""


def check_axes(arm: Arm) -> Iterator[Finding]:
    """One finding for all neighbouring axes, and the three of a wrist, that are almost special."""
    found = almost_exact(arm.screws, arm.home, arm.moving_names, arm.reach)
    if not found:
        return
    yield finding(
        "axes-almost-exact",
        place_of(arm.description, arm.name),
        f"{_listed(found)}; taken as exact, the tool is off by some "
        f"{length_in_words(sum(near.moves for near in found))}; inverse kinematics allows for up to "
        f"{length_in_words(POSITION_ROUNDING)} and {math.degrees(ORIENTATION_ROUNDING):.1g}° of it, and says so",
        rewriting(arm, apart=any(near.apart for near in found)),
    )


def check_closed_form(arm: Arm) -> Iterator[Finding]:
    """One finding if the axes just miss a family, by what looks like rounding; none for arms of another build."""
    report = closed_form_of(arm)
    if not report.nearly or report.held:
        return
    yield finding(
        "closed-form-missed",
        place_of(arm.description, arm.name),
        f"{report.miss}: a {report.target} has no exact closed form; solve_ik_all corrects the answers of the nearest "
        "exact arm, and cannot say whether these are all",
        f"{rewriting(arm, apart=False)}; exact axes give every configuration, and the proof that a target has none",
    )


def _listed(found: list[Near]) -> str:
    """What almost holds, each with the joints it holds for."""
    joints: dict[str, list[str]] = {}
    for near in found:
        joints.setdefault(near.what, []).append(near.joints)
    parts = [f"{', '.join(names)} {what}" for what, names in joints.items()]
    more = f"; and {len(parts) - SHOWN} more" if len(parts) > SHOWN else ""
    return "; ".join(parts[:SHOWN]) + more


def rewriting(arm: Arm, *, apart: bool) -> str:
    """The rounded angles in the chain's origins and their exact text, if any."""
    rounded: dict[str, list[str]] = {}
    for word in _rounded_words(arm):
        exact = abs(_quarter_turns(float(word)) or 0.0)
        rounded.setdefault(f"{exact!r}" if exact else "0", []).append(word)
    if not rounded:
        return "if the drawing says so, write the chain's origins and axes with 16 digits"
    given = "; ".join(f"{exact} for {_shown(words)}" for exact, words in rounded.items())
    left = "; a remaining distance is then in <origin xyz>, or intended" if apart else ""
    return f"write {given} in <origin rpy>{left}"


def _shown(words: list[str]) -> str:
    more = len(words) - SHOWN_WORDS
    return ", ".join(words[:SHOWN_WORDS]) + (f" and {more} more as near to it" if more > 0 else "")


def _rounded_words(arm: Arm) -> list[str]:
    """Each rpy word of the chain that is a rounded multiple of a quarter turn, once and without its sign."""
    if arm.description is None:
        return []
    chain = {joint.name for joint in arm.description.chain(arm.base, arm.tip_link)}
    joints = SourceText(arm.description.text).robot.findall("joint")
    origins = [joint.find("origin") for joint in joints if joint.get("name") in chain]
    words = [word for origin in origins if origin is not None for word in origin.get("rpy", "").split()]
    return list(dict.fromkeys(word.lstrip("+-") for word in words if _quarter_turns(float(word)) is not None))


def _quarter_turns(angle: float) -> float | None:
    """The multiple of a quarter turn that `angle` rounds."""
    near = round(angle / (math.pi / 2)) * (math.pi / 2)
    return near if EXACT_ANGLE < abs(angle - near) < ALMOST_ANGLE else None
