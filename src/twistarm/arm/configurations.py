"""Configurations by name: `ready`, `zero` and an arm's named states, as one read-only mapping."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from ..support.checks import Array, frozen
from ..support.errors import listed, unknown_name

READY, ZERO = "ready", "zero"

USUAL_NAMES = ("ready", "home", "default", "rest", "stowed")
"""Usual names of the ready configuration, the most likely first."""


class Configurations(Mapping[str, Array]):
    """An arm's configurations by name, theta (n,) [rad, m], in this order: ready, zero, the named states.

    A named state `ready` or `zero` replaces the computed one. `ready` is computed on first use. An unknown name
    raises UnknownNameError, a LookupError that lists the names.
    """

    def __init__(self, arm: str, n: int, named: Mapping[str, Array], ready: Callable[[], Array]) -> None:
        self._arm = arm
        self._n = n
        self._named = named
        self._ready = ready

    def __getitem__(self, name: str) -> Array:
        if name in self._named:
            return self._named[name]
        if name not in (READY, ZERO):
            known = tuple(self)
            raise unknown_name("pose", name, known, within=self._arm, listing=f"poses: {listed(known)}")
        return self._ready() if name == READY else frozen(np.zeros(self._n))

    def __contains__(self, name: object) -> bool:
        return name in (READY, ZERO) or name in self._named

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys((READY, ZERO, *self._named)))

    def __len__(self) -> int:
        return len({READY, ZERO, *self._named})

    def __repr__(self) -> str:
        return f"Configurations({listed(tuple(self))})"


def named_ready(names: Iterable[str]) -> str | None:
    """The given name that comes first in `USUAL_NAMES`, or None. Case does not count, but exact case wins."""
    given = sorted(names, key=lambda name: name not in USUAL_NAMES)
    for usual in USUAL_NAMES:
        for name in given:
            if name.strip().casefold() == usual:
                return name
    return None
