"""plan_joint's kinds that a time law times: time-optimal, and double-S from stop to stop."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from joint_space_cases import ARM
from twistarm import InputError, LimitError, plan_joint
from twistarm.limits import Actuators, JointLimits
from twistarm.planning.trajectory import Trajectory

LIMITS = {"lower": -3.0, "upper": 3.0, "velocity": 2.0, "acceleration": 5.0}
POINTS = np.random.default_rng(4).uniform(-1.0, 1.0, (8, ARM.n))


def require_inside(motion: Trajectory, points: np.ndarray) -> None:
    """Passes every waypoint, at rest at both ends, keeps the limits and is at one of them."""
    assert motion(motion.times) == pytest.approx(points, abs=2e-9)
    assert np.abs(motion(np.array([1e-12, motion.duration - 1e-12]), 1)).max() < 1e-9
    rates = motion.peak(1).max() / 2.0, motion.peak(2).max() / 5.0
    assert 1.0 - 1e-3 < max(rates) < 1.0 + 1e-6


@pytest.mark.parametrize(("kind", "stop"), [("time_optimal", False), ("time_optimal", True), ("s_curve", False)])
def test_waypoints_are_passed_inside_the_limits(kind: str, stop: bool) -> None:
    points = np.concatenate([POINTS[:1], POINTS, POINTS[-1:] + 1e-9])
    motion = plan_joint(ARM, points, kind=kind, limits=LIMITS, stop_at_waypoints=stop)
    require_inside(motion, points)
    at_rest = np.abs(motion(motion.times, 1)).max(axis=1) < 1e-9
    assert at_rest.all() == (stop or kind == "s_curve")
    assert (motion.times[:2] == 0).all()
    assert plan_joint(ARM, [POINTS[0]] * 3, kind=kind, limits=LIMITS).duration == 0


def test_a_time_optimal_motion_is_shorter_than_the_other_splines_and_than_stopping() -> None:
    durations = {
        (kind, stop): plan_joint(ARM, POINTS, kind=kind, limits=LIMITS, stop_at_waypoints=stop).duration
        for kind in ("cubic", "time_optimal")
        for stop in (False, True)
    }
    assert min(durations, key=durations.__getitem__) == ("time_optimal", False)
    straight = plan_joint(ARM, POINTS, kind="trapezoid", limits=LIMITS).duration
    assert durations["time_optimal", True] == pytest.approx(straight, rel=1e-3)


@pytest.mark.parametrize("count", [30, 100])
def test_many_waypoints_are_passed_though_the_first_grid_is_coarse(count: int) -> None:
    points = np.random.default_rng(0).uniform(ARM.limits.lower, ARM.limits.upper, (count, ARM.n))
    rates = {"velocity": 2.0, "acceleration": {"slide": 1, "shoulder": 2, "elbow": 4}}
    motion, stops = (plan_joint(ARM, points, kind=kind, limits=rates) for kind in ("time_optimal", "trapezoid"))
    assert motion(motion.times) == pytest.approx(points, abs=2e-9)
    assert motion.duration < stops.duration


@pytest.mark.parametrize("kind", ["cubic", "quintic", "trapezoid", "time_optimal", "s_curve"])
def test_limits_of_motors_are_kept(kind: str) -> None:
    G = np.eye(ARM.n) * 50.0
    G[0, 1], G[1, 0] = 50.0, -50.0
    names = tuple(f"m{j}" for j in range(ARM.n))
    most = JointLimits.unbounded(ARM.n).with_({"velocity": 60.0, "acceleration": 200.0}, names)
    motors = Actuators(
        names, ARM.joint_names, G, np.zeros(ARM.n), ("rad",) * ARM.n, np.full(ARM.n, np.nan), limits=most
    )
    arm = replace(ARM, actuators=motors)
    planned = plan_joint(arm, POINTS, kind=kind, limits=LIMITS)
    if kind == "cubic":
        with pytest.raises(LimitError, match=r"motor 'm\d' would need .* limit is .*: multiply times by"):
            plan_joint(arm, POINTS, limits=LIMITS, times=0.9 * planned.times)
    motion = planned.of_motors()
    ratio = max(motion.peak(1).max() / 60.0, motion.peak(2).max() / 200.0)
    assert 1.0 - 1e-3 < ratio < 1.0 + 1e-6


def test_an_s_curve_takes_the_times_given_or_says_how_long_it_needs() -> None:
    motion = plan_joint(ARM, POINTS[:3], kind="s_curve", limits=LIMITS, times=[0.0, 5.0, 7.5])
    assert motion.times.tolist() == [0.0, 5.0, 7.5]
    assert motion.peak(3).max() < 50.0
    waits = plan_joint(ARM, POINTS[[0, 0, 1]], kind="s_curve", limits=LIMITS, times=[0.0, 1.0, 5.0])
    assert waits(0.9) == pytest.approx(POINTS[0])
    with pytest.raises(LimitError, match=r"from waypoint 1 \(counted from 0\) to the next takes .*: multiply times by"):
        plan_joint(ARM, POINTS[:3], kind="s_curve", limits=LIMITS, times=[0.0, 5.0, 5.1])
    with pytest.raises(InputError, match="time_optimal motion takes no times"):
        plan_joint(ARM, POINTS[:3], kind="time_optimal", limits=LIMITS, times=[0.0, 5.0, 7.5])
    assumed = plan_joint(ARM, POINTS[:3], kind="s_curve", limits={**LIMITS, "acceleration": np.inf})
    assert "acceleration 3 rad/s²" in assumed.notes[0]
