"""Random starts, spread without gaps: start k of a seed is the same however many are drawn, in any order."""

from __future__ import annotations

from functools import cache

import numpy as np

from ..checks import SEEDS, Array
from .ranges import JointRanges

GOLDEN = 0x9E3779B97F4A7C15
"""The increment of SplitMix64: 2⁶⁴ over the golden ratio."""

NEWTON_STEPS = 64


def random_start(ranges: JointRanges, seed: int, index: int) -> Array:
    """Start `index` (n,) of `seed`, spread over the ranges: frac(shift(seed, i) + index φ⁻ⁱ⁻¹) for coordinate i.

    φ is the positive root of x^(n+1) = x + 1. A hundred starts that keep away from each other find a small basin more
    often than a hundred independent ones. The compiled core draws the same ones. Source: M. Roberts, The unreasonable
    effectiveness of quasirandom sequences, 2018 (the sequence R_d).
    """
    n = len(ranges.lower)
    words = [(_shift(seed, i) + index * stride) % SEEDS for i, stride in enumerate(_strides(n))]
    return ranges.random(np.array([word >> 11 for word in words]) * 2.0**-53)


@cache
def _strides(n: int) -> tuple[int, ...]:
    """φ⁻¹ … φ⁻ⁿ in turns of 2⁶⁴, to the rounding of float64."""
    root = 2.0
    for _ in range(NEWTON_STEPS):
        root -= (root ** (n + 1) - root - 1.0) / ((n + 1) * root**n - 1.0)
    return tuple(int(float(SEEDS) / root ** (i + 1)) for i in range(n))


def _shift(seed: int, coordinate: int) -> int:
    """Where a seed's sequence begins in one coordinate: word `coordinate` of a SplitMix64 stream of its own."""
    return _mixed((_mixed((seed + GOLDEN) % SEEDS) + GOLDEN * (coordinate + 1)) % SEEDS)


def _mixed(word: int) -> int:
    """The finaliser of SplitMix64, in D. Stafford's variant 13.

    Source: G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
    """
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9 % SEEDS
    word = (word ^ (word >> 27)) * 0x94D049BB133111EB % SEEDS
    return word ^ (word >> 31)
