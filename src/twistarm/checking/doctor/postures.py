"""Singular configurations among those that programs start from, and a better one."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...arm.arm import Arm
from ...description.findings import Finding, finding
from ...support.checks import Array
from .wording import place_of, toml_table

SINGULAR = 1e3
"""A condition number beyond which a configuration is singular in practice: one direction a thousand times slower."""

POOR = 100.0
"""A ready pose worse than this is worth a word, if there is one that is ten times better."""


def check_postures(arm: Arm, rank: int) -> Iterator[Finding]:
    """Zero, home and ready pose: the condition number of the `rank` directions of the arm's tool.

    A singular home that is also the ready pose is a remark, not a warning, because most arms are delivered so.
    """
    at_ready = _condition(arm, arm.ready, rank)
    place = place_of(arm.description, arm.name)
    homes = _homes(arm)
    conditions = {pose: _condition(arm, theta, rank) for pose, theta in homes.items()}
    singular = {pose: number for pose, number in conditions.items() if number > SINGULAR}
    poor = at_ready > POOR
    if not (poor or singular):
        return
    best = arm.computed_ready
    at_best = _condition(arm, best, rank)
    said = f"say in arm.toml (condition number {at_best:.1f}; look at it first, twistarm view):\n"
    snippet = said + toml_table("poses.ready", arm.theta_to_dict(best))
    if poor and at_best < at_ready / 10 and not any(np.array_equal(arm.ready, homes[pose]) for pose in singular):
        what = f"the ready pose is nearly singular: condition number {_number(at_ready)}"
        yield finding("ready-singular", place, what, snippet)
    for pose, number in singular.items():
        named = arm.ready_name is not None
        what = (
            f"the {pose} pose is singular: condition number {_number(number)}; motions that start there stall or jump"
        )
        remedy = f"start from the ready pose (condition number {at_ready:.1f})" if named and not poor else snippet
        yield finding("home-singular", place, what, remedy)


def _homes(arm: Arm) -> dict[str, Array]:
    """Zero and the pose named home, where they are inside the limits."""
    homes = {"zero": np.zeros(arm.n)}
    if "home" in arm.named_states and arm.named_states["home"].any():
        homes["home"] = arm.named_states["home"]
    return {pose: theta for pose, theta in homes.items() if arm.limits.contains(theta)}


def _condition(arm: Arm, theta: Array, rank: int) -> float:
    """σ_1/σ_rank at theta (n,): the condition number with what the arm lacks everywhere left out."""
    return float(arm.manipulability(theta).condition_in(rank))


def _number(value: float) -> str:
    return "∞" if value > 1e9 else f"{value:.3g}"
