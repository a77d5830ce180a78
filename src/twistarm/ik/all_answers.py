"""All configurations of one target by name, whoever found them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ..support.checks import Array
from .closed_form.roots import Root

if TYPE_CHECKING:
    from .._core import AllAnswers as CoreAllAnswers


@dataclass(frozen=True, eq=False)
class AllAnswers:
    """Configurations theta (k, n), of which the first `inside` are inside the limits: `_core.AllAnswers` has the same.

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


AnyAllAnswers: TypeAlias = "AllAnswers | CoreAllAnswers"


def roots_in(found: AnyAllAnswers) -> Iterator[Root]:
    """The configurations as roots."""
    for theta, moves in zip(found.theta, found.moves, strict=True):
        yield Root(theta, tuple(np.flatnonzero(moves).tolist()))
