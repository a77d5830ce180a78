"""`calibrate`: the arm's true axes and zeros from measurements of its tool."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, as_flag, as_positive, as_theta, require, require_choice
from ..support.errors import InputError, listed
from ..support.errors import shown as brief
from ..theory.screws import exp
from .calibration import Calibration, Estimate
from .geometry import Geometry
from .log_checks import faults_of, refuse_unusable
from .measurements import Bools, Measurements, Rows, joined, read_measurements
from .problem import LOUD, MOST_STD, Problem, descend, observable, started

Frame = Literal["fit", "held"]
Log = Measurements | str | os.PathLike[str]

FOLDS, BLOCK = 5, 0.2
USUAL = {"zero": 0.2, "shift": 0.002, "tilt": 0.01, "scale": 0.1, "eccentricity": 0.1}
"""How far joints are out as a rule [m, rad, 1]: what the fit knows before the log."""


def calibrate(
    arm: Arm,
    measurements: Log | Sequence[Log],
    *,
    base: Frame = "fit",
    tool: Frame = "fit",
    position_noise: float = 1e-4,
    orientation_noise: float = 1e-3,
    distances: dict[tuple[str, str], float] | None = None,
    distance_noise: float = 1e-4,
    scales: bool = False,
    eccentricity: bool = False,
    robust: bool = True,
) -> Calibration:
    """Fit an arm's axes and joint zeros to measurements of its tool, with base and tool beside them.

    The model is `geometry.Geometry`, a local product of exponentials. Each turning joint has 4 parameters and each
    slide 2; base and tool have 6 each. Zeros, scales and eccentricities come on top. A parameter that the log does
    not show beside the others is held at 0 and named. Base and tool come first, then zeros, then axes: first what
    would show most if it were out by its usual size. The choice follows from the nominal arm and the rows'
    configurations. Without positions or poses the base is the arm's own.

    Args:
        arm: The nominal arm.
        measurements: A `Measurements`, the path of a CSV file (`read_measurements`), or several of them. Places of the
            same name are the same.
        base: "fit", or "held" where the positions are in the base frame.
        tool: "fit", or "held" where the measured point is the arm's tip.
        position_noise: Standard deviation of rows without their own [m].
        orientation_noise: Standard deviation of measured orientations [rad].
        distances: Known distances {(point, point): m} between resting points.
        distance_noise: Standard deviation of each of them [m].
        scales: Fit a scale of each joint's drive too.
        eccentricity: Fit sine and cosine of each joint's angle too, as an eccentric gear gives.
        robust: Weigh outliers down (Cauchy's loss).

    Returns:
        The `Calibration`.

    Raises:
        InputError: The log is unusable: too few rows, angles in degrees, positions in millimetres.
    """
    require_arm(arm)
    for choice, name in ((base, "base"), (tool, "tool")):
        require_choice(choice, ("fit", "held"), name)
    log = _read(arm, measurements)
    geometry = Geometry(arm, np.eye(4), np.eye(4), as_flag(scales, "scales"), as_flag(eccentricity, "eccentricity"))
    noise = as_positive(position_noise, "position_noise"), as_positive(orientation_noise, "orientation_noise")
    known, apart = _distances(distances, log), as_positive(distance_noise, "distance_noise")
    usual = [0.0] * 12 + [1.0 / USUAL[each.what.split()[0]] for each in geometry.parameters[12:]]
    problem, _ = Problem(geometry, log, noise, np.array(usual), known, apart).placed()
    fitted = _fitted(problem, base == "fit", tool == "fit")
    said = refuse_unusable(problem, fitted)
    problem, q = started(problem, bool(fitted[:6].any()), fitted[6:12])
    seen = _shown(problem, q, fitted)
    frames = seen.copy()
    frames[12 : problem.P] = False
    first = descend(problem, q, frames, robust=as_flag(robust, "robust"))[0]
    q, weights = descend(problem, first, seen, robust=robust)
    faults = faults_of(problem, q, first)
    held = {"folds": (np.inf, np.inf), "block": (np.inf, np.inf)}
    if not faults:
        loud = float(np.median(problem.loudness(q)))
        if loud > LOUD:
            said = (*said, f"the rows fit {loud:.0f} times worse than the stated noise: something is not explained")
        held = {part: _held_out(problem, first, seen, left, robust) for part, left in _parts(problem)}
    return _result(problem, q, seen, fitted, weights, first, held, said, faults)


def _read(arm: Arm, measurements: Log | Sequence[Log]) -> Measurements:
    several = [measurements] if isinstance(measurements, (Measurements, str, os.PathLike)) else measurements
    if not isinstance(several, (list, tuple)):
        raise InputError(f"measurements must be a log or a sequence of logs; got {brief(several)}")
    parts = [each if isinstance(each, Measurements) else read_measurements(each, arm) for each in several]
    if not parts:
        raise InputError("calibrate needs one log or more; got none")
    for part in parts:
        as_theta(part.theta, arm.n, "theta", arm.joint_names)
    return joined(parts)


def _distances(distances: dict[tuple[str, str], float] | None, log: Measurements) -> dict[tuple[str, str], float]:
    known = {}
    given = {} if distances is None else require(distances, dict, "distances", '{("left", "right"): 0.05}')
    for pair, length in given.items():
        if not isinstance(pair, tuple) or len(pair) != 2 or not set(pair) <= set(log.point) or pair[0] == pair[1]:
            points = listed(dict.fromkeys(filter(None, log.point))) or "none"
            raise InputError(f"distances join two points of the log ({points}); got {pair!r}")
        known[pair] = as_positive(length, f"distance of {pair}")
    return known


def _fitted(problem: Problem, base: bool, tool: bool) -> Bools:
    """The unknowns (Q,) that may move: without a measured frame not the base; turns of a tool only by poses."""
    may = np.ones(len(problem.parameters), dtype=bool)
    may[:6] = base and bool(problem.log.located.any())
    may[6:12] = tool
    may[9:12] &= bool(np.isfinite(problem.log.rotation).any())
    return may


def _shown(problem: Problem, q: Array, fitted: Bools) -> Bools:
    """The unknowns (Q,) that the log shows: places, base and tool rather than zeros, and zeros rather than axes."""
    usual = np.ones(len(q))
    usual[12 : problem.P] /= problem.usual[12:]
    most = np.array([MOST_STD[parameter.unit] for parameter in problem.parameters])
    seen, ones = fitted, np.ones(len(problem.log.theta))
    for resting in (False, True):  # the one shows what is the tool's as well, the other what is the base's as well
        seen = observable(problem.slopes(q, ones, resting=resting)[: -problem.P], usual * seen, most)
    return seen


def _errors(problem: Problem, q: Array) -> Array:
    """The distance (K,) [m] between computed and measured."""
    return np.asarray(np.linalg.norm(problem.misses(q)[:, :3], axis=1))


def _parts(problem: Problem) -> tuple[tuple[str, list[Rows]], ...]:
    """The rows that are left out of a fit in turn: folds, and the far end of the workspace, or of the joints.

    Folds are random. Without positions they are places, those with a known distance together, if there are several.
    """
    K, located = len(problem.log.theta), problem.log.located
    fold = np.random.default_rng(0).permutation(K) % min(FOLDS, K)
    placements, of_row = np.unique(problem.placements, return_inverse=True)
    if not located.any() and len(placements) > 1:
        fold = of_row % FOLDS
    where = problem.log.position if located.all() else problem.log.theta
    along = where @ np.linalg.svd(where - where.mean(axis=0), full_matrices=False)[2][0]
    far = np.flatnonzero(along > np.quantile(along, 1.0 - BLOCK))
    return ("folds", [np.flatnonzero(fold == k) for k in np.unique(fold)]), ("block", [far])


def _held_out(problem: Problem, first: Array, seen: Bools, parts: list[Rows], robust: bool) -> tuple[float, float]:
    """The mean error [m] on rows left out: with all that their rest shows, and with base and tool alone.

    Each fit begins at the unknowns with base and tool alone. A place that the rest does not have is fitted to the rows
    left out. The loudest percent of the rows does not count, because an outlier tells nothing of the arm. Infinity: a
    rest has no more numbers than unknowns.
    """
    K, P = len(problem.log.theta), problem.P
    errors = np.full((2, K), np.nan)
    for left in parts:
        rest = problem.of_rows(np.setdiff1d(np.arange(K), left))
        new = np.isin(np.arange(len(problem.places)), rest.place, invert=True)
        own = np.zeros(len(first), dtype=bool)
        own[P:] = np.repeat(new, 3)
        free = _shown(rest, first, seen & ~own)
        if rest.numbers <= free.sum():
            return np.inf, np.inf
        frames = free.copy()
        frames[12:P] = False
        q = descend(rest, first, frames, robust=robust)[0]
        for i, fitted in enumerate((descend(rest, q, free, robust=robust)[0], q)):
            errors[i, left] = _errors(problem, descend(problem.of_rows(left), fitted, own)[0])[left]
    few = errors[1] <= np.nanquantile(errors[1], 0.99)
    return float(errors[0, few].mean()), float(errors[1, few].mean())


def _covariance(problem: Problem, q: Array, free: Bools, weights: Array) -> Array:
    """The covariance (Q, Q) of the `free` unknowns. The noise is at least the stated; a louder log makes it larger."""
    r, A = problem.residual(q, weights), problem.slopes(q, weights)[:, free]
    louder = max(1.0, float(r @ r) / max(1, len(r) - A.shape[1]))
    covariance, size = np.zeros((len(q), len(q))), np.linalg.norm(A, axis=0)
    covariance[np.ix_(free, free)] = (
        louder * np.linalg.pinv((A / size).T @ (A / size), rcond=1e-12) / np.outer(size, size)
    )
    return covariance


def _result(
    problem: Problem, q: Array, seen: Bools, fitted: Bools, weights: Array, first: Array,
    held: dict[str, tuple[float, float]], said: tuple[str, ...], faults: tuple[str, ...],
) -> Calibration:  # fmt: skip
    geometry, loud = problem.geometry, problem.loudness(q)
    std = np.where(seen, np.sqrt(np.maximum(np.diag(_covariance(problem, q, seen, weights)), 0.0)), np.inf)
    each = zip(problem.parameters, np.where(seen, q, 0.0).tolist(), std.tolist(), seen.tolist(), strict=True)
    screws, home = geometry.corrected(q[: problem.P])
    return Calibration(
        arm=replace(geometry.arm, screws=screws, home=home, description=None, moving_names=geometry.arm.moving_names),
        base=geometry.base @ exp(q[:6]),
        tool=geometry.tool @ exp(q[6:12]),
        estimates=tuple(Estimate(*one) for one in each),
        before=_errors(problem, first),
        after=_errors(problem, q),
        held_out=held["folds"][0],
        held_out_before=held["folds"][1],
        block=held["block"][0],
        block_before=held["block"][1],
        outliers=tuple((np.flatnonzero(loud > LOUD * max(1.0, float(np.median(loud)))) + 1).tolist()),
        warnings=(*said, *faults),
        faults=faults,
        covariance=_covariance(problem, q, fitted, weights),
        problem=problem,
        unknowns=q,
    )
