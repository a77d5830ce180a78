"""For a team's own tests: the cross-check and the golden file as one assertion."""

from __future__ import annotations

import os
from typing import Any

from .loading.load import load_arm
from .model.arm import Arm
from .proof.crosscheck import crosscheck, require_yourdfpy
from .proof.difference import compare

_SAMPLES = 200


def assert_arm(
    source: str | os.PathLike[str],
    *,
    against: str | os.PathLike[str] | None = None,
    samples: int = _SAMPLES,
    **load: Any,
) -> Arm:
    """Load an arm, prove product of exponentials = Pinocchio = yourdfpy, and that it is still the one frozen.

    `source` and `load` as in `load_arm`; `against` a golden file written by `twistarm freeze` or `freeze(arm, path)`,
    or whatever else `compare` takes. Returns the arm. Raises AssertionError with every difference in words, and
    MissingExtraError without yourdfpy: a proof that leaves an engine out is none.

        def test_our_arm():
            assert_arm("arm/rover.urdf.xacro", against="arm/rover.golden.json")
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
