"""Times of waypoints: the shortest found that keep the limits of velocity, acceleration and jerk."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..arm import engine
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import InputError
from . import spline
from .joint_path import JointPath
from .piecewise import derivative, evaluate, rescaled
from .pulling_in import pulled_in
from .spans import MARGIN, Progress, require_span
from .time_laws.bounds import PathBounds
from .time_laws.jerk_limited import fastest_passes
from .waypoint_laws import fastest_along_spline
from .within import RATE_TOL, slowed_by, stretch_needed

Fit = Callable[[Array, Array], Array]

ROUNDS = 40
"""Corrections of a pulled-in spline; what further ones gain is below 1 %."""

CORRECTION = 0.5
"""Power of a correction: whole steps swing, because a spline answers one segment with its neighbours."""

LEAST_PART = 1e-5
"""Least share of a segment or ramp in the duration. Shorter ones are lost when they are added to the times."""

ROUNDING = 1e-14
"""No ramp at given times is shorter than this part of the whole."""

FEW_WAYPOINTS = 30
"""With at most so many waypoints, a search begins with the time that each segment takes alone."""

MOST_KNOTS = 1000
"""Greatest number of knots of the spline for the first motion with jerk limits."""

INSTANTS = 20_001
"""Samples of that motion, to find when it reaches the waypoints."""

DIVERGED = 1.2
"""A search that is longer than its best by this factor does not come back."""


def fastest_spline(
    waypoints: Array, degree: int, fit: Fit, bounds: PathBounds, progress: Progress | None = None
) -> tuple[Array, Array, Array]:
    """Times (k,), breakpoints and coefficients of `fit`, its worst rate just meeting its limit.

    Stretching the whole motion by one factor makes it meet its limits exactly. `shortest_spline` searches the
    proportions of its segments. Through few waypoints it starts from the time that each segment takes alone. Through
    more it starts from the fastest motion along a path (`jerk_limited` with jerk limits). A spline that leaves the
    position limits is pulled in. Then slack segments are shortened and those that set the factor lengthened. The
    shortest motion is taken.
    """
    way = np.ascontiguousarray(np.diff(waypoints, axis=0) @ bounds.C.T)
    least = np.maximum(np.abs(way) / bounds.velocity, np.sqrt(np.abs(way) / bounds.acceleration)).max(-1)
    least = np.diff(_accumulated(least))
    start = least if len(waypoints) <= FEW_WAYPOINTS else _along_path(waypoints, degree, bounds)
    times = _accumulated(shortest_spline(way, degree, bounds.rates, start))
    best = times, *pulled_in(fit(waypoints, times), times, waypoints, bounds.limits)
    if len(best[1]) > len(times):
        best = min(_search(waypoints, fit, bounds, np.diff(times), progress), key=lambda motion: float(motion[0][-1]))
    times, breakpoints, coefficients = best
    factor = slowed_by(coefficients @ bounds.C.T, np.diff(breakpoints), bounds.rates) * (1.0 + MARGIN)
    return times * factor, breakpoints * factor, rescaled(coefficients, 1.0 / factor)


def shortest_spline(way: Array, degree: int, rates: JointLimits, durations: Array) -> Array:
    """Durations (s,), up to one factor, of the shortest motion found near the given ones, by the compiled core.

    The cubic or quintic spline goes `way` (s, r) on each segment, each row within its `rates`. L-BFGS minimizes the
    logarithm of its time (core/include/twistarm/planning/spline_times.hpp). Raises TwistarmError without the core.
    """
    core = engine.need("the shortest spline")
    found: Array | None = core.shortest_spline(way, rates.velocity, rates.acceleration, rates.jerk, durations, degree)
    if found is None:
        raise InputError(f"a spline is timed through at most a million waypoints; got {len(way) + 1}")
    return found


def _along_path(waypoints: Array, degree: int, bounds: PathBounds) -> Array:
    """Durations (k − 1,) on the fastest motion along a path through the waypoints."""
    inside = np.isfinite(bounds.rates.jerk).any()
    times = _inside_jerk(waypoints, degree, bounds) if inside else fastest_along_spline(waypoints, bounds)[0]
    return np.diff(_accumulated(np.diff(times)))


def _inside_jerk(waypoints: Array, degree: int, bounds: PathBounds) -> Array:
    """Times (k,) of the waypoints on the fastest motion inside all limits along a spline."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))])
    kept = np.unique(np.linspace(0, len(way) - 1, min(len(way), MOST_KNOTS)).round().astype(np.intp))
    path = JointPath(way[kept], spline.unforced(waypoints[kept], way[kept]))
    fit = spline.cubic if degree == 3 else spline.quintic
    tried: list[Array] = []

    def excess(s: Array, t: Array) -> tuple[Array, Array]:
        rates = _largest_rates(fit(waypoints, tried[-1]) @ bounds.C.T, np.diff(tried[-1]), bounds)
        first, last = (np.clip(np.searchsorted(tried[-1], each) - 1, 0, len(way) - 2) for each in (t[:-2], t[2:]))
        most = [np.array([rate[i : j + 1].max() for i, j in zip(first, last, strict=True)]) for rate in rates]
        return most[0], most[1]

    for s, t in fastest_passes(path, bounds, excess, smooth_ends=degree == 5):
        instants = np.linspace(0.0, t[-1], INSTANTS)
        law = JointPath(t, fit(s[:, None], t))
        tried.append(np.interp(way, np.maximum.accumulate(law(instants)[:, 0]), instants))

    def needed(times: Array) -> float:
        """How long the motion takes at these times once it is slowed to its limits."""
        return float(times[-1]) * slowed_by(fit(waypoints, times) @ bounds.C.T, np.diff(times), bounds.rates)

    return min(tried, key=needed)


def _largest_rates(rows: Array, durations: Array, bounds: PathBounds) -> list[Array]:
    """Acceleration and jerk at the ends of each segment (k − 1,), as a share of the limit."""
    tau = durations[:, None] * np.array([0.0, 1.0])[:, None, None]
    return [
        np.max(np.abs(evaluate(derivative(rows, order), tau)) / limit, axis=(0, 2))
        for order, limit in ((2, bounds.rates.acceleration), (3, bounds.rates.jerk))
    ]


def fastest_rests(waypoints: Array, fit: Fit, bounds: PathBounds) -> Array:
    """Times (k,) of a `fit` that rests at every waypoint, with the shortest segments."""
    unhurried = np.arange(len(waypoints), dtype=np.float64)
    needed = stretch_needed(fit(waypoints, unhurried) @ bounds.C.T, np.diff(unhurried), bounds.rates)
    return _accumulated(needed * (1.0 + MARGIN))


def fastest_trapezoid(waypoints: Array, bounds: PathBounds) -> tuple[Array, Array]:
    """Times (k,) and ramps (k − 1,) of trapezoidal segments: full acceleration, full speed, full braking.

    The fraction travelled may have speed V = min v_j / |Δ_j| and acceleration A = min a_j / |Δ_j|, j each joint and
    motor. It takes 1/V + V/A, or 2/√A if V² ≥ A (Lynch & Park §9.2.2.2).
    """
    V, A = _line_limits(waypoints, bounds)
    ramps = np.minimum(V / A, np.sqrt(1.0 / A))
    ramps = np.maximum(ramps, LEAST_PART * (ramps + 1.0 / V).sum())
    durations = ramps + np.maximum(1.0 / V, ramps)
    return _accumulated(durations * (1.0 + MARGIN)), ramps * (1.0 + MARGIN)


def trapezoid_ramps(waypoints: Array, times: Array, bounds: PathBounds) -> Array:
    """Ramps (k − 1,) [s] of trapezoidal segments at given times, close to a third if possible.

    A ramp r of a segment of length T needs the speed 1/(T − r) ≤ V and the acceleration 1/(r (T − r)) ≤ A. If no ramp
    meets both, the result is too fast.
    """
    V, A = _line_limits(waypoints, bounds)
    T = np.diff(times)
    least = 0.5 * (T - np.sqrt(np.maximum(T**2 - 4.0 / A, 0.0)))
    most = np.minimum(T - 1.0 / V, 0.5 * T)
    feasible = most >= least * (1.0 - RATE_TOL)
    ramps: Array = np.where(feasible, np.clip(T / 3.0, least, most), T / 3.0)
    return np.maximum(ramps, ROUNDING * times[-1])


def _search(
    waypoints: Array, fit: Fit, bounds: PathBounds, durations: Array, progress: Progress | None
) -> Iterator[tuple[Array, Array, Array]]:
    """Motions that nearly meet the limits, each in better proportion than the last."""
    shortest = np.inf
    for done in range(1, ROUNDS + 1):
        times = _accumulated(durations)
        breakpoints, coefficients = pulled_in(fit(waypoints, times), times, waypoints, bounds.limits)
        rates = stretch_needed(coefficients @ bounds.C.T, np.diff(breakpoints), bounds.rates)
        needed = np.maximum.reduceat(rates, np.searchsorted(breakpoints, times[:-1]))
        factor = float(needed.max()) * (1.0 + MARGIN)
        if not factor * times[-1] < DIVERGED * shortest:
            return
        shortest = min(shortest, factor * float(times[-1]))
        yield times * factor, breakpoints * factor, rescaled(coefficients, 1.0 / factor)
        if progress is not None:
            progress(done / ROUNDS)
        durations = durations * factor * (needed / factor) ** CORRECTION


def _line_limits(waypoints: Array, bounds: PathBounds) -> tuple[Array, Array]:
    """Largest speed [1/s] and acceleration [1/s²] of the fraction travelled of each segment, (k − 1,) each.

    Infinite where nothing that moves is limited.
    """
    distances = np.abs(np.diff(waypoints, axis=0) @ bounds.C.T)
    speed, acceleration = (distances / bounds.velocity).max(-1), (distances / bounds.acceleration).max(-1)
    with np.errstate(divide="ignore"):
        return 1.0 / speed, 1.0 / acceleration


def _accumulated(durations: Array) -> Array:
    """Times (k,) from the durations between them, none too short beside the whole."""
    total = float(durations.sum())
    require_span(total)
    return np.concatenate([[0.0], np.cumsum(np.maximum(durations, LEAST_PART * total))])
