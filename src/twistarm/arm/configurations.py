"""Configurations by name: `ready`, `zero` and an arm's named states, as one read-only mapping."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..support.checks import Array, as_floats, as_theta, frozen, require_names
from ..support.errors import InputError, listed, unknown_name

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


def theta_by_joint(arm: str, joints: tuple[str, ...], values: Any, numbers: ArrayLike | None) -> Array:
    """theta (n,) from {joint: value}, or from joint names and as many numbers. They must name every joint."""
    if isinstance(values, Mapping):
        given = dict(values)
    else:
        names, row = require_names(values, "names"), as_floats([] if numbers is None else numbers, "numbers").ravel()
        if len(names) != row.size:
            raise InputError(f"{len(names)} names but {row.size} numbers; give one number per name")
        given = dict(zip(names, row.tolist(), strict=True))
        if len(given) != len(names):
            raise InputError(f"a joint is named twice in {listed(names)}")
    for name in given:
        if name not in joints:
            raise unknown_name("joint", name, joints, within=arm, listing=f"base to tip: {listed(joints)}")
    missing = [name for name in joints if name not in given]
    if missing:
        raise InputError(f"no value for joint {listed(missing)} of {arm}; give every joint")
    return as_theta([given[name] for name in joints], len(joints))


def usual_ready(names: Iterable[str]) -> list[str]:
    """The given names that are in `USUAL_NAMES`, in its order. Case does not count, but exact case comes first."""
    known = [name for name in names if name.strip().casefold() in USUAL_NAMES]
    return sorted(known, key=lambda name: (USUAL_NAMES.index(name.strip().casefold()), name not in USUAL_NAMES))
