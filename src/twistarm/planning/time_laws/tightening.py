"""Tightening of a time law: the needs of each piece of a path, and local ceilings of ṡ."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ..joint_path import JointPath
from ..piecewise import derivative, evaluate
from .bounds import PathBounds
from .law import TimeLaw

SAMPLES = np.array([[0.0], [0.5], [1.0 - 1e-9]])
"""Where in each of its pieces a law is looked at."""


class Needs:
    """Needs of a time law along a path with derivatives p', p'', p''' of the rows p = C q."""

    def __init__(self, path: JointPath, bounds: PathBounds) -> None:
        self.path, self.bounds, self.ceiling = path, bounds, bounds.ceiling_of(path)
        rows = path.coefficients @ bounds.C.T
        self.derivatives = [np.moveaxis(derivative(rows, k), 2, 1).copy() for k in (1, 2, 3)]

    def of(self, law: TimeLaw) -> tuple[Array, Array]:
        """By what factor each piece of the path must be slowed (m,), and ṡ (m,).

        The rates are p' ṡ, p'' ṡ² + p' s̈ and p''' ṡ³ + 3 p'' ṡ s̈ + p' s⃛. Each piece of the law is sampled at three
        instants. It may span several pieces of the path.
        """
        tau = SAMPLES * np.diff(law.breakpoints)
        s, s1, s2, s3 = (evaluate(derivative(law.coefficients[:, :, None], k)[..., 0], tau).ravel() for k in range(4))
        piece = self.path.piece_at(s)
        sigma = s - self.path.breakpoints[piece]
        p1, p2, p3 = (evaluate(rows[:, :, piece], sigma) for rows in self.derivatives)
        rates = (p1 * s1, p2 * s1**2 + p1 * s2, (p3 * s1**2 + 3.0 * p2 * s2) * s1 + p1 * s3)
        limits = (self.bounds.velocity, self.bounds.acceleration, self.bounds.jerk)
        shares = (np.abs(rate / limit[:, None]).max(axis=0) for rate, limit in zip(rates, limits, strict=True))
        factors = [share ** (1.0 / order) for order, share in enumerate(shares, start=1)]
        factor, fastest = np.zeros((2, len(self.path.breakpoints) - 1))
        np.maximum.at(factor, piece, np.max(factors, axis=0))
        np.maximum.at(fastest, piece, s1)
        return np.maximum(factor, fastest / self.ceiling), fastest


def widened(ceiling: Array, breakpoints: Array, window: float) -> Array:
    """The ceiling (m,), held for half a window [s] around each piece, so that its average keeps it."""
    slow = np.flatnonzero(np.isfinite(ceiling))
    reach = 0.5 * window * ceiling[slow, None]
    before, after = breakpoints[slow, None] - reach, breakpoints[slow + 1, None] + reach
    near = (breakpoints[:-1] < after) & (breakpoints[1:] > before)
    wide: Array = np.where(near, ceiling[slow, None], np.inf).min(axis=0, initial=np.inf)
    return wide
