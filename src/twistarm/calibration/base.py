"""The base as a source of error: it stands a little beside its measured place, in every row alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import Array

USUAL = (0.01, float(np.radians(2.0)))
"""One standard deviation [m, rad] of a base measured with a tape, for a log that does not fit without it."""


@dataclass(frozen=True)
class BaseOffset:
    """The base's apparent place, seen from its measured place: `position` [m], `rotation` vector [rad]."""

    position: tuple[float, float, float]
    rotation: tuple[float, float, float]

    def __str__(self) -> str:
        turned = np.degrees(np.linalg.norm(self.rotation))
        return f"{1000 * np.linalg.norm(self.position):.0f} mm and {turned:.1f}° from where it was measured"


class BaseError:
    """The base's offset as a random effect: r = A z + noise, with z (6,) and noise of standard deviation 1.

    A (N, 6) is the effect of the base's translations and rotations on the residuals, in standard deviations. r has
    the covariance C = 1 + A Aᵀ. Generalised least squares (Aitken 1935) minimise rᵀ C⁻¹ r = ‖C^(−1/2) r‖².

    With A = U D Vᵀ, C^(−1/2) = 1 − U (1 − (1 + D²)^(−1/2)) Uᵀ and ln det C = Σ ln (1 + D²). The expected z is
    V D (1 + D²)⁻¹ Uᵀ r (Laird, Ware 1982, eq. 3.3). What the base explains does not count for or against a motor.
    The offset is taken to first order.
    """

    def __init__(self, A: Array) -> None:
        self.U, self.d, self.Vt = np.linalg.svd(A, full_matrices=False)
        self.complexity = float(np.log1p(self.d**2).sum())

    def whitened(self, r: Array) -> Array:
        """C^(−1/2) r of residuals (..., N)."""
        kept = 1.0 - 1.0 / np.sqrt(1.0 + self.d**2)
        white: Array = r - ((r @ self.U) * kept) @ self.U.T
        return white

    def expected(self, r: Array) -> Array:
        """The expected z (6,) of measured residuals (N,)."""
        z: Array = ((r @ self.U) * self.d / (1.0 + self.d**2)) @ self.Vt
        return z


def moved_by_base(position: Array, rotation: Array | None) -> tuple[Array, Array]:
    """d(measured)/d(translation, rotation of the base): of positions (K, 3, 6), and of tool axes (K, 3, 6).

    dx = v + ω × x, and dw = Rᵀ ω in tool axes.
    """
    K, eye = len(position), np.broadcast_to(np.eye(3), (len(position), 3, 3))
    turned = np.swapaxes(np.cross(np.eye(3), position[:, None, :]), 1, 2)
    axes = eye if rotation is None else np.swapaxes(rotation, 1, 2)
    return np.concatenate([eye, turned], -1), np.concatenate([np.zeros((K, 3, 3)), axes], -1)
