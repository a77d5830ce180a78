"""Time laws along paths, and the velocity that they follow: every limit kept, and as short as they should be."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from twistarm.limits import Actuators, JointLimits
from twistarm.planning.piecewise import JointPath
from twistarm.planning.s_curve import double_s, s_curve
from twistarm.planning.time_law import PathBounds, TimeLaw, quintic
from twistarm.planning.time_optimal import LimitedPath, path_velocity, time_optimal
from twistarm.planning.trajectory import Trajectory

LAWS = {"quintic": quintic, "time_optimal": time_optimal, "s_curve": s_curve}


def spline_path(n: int, k: int, seed: int) -> JointPath:
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (k, n))
    spline = CubicSpline(np.linspace(0.0, 1.0, k), points, bc_type="natural")
    return JointPath(spline.x, spline.c)


def limits(n: int, **rates: float) -> JointLimits:
    names = [str(j) for j in range(n)]
    return JointLimits.unbounded(n).with_({"velocity": 2.0, "acceleration": 5.0, **rates}, names)


def wrist(velocity: float) -> Actuators:
    """Two motors that both drive both joints."""
    G = np.array([[10.0, 10.0], [10.0, -10.0]])
    motors = JointLimits.unbounded(2).with_({"velocity": velocity, "acceleration": 60.0}, ["a", "b"])
    return Actuators(("a", "b"), ("x", "y"), G, np.ones(2), ("rad", "rad"), np.full(2, np.nan), motors)


def motion_of(path: JointPath, law: TimeLaw) -> Trajectory:
    breakpoints, coefficients = law.along(path)
    names = tuple(f"j{j}" for j in range(path.n))
    ends, when = path([0.0, path.length]), np.array([0.0, law.duration])
    return Trajectory(names, ("rad",) * path.n, ends, when, breakpoints, coefficients)


def excess(path: JointPath, law: TimeLaw, bounds: PathBounds, jerk: bool) -> tuple[float, float]:
    """The largest ratio of a rate to its limit, sampled 20 times a piece, and the deviation from the path [rad]."""
    motion = motion_of(path, law)
    u = np.linspace(0.0, 1.0, 20, endpoint=False)
    t = (motion.breakpoints[:-1, None] + np.diff(motion.breakpoints)[:, None] * u).ravel()
    C, worst = bounds.C, 0.0
    for order, limit in enumerate((bounds.velocity, bounds.acceleration, bounds.jerk)[: 2 + jerk], 1):
        worst = max(worst, float((np.abs(motion(t, order) @ C.T) / limit).max()))
    piece = np.searchsorted(law.breakpoints, t, side="right") - 1
    s = np.array([np.polyval(law.coefficients[:, i], x - law.breakpoints[i]) for i, x in zip(piece, t, strict=True)])
    assert (np.diff(s) > -1e-12).all()
    return worst, float(np.abs(path(s) - motion(t)).max())


@pytest.mark.parametrize("law", LAWS)
def test_limits_of_joints_motors_and_tool_are_kept_and_one_is_met(law: str) -> None:
    for path, bounds in (
        (spline_path(7, 10, 1), PathBounds(limits(7))),
        (spline_path(2, 5, 2), PathBounds(limits(2), wrist(15.0))),
        (spline_path(3, 6, 3), PathBounds(limits(3), None, np.array([np.inf, 0.1, np.inf, np.inf, 0.05]))),
    ):
        found = LAWS[law](path, bounds)
        ratio, deviation = excess(path, found, bounds, jerk=law == "s_curve")
        rate = np.polyval(np.polyder(found.coefficients[:, 0]), 0.0)
        assert rate == 0
        assert ratio < 1 + 1e-6
        assert deviation < 1e-9
        assert ratio > 0.99 or bounds.ceiling is not None


def test_the_quintic_law_on_a_line_is_the_textbook_s() -> None:
    """Lynch & Park §9.2.2.1: the peak velocity is 15/8 of the mean, the peak acceleration 10/√3 of L/T²."""
    line = JointPath([0.0, 0.25, 1.0], np.array([[[3.0], [3.0]], [[0.0], [0.75]]]))
    slow, fast = quintic(line, PathBounds(limits(1, velocity=0.5))), quintic(line, PathBounds(limits(1, velocity=90.0)))
    assert slow.duration == pytest.approx(15 / 8 * 3.0 / 0.5)
    assert fast.duration == pytest.approx(np.sqrt(10 / np.sqrt(3) * 3.0 / 5.0))


@pytest.mark.parametrize(
    ("way", "velocity", "acceleration", "jerk", "duration"),
    [
        (3.0, 2.0, 5.0, 50.0, 3.0 / 2.0 + 2.0 / 5.0 + 5.0 / 50.0),  # reaches V and A: d/V + V/A + A/J
        (0.1, 2.0, 5.0, 25.0, 4.0 * np.cbrt(0.1 / 50.0)),  # neither: 4 (d/2J)^(1/3)
        (3.0, 0.2, 5.0, 5.0, 3.0 / 0.2 + 2.0 * np.sqrt(0.2 / 5.0)),  # V, not A: d/V + 2 (V/J)^(1/2)
        (1.0, 9.0, 5.0, 50.0, 0.1 + np.sqrt(0.1**2 + 4.0 / 5.0)),  # A, not V: A/J + ((A/J)² + 4 d/A)^(1/2)
    ],
)
def test_double_s_takes_the_textbooks_time(
    way: float, velocity: float, acceleration: float, jerk: float, duration: float
) -> None:
    """Biagiotti & Melchiorri §3.4.2; the other joint, whose way is short, takes as long and stays far below."""
    bounds = PathBounds(limits(2, velocity=velocity, acceleration=acceleration, jerk=jerk))
    start, goal = np.array([1.0, -1.0]), np.array([1.0 - way, -1.0 + 0.01 * way])
    breakpoints, coefficients = double_s(start, goal, bounds)
    motion = Trajectory(
        ("a", "b"), ("rad",) * 2, np.array([start, goal]), breakpoints[[0, -1]], breakpoints, coefficients
    )
    assert motion.duration == pytest.approx(duration, rel=1e-12)
    for order in range(3):
        before = motion(breakpoints[1:-1] - 1e-12, order)
        assert np.abs(motion(breakpoints[1:-1], order) - before).max() < 1e-9
    ratios = np.array([motion.peak(order)[0] for order in (1, 2, 3)]) / (velocity, acceleration, jerk)
    assert ratios.max() == pytest.approx(1.0)
    assert motion(motion.duration - 1e-9) == pytest.approx(goal)
    assert (np.diff(motion(np.linspace(0.0, motion.duration, 200)), axis=0) * [-1.0, 1.0] >= -1e-15).all()


def test_double_s_of_joints_that_share_motors_is_straight_and_keeps_the_motors_limits() -> None:
    bounds = PathBounds(limits(2), wrist(15.0))
    _breakpoints, coefficients = double_s(np.zeros(2), np.array([1.0, 0.5]), bounds)
    assert coefficients[..., 1] == pytest.approx(0.5 * coefficients[..., 0])
    velocity = coefficients[2] @ bounds.C.T
    assert np.abs(velocity).max() == pytest.approx(15.0)
    assert double_s(np.ones(2), np.ones(2), bounds)[0].tolist() == [0.0, 0.0]


def test_where_all_joints_turn_back_at_once_the_law_goes_on() -> None:
    """q' = 0 for every joint. Joint 0 rests where it turns: legs of 1, 2, 2, 2 and 1 rad, each d / V + V / A."""
    t = np.linspace(0.0, 1.0, 40)
    wave = CubicSpline(t, np.outer(np.sin(4.0 * np.pi * t), [1.0, 0.5]), bc_type="natural")
    path, bounds = JointPath(wave.x, wave.c), PathBounds(limits(2))
    law = time_optimal(path, bounds)
    assert excess(path, law, bounds, jerk=False)[0] < 1 + 1e-6
    assert law.duration == pytest.approx(2 * 0.9 + 3 * 1.4, rel=0.002)


def test_velocity_limits_that_limit_nothing_do_no_harm():
    """1e9 rad/s, as descriptions write it: 2 √(D/a) still (Lynch & Park §9.2.2.2)."""
    limits = JointLimits.unbounded(1).with_({"velocity": 1e9, "acceleration": 5.0}, ["a"])
    path = JointPath(np.array([0.0, 1.0]), np.array([[[3.0]], [[0.0]]]))
    x = path_velocity(LimitedPath.of(path, PathBounds(limits)), np.linspace(0.0, 1.0, 201)).x
    assert (0.01 / (np.sqrt(x[1:]) + np.sqrt(x[:-1]))).sum() == pytest.approx(2.0 * np.sqrt(3.0 / 5.0), rel=1e-6)
