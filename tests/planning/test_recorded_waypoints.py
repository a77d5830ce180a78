"""Recorded waypoints: many of one path, rounded, noisy, repeated, beside the time-optimal motion along that path."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from reference.phase_plane import least_time
from twistarm import Arm, arm_from_screws, plan_joint
from twistarm.cli.application import run
from twistarm.support.errors import InputError

JOINTS = 6
SPEED, ACCELERATION = 1.5, 4.0
LIMITS = {"velocity": SPEED, "acceleration": ACCELERATION}
ARM: Arm = arm_from_screws(np.eye(6)[:, [5] * JOINTS], np.eye(4), limits=LIMITS)
KEYS = np.cumsum(np.random.default_rng(2).uniform(-0.6, 0.6, (6, JOINTS)), axis=0)
PATH = CubicSpline(np.arange(6.0), KEYS, bc_type="natural")


@pytest.fixture(scope="module")
def least() -> float:
    return least_time(PATH, 5.0, SPEED, ACCELERATION)


def recorded(count: int, uneven: float = 0.0) -> np.ndarray:
    """Places of the path, evenly spaced, or each moved by up to that part of a step."""
    at = np.linspace(0.0, 5.0, count)
    at[1:-1] += np.random.default_rng(5).uniform(-uneven, uneven, count - 2) * at[1]
    return PATH(at)


def require_limits(motion, points: np.ndarray, within: float) -> None:
    assert motion.peak(1).max() <= SPEED * (1 + 1e-9)
    assert motion.peak(2).max() <= ACCELERATION * (1 + 1e-9)
    assert np.abs(motion(motion.times) - points).max() <= within * (1 + 1e-9) + 1e-12


@pytest.mark.parametrize(("kind", "most"), [("time_optimal", 1.005), ("s_curve", 1.25)])
@pytest.mark.parametrize(("count", "uneven"), [(100, 0.3), (300, 0.49), (1000, 0.0)])
def test_many_waypoints_of_a_path_take_no_longer_than_the_path(kind, most, count, uneven, least):
    motion = plan_joint(ARM, recorded(count, uneven), kind=kind)
    assert 0.99 * least < motion.duration < most * least
    require_limits(motion, recorded(count, uneven), 1e-9)


@pytest.mark.parametrize(("jerk", "shortest"), [(40.0, 3.122), (150.0, 3.018)])
@pytest.mark.parametrize("count", [50, 1000])
def test_many_waypoints_with_a_jerk_limit_take_hardly_longer_than_the_path(jerk, shortest, count):
    """The least times along PATH: linear programs one after the other over s⃛ at 480 instants (HiGHS)."""
    motion = plan_joint(ARM, recorded(count), limits={"jerk": jerk})
    assert motion.duration < 1.25 * shortest
    assert motion.peak(3).max() <= jerk * (1 + 1e-9)
    require_limits(motion, recorded(count), 1e-9)


@pytest.mark.parametrize(("kind", "most"), [("time_optimal", 1.01), ("s_curve", 1.15)])
@pytest.mark.parametrize("gap", [1e-3, 1e-5, 3e-6, 1e-8])
def test_one_more_waypoint_however_near_costs_little(kind, most, gap):
    at = np.linspace(0.0, 5.0, 20)
    without = plan_joint(ARM, PATH(at), kind=kind)
    near = at[7] + gap / np.abs(PATH(at[7], 1)).max()
    points = PATH(np.insert(at, 8, near))
    motion = plan_joint(ARM, points, kind=kind)
    assert motion.duration < most * without.duration
    require_limits(motion, points, max(gap, 1e-9) if gap < 1e-6 else 1e-9)
    beside = points.copy()
    beside[8] = points[7] + gap * np.array([1, -1, 0.5, 1, 0.2, -1])
    assert plan_joint(ARM, beside, kind=kind).duration < 1.3 * without.duration


@pytest.mark.parametrize(("kind", "most"), [("time_optimal", 1.03), ("s_curve", 2.1)])
def test_rounded_and_noisy_waypoints_are_passed_smoothly_within_a_tolerance(kind, most, least):
    points = recorded(400)
    for given, smooth in (
        (np.round(points, 2), 0.01),
        (points + np.random.default_rng(3).normal(0.0, 1e-3, points.shape), 4e-3),
    ):
        motion = plan_joint(ARM, given, kind=kind, smooth=smooth)
        assert motion.duration < most * least
        require_limits(motion, given, smooth)
        np.testing.assert_array_equal(motion.waypoints[[0, -1]], given[[0, -1]])
        assert plan_joint(ARM, given, kind=kind).duration > 2 * motion.duration  # it was worth it


def test_a_path_that_is_smooth_but_for_rounding_stays_near():
    """Without an end of the search its systems become singular."""
    t = np.linspace(0.0, 1.0, 300)[:, None]
    path = t * np.linspace(-0.2, 0.5, JOINTS) + 0.1 * t**2
    assert np.abs(plan_joint(ARM, np.round(path, 5), smooth=0.1).waypoints - path).max() < 0.1


def test_smoothing_keeps_inside_the_limits_of_joints():
    points = recorded(100)
    top = np.round(points, 2).max()
    limits = {"upper": float(top), "lower": -4.0}
    motion = plan_joint(ARM, np.round(points, 2), limits=limits, smooth=0.05)
    assert motion(np.linspace(0.0, motion.duration, 5000)).max() <= top + 1e-9


def test_a_stay_in_a_recording_costs_little(least):
    points = recorded(400)
    ends = np.repeat(points[[0, -1]], 30, axis=0)  # and at both ends
    stays = np.concatenate([ends[:30], points[:200], np.repeat(points[199:200], 60, axis=0), points[200:], ends[30:]])
    stays = np.round(stays, 3)
    motion = plan_joint(ARM, stays, kind="time_optimal", smooth=1e-3)
    assert motion.duration < 1.02 * least
    require_limits(motion, stays, 1e-3)


def test_the_command_line_smooths_in_degrees(capsys):
    u = np.linspace(0.0, 2.0, 30)
    way = [f"0 {a:.0f} {b:.0f} 0 0" for a, b in np.stack([30 * np.sin(u), 20 * u**2], axis=1)]
    durations = []
    for more in ([], ["--smooth", "0.6"]):
        assert run(["plan", "rover_arm", *(f"--to={theta}" for theta in way), "--json", *more]) == 0
        durations.append(json.loads(capsys.readouterr().out)["duration"])
    assert durations[1] < 0.8 * durations[0]
    assert run(["plan", "rover_arm", "--xyz", "0.8 0 0.6", "--smooth", "1"]) == 2


def test_what_is_no_tolerance_is_refused():
    with pytest.raises(InputError, match="smooth"):
        plan_joint(ARM, recorded(10), smooth=0.0)
