"""`calibrate`: the arm's true axes and zeros from measurements of its tool."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, as_flag, as_positive, as_theta, require, require_choice
from ..support.display import told
from ..support.errors import InputError
from ..theory.screws import exp
from .geometry import Geometry, Parameter
from .measurements import Bools, Measurements, read_measurements
from .problem import LOUD, Problem, descend, shown, started
from .suspicions import refuse_unusable, suspicions

Frame = Literal["fit", "held"]

FOLDS = 5
ROUNDS = 6
FIRST, BEFORE_AXES = 30.0, 3.0
"""How much rather the log is explained by base, tool and places, and by zeros, than by moved axes."""

SURE = 0.95
"""The share of the error of base and tool alone that the corrected arm must stay below, on rows not fitted."""


class Estimate(NamedTuple):
    """One parameter: its value and standard deviation [m, rad, 1]. `seen`: the log shows it; else it is held at 0."""

    parameter: Parameter
    value: float
    std: float
    seen: bool


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """What a log tells of an arm's geometry.

    `arm` is the corrected arm: axes and zeros, without scales and eccentricity. `base` and `tool` (4, 4) are the base
    in the frame of the measurements, and the measured point beyond the tip. `estimates` are all parameters. `before`,
    `after` and `held_out` are mean errors [m]: with base and tool fitted alone, with all, and on rows that were left
    out of the fit; `held_out_before` is that with base and tool alone. `outliers` are rows, from 1. `errors` (K,) [m]
    are those of the rows. `warnings` say what is odd about the log. `faults` are those that spoil the correction.
    """

    arm: Arm
    base: Array
    tool: Array
    estimates: tuple[Estimate, ...]
    before: float
    after: float
    held_out: float
    held_out_before: float
    outliers: tuple[int, ...]
    errors: Array
    warnings: tuple[str, ...]
    faults: tuple[str, ...]
    covariance: Array = field(repr=False)
    problem: Problem = field(repr=False)
    unknowns: Array = field(repr=False)

    def __repr__(self) -> str:
        said = {"arm": self.arm.name, "before": self.before, "held_out": self.held_out, "confirmed": self.confirmed}
        return told("Calibration", said)

    @property
    def confirmed(self) -> bool:
        """Rows that were not fitted confirm the correction, and the log has no faults."""
        return not self.faults and self.held_out < SURE * self.held_out_before

    @property
    def unseen(self) -> tuple[Parameter, ...]:
        """The parameters that this log does not show beside the others."""
        return tuple(estimate.parameter for estimate in self.estimates if not estimate.seen)

    @property
    def places(self) -> dict[str, Array]:
        """Where the named points and anchors are (3,) [m]."""
        P = len(self.problem.geometry.parameters)
        found = self.unknowns[P:].reshape(-1, 3)
        return {name: found[k] for k, (kind, name) in enumerate(self.problem.places) if kind != "plane"}

    def predict(self, theta: ArrayLike) -> Array:
        """The positions (N, 3) [m] that would be measured at commanded theta (N, n) [rad, m]."""
        x = as_theta(theta, self.arm.n, "theta", self.arm.joint_names)
        flat = self.predict_poses(x.reshape(-1, self.arm.n))[:, :3, 3]
        return flat.reshape(*x.shape[:-1], 3)

    def predict_poses(self, theta: ArrayLike) -> Array:
        """The poses (N, 4, 4) that would be measured at commanded theta (N, n) [rad, m]."""
        x = as_theta(theta, self.arm.n, "theta", self.arm.joint_names)
        return self.problem.geometry.poses(self._p, x)

    @property
    def _p(self) -> Array:
        return self.unknowns[: len(self.problem.geometry.parameters)]

    @cached_property
    def displacements(self) -> Array:
        """The motion (m, 4, 4) of each moving joint's frame at rest, in base coordinates: axis and zero."""
        return self.problem.geometry.displacements(self._p)

    def changes(self) -> tuple[str, ...]:
        """The corrections of each joint in words, in mm and degrees: "elbow: axis 0.81 mm toward x, …"."""
        told: dict[str, list[str]] = {}
        for (owner, what, unit), value, std, seen in self.estimates:
            if seen and owner not in ("base", "tool") and not owner.startswith(("point ", "plane ", "wire ")):
                told.setdefault(owner, []).append(f"{_in_words(what, value, unit)} ± {_amount(std, unit)}")
        return tuple(f"{owner}: {', '.join(parts)}" for owner, parts in told.items())

    def next_postures(self, count: int = 10, *, among: ArrayLike | None = None) -> Array:
        """The configurations (count, n) whose positions would show most beside the log: D-optimal, one by one.

        Each next one maximises det(I + σ⁻² J C Jᵀ) for the covariance C so far. Candidates are `among` (N, n), for
        example those that a scene allows, or 500 random configurations.
        """
        theta = self.arm.random_theta(0, 500) if among is None else as_theta(among, self.arm.n, "among")
        geometry, sigma = self.problem.geometry, self.problem.noise[0]
        g, V = geometry.poses_and_twists(self._p, theta)
        p = g[:, :3, 3]
        free = np.array([e.seen or e.parameter.owner not in ("base", "tool") for e in self.estimates])[: V.shape[-1]]
        J = (V[:, :3] - np.cross(p[:, :, None], V[:, 3:], axisa=1, axisb=1, axisc=1))[:, :, free] / sigma
        C = (
            self.covariance[: V.shape[-1], : V.shape[-1]]
            + np.diag([0.0 if e.seen else 1e-4 for e in self.estimates])[: V.shape[-1], : V.shape[-1]]
        )
        C = C[np.ix_(free, free)]
        chosen: list[int] = []
        for _ in range(min(count, len(theta))):
            gain = np.linalg.slogdet(np.eye(3) + J @ C @ np.swapaxes(J, 1, 2))[1]
            gain[chosen] = -np.inf
            chosen.append(int(gain.argmax()))
            CJ = C @ J[chosen[-1]].T
            C = C - CJ @ np.linalg.solve(np.eye(3) + J[chosen[-1]] @ CJ, CJ.T)
        return theta[chosen]


def calibrate(
    arm: Arm,
    measurements: Measurements | str | os.PathLike[str],
    *,
    base: Frame = "fit",
    tool: Frame = "fit",
    position_noise: float = 1e-4,
    orientation_noise: float = 1e-3,
    distances: dict[tuple[str, str], float] | None = None,
    scales: bool = False,
    eccentricity: bool = False,
    robust: bool = True,
) -> Calibration:
    """Fit an arm's axes and joint zeros to measurements of its tool, with base and tool beside them.

    The model is `geometry.Geometry`, a local product of exponentials. Each turning joint has 4 parameters and each
    slide 2; base and tool have 6 each. Zeros, scales and eccentricities come on top. A parameter that the log does
    not show beside those before it is held at 0 and told: base and tool come first, then zeros, then axes from the
    base outward. So no number is redundant. Without positions or poses the base is the arm's own.

    Args:
        arm: The nominal arm.
        measurements: A `Measurements`, or the path of a CSV file (`read_measurements`).
        base: "fit", or "held" where the positions are in the base frame.
        tool: "fit", or "held" where the measured point is the arm's tip.
        position_noise: Standard deviation of rows without their own [m].
        orientation_noise: Standard deviation of measured orientations [rad].
        distances: Known distances {(point, point): m} between resting points.
        scales: Fit a scale of each joint's drive too.
        eccentricity: Fit sine and cosine of each joint's angle too, as an eccentric gear gives.
        robust: Weigh outliers down (Cauchy's loss).

    Returns:
        The `Calibration`.

    Raises:
        InputError: The log is unusable: too few rows, angles in degrees, a row twice, a joint that never moves.
    """
    require_arm(arm)
    for choice, name in ((base, "base"), (tool, "tool")):
        require_choice(choice, ("fit", "held"), name)
    log = measurements if isinstance(measurements, Measurements) else read_measurements(measurements, arm)
    as_theta(log.theta, arm.n, "theta", arm.joint_names)
    geometry = Geometry(arm, np.eye(4), np.eye(4), as_flag(scales, "scales"), as_flag(eccentricity, "eccentricity"))
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    problem = Problem(geometry, log, noise, _distances(distances, log))
    fitted = _fitted(problem, base == "fit", tool == "fit")
    said = refuse_unusable(problem, int(fitted.sum()))
    problem = started(problem, bool(fitted[:6].any()), fitted[6:12])
    q, seen, weights, first = solve(problem, fitted, as_flag(robust, "robust"))
    frames = seen.copy()
    frames[12 : len(problem.geometry.parameters)] = False
    held = _held_out(problem, ((q, seen), (first, frames)), robust)
    return _result(problem, q, seen, weights, first, held, said)


def _distances(distances: dict[tuple[str, str], float] | None, log: Measurements) -> dict[tuple[str, str], float]:
    known = {}
    given = {} if distances is None else require(distances, dict, "distances", '{("left", "right"): 0.05}')
    for pair, length in given.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or not set(pair) <= set(log.point) or pair[0] == pair[1]:
            raise InputError(f"distances must be {{(point, point): metres}} of the log's points; got {pair!r}")
        known[pair] = as_positive(length, f"distance of {pair}")
    return known


def _fitted(problem: Problem, base: bool, tool: bool) -> Bools:
    """The unknowns (Q,) that may move: without a measured frame not the base; turns of a tool only by poses."""
    may = np.ones(len(problem.parameters), dtype=bool)
    may[:6] = base and bool(problem.log.located.any())
    may[6:12] = tool
    may[9:12] &= bool(np.isfinite(problem.log.rotations).any())
    return may


def solve(problem: Problem, fitted: Bools, robust: bool) -> tuple[Array, Bools, Array, Array]:
    """The unknowns (Q,), which of them the log shows, the rows' weights, and the unknowns with base and tool alone."""
    P, Q = len(problem.geometry.parameters), len(fitted)
    order = np.full(Q, FIRST) * fitted
    order[12:P] /= FIRST
    order[12 : 12 + problem.geometry.arm.n] *= BEFORE_AXES
    ones = np.ones(len(problem.log.theta))
    q = problem.first
    frames = fitted.copy()
    frames[12:P] = False
    frames &= shown(problem.system(q, ones)[1], order * frames, most=1.0)
    q = first = descend(problem, q, frames, robust=robust)[0]
    seen, weights = frames, ones
    for _ in range(ROUNDS):
        before, seen = seen, shown(problem.system(q, weights)[1], order)
        if (before == seen).all():
            break
        q = np.where(seen | (np.arange(Q) >= P), q, 0.0)
        q, weights = descend(problem, q, seen, robust=robust)
    return q, seen, weights, first


def _errors(problem: Problem, q: Array) -> Array:
    """The distance (K,) [m] between computed and measured."""
    return np.asarray(np.linalg.norm(problem.misses(q)[0][:, :3], axis=1))


def _held_out(problem: Problem, fits: tuple[tuple[Array, Bools], ...], robust: bool) -> tuple[float, ...]:
    """The mean error [m] on rows left out, over random folds, of each fit: its unknowns and the free ones.

    The loudest percent of the rows does not count, because an outlier tells nothing of the arm.
    """
    K = len(problem.log.theta)
    fold = np.random.default_rng(0).permutation(K) % min(FOLDS, K)
    errors = np.full((len(fits), K), np.nan)
    for k in range(fold.max() + 1):
        rest = problem.of_rows(np.flatnonzero(fold != k))
        if set(rest.places) != set(problem.places):
            continue
        for i, (q, free) in enumerate(fits):
            fitted = descend(_ordered(rest, problem), q, free, robust=robust)[0]
            errors[i, fold == k] = _errors(problem, fitted)[fold == k]
    kept = errors[:, ~np.isnan(errors[0])]
    if not kept.size:
        return (np.inf,) * len(fits)
    few = kept[0] <= np.quantile(kept[0], 0.99)
    return tuple(kept[:, few].mean(axis=1).tolist())


def _ordered(rest: Problem, whole: Problem) -> Problem:
    """`rest` with the places in the order, and the planes in the axes, of the whole."""
    rest.__dict__.update(places=whole.places, normals=whole.normals)
    return rest


def _result(
    problem: Problem, q: Array, seen: Bools, weights: Array, first: Array, held: tuple[float, ...],
    said: tuple[str, ...],
) -> Calibration:  # fmt: skip
    r, A = problem.system(q, weights)
    A = A[:, seen]
    loud = problem.loudness(q)
    # The noise is at least the stated; a louder log makes every deviation larger.
    louder = max(1.0, float(r @ r) / max(1, len(r) - A.shape[1]))
    covariance = np.zeros((len(q), len(q)))
    size = np.linalg.norm(A, axis=0)
    covariance[np.ix_(seen, seen)] = louder * np.linalg.pinv((A / size).T @ (A / size)) / np.outer(size, size)
    std = np.where(seen, np.sqrt(np.maximum(np.diag(covariance), 0.0)), np.inf)
    outliers = np.flatnonzero(loud > LOUD * max(1.0, float(np.median(loud))))
    geometry, P = problem.geometry, len(problem.geometry.parameters)
    screws, home = geometry.corrected(q[:P])
    values = np.where(seen, q, 0.0)
    estimates = tuple(
        Estimate(*each) for each in zip(problem.parameters, values.tolist(), std.tolist(), seen.tolist(), strict=True)
    )
    corrected = replace(
        geometry.arm, screws=screws, home=home, description=None, moving_names=geometry.arm.moving_names
    )
    errors, faults = _errors(problem, q), suspicions(problem, q, first)
    return Calibration(
        arm=corrected,
        base=geometry.base @ exp(q[:6]),
        tool=geometry.tool @ exp(q[6:12]),
        estimates=estimates,
        before=float(_errors(problem, first).mean()),
        after=float(errors.mean()),
        held_out=held[0],
        held_out_before=held[1],
        outliers=tuple((outliers + 1).tolist()),
        errors=errors,
        warnings=(*said, *faults),
        faults=faults,
        covariance=covariance,
        problem=problem,
        unknowns=q,
    )


def _in_words(what: str, value: float, unit: str) -> str:
    kind, _, axis = what.partition(" ")
    if kind == "shift":
        return f"axis {_amount(value, unit)} toward its {axis}"
    if kind == "tilt":
        return f"tilted {_amount(value, unit)} about its {axis}"
    return f"{what} {_amount(value, unit)}"


def _amount(value: float, unit: str) -> str:
    if unit == "1":
        return f"{value:.2g}"
    return f"{1000 * value:.2f} mm" if unit == "m" else f"{np.degrees(value):.3f}°"
