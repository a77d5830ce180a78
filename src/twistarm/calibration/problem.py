"""The least-squares problem of a calibration in the units of the noise, and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..support.checks import Array, nearest_rotation
from ..support.errors import InputError
from ..theory.rotations import log_of, skew
from ..theory.screws import exp
from .geometry import Geometry, Parameter
from .measurements import Bools, Measurements, Rows

STEPS, STARTS = 30, 8
LEAST_GAIN = 1e-7
MOST_STD = 0.005
"""Standard deviation [m, rad, 1] beyond which the log does not show a parameter: more than arms are out."""

DEPENDENT = 1e-9
"""The share of a column's square across the others below which it is rounding."""

LOUD = 5.0
"""Standard deviations from which a row is an outlier: of 10,000 rows with normal noise it is none."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Measurements of a geometry, with known distances {(point, point): m} between resting points.

    A vector of unknowns q is the geometry's parameters, then 3 numbers for each unknown place: a point, an anchor, or
    a plane (two tilts of the normal, and its distance from the origin).
    """

    geometry: Geometry
    log: Measurements
    noise: tuple[float, float]
    distances: Mapping[tuple[str, str], float]
    distance_noise: float = 1e-5

    @cached_property
    def places(self) -> tuple[tuple[str, str], ...]:
        """(kind, name) of every unknown place."""
        named = [(kind, name) for kind in ("point", "plane", "wire") for name in getattr(self.log, kind) if name]
        return tuple(dict.fromkeys(named))

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All unknowns."""
        more = [Parameter(f"{kind} {name}", axis, "m") for kind, name in self.places for axis in "xyz"]
        return (*self.geometry.parameters, *more)

    @cached_property
    def first(self) -> Array:
        """The unknowns (Q,) to begin with: places from where the nominal tool was."""
        P = len(self.geometry.parameters)
        p = self.geometry.poses(np.zeros(P), self.log.theta)[:, :3, 3]
        starts = [_place(kind, p[self._rows(kind, name)], self.log.lengths[self._rows(kind, name)])
                  for kind, name in self.places]  # fmt: skip
        return np.concatenate([np.zeros(P), *starts])

    @cached_property
    def normals(self) -> dict[str, Array]:
        """Axes (3, 3) of each touched plane, the last the normal, from where the nominal tool was."""
        p = self.geometry.poses(np.zeros(len(self.geometry.parameters)), self.log.theta)[:, :3, 3]
        planes = [name for kind, name in self.places if kind == "plane"]
        rows = {name: p[self._rows("plane", name)] for name in planes}
        return {name: np.linalg.svd(at - at.mean(axis=0))[2].T for name, at in rows.items()}

    def _rows(self, kind: str, name: str) -> Rows:
        return np.flatnonzero(np.array(getattr(self.log, kind)) == name)

    @cached_property
    def sigma(self) -> Array:
        """The noise (K,) [m] of each row."""
        assert self.log.noise is not None
        return np.asarray(np.where(np.isfinite(self.log.noise), self.log.noise, self.noise[0]))

    def misses(self, q: Array) -> tuple[Array, Array]:
        """Computed minus measured (K, 6) [m, rad], zeros where nothing was measured, and derivatives (K, 6, Q)."""
        g, V = self.geometry.poses_and_twists(q[: len(self.geometry.parameters)], self.log.theta)
        p, K, P = g[:, :3, 3], len(g), V.shape[-1]
        r, J = np.zeros((K, 6)), np.zeros((K, 6, len(q)))
        dp = V[:, :3] - skew(p) @ V[:, 3:]
        at = self.log.located
        r[at, :3], J[at, :3, :P] = (p - self.log.positions)[at], dp[at]
        turned = np.isfinite(self.log.rotations).all(axis=(1, 2))
        # (R_m)ᵀ R: its logarithm in the measured axes.
        r[turned, 3:] = log_of(np.swapaxes(self.log.rotations[turned], 1, 2) @ g[turned, :3, :3])
        J[turned, 3:, :P] = np.swapaxes(self.log.rotations[turned], 1, 2) @ V[turned, 3:]
        for k, (kind, name) in enumerate(self.places):
            rows, own = self._rows(kind, name), slice(P + 3 * k, P + 3 * k + 3)
            r[rows, :3], slope, J[rows, :3, own] = self._at_place(kind, name, p[rows], q[own], self.log.lengths[rows])
            J[rows, :3, :P] = slope @ dp[rows]
        return r, J

    def _at_place(self, kind: str, name: str, p: Array, c: Array, length: Array) -> tuple[Array, Array, Array]:
        """Miss (k, 3), and its slopes (k, 3, 3) by the tool's position and by the place."""
        if kind == "point":
            each = np.broadcast_to(np.eye(3), (len(p), 3, 3))
            return p - c, each, -each
        r, slope, own = np.zeros((len(p), 3)), np.zeros((len(p), 3, 3)), np.zeros((len(p), 3, 3))
        if kind == "plane":
            axes = self.normals[name]
            n = axes @ [c[0], c[1], 1.0]
            size = np.linalg.norm(n)
            r[:, 0], slope[:, 0] = (p @ n - c[2]) / size, n / size
            own[:, 0, :2], own[:, 0, 2] = p @ axes[:, :2] / size, -1.0 / size
            return r, slope, own
        far = np.linalg.norm(p - c, axis=1)
        slope[:, 0] = (p - c) / np.maximum(far, 1e-9)[:, None]
        r[:, 0] = far - length
        return r, slope, -slope

    def residual(self, q: Array) -> tuple[Array, Array]:
        """`misses` in standard deviations, (K, 6) and (K, 6, Q)."""
        scale = np.repeat(np.stack([1 / self.sigma, np.full(len(self.sigma), 1 / self.noise[1])], axis=1), 3, axis=1)
        r, J = self.misses(q)
        return r * scale, J * scale[..., None]

    def _known(self, q: Array) -> tuple[Array, Array]:
        """Residuals of the known distances (d,) and (d, Q)."""
        P = len(self.geometry.parameters)
        r, J = np.zeros(len(self.distances)), np.zeros((len(self.distances), len(q)))
        for k, (pair, length) in enumerate(self.distances.items()):
            a, b = (P + 3 * self.places.index(("point", name)) for name in pair)
            apart = q[a : a + 3] - q[b : b + 3]
            far = float(np.linalg.norm(apart))
            r[k] = (far - length) / self.distance_noise
            J[k, a : a + 3] = apart / max(far, 1e-9) / self.distance_noise
            J[k, b : b + 3] = -J[k, a : a + 3]
        return r, J

    def system(self, q: Array, weights: Array) -> tuple[Array, Array]:
        """The stacked residual (N,) and slope (N, Q), rows weighted by (K,)."""
        r, J = self.residual(q)
        w: Array = np.sqrt(weights)[:, None]
        known, slope = self._known(q)
        used = (J != 0).any(axis=-1).ravel()
        return (
            np.concatenate([(r * w).ravel()[used], known]),
            np.concatenate([(J * w[..., None]).reshape(-1, len(q))[used], slope]),
        )

    def loudness(self, q: Array) -> Array:
        """The root mean square (K,) of each row's residuals in standard deviations."""
        r, J = self.residual(q)
        count = (J != 0).any(axis=-1).sum(axis=1)
        return np.asarray(np.sqrt((r * r).sum(axis=1) / np.maximum(count, 1)))

    def of_rows(self, rows: Rows) -> Problem:
        """The problem of these rows."""
        return replace(self, log=self.log.of_rows(rows))


def _place(kind: str, p: Array, length: Array) -> Array:
    centre = p.mean(axis=0)
    if kind == "plane":
        n = np.linalg.svd(p - centre)[2][-1] if len(p) > 2 else np.array([0.0, 0.0, 1.0])
        return np.array([0.0, 0.0, n @ centre])
    if kind == "wire":  # |p|² − l² = 2 p·c − |c|², linear in c and |c|²
        rows = np.column_stack([2 * p, -np.ones(len(p))])
        return np.asarray(np.linalg.lstsq(rows, (p * p).sum(axis=1) - length**2, rcond=None)[0][:3])
    return np.asarray(centre)


def shown(A: Array, weights: Array, most: float = MOST_STD) -> Bools:
    """The unknowns (Q,) that a slope A (N, Q) shows beside each other.

    Cholesky's factors of AᵀA with pivots: the next unknown is the one whose column has the longest part across those
    chosen, times its weight (Q,). That part has the length 1/σ. Weight 0: never chosen.
    """
    G = A.T @ A
    size = np.diag(G).copy()
    seen = np.zeros(len(G), dtype=bool)
    for _ in range(len(G)):
        left = np.where(seen, 0.0, np.diag(G)) * weights**2
        left[np.diag(G) <= np.maximum(DEPENDENT * size, 1.0 / most**2)] = 0.0
        j = int(left.argmax())
        if not left[j] > 0.0:
            break
        seen[j] = True
        G = G - np.outer(G[j], G[j]) / G[j, j]
    return seen


def descend(problem: Problem, q: Array, free: Bools, *, robust: bool = True) -> tuple[Array, Array]:
    """The unknowns near q with the least squares in the `free` ones, and the rows' weights (K,).

    Gauss–Newton with halved steps. With `robust`, weights are Cauchy's 1/(1 + (r/3s)²), where s is the median noise
    found, at least what was stated.
    """
    weights = np.ones(len(problem.log.theta))
    for _ in range(STEPS):
        if robust:
            loud = problem.loudness(q)
            weights = 1.0 / (1.0 + (loud / (3.0 * max(1.0, float(np.median(loud))))) ** 2)
        r, A = problem.system(q, weights)
        A = A[:, free]
        size = np.linalg.norm(A, axis=0)
        size[size == 0] = np.inf
        A = A / size
        step = -np.linalg.lstsq(A.T @ A, A.T @ r, rcond=1e-12)[0] / size
        before, tried = float(r @ r), q
        for halved in range(STARTS):
            tried = q.copy()
            tried[free] += step / 2**halved
            after = problem.system(tried, weights)[0]
            if float(after @ after) < before:
                break
        else:
            break
        gained = before - float(after @ after)
        q = tried
        if gained < LEAST_GAIN * before:
            break
    return q, weights


def started(problem: Problem, base: bool, tool: Bools) -> Problem:
    """The problem with base and tool fitted alone: the base by Kabsch's method, then both by least squares."""
    geometry, located = problem.geometry, problem.log.located
    P = len(geometry.parameters)
    if base:
        p = geometry.poses(np.zeros(P), problem.log.theta)[located, :3, 3]
        geometry = replace(geometry, base=kabsch(p, problem.log.positions[located]) @ geometry.base)
    for _ in range(STARTS):
        problem = replace(problem, geometry=geometry)
        free = np.ones(len(problem.parameters), dtype=bool)
        free[:P] = False
        free[:6], free[6:12] = base, tool
        if not free.any():
            break
        _, A = problem.system(problem.first, np.ones(len(located)))
        free &= shown(A, free.astype(float), most=1.0)
        q, _ = descend(problem, problem.first, free)
        geometry = replace(geometry, base=geometry.base @ exp(q[:6]), tool=geometry.tool @ exp(q[6:12]))
        if np.abs(q[:12]).max() < 1e-7:
            break
    return problem


def kabsch(a: Array, b: Array) -> Array:
    """The motion (4, 4) that takes points a (K, 3) nearest to b."""
    if len(a) < 3:
        raise InputError(f"{len(a)} positions do not show the base: measure 3 or more, or hold it (base='held')")
    g = np.eye(4)
    g[:3, :3], _ = nearest_rotation((b - b.mean(axis=0)).T @ (a - a.mean(axis=0)))
    g[:3, 3] = b.mean(axis=0) - g[:3, :3] @ a.mean(axis=0)
    return g
