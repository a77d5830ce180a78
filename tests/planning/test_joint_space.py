"""`plan_joint`: the laws of every kind, how long a motion takes, times that are given."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from joint_space_cases import ARM, LAWS, MET, PASSES, PATH, RATE, RATES, SPLINES, TIMED, WAYS, use
from strategies import generators
from twistarm.limits import Actuators, JointLimits
from twistarm.planning import plan_joint
from twistarm.planning.waypoints import MERGE_TOL
from twistarm.support.errors import InputError, LimitError

few = settings(max_examples=15)


@st.composite
def tasks(draw):
    """Waypoints inside ARM's position limits, some repeated or nearly so, and limits of several orders."""
    rng = draw(generators)
    k = int(rng.integers(2, 8))
    points = rng.uniform(0.6 * ARM.limits.lower, 0.6 * ARM.limits.upper, (k, 3))
    for i in range(1, k):
        if rng.random() < 0.25:
            points[i] = points[i - 1] + rng.choice([0.0, 1e-9, 1e-5, 1e-3]) * rng.normal(size=3)
    still = rng.random(3) < 0.2
    points[:, still] = points[0, still]
    rates = {name: 10.0 ** rng.uniform(-1.5, 1.5, 3) for name in ("velocity", "acceleration")}
    return points, ARM.limits.with_(rates, ARM.joint_names)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_limits_are_kept_and_waypoints_are_passed_from_rest_to_rest(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    assert np.array_equal(motion.waypoints, points)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert np.array_equal(motion(-1.0), points[0])
    assert np.array_equal(motion(motion.duration), points[-1])
    assert motion.times[0] == 0
    assert motion.times[-1] == motion.duration
    if motion.duration == 0:
        return
    used = use(motion, limits, kind)
    assert 1.0 - MET < used < 1.0 + RATE
    ends, near = [0.0, motion.duration], 1e-12 * motion.duration
    assert (motion(ends, 1) == 0).all()
    speed = np.abs(motion([near, motion.duration - near], 1))
    assert (speed <= 2 * near * motion.peak(2) + PASSES * motion.peak(1)).all()
    if kind == "s_curve":
        assert np.abs(motion(ends, 2)).max() <= 1e-6 * motion.peak(2).max()
    if stop:
        assert np.abs(motion(motion.times, 1)).max() <= 1e-6 * motion.peak(1).max()
        assert_between(motion, points)
        if kind == "time_optimal":
            assert_straight(motion, points)


def assert_between(motion, points):
    """From each waypoint to the next, never beyond both."""
    for a, b, start, goal in zip(motion.times[:-1], motion.times[1:], points[:-1], points[1:], strict=True):
        theta = motion(np.linspace(a, b, 51))
        assert (theta >= np.minimum(start, goal) - MERGE_TOL - PASSES).all()
        assert (theta <= np.maximum(start, goal) + MERGE_TOL + PASSES).all()


def assert_straight(motion, points):
    for a, b, start, goal in zip(motion.times[:-1], motion.times[1:], points[:-1], points[1:], strict=True):
        line, step = motion(np.linspace(a, b, 7)[1:-1]) - start, goal - start
        across = line - np.outer(line @ step, step) / max(step @ step, 1e-300)
        assert b == a or np.abs(across).max() <= MERGE_TOL + PASSES


@pytest.mark.parametrize(
    ("kind", "times"), [("Cubic", None), ("trapezoid", None), (3, None), ("cubic", None), ("s_curve", [0, 2, 5, 9])]
)
def test_a_kind_that_does_not_go_with_the_times_lists_those_that_do(kind, times):
    with pytest.raises(InputError) as error:
        plan_joint(ARM, PATH, kind=kind, times=times, limits=RATES)
    assert all(name in str(error.value) for name in (LAWS if times is None else SPLINES))


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_progress_rises_to_one(kind, stop):
    seen = []
    plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES, progress=seen.append)
    assert all(0 < a <= b for a, b in itertools.pairwise(seen))
    assert seen[-1] == 1.0


def test_rates_far_apart_are_no_trouble():
    for kind, stop in WAYS:
        for rates in ({"velocity": 1e-3, "acceleration": 1e6}, {"velocity": 1e6, "acceleration": 1e-3}):
            limits = ARM.limits.with_(rates, ARM.joint_names)
            motion = plan_joint(ARM, PATH, kind=kind, limits=limits, stop_at_waypoints=stop)
            assert use(motion, limits, kind) == pytest.approx(1.0, rel=MET)


@pytest.mark.parametrize("acceleration", [10.0, 1e6])
def test_a_long_motion_keeps_its_short_segments_and_ramps(acceleration):
    rng = np.random.default_rng(1)
    points = np.repeat(rng.uniform(-0.4, 0.4, (60, 3)), 2, axis=0)
    points[1::2] += 3e-6
    limits = ARM.limits.with_({"velocity": 0.01, "acceleration": acceleration}, ARM.joint_names)
    for kind in LAWS:
        motion = plan_joint(ARM, points, kind=kind, limits=limits, stop_at_waypoints=True)
        assert use(motion, limits, kind) == pytest.approx(1.0, rel=MET)
        assert np.abs(motion(motion.times) - points).max() <= PASSES


@pytest.mark.parametrize(("kind", "stop"), TIMED)
def test_given_times_are_kept_and_missing_rates_not_asked_for(kind, stop):
    times = [0.0, 2.0, 5.0, 9.0]
    motion = plan_joint(ARM, PATH, kind=kind, times=times, stop_at_waypoints=stop)
    assert motion.times.tolist() == times
    assert motion.duration == 9.0
    assert np.allclose(motion(times), PATH)


@pytest.mark.parametrize(("kind", "stop"), TIMED)
def test_times_that_are_too_short_are_refused_with_the_factor_that_helps(kind, stop):
    short = np.array([0.0, 0.3, 0.8, 1.2])
    with pytest.raises(LimitError, match="its (velocity|acceleration) limit is") as error:
        plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=short)
    factor = float(str(error.value).split("multiply times by ")[1].split(",")[0])
    motion = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=factor * short)
    assert use(motion, motion.limits) == pytest.approx(1.0, rel=2e-3)


def test_equal_waypoints_at_different_times_are_a_dwell():
    for kind in SPLINES:
        motion = plan_joint(
            ARM, [PATH[0], PATH[1], PATH[1], PATH[2]], kind=kind, times=[0, 3, 5, 8], stop_at_waypoints=True
        )
        assert np.allclose(motion(np.linspace(3, 5, 9)), PATH[1], atol=1e-12)


@pytest.mark.parametrize(
    ("times", "text"),
    [
        ([0, 1], "one instant per waypoint"),
        ([1, 2, 3, 4], "start at 0"),
        ([0, 2, 2, 3], "increase strictly"),
        ([0, 1, np.nan, 3], "finite"),
        ([0, 1e-9, 2, 3], "no segment under"),
        ([0, 1e300, 2e300, 3e300], "must span"),
        ("soon", "real numbers"),
    ],
)
def test_times_that_make_no_sense(times, text):
    with pytest.raises(InputError, match=text):
        plan_joint(ARM, PATH, times=times)


LIMITS = {"lower": -3.0, "upper": 3.0, "velocity": 2.0, "acceleration": 5.0}
POINTS = np.random.default_rng(4).uniform(-1.0, 1.0, (8, ARM.n))


def test_stopping_everywhere_takes_the_time_of_the_single_ways() -> None:
    ways = np.abs(np.diff(POINTS, axis=0)).max(axis=1)
    alone = np.where(ways > 2.0**2 / 5.0, ways / 2.0 + 2.0 / 5.0, 2.0 * np.sqrt(ways / 5.0))  # Lynch & Park §9.2.2.2
    motions = {
        (kind, stop): plan_joint(ARM, POINTS, kind=kind, limits=LIMITS, stop_at_waypoints=stop).duration
        for kind, stop in WAYS
    }
    assert motions["time_optimal", True] == pytest.approx(alone.sum(), rel=1e-9)
    assert min(motions, key=motions.__getitem__) == ("time_optimal", False)
    assert motions["s_curve", False] < motions["s_curve", True]


def test_where_a_path_turns_back_the_motion_stops_there() -> None:
    """Out and back by one joint: resting in the middle takes 2 (d/v + v/a), as no smooth curve does."""
    out = np.array([[0, 0, 0], [0, 1, 0], [0, 0, 0]], dtype=float)
    motion = plan_joint(ARM, out, kind="time_optimal", limits=LIMITS)
    assert motion.duration <= 2 * (1.0 / 2.0 + 2.0 / 5.0) * (1 + 1e-9)


@pytest.mark.parametrize("count", [30, 100])
def test_many_waypoints_are_passed_though_the_first_grid_is_coarse(count: int) -> None:
    points = np.random.default_rng(0).uniform(ARM.limits.lower, ARM.limits.upper, (count, ARM.n))
    rates = {"velocity": 2.0, "acceleration": {"slide": 1, "shoulder": 2, "elbow": 4}}
    motion, stops = (
        plan_joint(ARM, points, kind="time_optimal", limits=rates, stop_at_waypoints=stop) for stop in (False, True)
    )
    assert motion(motion.times) == pytest.approx(points, abs=2e-9)
    assert motion.duration <= stops.duration * (1 if count > 30 else 0.999)


@pytest.mark.parametrize("kind", LAWS)
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
    if kind == "time_optimal":
        with pytest.raises(LimitError, match=r"motor 'm\d' would need .* limit is .*: multiply times by"):
            plan_joint(arm, POINTS, limits={"lower": -3.0, "upper": 3.0}, times=0.8 * planned.times)
    motion = planned.to_motors()
    rates = [(1, 60.0), (2, 200.0), *([(3, 2000.0)] if kind == "s_curve" else [])]
    assert 1.0 - MET < max(motion.peak(order).max() / limit for order, limit in rates) < 1.0 + RATE
