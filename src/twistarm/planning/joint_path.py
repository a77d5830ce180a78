"""JointPath: a curve in joint space, without time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..support.checks import Array, frozen
from ..support.display import told
from .piecewise import derivative, evaluate, rescaled, shifted, spread

Indices = NDArray[np.intp]

ROUNDING = 1e-9
"""A piece may exceed its greatest length by this share before it is cut again."""

STILL = 1e-12
"""A joint that moves by less [rad, m] stays where it is, and so does a cut nearer to a breakpoint by such a share."""


@dataclass(frozen=True, eq=False, repr=False)
class JointPath:
    """q(s) of n joints: polynomials on m pieces of a path parameter s without a unit.

    `breakpoints` (m + 1,) starts at 0 and increases. `coefficients` (degree + 1, m, n) [rad, m] hold the highest power
    of s − breakpoints[i] first. Position, tangent q' and curvature q'' are continuous. A path without motion may have
    one piece of no length.
    """

    breakpoints: Array
    coefficients: Array

    def __post_init__(self) -> None:
        for name in ("breakpoints", "coefficients"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @classmethod
    def straight(cls, start: Array, end: Array) -> JointPath:
        """The straight line from `start` to `end` (n,), of length 1."""
        return cls(np.array([0.0, 1.0]), np.stack([end - start, start])[:, None])

    def __repr__(self) -> str:
        return told("JointPath", {"n": self.n, "pieces": self.breakpoints.size - 1, "length": self.length})

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.coefficients.shape[2])

    @property
    def length(self) -> float:
        """The largest s; the smallest is 0."""
        return float(self.breakpoints[-1])

    @property
    def start(self) -> Array:
        """q(0), (n,)."""
        return self(0.0)

    @property
    def end(self) -> Array:
        """q(length), (n,)."""
        return self(self.length)

    @property
    def moves(self) -> bool:
        """Whether any joint moves along it, by more than rounding."""
        ways = rescaled(self.coefficients, np.diff(self.breakpoints))[:-1]
        return bool(np.abs(ways).max(initial=0.0) > STILL)

    def in_pieces(self, most: float) -> tuple[JointPath, Indices]:
        """Cut the path evenly into pieces no longer than `most`. Also return the old piece of each new one."""
        steps = np.diff(self.breakpoints)
        count = np.maximum(np.ceil(steps / most - ROUNDING), 1.0).astype(np.intp)
        piece, nth = spread(count)
        by = steps[piece] * nth / count[piece]
        breakpoints = np.append(self.breakpoints[piece] + by, self.length)
        return JointPath(breakpoints, shifted(self.coefficients[:, piece], by)), piece

    def cut_at(self, places: Array) -> JointPath:
        """Cut the path at these places (k,) too, but at none that only rounding tells from a breakpoint."""
        before = self.piece_at(places)
        gaps = places - self.breakpoints[before], self.breakpoints[before + 1] - places
        apart = np.minimum(*gaps) > STILL * self.length
        breakpoints = np.union1d(self.breakpoints, places[apart])
        piece = self.piece_at(breakpoints[:-1])
        moved = shifted(self.coefficients[:, piece], breakpoints[:-1] - self.breakpoints[piece])
        return JointPath(breakpoints, moved)

    def piece_at(self, s: Array) -> Indices:
        """Return the indices of the pieces at s (...); at a breakpoint the later one."""
        inner = self.breakpoints[1:-1]
        return np.searchsorted(inner, s, side="right")

    def __call__(self, s: ArrayLike, order: int = 0) -> Array:
        """Return that derivative by s at s (...), (..., n); at a breakpoint the limit from above."""
        at = np.asarray(s, dtype=np.float64)
        piece = self.piece_at(at.ravel())
        return self.within(piece, at.ravel() - self.breakpoints[piece], order).reshape(*at.shape, self.n)

    def within(self, piece: Indices, sigma: Array, order: int = 0) -> Array:
        """Return that derivative in pieces (k,), at sigma (k,) from their starts, (k, n)."""
        return evaluate(derivative(self.coefficients[:, piece], order), sigma[:, None])
