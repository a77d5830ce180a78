"""Joint values by name, in whatever order they arrive."""

from __future__ import annotations

from collections.abc import Sequence

from ..arm import Arm
from ..checks import Array
from ..errors import InputError, closest, listed


def theta_by_name(arm: Arm, names: Sequence[str], values: Sequence[float]) -> Array:
    """theta (n,) of the arm, base to tip, from names and values in any order; other joints are passed over.

    Raises InputError for unequal lengths, a joint of the arm that is missing or named twice, a value not finite.
    """
    if len(names) != len(values):
        raise InputError(f"a joint state has as many names as values; got {len(names)} names, {len(values)} values")
    ours = [(name, value) for name, value in zip(names, values, strict=True) if name in arm.joint_names]
    given = dict(ours)
    if len(given) != len(ours):
        twice = [name for name in given if list(names).count(name) > 1]
        raise InputError(f"a joint state names each joint once; twice: {listed(twice)}")
    missing = [name for name in arm.joint_names if name not in given]
    if missing:
        others = [name for name in names if name not in given]
        raise InputError(f"the joint state lacks {listed(missing)} of {arm.name}{closest(missing[0], others)}")
    return arm.theta_from(given)
