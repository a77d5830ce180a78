"""Random starts from a counter-based generator: start k of a seed is the same however many are drawn, in any order."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..checks import Array
from ..errors import InputError
from .ranges import JointRanges

SEEDS = 2**64


def random_start(ranges: JointRanges, seed: int, index: int) -> Array:
    """Start `index` (n,) of `seed`, uniform in the ranges.

    u_i = (word_i >> 11) 2⁻⁵³, the words of Philox-4×64 with the key (seed, index), its counter from 1 on as in NumPy.
    Source: J. Salmon et al., Parallel random numbers: as easy as 1, 2, 3, SC 2011.
    """
    key = np.array([seed, index], dtype=np.uint64)
    return ranges.random(np.random.Generator(np.random.Philox(key=key)).random(len(ranges.lower)))


def as_seed(rng: Any) -> int:
    """A seed from an integer in [0, 2⁶⁴), or drawn from a NumPy Generator."""
    if isinstance(rng, np.random.Generator):
        return int(rng.integers(2**63))
    if isinstance(rng, (int, np.integer)) and not isinstance(rng, bool) and 0 <= rng < SEEDS:
        return int(rng)
    raise InputError(f"rng must be a seed, an integer from 0 to 2^64 − 1, or a numpy Generator; got {rng!r}")
