"""`plan_joint`: the laws of every kind, how long a motion takes, times that are given."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from joint_space_cases import ARM, KINDS, MET, PASSES, PATH, RATE, RATES, STRAIGHT, WAYS, use
from strategies import generators
from twistarm.limits import Actuators, JointLimits
from twistarm.planning import plan_joint
from twistarm.planning.joint_space import MERGE_TOL
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
    t = np.linspace(0, motion.duration, 3001)
    for order, limit in ((1, limits.velocity), (2, limits.acceleration)):
        assert (motion.peak(order) <= limit * (1 + RATE)).all()
        assert (np.abs(motion(t, order)) <= limit * (1 + RATE)).all()
    assert np.array_equal(motion.waypoints, points)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert np.array_equal(motion(-1.0), points[0])
    assert np.array_equal(motion(motion.duration), points[-1])
    assert motion.times[0] == 0
    assert motion.times[-1] == motion.duration
    if motion.duration == 0:
        return
    assert use(motion, limits) == pytest.approx(1.0, rel=MET)
    assert np.array_equal(motion(0.0), points[0])
    ends, near = [0.0, motion.duration], 1e-12 * motion.duration
    assert (motion(ends, 1) == 0).all()
    speed = np.abs(motion([near, motion.duration - near], 1))
    assert (speed <= 2 * near * motion.peak(2) + PASSES * motion.peak(1)).all()
    if kind == "quintic":
        assert np.abs(motion(ends, 2)).max() <= 1e-6 * motion.peak(2).max()
    if (kind, stop) in STRAIGHT:
        assert np.abs(motion(motion.times, 1)).max() <= 1e-6 * motion.peak(1).max()
        assert_straight(motion, points)


def assert_straight(motion, points):
    """From each waypoint straight to the next, and never beyond both."""
    theta = motion(np.linspace(0, motion.duration, 501))
    assert (theta >= points.min(0) - PASSES).all()
    assert (theta <= points.max(0) + PASSES).all()
    for a, b, start, goal in zip(motion.times[:-1], motion.times[1:], points[:-1], points[1:], strict=True):
        line, step = motion(np.linspace(a, b, 7)[1:-1]) - start, goal - start
        across = line - np.outer(line @ step, step) / max(step @ step, 1e-300)
        assert b == a or np.abs(across).max() <= MERGE_TOL + PASSES


# -- the rest -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["Cubic", "spline", "s-curve", None, 3])
def test_an_unknown_kind_lists_the_known(kind):
    with pytest.raises(
        InputError, match=r"kind must be 'cubic', 'quintic', 'trapezoid', 'time_optimal' or 's_curve'; got"
    ):
        plan_joint(ARM, PATH, kind=kind, limits=RATES)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_progress_rises_to_one(kind, stop):
    seen = []
    plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES, progress=seen.append)
    assert all(0 < a <= b for a, b in itertools.pairwise(seen))
    assert seen[-1] == 1.0


# -- durations ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("distance", "velocity", "acceleration"), [(1.0, 0.5, 1.0), (1.0, 1.0, 1.0), (0.1, 1.0, 2.0), (2.0, 0.1, 50.0)]
)
def test_a_trapezoid_takes_the_textbooks_time(distance, velocity, acceleration):
    # Lynch & Park §9.2.2.2: d/v + v/a, or 2 √(d/a) where v²/a > d and the speed limit is not reached.
    coasts = velocity**2 / acceleration <= distance
    expected = distance / velocity + velocity / acceleration if coasts else 2 * np.sqrt(distance / acceleration)
    limits = {"velocity": velocity, "acceleration": acceleration}
    motion = plan_joint(ARM, [[0, 0, 0], [0, distance, -distance / 2]], kind="trapezoid", limits=limits)
    assert motion.duration == pytest.approx(expected, rel=MET)
    assert motion.peak(1)[1] == pytest.approx(min(velocity, np.sqrt(acceleration * distance)), rel=MET)
    assert motion(motion.duration / 2)[1] == pytest.approx(distance / 2)


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize(
    ("kind", "velocity", "acceleration", "jerk"), [("cubic", 3 / 2, 6.0, 12.0), ("quintic", 15 / 8, 10 / 3**0.5, 60.0)]
)
def test_a_single_segment_takes_the_textbooks_time(kind, stop, velocity, acceleration, jerk):
    # Peaks of a rest-to-rest polynomial: c d/T, c d/T², c d/T³ (Lynch & Park §9.2.2.1).
    for v, a, j in ((0.3, 9.0, np.inf), (5.0, 0.7, np.inf), (5.0, 9.0, 0.9)):
        limits = {"velocity": v, "acceleration": a, "jerk": j}
        motion = plan_joint(ARM, [[0, 0, 0], [0, 1.5, 0]], kind=kind, limits=limits, stop_at_waypoints=stop)
        expected = max(velocity * 1.5 / v, (acceleration * 1.5 / a) ** (1 / 2), (jerk * 1.5 / j) ** (1 / 3))
        assert motion.duration == pytest.approx(expected, rel=MET)


def test_a_trapezoid_does_not_look_at_jerk():
    free = plan_joint(ARM, PATH, kind="trapezoid", limits=RATES)
    assert plan_joint(ARM, PATH, kind="trapezoid", limits=RATES | {"jerk": 1e-3}).duration == free.duration


def test_rates_far_apart_are_no_trouble():
    for kind, stop in WAYS:
        for rates in ({"velocity": 1e-3, "acceleration": 1e6}, {"velocity": 1e6, "acceleration": 1e-3}):
            limits = ARM.limits.with_(rates, ARM.joint_names)
            motion = plan_joint(ARM, PATH, kind=kind, limits=limits, stop_at_waypoints=stop)
            assert use(motion, limits) == pytest.approx(1.0, rel=MET)


@pytest.mark.parametrize("acceleration", [10.0, 1e6])
def test_a_long_motion_keeps_its_short_segments_and_ramps(acceleration):
    rng = np.random.default_rng(1)
    points = np.repeat(rng.uniform(-0.4, 0.4, (60, 3)), 2, axis=0)
    points[1::2] += 3e-6
    limits = ARM.limits.with_({"velocity": 0.01, "acceleration": acceleration}, ARM.joint_names)
    for kind in KINDS:
        motion = plan_joint(ARM, points, kind=kind, limits=limits, stop_at_waypoints=True)
        assert use(motion, limits) == pytest.approx(1.0, rel=MET)
        assert np.abs(motion(motion.times) - points).max() <= PASSES


# -- times given --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_given_times_are_kept_and_missing_rates_not_asked_for(kind, stop):
    times = [0.0, 2.0, 5.0, 9.0]
    motion = plan_joint(ARM, PATH, kind=kind, times=times, stop_at_waypoints=stop)
    assert motion.times.tolist() == times
    assert motion.duration == 9.0
    assert np.allclose(motion(times), PATH)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_times_that_are_too_short_are_refused_with_the_factor_that_helps(kind, stop):
    first = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop)
    short = 0.8 * first.times
    with pytest.raises(LimitError, match="its (velocity|acceleration) limit is") as error:
        plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=short)
    factor = float(str(error.value).split("multiply times by ")[1].split(",")[0])
    assert 1.2 < factor < 1.8
    plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=factor * short)


def test_a_ramp_is_chosen_that_keeps_both_limits_at_a_given_time():
    line = [[0, 0, 0], [0, 1, 0]]
    for limits in ({"velocity": 1.0, "acceleration": 1.01}, {"velocity": 0.55, "acceleration": 5.0}, {"velocity": 0.6}):
        motion = plan_joint(ARM, line, kind="trapezoid", times=[0, 2.0], limits=limits)
        assert motion.peak(1)[1] <= limits["velocity"] * (1 + RATE)
        assert motion.peak(2)[1] <= limits.get("acceleration", np.inf) * (1 + RATE)


def test_equal_waypoints_at_different_times_are_a_dwell():
    for kind, stop in STRAIGHT:
        motion = plan_joint(
            ARM, [PATH[0], PATH[1], PATH[1], PATH[2]], kind=kind, times=[0, 3, 5, 8], stop_at_waypoints=stop
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


@pytest.mark.parametrize(("kind", "stop"), [("time_optimal", False), ("time_optimal", True), ("s_curve", False)])
def test_waypoints_are_passed_inside_the_limits(kind: str, stop: bool) -> None:
    points = np.concatenate([POINTS[:1], POINTS, POINTS[-1:] + 1e-9])
    motion = plan_joint(ARM, points, kind=kind, limits=LIMITS, stop_at_waypoints=stop)
    assert motion(motion.times) == pytest.approx(points, abs=2e-9)
    assert np.abs(motion(np.array([1e-12, motion.duration - 1e-12]), 1)).max() < 1e-9
    assert max(motion.peak(1).max() / 2.0, motion.peak(2).max() / 5.0) == pytest.approx(1.0, abs=1e-3)
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
    motion = planned.to_motors()
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
