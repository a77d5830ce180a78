"""The predicted motion of the tool for other scales and zeros, and for another base."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..theory.rotations import exp, log_of

SLACK = np.radians(1.0)
"""Allowed contradiction of motors that share a joint [joint rad]: backlash and belts."""

USUAL = (0.01, float(np.radians(2.0)))
"""One standard deviation [m, rad] of a base measured by tape, for logs that need it."""


@dataclass(frozen=True)
class BaseOffset:
    """The base's apparent place, seen from its measured place: `position` [m], `rotation` vector [rad]."""

    position: tuple[float, float, float]
    rotation: tuple[float, float, float]

    def __str__(self) -> str:
        turned = np.degrees(np.linalg.norm(self.rotation))
        return f"{1000 * np.linalg.norm(self.position):.0f} mm and {turned:.1f}° from where it was measured"


class BaseError:
    """The base's offset as a random effect: r = A z + noise, z (6,) and noise of standard deviation 1.

    A (N, 6) maps translations and rotations of the base to residuals, in standard deviations. r has the covariance C =
    1 + A Aᵀ. Generalised least squares (Aitken 1935) minimise rᵀ C⁻¹ r = ‖C^(−1/2) r‖².

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
        return r - ((r @ self.U) * kept) @ self.U.T

    def expected(self, r: Array) -> Array:
        """The expected z (6,) of measured residuals (N,)."""
        return ((r @ self.U) * self.d / (1.0 + self.d**2)) @ self.Vt


def moved_by_base(position: Array, rotation: Array | None) -> tuple[Array, Array]:
    """d(measured)/d(translation, rotation of the base), for positions (K, 3, 6) and tool axes (K, 3, 6).

    dx = v + ω × x, and dw = Rᵀ ω in tool axes.
    """
    K, eye = len(position), np.broadcast_to(np.eye(3), (len(position), 3, 3))
    turned = np.swapaxes(np.cross(np.eye(3), position[:, None, :]), 1, 2)
    axes = eye if rotation is None else np.swapaxes(rotation, 1, 2)
    return np.concatenate([eye, turned], -1), np.concatenate([np.zeros((K, 3, 3)), axes], -1)


@dataclass(frozen=True, eq=False)
class Wiring:
    """theta = P (s y + e). y (K, k) are the motors' readings from their configured zeros. P (n, k) is the inverse of G.

    The parameters p (2k,) are the scales s and the offsets e over `unit` (k,). The unit makes them rad (or m) of the
    joint that the motor turns most. Configuration and arm agree at s = 1 and e = 0; a reversed motor has s = −1.
    `surplus` (k, k) is I − G P. With more motors than joints the readings must have none of it. `base` is one standard
    deviation of the base's place [m, rad], 0 for an exact base.
    """

    arm: Arm
    y: Array
    position: Array
    rotation: Array | None
    noise: tuple[float, float]
    P: Array
    unit: Array
    surplus: Array | None
    base: tuple[float, float] = (0.0, 0.0)

    @property
    def k(self) -> int:
        """Motors."""
        return int(self.y.shape[1])

    @property
    def sound(self) -> Array:
        """The parameters (2k,) of an arm that agrees with its arm.toml."""
        return np.repeat([1.0, 0.0], self.k)

    def of_rows(self, rows: Array) -> Wiring:
        """The same of some of the moments, by their indices."""
        rotation = None if self.rotation is None else self.rotation[rows]
        return replace(self, y=self.y[rows], position=self.position[rows], rotation=rotation)

    def theta(self, p: Array) -> Array:
        """Joint coordinates (..., K, n) of parameters (..., 2k)."""
        return self._driven(p) @ self.P.T

    def misses(self, p: Array) -> tuple[Array, Array | None]:
        """Measured minus computed, of parameters (..., 2k): positions (..., K, 3) [m]; rotations, tool axes [rad]."""
        g = self.arm.fk(self.theta(p))
        rotation = None
        if self.rotation is not None:
            rotation = log_of(np.swapaxes(g[..., :3, :3], -1, -2) @ self.rotation)
        return self.position - g[..., :3, 3], rotation

    @cached_property
    def base_error(self) -> BaseError | None:
        """What the base does to the residuals; None where it is exactly known."""
        if not any(self.base):
            return None
        moved = moved_by_base(self.position, self.rotation)
        parts = [part / noise for part, noise in zip(moved, self.noise, strict=True)][: 1 + (self.rotation is not None)]
        A = np.concatenate([part.reshape(-1, 6) for part in parts]) * np.repeat(self.base, 3)
        none = 0 if self.surplus is None else self.y.size
        return BaseError(np.concatenate([A, np.zeros((none, 6))]))

    def base_offset(self, p: Array) -> BaseOffset | None:
        """The expected place of the base for parameters (2k,); None if it is exactly known."""
        if self.base_error is None:
            return None
        moved = self.base_error.expected(self._measured_residual(p)) * np.repeat(self.base, 3)
        x, y, z, *turned = map(float, moved)
        return BaseOffset((x, y, z), (turned[0], turned[1], turned[2]))

    def with_base_moved(self, p: Array) -> Wiring:
        """The same, measured from the expected place of the base."""
        offset = self.base_offset(p)
        if offset is None:
            return self
        R = exp(np.array(offset.rotation))
        rotation = None if self.rotation is None else R.T @ self.rotation
        return replace(self, position=(self.position - offset.position) @ R, rotation=rotation)

    def residual(self, p: Array) -> Array:
        """`misses` in standard deviations, (..., N), without what an uncertain base explains."""
        r = self._measured_residual(p)
        return r if self.base_error is None else self.base_error.whitened(r)

    def _measured_residual(self, p: Array) -> Array:
        position, rotation = self.misses(p)
        parts = [position / self.noise[0]]
        if rotation is not None:
            parts.append(rotation / self.noise[1])
        if self.surplus is not None:
            parts.append(-(self._driven(p) @ self.surplus.T) / self.unit / SLACK)
        return np.concatenate([part.reshape(*part.shape[:-2], -1) for part in parts], axis=-1)

    def slope(self, p: Array) -> Array:
        """d(computed, in standard deviations)/dp, (N, 2k), for one set of parameters.

        dp = R J_v dtheta and dw = J_w dtheta of the body Jacobian (MLS §3.4.1), with dtheta/ds_i = P_i y_i and
        dtheta/de_i = P_i. For large rotations it is the first term of the logarithm.
        """
        theta = self.theta(p)
        R, J = self.arm.fk(theta)[:, :3, :3], self.arm.body_jacobian(theta)
        driven = np.concatenate(
            [self.y[:, None, :] * self.P, np.broadcast_to(self.P * self.unit, (len(R), *self.P.shape))], -1
        )
        parts = [R @ J[:, :3] @ driven / self.noise[0]]
        if self.rotation is not None:
            parts.append(J[:, 3:] @ driven / self.noise[1])
        if self.surplus is not None:
            by_scale = self.surplus * self.y[:, None, :]
            by_offset = np.broadcast_to(self.surplus * self.unit, by_scale.shape)
            parts.append(np.concatenate([by_scale, by_offset], -1) / self.unit[:, None] / SLACK)
        slope = np.concatenate([part.reshape(-1, 2 * self.k) for part in parts])
        return slope if self.base_error is None else self.base_error.whitened(slope.T).T

    def _driven(self, p: Array) -> Array:
        """s y + e, (..., K, k) [motor rad or m]."""
        s, e = p[..., None, : self.k], p[..., None, self.k :] * self.unit
        return s * self.y + e
