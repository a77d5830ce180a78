"""For a team's own tests: the cross-check and the golden file as one assertion."""

from __future__ import annotations

import os
from typing import Any

from .arm.arm import Arm
from .arm.loading.load import load_arm
from .checking.crosscheck import crosscheck
from .checking.difference import compare
from .checking.yourdfpy_poses import require_yourdfpy


def assert_arm(
    source: str | os.PathLike[str],
    *,
    against: str | os.PathLike[str] | None = None,
    samples: int = 200,
    **load: Any,
) -> Arm:
    """Load an arm, prove product of exponentials = Pinocchio = yourdfpy, and that it is still the one frozen.

    In a test::

        def test_our_arm():
            assert_arm("arm/rover.urdf.xacro", against="arm/rover.golden.json")

    Args:
        source: As in `load_arm`.
        against: A golden file written by `freeze`, or whatever else `compare` takes; None for the cross-check alone.
        samples: Number of random configurations.
        **load: The options of `load_arm`.

    Returns:
        The arm.

    Raises:
        AssertionError: Something differs; the message gives every difference in words.
        MissingExtraError: yourdfpy is not installed: a proof that leaves an engine out is none.
    """
    __tracebackhide__ = True
    arm = load_arm(source, **load)
    check = crosscheck(arm, samples)
    require_yourdfpy()
    problems = [
        f"{row.quantity}: {row.engines[0]} and {row.engines[1]} differ by {row.worst:.2g} (allowed {row.tolerance:g})"
        for row in check.comparisons
        if not row.ok
    ]
    if against is not None:
        problems += compare(arm, against).changes
    if problems:
        raise AssertionError(f"{arm.name}: " + "; ".join(problems))
    return arm
