"""The best fit of scales and zeros: many starts, refined by damped Gauss–Newton steps."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np

from ..support.checks import Array
from .model import Wiring

STEPS = 60
LEAST_GAIN = 1e-9
"""A step that reduces the sum of squares by a smaller share is the last."""

MOST_SIGNS = 8
"""Motors up to which every pattern of signs is tried. With more, at most two are reversed."""

SCALES = (1.0, 0.1, 0.25, 0.5, 0.75, 1.5, 2.0, 4.0, 10.0)
OFFSETS = np.radians([0.0, 30.0, -30.0, 75.0, -75.0, 120.0, -120.0, 180.0])
"""Start values for a single motor's zero, with a scale of either sign."""

_ANYWHERE = np.array([(sign * s, e) for s in SCALES for sign in (1.0, -1.0) for e in OFFSETS])

BEAM_WIDTH, BEAM_ROUNDS = 6, 3
"""Width of the beam search, and its rounds."""

FITS = 2.0
"""A mean square [standard deviations²] below this needs no further search."""

SEARCH_MOMENTS = 30
"""Moments for a search. The final fit uses all."""


def refine(wiring: Wiring, p: Array, free: Array | None = None) -> tuple[Array, float]:
    """The parameters (2k,) near p with the least sum of squared residuals, and that sum.

    Only the `free` (2k,) move, by default all. Levenberg–Marquardt with the columns scaled to length 1:
    (AᵀA + λ I) step = Aᵀ r.
    """
    r = wiring.residual(p)
    total, damping = float(r @ r), 1e-3
    free = np.ones(len(p), dtype=bool) if free is None else free
    if not free.any():
        return p, total
    for _ in range(STEPS):
        A = wiring.slope(p)[:, free]
        size = np.linalg.norm(A, axis=0)
        A = A / np.where(size > 0, size, 1.0)
        H, gradient = A.T @ A, A.T @ r
        for _ in range(STEPS):
            step = np.linalg.solve(H + damping * np.eye(len(H)), gradient) / np.where(size > 0, size, np.inf)
            tried = p.copy()
            tried[free] += step
            r_tried = wiring.residual(tried)
            after = float(r_tried @ r_tried)
            if after < total or damping > 1e8:
                break
            damping *= 8.0
        if not after < total:
            break
        gained, p, r, total, damping = total - after, tried, r_tried, after, max(damping / 8.0, 1e-9)
        if gained < LEAST_GAIN * total:
            break
    return p, total


def best_fit(wiring: Wiring, progress: Callable[[float], object]) -> tuple[Array, float]:
    """The parameters (2k,) that fit the log best, and the sum of squares.

    The search first refines the patterns of reversed motors that come nearest. It then runs a beam from the sound
    motors and one from the reversed. Each round gives one more motor the scale and offset that help most.
    `progress(fraction)` is called along the way.
    """
    rows = np.unique(np.linspace(0, len(wiring.y) - 1, min(SEARCH_MOMENTS, len(wiring.y))).astype(int))
    few = wiring.of_rows(rows)
    reversed_ = _most_promising(few, sign_patterns(wiring.k), BEAM_WIDTH)
    best, total = min((refine(few, p) for p in (few.sound, *reversed_)), key=lambda fit: fit[1])
    enough = FITS * len(few.residual(few.sound))
    for half, beam in enumerate(([few.sound], list(reversed_))):
        for turn in range(BEAM_ROUNDS):
            if total <= enough:
                break
            starts = [start for p in beam for i in range(few.k) for start in one_more(few, p, i)]
            changed = [refine(few, start, _moved(start)) for start in starts]
            beam = [p for p, _ in sorted(changed, key=lambda fit: fit[1])[:BEAM_WIDTH]]
            best, total = min([(best, total), *(refine(few, p) for p in beam)], key=lambda fit: fit[1])
            progress((half + (turn + 1) / BEAM_ROUNDS) / 2)
    return refine(wiring, best)


def _most_promising(wiring: Wiring, starts: Array, count: int) -> Array:
    r = wiring.residual(starts)
    return starts[np.argsort((r * r).sum(axis=-1), kind="stable")[:count]]


def sign_patterns(k: int) -> Array:
    """Patterns of reversed motors as parameters (M, 2k), fewest first. With many motors at most two are reversed."""
    patterns = [flips for count in range(1, k + 1 if k <= MOST_SIGNS else 3) for flips in combinations(range(k), count)]
    starts = np.tile(np.repeat([1.0, 0.0], k), (len(patterns), 1))
    for start, flips in zip(starts, patterns, strict=True):
        start[list(flips)] = -1.0
    return starts


def one_more(wiring: Wiring, p: Array, i: int) -> Array:
    """p with the two best scales and offsets of motor i, (2, 2k)."""
    changed = np.tile(p, (len(_ANYWHERE), 1))
    changed[:, [i, wiring.k + i]] = _ANYWHERE
    return _most_promising(wiring, changed, 2)


def _moved(p: Array) -> Array:
    """Both parameters of every motor that is not sound, (2k,)."""
    k = len(p) // 2
    return np.tile((p[:k] != 1.0) | (p[k:] != 0.0), 2)
