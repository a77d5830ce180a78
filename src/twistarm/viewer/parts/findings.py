"""The doctor's findings for the pages, gravest first, each with its node of the scene."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any, get_args

from ...arm.arm import Arm
from ...checking.doctor import examine_arm
from ...description.findings import Finding, Place, Severity
from ...support.errors import one_line, without_places
from ..protocol.messages import LONGEST_NAME, Message
from ..scene.drawing import link_path, screw_path

MAX_FINDINGS = 500
"""Most findings on the page. The rest is counted."""

PENDING = "From the loading alone: the doctor looks while no servo drives."


def loaded(arm: Arm) -> Message:
    """What the loading noted, until the doctor has looked."""
    return _message(arm, arm.findings, PENDING if arm.description is not None else "")


def examined(arm: Arm) -> Message:
    """The doctor's findings, or those of loading without a description or if the doctor fails."""
    if arm.description is None:
        return _message(arm, arm.findings, "")
    try:
        found = examine_arm(arm).findings
    except Exception as error:  # whatever ails the doctor, the page lives, and says so
        reason = str(error) or type(error).__name__
        failed = one_line(f"From the loading alone: the doctor failed: {reason}")
        return _message(arm, arm.findings, without_places(failed, arm.description.path))
    return _message(arm, found, "")


def node_of(arm: Arm, place: Place) -> str | None:
    """The node of the link or joint at `place`: a screw for a joint of the chain, else a link."""
    name = place.name
    joints, links = ({}, {}) if arm.description is None else (arm.description.joints, arm.description.links)
    if place.element == "link" and name in links:
        return link_path(name)
    if place.element != "joint":
        return None
    for i, moving in enumerate(arm.moving_names):
        if name == moving or (moving in joints and name == joints[moving].part_of):  # a planar joint is its first part
            return screw_path(i)
    return link_path(joints[name].child) if name in joints else None


def _message(arm: Arm, findings: Iterable[Finding], note: str) -> Message:
    """{"type": "findings", "findings": [...], "counts": {severity: how many}, "note": text}, gravest first."""
    severities = get_args(Severity)
    ordered = sorted(findings, key=lambda one: severities.index(one.severity), reverse=True)
    more = f"{len(ordered) - MAX_FINDINGS} more: twistarm doctor lists them." if len(ordered) > MAX_FINDINGS else ""
    return {
        "type": "findings",
        "findings": [_finding_fields(arm, one) for one in ordered[:MAX_FINDINGS]],
        "counts": dict(Counter(one.severity for one in ordered)),
        "note": " ".join(part for part in (note, more) if part),
    }


def _finding_fields(arm: Arm, found: Finding) -> dict[str, Any]:
    """A finding as plain text. Its node is null if it concerns no single link or joint."""
    node = node_of(arm, found.place)
    here = None if arm.description is None else arm.description.path
    return {
        "severity": found.severity,
        "code": found.code,
        "place": without_places(str(found.place), here),
        "what": without_places(found.what, here),
        "remedy": without_places(found.remedy, here),
        "node": node,
        "name": one_line(found.place.name, LONGEST_NAME) if node else "",
    }
