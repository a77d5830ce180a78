"""Values of joints or motors by name, as messages tell them: in any order, of some alone, others among them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import isfinite

from ...support.errors import InputError, listed


def values_by_name(known: Collection[str], names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
    """Values by name. What tells of none that is `known` is nobody's trouble, whatever it holds.

    Raises InputError for unequal lengths, a known name that is there twice, and its value where that is not finite.
    """
    ours = [name for name in names if name in known]
    if ours and len(names) != len(values):
        raise InputError(f"a joint state has as many names as values; got {len(names)} names, {len(values)} values")
    if len(set(ours)) != len(ours):
        twice = [name for name in dict.fromkeys(ours) if ours.count(name) > 1]
        raise InputError(f"a joint state names each joint once; twice: {listed(twice)}")
    given = dict(zip(names, values, strict=False))
    for name in ours:
        if not isfinite(given[name]):
            raise InputError(f"the joint state of {name} must be finite; got {given[name]}")
    return given
