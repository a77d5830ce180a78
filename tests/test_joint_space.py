import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from strategies import generators
from twistarm import JointLimits, arm_from_screws, load_arm
from twistarm.errors import InputError, LimitError, UnknownNameError
from twistarm.planning import plan_joint, timing
from twistarm.planning.joint_space import FITS, MERGE_TOL

KINDS = ("cubic", "quintic", "trapezoid")
WAYS = [(kind, stop) for kind in KINDS for stop in (False, True)]
STRAIGHT = [way for way in WAYS if way[1] or way[0] == "trapezoid"]

RATE = 1e-9
"""Relative excess over a rate limit that is rounding: what the planner promises."""

few = settings(max_examples=15)

MET = 1e-9
"""Relative: a limit that is met exactly, but for the planner's own margin of 1e-10 per power of time."""

PASSES = 1e-9
"""A waypoint is passed to the rounding of a spline's solution [rad, m]."""

RATES = {
    "velocity": {"slide": 0.5, "shoulder": 1.0, "elbow": 1.5},
    "acceleration": {"slide": 1, "shoulder": 2, "elbow": 4},
}


def make_arm(**limits):
    """A slide and two turning joints, with position limits only, unless `limits` says more."""
    ranges = {
        "lower": {"slide": -0.5, "shoulder": -2.0, "elbow": -2.5},
        "upper": {"slide": 0.5, "shoulder": 2.0, "elbow": 2.5},
    }
    screws = [[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, -0.5, 0, 1, 0]]
    joints = ("slide", "shoulder", "elbow")
    home = np.eye(4)
    home[0, 3] = 0.8
    return arm_from_screws(np.transpose(screws), home, joints=joints, limits=ranges | limits)


ARM = make_arm()
PATH = np.array([[0.0, 0.0, 0.0], [0.2, 0.8, -0.5], [0.1, 1.0, 1.0], [-0.3, -0.5, 0.5]])


def with_rates(arm, **changes):
    return arm.limits.with_(RATES | changes, arm.joint_names)


def use(motion, limits):
    """The largest part of a velocity or acceleration limit that the motion uses."""
    return max((motion.peak(1) / limits.velocity).max(), (motion.peak(2) / limits.acceleration).max())


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


# -- the laws of every kind ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_limits_are_kept_and_one_is_met(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    assert (motion.peak(1) <= limits.velocity * (1 + RATE)).all()
    assert (motion.peak(2) <= limits.acceleration * (1 + RATE)).all()
    t = np.linspace(0, motion.duration, 3001)
    assert (np.abs(motion(t, 1)) <= limits.velocity * (1 + RATE)).all()
    assert (np.abs(motion(t, 2)) <= limits.acceleration * (1 + RATE)).all()
    if motion.duration > 0:
        assert use(motion, limits) == pytest.approx(1.0, rel=MET)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_waypoints_are_passed_at_their_times_from_rest_to_rest(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    assert np.array_equal(motion.waypoints, points)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert np.array_equal(motion(-1.0), points[0])
    assert np.array_equal(motion(motion.duration), points[-1])
    assert motion.duration == 0 or np.array_equal(motion(0.0), points[0])
    assert motion.times[0] == 0
    assert motion.times[-1] == motion.duration
    ends = [0.0, motion.duration]
    near = 1e-12 * motion.duration
    assert (motion(ends, 1) == 0).all()
    speed = np.abs(motion([near, motion.duration - near], 1))
    assert (speed <= 2 * near * motion.peak(2) + PASSES * motion.peak(1)).all()
    if kind == "quintic":
        assert np.abs(motion(ends, 2)).max() <= 1e-6 * motion.peak(2).max()
    if (kind, stop) in STRAIGHT:
        assert np.abs(motion(motion.times, 1)).max() <= 1e-6 * motion.peak(1).max()


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_each_derivative_integrates_to_the_one_before(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    for a, b in zip(motion.breakpoints[:-1], motion.breakpoints[1:], strict=True):
        t = 0.5 * (b - a) * nodes + 0.5 * (a + b)
        for order in (1, 2):
            gained = 0.5 * (b - a) * weights @ motion(t, order)
            size = motion.peak(order - 1) + motion.peak(order) * motion.duration * 1e-3
            assert (np.abs(gained - (motion(b, order - 1) - motion(a, order - 1))) <= 1e-7 * size + 1e-12).all()


@pytest.mark.parametrize(("kind", "stop"), STRAIGHT)
@few
@given(task=tasks())
def test_motions_that_stop_go_straight_and_stay_among_their_waypoints(kind, stop, task):
    points, limits = task
    motion = plan_joint(ARM, points, kind=kind, limits=limits, stop_at_waypoints=stop)
    theta = motion(np.linspace(0, motion.duration, 501))
    assert (theta >= points.min(0) - PASSES).all()
    assert (theta <= points.max(0) + PASSES).all()
    for a, b, start, goal in zip(motion.times[:-1], motion.times[1:], points[:-1], points[1:], strict=True):
        line = motion(np.linspace(a, b, 7)[1:-1]) - start
        step = goal - start
        across = line - np.outer(line @ step, step) / max(step @ step, 1e-300)
        assert b == a or np.abs(across).max() <= MERGE_TOL + PASSES


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


def test_joints_of_a_trapezoid_start_coast_and_finish_together():
    motion = plan_joint(ARM, PATH[:2], kind="trapezoid", limits=RATES)
    fractions = (motion(np.linspace(0, motion.duration, 50)) - PATH[0]) / (PATH[1] - PATH[0])
    assert np.allclose(fractions, fractions[:, :1], atol=1e-12)
    assert (motion(motion.duration / 2, 2) == 0).all()


@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_proportions_are_better_than_those_of_the_distances(kind):
    rng, planned, scaled = np.random.default_rng(0), 0.0, 0.0
    for _ in range(5):
        points = rng.uniform(-0.4, 0.4, (8, 3)) * [1, 4, 4]
        limits = with_rates(ARM, lower=-10.0, upper=10.0)
        distances = (np.abs(np.diff(points, axis=0)) / limits.velocity).max(1)
        times = np.concatenate([[0.0], np.cumsum(distances)])
        naive = plan_joint(ARM, points, kind=kind, limits={"lower": -10.0, "upper": 10.0}, times=times)
        stretch = max((naive.peak(1) / limits.velocity).max(), np.sqrt((naive.peak(2) / limits.acceleration).max()))
        planned += plan_joint(ARM, points, kind=kind, limits=limits).duration
        scaled += stretch * naive.duration
    assert planned < 0.97 * scaled


@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_a_jerk_limit_is_kept(kind):
    for stop in (False, True):
        motion = plan_joint(ARM, PATH, kind=kind, limits=RATES | {"jerk": 3.0}, stop_at_waypoints=stop)
        assert motion.peak(3).max() == pytest.approx(3.0, rel=MET)


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
def test_times_of_a_plan_can_be_given_back(kind, stop):
    first = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop)
    again = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=first.times)
    t = np.linspace(0, first.duration, 50)
    assert np.allclose(again(t), first(t), atol=1e-4)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_times_that_are_too_short_are_refused_with_the_factor_that_helps(kind, stop):
    first = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop)
    short = 0.8 * first.times
    text = (
        r"joint '(slide|shoulder|elbow)' would need [\d.]+ (m|rad)/s²? at t = [\d.]+ s; its (velocity|acceleration) "
        r"limit is [\d.]+ (m|rad)/s²?: multiply times by [\d.]+, or leave times out"
    )
    with pytest.raises(LimitError, match=text) as error:
        plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=short)
    factor = float(str(error.value).split("multiply times by ")[1].split(",")[0])
    assert 1.2 < factor < 1.8
    plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=factor * short)


def test_the_error_names_joint_value_limit_and_time():
    # Rest to rest 0 → 1 in 2 s: 1.5 · 1/2 = 0.75 rad/s in the middle (Lynch & Park §9.2.2.1).
    text = r"joint 'shoulder' would need 0.75 rad/s at t = 1 s; its velocity limit is 0.5 rad/s: multiply times by 1.50"
    with pytest.raises(LimitError, match=text):
        plan_joint(ARM, [[0, 0, 0], [0, 1, 0]], times=[0, 2], limits={"velocity": 0.5})


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
        ([0, 1], r"times must be one instant per waypoint, \(4,\); got \(2,\)"),
        ([1, 2, 3, 4], "times must start at 0 and increase strictly"),
        ([0, 2, 2, 3], r"must start at 0 and increase strictly; got \[0.0, 2.0, 2.0, 3.0\]"),
        ([0, 3, 2, 4], "increase strictly"),
        ([0, 1, np.nan, 3], "times must be finite; it holds nan at index"),
        ([0, 1e-9, 2, 3], "no segment under 1e-07 of the whole; got a segment of 1e-09 s in 3 s"),
        ([0, 1e300, 2e300, 3e300], "times must span 1e-09 s to 1e"),
        ("soon", "times must be an array of real numbers"),
    ],
)
def test_times_that_make_no_sense(times, text):
    with pytest.raises(InputError, match=text):
        plan_joint(ARM, PATH, times=times)


# -- waypoints ----------------------------------------------------------------------------------------------------


def test_waypoints_may_be_mappings_and_names():
    arm = make_arm(velocity=1.0, acceleration=2.0)
    motion = plan_joint(arm, ["zero", {"elbow": 1.0, "slide": 0.1, "shoulder": 0.5}, [0.1, 0.2, 0.3], "ready"])
    assert motion.waypoints.tolist() == [[0, 0, 0], [0.1, 0.5, 1.0], [0.1, 0.2, 0.3], arm.ready.tolist()]
    assert motion.joint_names == arm.joint_names
    assert motion.units == ("m", "rad", "rad")


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@pytest.mark.parametrize("apart", [0.0, 1e-7])
def test_start_equal_to_goal_is_a_motion_of_no_length(kind, stop, apart):
    motion = plan_joint(ARM, [PATH[1], PATH[1] + apart, PATH[1]], kind=kind, stop_at_waypoints=stop, limits=RATES)
    assert motion.duration == 0.0
    assert motion.times.tolist() == [0.0] * 3
    assert motion([-1, 0, 1]).tolist() == [PATH[1].tolist()] * 3
    assert motion.sample(0.1).theta.tolist() == [PATH[1].tolist()]


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_repeated_waypoints_change_nothing(kind, stop):
    once = plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES)
    many = plan_joint(ARM, PATH[[0, 0, 1, 1, 1, 2, 3, 3]], kind=kind, stop_at_waypoints=stop, limits=RATES)
    assert many.duration == once.duration
    assert many.times.tolist() == once.times[[0, 0, 1, 1, 1, 2, 3, 3]].tolist()
    assert np.allclose(many(many.times), PATH[[0, 0, 1, 1, 1, 2, 3, 3]])


def test_the_goal_is_reached_exactly_though_its_neighbour_is_nearly_there():
    motion = plan_joint(ARM, [PATH[0], PATH[1] - 5e-7, PATH[1]], limits=RATES)
    assert np.abs(motion(motion.duration * (1 - 1e-12)) - PATH[1]).max() <= PASSES
    assert len(motion.breakpoints) == 2


def test_steps_too_small_each_but_not_together_are_not_lost():
    points = np.linspace([0, 0, 0], [0, 1e-5, 0], 101)
    motion = plan_joint(ARM, points, limits=RATES, stop_at_waypoints=True)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert motion(motion.duration)[1] == 1e-5


def test_angles_are_not_wrapped():
    arm = arm_from_screws(np.eye(6)[:, [5]], np.eye(4), limits={"velocity": 1.0, "acceleration": 1.0})
    motion = plan_joint(arm, [[0.0], [4 * np.pi]])
    assert motion(motion.duration / 2)[0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize(
    ("waypoints", "kind_of_error", "text"),
    [
        ([[0, 0, 0]], InputError, "at least two configurations, start and goal; got 1"),
        ([], InputError, "at least two configurations"),
        ("ready", InputError, "waypoints must be a sequence of at least two configurations; got 'ready'"),
        ({"slide": 0}, InputError, "waypoints must be a sequence"),
        (7, InputError, "waypoints must be a sequence"),
        (None, InputError, "waypoints must be a sequence"),
        ([0, 1], InputError, r"waypoint 0 must have shape \(..., 3\): slide, shoulder, elbow; got \(\)"),
        ([[0, 0, 0], [0, 0]], InputError, r"waypoint 1 must have shape \(..., 3\).*got \(2,\)"),
        ([[0, 0, 0], [[0, 0, 0]]], InputError, r"waypoint 1 must be one configuration \(3,\); got \(1, 3\)"),
        ([[0, 0, 0], [0, np.nan, 0]], InputError, "waypoint 1 must be finite; it holds nan at index"),
        (["zero", "raedy"], UnknownNameError, "no named state 'raedy' in arm; closest: 'ready'.*'ready', 'zero'"),
        (["zero", {"slide": 0, "elbow": 1}], InputError, "no value for joint 'shoulder'"),
        (["zero", {"slide": 0, "elbow": 1, "sholder": 0}], UnknownNameError, "no joint 'sholder'.*closest: 'shoulder'"),
    ],
)
def test_waypoints_that_are_none(waypoints, kind_of_error, text):
    with pytest.raises(kind_of_error, match=text):
        plan_joint(ARM, waypoints, limits=RATES)


def test_a_waypoint_outside_the_limits_is_named():
    text = (
        r"waypoint 1 \(counted from 0\) puts joint 'shoulder' at 2.3 rad, 0.3 rad beyond its upper limit 2 rad: "
        "move the waypoint, or change the limit by limits="
    )
    with pytest.raises(LimitError, match=text):
        plan_joint(ARM, [[0, 0, 0], [0, 2.3, 0]], limits=RATES)
    with pytest.raises(LimitError, match=r"joint 'slide' at -0.51 m, 0.01 m beyond its lower limit -0.5 m"):
        plan_joint(ARM, [[0, 0, 0], [-0.51, 0, 0]], limits=RATES)
    plan_joint(ARM, [[0, 0, 0], [0, 2.3, 0]], limits=RATES | {"upper": {"shoulder": 2.5}})


# -- position limits between waypoints ----------------------------------------------------------------------------

SWINGING = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.95, 2.4], [0.0, -1.0, 0.0]])
"""The shoulder comes to its limit 2.0 at speed: any smooth curve through these goes beyond."""


@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_a_spline_that_swings_beyond_a_limit_is_refused_and_the_advice_helps(kind):
    text = (
        r"between its waypoints joint 'shoulder' would swing to [23][.\d]* rad at t = [\d.]+ s, [\d.]+ rad beyond its "
        r"upper limit 2 rad: use stop_at_waypoints=True"
    )
    with pytest.raises(LimitError, match=text):
        plan_joint(ARM, SWINGING, kind=kind, limits=RATES)
    with pytest.raises(LimitError, match=text):
        plan_joint(ARM, SWINGING, kind=kind, times=[0, 3, 6, 9])
    motion = plan_joint(ARM, SWINGING, kind=kind, limits=RATES, stop_at_waypoints=True)
    assert ARM.limits.contains(motion(np.linspace(0, motion.duration, 999)), tol=PASSES).all()


@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_whatever_a_spline_returns_is_inside(kind):
    rng, inside, refused = np.random.default_rng(2), 0, 0
    for _ in range(30):
        points = rng.uniform(ARM.limits.lower, ARM.limits.upper, (4, 3))
        try:
            motion = plan_joint(ARM, points, kind=kind, limits=RATES)
        except LimitError:
            refused += 1
            continue
        inside += 1
        assert ARM.limits.contains(motion(np.linspace(0, motion.duration, 2001)), tol=PASSES).all()
    assert inside > 3
    assert refused > 3


def test_the_proportions_that_stay_inside_are_preferred():
    rng = np.random.default_rng(3)
    for _ in range(200):
        points = rng.uniform(0.9 * ARM.limits.lower, 0.9 * ARM.limits.upper, (5, 3))
        limits = with_rates(ARM)
        times, _ = timing.fastest_spline(points, FITS["cubic", False], limits)
        free, _ = timing.fastest_spline(
            points, FITS["cubic", False], limits.with_({"lower": -99, "upper": 99}, ARM.joint_names)
        )
        assert times[-1] >= free[-1]
        if times[-1] > free[-1]:
            return
    pytest.fail("no case in which the shortest motion leaves the limits and another stays inside")


# -- limits -------------------------------------------------------------------------------------------------------


def test_limits_may_be_the_arms_or_given_whole_or_as_changes():
    arm = make_arm(velocity=0.5, acceleration=1.0)
    whole = plan_joint(ARM, PATH, limits=arm.limits)
    assert plan_joint(arm, PATH).duration == whole.duration
    assert plan_joint(ARM, PATH, limits={"velocity": 0.5, "acceleration": 1.0}).duration == whole.duration
    assert plan_joint(arm, PATH, limits={"velocity": {"elbow": 0.1}}).duration > whole.duration


@pytest.mark.parametrize("kind", KINDS)
def test_a_missing_limit_names_joint_and_argument(kind):
    with pytest.raises(LimitError, match=r"no acceleration limit for slide, shoulder, elbow.*limits={'acceleration'"):
        plan_joint(ARM, PATH, kind=kind, limits={"velocity": 1.0})
    with pytest.raises(LimitError, match=r"no velocity limit for elbow.*limits={'velocity': {'elbow': …}}"):
        plan_joint(ARM, PATH, kind=kind, limits={"velocity": {"slide": 1, "shoulder": 1}, "acceleration": 1})


@pytest.mark.parametrize(
    ("limits", "kind_of_error", "text"),
    [
        ({"speed": 1.0}, UnknownNameError, "no limit 'speed'"),
        ({"velocity": {"wrist": 1.0}}, UnknownNameError, "no joint 'wrist'"),
        ({"velocity": -1.0}, InputError, "must not be negative"),
        (JointLimits.unbounded(2), InputError, "limits must be JointLimits of 3 joints or a mapping"),
        (1.0, InputError, "limits must be JointLimits of 3 joints or a mapping such as dict"),
    ],
)
def test_limits_that_make_no_sense(limits, kind_of_error, text):
    with pytest.raises(kind_of_error, match=text):
        plan_joint(ARM, PATH, limits=limits)


def test_limits_in_the_wrong_unit_are_noticed_before_they_overflow():
    for kind, stop in WAYS:
        for rate in (1e-300, 1e300):
            with pytest.raises(InputError, match=r"make a motion of .* s; 1e-09 s to 1e\+09 s can be planned"):
                plan_joint(
                    ARM, PATH, kind=kind, stop_at_waypoints=stop, limits={"velocity": rate, "acceleration": rate}
                )


# -- the rest -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["Cubic", "spline", "s_curve", None, 3])
def test_an_unknown_kind_lists_the_known(kind):
    with pytest.raises(InputError, match=r"kind must be one of 'cubic', 'quintic', 'trapezoid'; got"):
        plan_joint(ARM, PATH, kind=kind, limits=RATES)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_progress_rises_to_one(kind, stop):
    seen = []
    plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES, progress=seen.append)
    assert all(0 < a <= b for a, b in itertools.pairwise(seen))
    assert seen[-1] == 1.0


def test_the_same_call_gives_the_same_bits_and_survives_pickling():
    for kind in KINDS:
        first, again = (plan_joint(ARM, PATH, kind=kind, limits=RATES) for _ in range(2))
        assert np.array_equal(first.coefficients, again.coefficients)
        assert np.array_equal(pickle.loads(pickle.dumps(first)).breakpoints, again.breakpoints)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_the_rover_arm_moves_through_three_poses(kind, stop):
    arm = load_arm("rover_arm")
    via = 0.5 * (arm.ready + arm.random_theta(np.random.default_rng(0)))
    motion = plan_joint(arm, ["ready", via, "ready"], kind=kind, stop_at_waypoints=stop)
    samples = motion.sample(0.01)
    assert arm.limits.contains(samples.theta, tol=PASSES).all()
    assert use(motion, arm.limits) == pytest.approx(1.0, rel=MET)
    assert np.allclose(motion(motion.times[1]), via)
    # The tool's velocity is the hybrid Jacobian's: position differences against the joint rates of the plan.
    i = len(samples.t) // 3
    h = 1e-5
    moved = arm.fk(motion(samples.t[i] + h))[:3, 3] - arm.fk(motion(samples.t[i] - h))[:3, 3]
    assert np.allclose(moved / (2 * h), (arm.hybrid_jacobian(samples.theta[i]) @ samples.theta_dot[i])[:3], atol=1e-6)
