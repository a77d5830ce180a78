"""All configurations of one target by name, whoever found them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array
from .closed_form.roots import Root


@dataclass(frozen=True, eq=False)
class AllAnswers:
    """Configurations theta (k, n), of which the first `inside` are inside the limits; the core's own has the same.

    `moves` (k, n): which joints may move while the target stays met. `tries`: searches or values that were tried, of
    which `hits` had an answer. theta0 (n,), `kind` and `numbers` are what was asked.
    """

    theta: Array
    moves: NDArray[np.bool_]
    inside: int
    theta0: Array
    kind: int
    numbers: Array
    tries: int = 0
    hits: int = 0

    def __post_init__(self) -> None:
        for array in (self.theta, self.moves, self.theta0, self.numbers):
            array.flags.writeable = False


def roots_in(found: AllAnswers) -> Iterator[Root]:
    """The configurations as roots."""
    for theta, moves in zip(found.theta, found.moves, strict=True):
        yield Root(theta, tuple(np.flatnonzero(moves).tolist()))
