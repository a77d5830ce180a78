"""A ghost of the arm at a target that its limits forbid, beside the nearest configuration."""

from __future__ import annotations

from collections.abc import Mapping

from ...ik import IKSolution
from ...support.checks import Array
from .placement import Placement


def ghost(solution: IKSolution, others: Mapping[str, float]) -> dict[str, list[float]] | None:
    """Link poses without limits, {node: matrix by columns}, or None if limits are not the reason.

    A met target needs no ghost. A target out of reach has none.
    """
    if solution.unlimited is None:
        return None
    return standing_at(Placement(solution.arm), solution.unlimited, others)


def standing_at(placement: Placement, theta: Array, others: Mapping[str, float]) -> dict[str, list[float]]:
    """Where each link stands at theta (n,), {node: matrix by columns}."""
    transforms = placement.at(theta, others)["transforms"]
    return {path: matrix for path, matrix in transforms.items() if path.startswith("/arm/")}
