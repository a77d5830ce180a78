"""Singular postures among those that programs start from, and a better one found by search."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arm import Arm
from ..checks import Array
from ..description.findings import Finding, finding
from .wording import place_of, toml_table

SINGULAR = 1e3
"""A condition number beyond which a posture is singular in practice: one direction a thousand times slower."""

POOR = 100.0
"""A ready pose worse than this is worth a word, if there is one that is ten times better."""

MARGIN = 0.1
"""The share of its range that a recommended pose stays away from each bound."""

STARTS, BEST = 256, 4
"""Random postures, and how many of the best are improved."""

EVALUATIONS = 20_000
"""At most so many postures are looked at while improving, however many joints there are."""

STEPS = (0.1, 0.03, 0.01)
"""Steps of the improvement, as shares of each joint's range."""

GRIDS = (0.1, 0.05, 0.01, 0.001)
"""What a recommended pose is rounded to [rad, m], coarse first."""

WORSE = 1.1
"""By how much rounding, or a zero instead of a number, may raise the condition number."""


def check_postures(arm: Arm, rank: int) -> Iterator[Finding]:
    """Zero, home and ready pose: the condition number of the `rank` directions that the arm can move its tool in."""
    at_ready = float(condition(arm, arm.ready, rank))
    place = place_of(arm.description, arm.name)
    singular = _singular_homes(arm, rank)
    poor = at_ready > POOR
    if not (poor or singular):
        return
    best = recommended(arm, rank)
    at_best = float(condition(arm, best, rank))
    said = f"say in arm.toml (condition number {at_best:.1f}; look for collisions first, twistarm view):\n"
    snippet = said + toml_table("poses.ready", arm.theta_to_dict(best))
    if poor and at_best < at_ready / 10:
        what = f"the ready pose is nearly singular: condition number {_number(at_ready)}"
        yield finding("ready-singular", place, what, snippet)
    for pose, number in singular.items():
        named = "ready" in arm.named_states
        what = (
            f"the {pose} pose is singular: condition number {_number(number)}; motions that start there stall or jump"
        )
        remedy = f"start from the ready pose (condition number {at_ready:.1f})" if named and not poor else snippet
        yield finding("home-singular", place, what, remedy)


def _singular_homes(arm: Arm, rank: int) -> dict[str, float]:
    """The condition numbers of zero and the pose named home, where they are inside the limits and singular."""
    homes = {"zero": np.zeros(arm.n)}
    if "home" in arm.named_states and arm.named_states["home"].any():
        homes["home"] = arm.named_states["home"]
    numbers = {name: float(condition(arm, theta, rank)) for name, theta in homes.items() if arm.limits.contains(theta)}
    return {name: number for name, number in numbers.items() if number > SINGULAR}


def condition(arm: Arm, theta: Array, rank: int) -> Array:
    """σ_1/σ_rank (...) at theta (..., n): the condition number with what the arm lacks everywhere left out."""
    return arm.manipulability(theta).condition_in(rank)


def recommended(arm: Arm, rank: int) -> Array:
    """A well-conditioned posture (n,) off the bounds, in few digits: seeded random postures, the best improved."""
    lower, upper = _room(arm)
    starts = np.random.default_rng(0).uniform(lower, upper, (STARTS, arm.n))
    order = np.argsort(condition(arm, starts, rank), kind="stable")[:BEST]
    improved = [_improved(arm, starts[k], lower, upper, rank) for k in order]
    best = improved[int(np.argmin(condition(arm, np.stack(improved), rank)))]
    return _rounded(arm, _with_zeros(arm, best, lower, upper, rank), lower, upper, rank)


def _room(arm: Arm) -> tuple[Array, Array]:
    """Bounds (n,) that keep the margin, angles within half a turn where the limits allow that."""
    lower, upper = arm.sampling_bounds
    half = np.where(np.array(arm.units) == "m", np.inf, np.pi)
    near = np.maximum(lower, -half) < np.minimum(upper, half)
    lower, upper = np.where(near, np.maximum(lower, -half), lower), np.where(near, np.minimum(upper, half), upper)
    margin = MARGIN * (upper - lower)
    return lower + margin, upper - margin


def _improved(arm: Arm, theta: Array, lower: Array, upper: Array, rank: int) -> Array:
    """Downhill along the joints' axes, the steps getting finer."""
    for step in STEPS:
        moves = np.vstack([np.diag(upper - lower), -np.diag(upper - lower)]) * step
        for _ in range(max(1, EVALUATIONS // (BEST * len(STEPS) * len(moves)))):
            near = np.clip(theta + moves, lower, upper)
            values = condition(arm, np.vstack([theta, near]), rank)
            if values[1:].min() >= values[0]:
                break
            theta = near[int(np.argmin(values[1:]))]
    return theta


def _with_zeros(arm: Arm, theta: Array, lower: Array, upper: Array, rank: int) -> Array:
    """theta with a zero wherever that costs next to nothing: the base's turn, the last roll."""
    allowed = WORSE * float(condition(arm, theta, rank))
    for i in range(arm.n):
        tried = theta.copy()
        tried[i] = 0.0
        if lower[i] <= 0.0 <= upper[i] and condition(arm, tried, rank) <= allowed:
            theta = tried
    return theta


def _rounded(arm: Arm, theta: Array, lower: Array, upper: Array, rank: int) -> Array:
    allowed = WORSE * float(condition(arm, theta, rank))
    for grid in GRIDS:
        tried = np.round(np.round(theta / grid) * grid, 6)
        if (lower <= tried).all() and (tried <= upper).all() and condition(arm, tried, rank) <= allowed:
            return tried
    return theta


def _number(value: float) -> str:
    return "∞" if value > 1e9 else f"{value:.3g}"
