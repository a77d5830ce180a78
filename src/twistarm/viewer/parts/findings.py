"""The doctor's findings as the page is told of them: gravest first, each with the node of the scene it points at."""

from __future__ import annotations

import asyncio
import threading
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, get_args

from ...arm.arm import Arm
from ...checking.doctor import examine_arm
from ...description.findings import Finding, Place, Severity
from ...description.meshes import MeshReader
from ...support.errors import one_line
from ...support.path_redaction import without_places
from ..protocol.messages import LONGEST_NAME, Message
from ..scene.nodes import link_path, screw_path

MOST = 500
"""Findings on the page; nobody reads more, and the rest is counted."""

PATIENCE = 0.5
"""Seconds."""

PENDING = "From the loading alone: the doctor looks while no servo drives."


def loaded(arm: Arm) -> Message:
    """What the loading noted, until the doctor has looked."""
    return _message(arm, arm.findings, PENDING if arm.description is not None else "")


def examined(arm: Arm, reader: MeshReader | None = None) -> Message:
    """What the doctor finds; of an arm without a description, and where the doctor fails, what the loading noted.

    reader: who has read the arm's meshes.
    """
    if arm.description is None:
        return _message(arm, arm.findings, "")
    try:
        found = examine_arm(arm, reader).findings
    except Exception as error:  # whatever ails the doctor, the page lives, and says so
        reason = str(error) or type(error).__name__
        failed = one_line(f"From the loading alone: the doctor failed: {reason}")
        return _message(arm, arm.findings, without_places(failed, arm.description.path))
    return _message(arm, found, "")


def node_of(arm: Arm, place: Place) -> str | None:
    """The node of the link or joint at `place`: a joint of the chain has its screw, any other the link it carries."""
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


class Examination:
    """The doctor at work in a thread of its own, once: `tell` is called from there with the message."""

    def __init__(self, arm: Arm, reader: MeshReader, tell: Callable[[Message], None]) -> None:
        self._begun = arm.description is None
        self._reader = reader
        self._thread = threading.Thread(target=lambda: tell(examined(arm, reader)), name="twistarm doctor", daemon=True)

    async def wait(self, calm: Callable[[], bool]) -> None:
        """Begin when it has been `calm` for PATIENCE: a page that loads and a servo that drives would be delayed."""
        before = False
        while not (before and calm()):
            before = calm()
            await asyncio.sleep(PATIENCE)
        self.begin()

    def begin(self) -> None:
        """Start unless that was done, or the loading has said everything; returns at once."""
        if not self._begun:
            self._begun = True
            self._thread.start()

    def join(self, timeout: float) -> None:
        """Wait until it has ended, or `timeout` [s]: but for what is being read, the doctor cannot be interrupted."""
        self._reader.close()
        if self._thread.is_alive():
            self._thread.join(timeout)


def _message(arm: Arm, findings: Iterable[Finding], note: str) -> Message:
    """{"type": "findings", "findings": [...], "counts": {severity: how many}, "note": text}, gravest first."""
    severities = get_args(Severity)
    ordered = sorted(findings, key=lambda one: severities.index(one.severity), reverse=True)
    more = f"{len(ordered) - MOST} more: twistarm doctor lists them." if len(ordered) > MOST else ""
    return {
        "type": "findings",
        "findings": [_finding_fields(arm, one) for one in ordered[:MOST]],
        "counts": dict(Counter(one.severity for one in ordered)),
        "note": " ".join(part for part in (note, more) if part),
    }


def _finding_fields(arm: Arm, found: Finding) -> dict[str, Any]:
    """A finding in plain text; node null where it is about no single link or joint of the arm."""
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
