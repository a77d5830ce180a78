"""The times between a spline's waypoints: gradients beside differences, core beside NumPy and a long search."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_interp_spline

from twistarm import arm_from_screws, plan_joint
from twistarm.arm import engine
from twistarm.limits import JointLimits
from twistarm.planning.spline_times import duration, in_numpy, shortest_spline

JOINTS = 7

LONG = {
    # The best of linear programs in a trust region from 16 starts (SciPy, minutes), through the waypoints of `drawn`,
    # 2 rad/s and 5 rad/s²: benchmarks/long_search.py does the same.
    "quintic": (17.760, 21.497, 16.543, 19.368),
    "cubic": (16.585, 19.418, 14.994, 17.589),
}


def drawn(seed):
    return np.random.default_rng([20260701, seed]).uniform(-2.0, 2.0, (10, JOINTS))


def rates(rows, **given):
    names = [str(row) for row in range(rows)]
    return JointLimits.unbounded(rows).with_({"velocity": 2.0, "acceleration": 5.0, **given}, names)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_a_long_search_finds_nothing_much_shorter(kind, seed):
    arm = arm_from_screws(np.eye(6)[:, [5] * JOINTS], np.eye(4), limits={"velocity": 2.0, "acceleration": 5.0})
    assert LONG[kind][seed] * (1 - 1e-3) < plan_joint(arm, drawn(seed), kind=kind).duration < 1.01 * LONG[kind][seed]


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("segments", [1, 2, 6])
def test_the_gradient_is_that_of_differences(degree, segments):
    rng = np.random.default_rng(segments)
    way, x = rng.normal(size=(segments, 3)), rng.normal(0.0, 0.4, segments)
    limits = (np.ones(3), np.array([2.0, 1.0, np.inf]), np.array([5.0, np.inf, 3.0]))
    _, gradient, _ = duration(way, degree, limits, x, 16.0)
    nudged = [
        [duration(way, degree, limits, x + by * axis, 16.0)[0] for by in (1e-6, -1e-6)] for axis in np.eye(segments)
    ]
    assert gradient == pytest.approx(-np.diff(nudged, axis=1)[:, 0] / 2e-6, abs=1e-7)


@pytest.mark.parametrize("degree", [3, 5])
def test_the_time_is_that_of_scipys_splines(degree):
    points, x = drawn(0), np.random.default_rng(1).normal(0.0, 0.4, 9)
    limits = rates(JOINTS, jerk=30.0)
    _, _, exact = duration(
        np.diff(points, axis=0), degree, (limits.velocity, limits.acceleration, limits.jerk), x, 16.0
    )
    times = np.append(0.0, np.cumsum(np.exp(x - x.mean())))
    still = [(1, np.zeros(JOINTS)), (2, np.zeros(JOINTS))]
    curve = CubicSpline(times, points, bc_type="clamped") if degree == 3 else None
    curve = make_interp_spline(times, points, k=5, bc_type=(still, still)) if curve is None else curve
    t = np.clip(np.linspace(times[:-1], times[1:], 17), 1e-12, times[-1] - 1e-12)
    slowed = [(np.abs(curve(t, order)).max() / most) ** (1 / order) for order, most in ((1, 2.0), (2, 5.0), (3, 30.0))]
    assert exact == pytest.approx(np.log(times[-1] * max(slowed)), abs=1e-6 if degree == 5 else 0.05)


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("given", [{}, {"jerk": 30.0}])
def test_core_and_numpy_find_the_same_time(degree, given):
    way, limits = np.ascontiguousarray(np.diff(drawn(0), axis=0)), rates(JOINTS, **given)
    three = (limits.velocity, limits.acceleration, limits.jerk)
    start = np.sqrt(np.abs(way).max(1))
    assert engine.core() is not None
    found = shortest_spline(way, degree, limits, start), in_numpy(way, degree, three, start)
    core, numpy = (duration(way, degree, three, np.log(each), 16.0)[2] for each in found)
    assert core == pytest.approx(numpy, abs=2e-3)
