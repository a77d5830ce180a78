"""Tightening of a time law: what each piece of a path needs, and ceilings of ṡ that slow the law down there alone."""

from __future__ import annotations

import numpy as np

from ...support.checks import Array
from ..joint_path import JointPath
from ..piecewise import derivative, evaluate
from .bounds import PathBounds
from .law import TimeLaw

LOOKS = np.array([[0.0], [0.5], [1.0 - 1e-9]])
"""Where in each of its pieces a law is looked at."""


def needed(path: JointPath, law: TimeLaw, bounds: PathBounds) -> tuple[Array, Array]:
    """By what factor each piece of the path must be slowed to keep velocity, acceleration and jerk, (m,), and ṡ (m,).

    With p = C q: velocity p' ṡ, acceleration p'' ṡ² + p' s̈, jerk p''' ṡ³ + 3 p'' ṡ s̈ + p' s⃛, at three instants of each
    piece of the law; ṡ is the largest there.
    """
    piece, tau = law.pieces(path), LOOKS * np.diff(law.breakpoints)
    s, s1, s2, s3 = (evaluate(derivative(law.coefficients[:, :, None], k)[..., 0], tau) for k in range(4))
    rows, sigma = path.coefficients @ bounds.C.T, (s - path.breakpoints[piece])[..., None]
    p1, p2, p3 = (evaluate(derivative(rows, k)[:, None, piece], sigma) for k in (1, 2, 3))
    speed, s1, s2, s3 = s1, s1[..., None], s2[..., None], s3[..., None]
    velocity, acceleration = p1 * s1, p2 * s1**2 + p1 * s2
    jerk = s1 * (p3 * s1**2 + 3.0 * p2 * s2) + p1 * s3
    limited = (velocity / bounds.velocity, acceleration / bounds.acceleration, jerk / bounds.jerk)
    factors = [np.abs(share).max(axis=(0, 2)) ** (1.0 / order) for order, share in enumerate(limited, start=1)]
    factor, fastest = np.zeros((2, len(path.breakpoints) - 1))
    np.maximum.at(factor, piece, np.max(factors, axis=0))
    np.maximum.at(fastest, piece, speed.max(axis=0))
    return factor, fastest


def widened(ceiling: Array, breakpoints: Array, window: float) -> Array:
    """The ceiling (m,), held for half a window [s] before and after each piece: its average is then as low there."""
    slow = np.flatnonzero(np.isfinite(ceiling))
    reach = 0.5 * window * ceiling[slow, None]
    before, after = breakpoints[slow, None] - reach, breakpoints[slow + 1, None] + reach
    near = (breakpoints[:-1] < after) & (breakpoints[1:] > before)
    wide: Array = np.where(near, ceiling[slow, None], np.inf).min(axis=0, initial=np.inf)
    return wide
