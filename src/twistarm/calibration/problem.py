"""The least-squares problem of a calibration in the units of the noise, and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ..support.checks import Array, nearest_rotation, pose_of
from ..support.errors import InputError
from ..theory.rotations import log_of, skew
from ..theory.screws import exp
from .camera import Camera, first_guess, poses_of
from .geometry import BASE, JOINTS, TOOL, Geometry, Parameter
from .measurements import Bools, Measurements, Rows

STEPS, TRIES, LEAST_DAMPING = 30, 8, 1e-9
SETTLED = 1e-4  # Share of a standard deviation, squared, below which a step ends the descent.
# Standard deviation by unit beyond which the log does not show a parameter: most arms are out by less.
MOST_STD = {"m": 0.003, "rad": 0.01, "1": 0.01}
# The share of a column's square across the others below which it shows nothing: they are parallel within 0.06°.
DEPENDENT = 1e-6
ALIKE = 1.25  # Unknowns that show nearly alike are as good as each other: the first of them is chosen.
OUTLIER = 5.0  # Standard deviations from which a row is an outlier: of 10,000 rows with normal noise it is none.


@dataclass(frozen=True, eq=False)
class Problem:
    """Measurements of a geometry, with known distances {(point, point): m} between resting points.

    With a `camera` all rows are poses that it measured, and their residual is its reprojection error.

    `prior` (P,) is one over the standard deviation of each parameter before the log, 0 where nothing is known.
    `contradiction` (k, k) maps readings of motors that share a joint to how far they contradict each other [σ].

    A vector of unknowns q is the geometry's parameters, then 3 numbers for each of `places` (kind, name). A place is a
    point, an anchor, or a plane: two tilts of its normal, and its distance from the origin. The columns
    of `normals` (3, 3) are the axes of each plane, the last one its first normal.
    """

    geometry: Geometry
    log: Measurements
    noise: tuple[float, float]
    prior: Array
    distances: Mapping[tuple[str, str], float] = field(default_factory=dict)
    distance_noise: float = 1.0
    contradiction: Array | None = None
    camera: Camera | None = None
    places: tuple[tuple[str, str], ...] = ()
    normals: Mapping[str, Array] = field(default_factory=dict)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All unknowns."""
        more = [Parameter(f"{kind} {name}", axis, "m") for kind, name in self.places for axis in "xyz"]
        return (*self.geometry.parameters, *more)

    @cached_property
    def P(self) -> int:
        """How many of the unknowns are the geometry's."""
        return len(self.geometry.parameters)

    def with_places(self) -> tuple[Problem, Array]:
        """The problem with the places that its log names, and unknowns (Q,) that put them at the tool."""
        places = tuple(dict.fromkeys(place for place in self.log.place if place != ("", "")))
        p = self.geometry.poses(np.zeros(self.P), self.log.theta)[:, :3, 3]
        normals, starts = {}, [np.zeros(self.P)]
        for kind, name in places:
            rows = np.array([place == (kind, name) for place in self.log.place])
            centre = p[rows].mean(axis=0)
            if kind == "plane":
                axes = np.linalg.svd(p[rows] - centre)[2].T
                normals[name], centre = axes, np.array([0.0, 0.0, axes[:, 2] @ centre])
            elif kind == "wire":  # |p|² − l² = 2 p·c − |c|², linear in c and |c|²
                A = np.column_stack([2 * p[rows], -np.ones(rows.sum())])
                centre = np.linalg.lstsq(A, (p[rows] ** 2).sum(axis=1) - self.log.length[rows] ** 2, rcond=None)[0][:3]
            starts.append(centre)
        return replace(self, places=places, normals=normals), np.concatenate(starts)

    @cached_property
    def place_of_row(self) -> Rows:
        """The place (K,) of each row, as its number in `places`; −1 for a position."""
        return np.array([self.places.index(place) if any(place) else -1 for place in self.log.place])

    @cached_property
    def sigma(self) -> Array:
        """The noise (K,) [m] of each row."""
        return np.asarray(np.where(np.isfinite(self.log.noise), self.log.noise, self.noise[0]))

    @cached_property
    def measured(self) -> Bools:
        """Which of each row's six numbers were measured (K, 6)."""
        vectors = self.log.located | np.array(self.log.point, dtype=bool)
        alone = np.array(self.log.plane, dtype=bool) | np.array(self.log.wire, dtype=bool)
        turned = np.isfinite(self.log.rotation).all(axis=(1, 2))
        return np.stack([vectors | alone, vectors, vectors, turned, turned, turned], axis=1)

    @property
    def numbers(self) -> int:
        """How many numbers were measured."""
        return int(self.measured.sum()) + len(self.distances)

    def errors(self, q: Array) -> Array:
        """The distance (K,) [m] between computed and measured: or of a tag's corners at its depth."""
        if self.camera is not None:
            depth = self.camera.in_camera(poses_of(self.log))[:, 2, 3]
            return np.asarray(np.linalg.norm(self.misses(q), axis=1) / 2 * depth)  # root mean square of four corners
        return np.asarray(np.linalg.norm(self.misses(q)[:, :3], axis=1))

    def misses(self, q: Array) -> Array:
        """Computed minus measured (K, 6) [m, rad], zeros where nothing was measured; of a camera, in its image."""
        return self._misses(q, self.geometry.poses(q[: self.P], self.log.theta))[0]

    def _misses(self, q: Array, g: Array) -> tuple[Array, Array, Array]:
        """`misses`, and their slopes (K, 6, 6) by the tool's position and turn, and (K, 6, Q − P) by the places."""
        log, p, K = self.log, g[:, :3, 3], len(g)
        r, slope, own = np.zeros((K, 6)), np.zeros((K, 6, 6)), np.zeros((K, 6, len(q) - self.P))
        if self.camera is not None:
            u, slope = self.camera.image(g)
            across = np.swapaxes(self._seen[1], 1, 2)
            return (across @ (u - self._seen[0])[..., None])[..., 0], across @ slope, own
        at, turned = log.located, self.measured[:, 3]
        r[at, :3], slope[at, :3, :3] = (p - log.position)[at], np.eye(3)
        if turned.any():  # log(R_mᵀ R), in the measured axes; without rows too, it would take a fifth of the time
            back = np.swapaxes(log.rotation[turned], 1, 2)
            r[turned, 3:], slope[turned, 3:, 3:] = log_of(back @ g[turned, :3, :3]), back
        for k, (kind, name) in enumerate(self.places):
            rows, columns = np.flatnonzero(self.place_of_row == k), slice(3 * k, 3 * k + 3)
            c = q[self.P :][columns]
            if kind == "point":
                r[rows, :3], slope[rows, :3, :3], own[rows, :3, columns] = p[rows] - c, np.eye(3), -np.eye(3)
            elif kind == "plane":
                axes = self.normals[name]
                n = axes @ [c[0], c[1], 1.0]
                size = np.linalg.norm(n)
                r[rows, 0], slope[rows, 0, :3] = (p[rows] @ n - c[2]) / size, n / size
                # The derivative of 1/‖n‖ is left out: it multiplies the distance from the plane, which is small.
                own[rows, 0, columns] = np.column_stack([p[rows] @ axes[:, :2], np.full(len(rows), -1.0)]) / size
            else:
                far = np.maximum(np.linalg.norm(p[rows] - c, axis=1), 1e-9)
                r[rows, 0], slope[rows, 0, :3] = far - log.length[rows], (p[rows] - c) / far[:, None]
                own[rows, 0, columns] = -slope[rows, 0, :3]
        return r, slope, own

    @cached_property
    def _seen(self) -> tuple[Array, Array]:
        assert self.camera is not None
        return self.camera.measured(self.log)

    @cached_property
    def _scale(self) -> Array:
        if self.camera is not None:
            return np.full((len(self.sigma), 6), 1.0 / self.camera.noise)
        return np.repeat(np.stack([1 / self.sigma, np.full(len(self.sigma), 1 / self.noise[1])], axis=1), 3, axis=1)

    def _beside(self, q: Array) -> tuple[Array, Array]:
        """Residuals of distances and of motors that share a joint, and their slopes, in standard deviations."""
        geometry, P, r, J = self.geometry, self.P, [np.empty(0)], [np.empty((0, len(q)))]
        for pair, length in self.distances.items():
            a, b = (P + 3 * self.places.index(("point", name)) for name in pair)
            difference, slope = q[a : a + 3] - q[b : b + 3], np.zeros((1, len(q)))
            far = float(np.linalg.norm(difference))
            slope[0, a : a + 3] = difference / max(far, 1e-9) / self.distance_noise
            slope[0, b : b + 3] = -slope[0, a : a + 3]
            r.append(np.array([(far - length) / self.distance_noise]))
            J.append(slope)
        if self.contradiction is not None:
            C, y, k = self.contradiction, self.log.theta, geometry.k
            _, _, z, _, s = geometry.split(q[:P])
            slope = np.zeros((*y.shape, len(q)))
            slope[..., JOINTS : JOINTS + k], slope[..., P - k : P] = C, C * y[:, None]
            r.append(((y * (1.0 + s) + z) @ C.T).ravel())
            J.append(slope.reshape(-1, len(q)))
        return np.concatenate(r), np.concatenate(J)

    def residual(self, q: Array, weights: Array, misses: Array | None = None) -> Array:
        """The stacked residual (N,) in standard deviations, rows weighted by (K,). `misses`: those of q, if known."""
        r = (self.misses(q) if misses is None else misses) * self._scale * np.sqrt(weights)[:, None]
        return np.concatenate([r[self.measured], self._beside(q)[0], self.prior * q[: self.P]])

    def slopes(self, q: Array, weights: Array, *, prior: bool = True, resting: bool = False) -> Array:
        """The derivative (N, Q) of `residual`; without `prior`, only of what was measured.

        A twist (v, ω) of the tool at p moves it by v + ω × p. With `resting`, p is the measured position p − r instead
        of the computed one. Errors r then show no turn of the whole arm about a socket where the tool rests.
        """
        g, V = self.geometry.twists(q[: self.P], self.log.theta)
        r, slope, own = self._misses(q, g)
        p = g[:, :3, 3]
        # A camera shows turns of the tool too, so a tool that is out shows no turn of the whole arm.
        if resting and self.camera is None:
            p = p - (np.swapaxes(slope[:, :3, :3], 1, 2) @ r[:, :3, None])[..., 0]
        V = np.concatenate([V[:, :3] - skew(p) @ V[:, 3:], V[:, 3:]], axis=1)
        J = np.concatenate([slope @ V, own], axis=-1) * (self._scale * np.sqrt(weights)[:, None])[..., None]
        J = np.concatenate([J[self.measured], self._beside(q)[1]])
        return np.vstack([J, np.eye(self.P, len(q)) * self.prior[:, None]]) if prior else J

    @cached_property
    def group_of_row(self) -> Rows:
        """The group of places (K,) of each row: places with a known distance move together. −1 for a position."""
        group = np.arange(len(self.places) + 1) - 1
        for a, b in self.distances:
            i, j = self.places.index(("point", a)) + 1, self.places.index(("point", b)) + 1
            group[group == group[j]] = group[i]
        return np.asarray(group[self.place_of_row + 1])

    def normalised_residual(self, q: Array, misses: Array | None = None) -> Array:
        """The root mean square (K,) of each row's residuals in standard deviations. `misses` as in `residual`."""
        r = (self.misses(q) if misses is None else misses) * self._scale
        return np.asarray(np.sqrt((r * r).sum(axis=1) / np.maximum(self.measured.sum(axis=1), 1)))

    def of_rows(self, rows: Rows) -> Problem:
        """The problem of these rows, with all places."""
        return replace(self, log=self.log.of_rows(rows))


def observable(A: Array, usual: Array, most: Array) -> Bools:
    """The unknowns (Q,) that a slope A (N, Q) shows beside each other, to deviations of `most` (Q,) at least.

    Cholesky's factors of AᵀA with pivots: the next unknown is the one whose `usual` size (Q,) shows most across those
    chosen, and the first of those that show nearly as much. The part of its column across them has the length 1/σ.
    Size 0: never chosen. An unknown that shows beside those before it, and not beside all, is left out at last: the
    smallest first, and of those the last.
    """
    information = A.T @ A
    G, size = information, np.diag(information)
    seen = np.zeros(len(G), dtype=bool)
    for _ in range(len(G)):
        left = np.where(seen, 0.0, np.diag(G)) * usual**2
        left[np.diag(G) <= np.maximum(DEPENDENT * size, 1.0 / most**2)] = 0.0
        if not left.max() > 0.0:
            break
        j = int((left >= left.max() / ALIKE**2).argmax())
        seen[j] = True
        G = G - np.outer(G[j], G[j]) / G[j, j]
    while seen.any():
        at = np.flatnonzero(seen)
        scale = np.sqrt(size[at])
        variance = np.diag(np.linalg.pinv(information[np.ix_(at, at)] / np.outer(scale, scale))) / scale**2
        weak = at[variance > most[at] ** 2][::-1]
        if not weak.size:
            break
        seen[weak[usual[weak].argmin()]] = False
    return seen


def of_joints(problem: Problem) -> Bools:
    """The unknowns (Q,) that are joints' zeros, axes and scales: not of base, tool or a place."""
    at = np.arange(len(problem.parameters))
    return np.asarray((at >= JOINTS) & (at < problem.P))


def observed(problem: Problem, q: Array, fitted: Bools) -> Bools:
    """Those of the `fitted` unknowns (Q,) that the log shows: base, tool and places first, then zeros, then axes."""
    usual = np.ones(len(q))
    usual[JOINTS : problem.P] /= problem.prior[JOINTS:]
    most = np.array([MOST_STD[parameter.unit] for parameter in problem.parameters])
    seen, ones = fitted, np.ones(len(problem.log.theta))
    for resting in (False, True):  # the one shows what is the tool's as well, the other what is the base's as well
        seen = observable(problem.slopes(q, ones, prior=False, resting=resting), usual * seen, most)
    return seen


def descend(problem: Problem, q: Array, free: Bools, *, robust: bool = True) -> tuple[Array, Array]:
    """The unknowns near q with the least squares in the `free` ones, and the rows' weights (K,).

    Levenberg–Marquardt with columns of length 1. With `robust`, weights are Cauchy's 1/(1 + (r/3s)²), where s is the
    median noise found, at least what was stated.
    """
    weights, damping, misses = np.ones(len(problem.log.theta)), LEAST_DAMPING, problem.misses(q)
    r = problem.residual(q, weights, misses)
    for _ in range(STEPS if free.any() else 0):
        if robust:
            loud = problem.normalised_residual(q, misses)
            weights = 1.0 / (1.0 + (loud / (3.0 * max(1.0, float(np.median(loud))))) ** 2)
            r = problem.residual(q, weights, misses)
        A = problem.slopes(q, weights)[:, free]
        size = np.linalg.norm(A, axis=0)
        size[size == 0] = np.inf
        A = A / size
        before = float(r @ r)
        for _ in range(TRIES):
            step = -np.linalg.solve(A.T @ A + damping * np.eye(A.shape[1]), A.T @ r)
            tried = q.copy()
            tried[free] += step / size
            there = problem.misses(tried)
            after = problem.residual(tried, weights, there)
            if float(after @ after) < before:
                q, r, misses, damping = tried, after, there, max(damping / 10, LEAST_DAMPING)
                break
            damping *= 10
        if float(r @ r) == before or float(np.sum((A @ step) ** 2)) < SETTLED * before / len(r):
            break
    return q, weights


def started(problem: Problem, base: bool, tool: Bools) -> tuple[Problem, Array]:
    """The problem with base and tool fitted alone, and its places: a closed form, then least squares."""
    geometry, located = problem.geometry, problem.log.located
    if problem.camera is not None:
        g = problem.geometry.arm.fk(problem.log.theta)
        base_frame, tool_frame = first_guess(g, poses_of(problem.log), problem.camera.mount)
        geometry = replace(geometry, base=base_frame, tool=tool_frame)
    elif base:
        p = geometry.poses(np.zeros(problem.P), problem.log.theta)[located, :3, 3]
        geometry = replace(geometry, base=kabsch(p, problem.log.position[located]) @ geometry.base)
    for _ in range(TRIES):
        problem, first = replace(problem, geometry=geometry).with_places()
        free = np.ones(len(first), dtype=bool)
        free[BASE], free[TOOL], free[JOINTS : problem.P] = base, tool, False
        if not free.any():
            break
        free &= observable(problem.slopes(first, np.ones(len(located))), free.astype(float), np.ones(len(first)))
        q, _ = descend(problem, first, free)
        geometry = replace(geometry, base=geometry.base @ exp(q[BASE]), tool=geometry.tool @ exp(q[TOOL]))
        if np.abs(q[:JOINTS]).max() < 1e-7:
            break
    else:
        problem, first = replace(problem, geometry=geometry).with_places()
    return problem, first


def kabsch(a: Array, b: Array) -> Array:
    """The motion (4, 4) that takes points a (K, 3) nearest to b."""
    if len(a) < 3:
        raise InputError(f"{len(a)} positions do not show the base: measure 3 or more, or hold it (base='held')")
    R, _ = nearest_rotation((b - b.mean(axis=0)).T @ (a - a.mean(axis=0)))
    return pose_of(R, b.mean(axis=0) - R @ a.mean(axis=0))
