"""Followers outside the chain (fingers, mostly) that their masters drive beyond their own limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ...description.coupling import Affine
from ...description.findings import Finding, finding
from ...description.tree import Description

SLACK = 1e-3
"""[rad, m]: limits that were rounded miss each other by less."""


def check_mimics(
    description: Description, couplings: Mapping[str, Affine], chain: tuple[str, ...]
) -> Iterator[Finding]:
    """A follower's range of motion against its limits; the walk has checked those in the chain."""
    for name, affine in couplings.items():
        follower = description.joints[name]
        if name in chain or affine.master in (None, name):
            continue
        master = description.joints[str(affine.master)]
        low, high = sorted(affine.multiplier * bound + affine.offset for bound in (master.lower, master.upper))
        if low < follower.lower - SLACK or high > follower.upper + SLACK:
            yield finding(
                "mimic-outside-limits",
                description.place(follower),
                f"{master.name} drives it through [{low:.4g}, {high:.4g}], beyond its own limits "
                f"[{follower.lower:.4g}, {follower.upper:.4g}], which are not kept",
                "make both joints' limits fit the mimic's multiplier and offset",
            )
