"""The reachable workspace: tool positions inside the limits and their dexterity."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...arm.inability import NO_MOTION
from ...support.checks import Array
from ..protocol.jobs import Job, Progress
from ..protocol.messages import Message
from .part import Part, Show

POINTS = 20_000
"""Dense enough to show the shape of a six-joint arm's reach."""

SEED = 0

BATCH = 1000
"""Configurations between two reports of progress: some 30 ms."""


class Workspace(Part):
    """The cloud of the arm, sampled when it is first switched on."""

    def __init__(self) -> None:
        self._cloud: Message | None = None

    def switched(self, what: str, show: Show) -> Job | None:
        """A job that samples the cloud when it is first switched on."""
        if what != "workspace" or self._cloud is not None or not show.visible["workspace"]:
            return None
        return Job("workspace", "sampling the workspace", partial(sampled_workspace, show.arm), self._finish)

    def messages(self, show: Show) -> Iterator[Message]:
        """The cloud, once it is there."""
        if self._cloud is not None:
            yield self._cloud

    def _finish(self, cloud: dict[str, Any]) -> None:
        self._cloud = {"type": "workspace", **cloud}


def sampled_workspace(arm: Arm, progress: Progress) -> dict[str, Any]:
    """`POINTS` tool positions (float32, base64) and dexterities (a byte each, 255 for the best, base64).

    best: the greatest dexterity; directions: of how many the dexterity speaks.
    """
    positions, singular_values = sampled(arm, progress)
    directions = directions_of(singular_values)
    dexterity = dexterity_of(singular_values, directions)
    best = float(dexterity.max(initial=0.0))
    shares = dexterity / best if best > 0.0 else dexterity
    return {
        "count": len(positions),
        "points": _packed(positions.astype("<f4")),
        "values": _packed(np.round(255.0 * shares).astype(np.uint8)),
        "best": best,
        "directions": directions,
    }


def sampled(arm: Arm, progress: Progress) -> tuple[Array, Array]:
    """Tool positions (N, 3) [m] and scaled singular values (N, min(6, n)) at random configurations."""
    theta = arm.random_theta(SEED, POINTS)
    positions, values = [], []
    for start in range(0, POINTS, BATCH):
        progress(start / POINTS)
        batch = theta[start : start + BATCH]
        positions.append(arm.fk(batch)[:, :3, 3])
        values.append(arm.manipulability(batch).singular_values)
    return np.concatenate(positions), np.concatenate(values)


def directions_of(singular_values: Array) -> int:
    """The number of directions of the tool's motion. Below `NO_MOTION` [rad/rad] counts as none."""
    return int((singular_values > NO_MOTION).sum(axis=-1).max(initial=0))


def dexterity_of(singular_values: Array, directions: int) -> Array:
    """σ_directions / σ_1 (N,): 1 where the tool moves equally in all its directions, 0 where it lacks one.

    It is the inverse condition of the scaled body Jacobian in the directions that the arm has. Sources: J. K. Salisbury
    & J. J. Craig, Articulated hands: force control and kinematic issues, Int. J. Robotics Research 1(1), 1982; J.
    Angeles & C. S. López-Cajún, the conditioning index, Int. J. Robotics Research 11(6), 1992.
    """
    if directions == 0:
        return np.zeros(len(singular_values))
    first, last = singular_values[:, 0], singular_values[:, directions - 1]
    return np.divide(last, first, out=np.zeros(len(first)), where=first > NO_MOTION)


def _packed(values: np.ndarray[Any, Any]) -> str:
    return base64.b64encode(values.tobytes()).decode("ascii")
