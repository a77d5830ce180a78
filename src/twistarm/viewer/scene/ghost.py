"""The arm as it would have to stand to meet a target that its limits forbid: drawn faintly beside the nearest one."""

from __future__ import annotations

from collections.abc import Mapping

from ...ik import IKSolution
from ...support.checks import Array
from .placement import Placement


def ghost(solution: IKSolution, others: Mapping[str, float]) -> dict[str, list[float]] | None:
    """Where each link stands, {node: matrix by columns}, with limits left aside; None where they are not the reason.

    A target that is met needs none, and one out of reach has no configuration to be drawn at, whatever the limits.
    """
    if solution.unlimited is None:
        return None
    return standing_at(Placement(solution.arm), solution.unlimited, others)


def standing_at(placement: Placement, theta: Array, others: Mapping[str, float]) -> dict[str, list[float]]:
    """Where each link stands at theta (n,), {node: matrix by columns}."""
    transforms = placement.at(theta, others)["transforms"]
    return {path: matrix for path, matrix in transforms.items() if path.startswith("/arm/")}
