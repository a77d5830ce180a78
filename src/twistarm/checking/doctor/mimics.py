"""Followers outside the chain (fingers, mostly) that their masters drive beyond their own limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...description.coupling import Affine
from ...description.findings import Finding, finding
from ...description.tree import Description, Joint

SLACK = 1e-3
"""[rad, m]: limits that were rounded miss each other by less."""


def check_mimics(
    description: Description, couplings: Mapping[str, Affine], chain: tuple[str, ...]
) -> Iterator[Finding]:
    """A follower's range of motion against its own limits; those in the chain were looked at when it was walked."""
    for name, affine in couplings.items():
        follower = description.joints[name]
        if name not in chain and affine.master not in (None, name):
            yield from _follower(description, follower, description.joints[str(affine.master)], affine)


def _follower(description: Description, follower: Joint, master: Joint, affine: Affine) -> Iterator[Finding]:
    ends = affine.multiplier * np.array([master.lower, master.upper]) + affine.offset
    low, high = float(ends.min()), float(ends.max())
    if low >= follower.lower - SLACK and high <= follower.upper + SLACK:
        return
    yield finding(
        "mimic-outside-limits",
        description.place(follower),
        f"{master.name} drives it through [{low:.4g}, {high:.4g}], beyond its own limits "
        f"[{follower.lower:.4g}, {follower.upper:.4g}], which are not kept",
        "make both joints' limits fit the mimic's multiplier and offset",
    )
