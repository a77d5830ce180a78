"""Searches for many targets: in the compiled core, or else one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..support.checks import Array, Progress
from .batch import solve_ik_batch
from .request import Deadline
from .solve import solve_ik
from .targets import AnyTarget
from .task_space import USUAL, Tolerances


class Searched(NamedTuple):
    """Ends of searches (k, n), which reach their targets (k,), and their number."""

    theta: Array
    converged: NDArray[np.bool_]
    run: int

    @property
    def solutions(self) -> Array:
        """The configurations that reach their targets, (m, n)."""
        return self.theta[self.converged]


def searched(
    arm: Arm,
    targets: Array | Sequence[AnyTarget],
    starts: Array,
    tolerances: Tolerances = USUAL,
    *,
    restarts: int = 1,
    posture: str | None = None,
    max_time: float | None = None,
    progress: Progress | None = None,
) -> Searched:
    """The answers of `solve_ik` to each target (poses (k, 4, 4), or a sequence) from its start (k, n)."""
    if arm.compiled is not None:
        batch = solve_ik_batch(
            arm, targets, starts, **tolerances.keywords, restarts=restarts, posture=posture, max_time=max_time,
            progress=progress,
        )  # fmt: skip
        return Searched(batch.theta, batch.converged, int((batch.restarts > 0).sum()))
    deadline = Deadline.after(max_time)
    theta, converged, run = np.array(starts), np.zeros(len(starts), dtype=np.bool_), 0
    for target, start in deadline.until(zip(targets, starts, strict=True)):
        found = solve_ik(
            arm, target, start, **tolerances.keywords, restarts=restarts, posture=posture, max_time=deadline.left
        )
        theta[run], converged[run] = found.theta, found.converged
        run += 1
        if progress is not None:
            progress(run / len(starts))
    return Searched(theta, converged, run)
