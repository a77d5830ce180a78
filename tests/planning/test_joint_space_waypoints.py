"""The waypoints of `plan_joint`, the limits it takes, and what a curve does between them."""

import itertools

import numpy as np
import pytest
from scipy.interpolate import PPoly

from joint_space_cases import ARM, LAWS, PASSES, PATH, RATES, WAYS, make_arm
from twistarm import Approach, JointLimits, Pose, Position, load_arm
from twistarm.arm.usual_limits import with_defaults
from twistarm.planning import plan_joint
from twistarm.planning.waypoints import MERGE_TOL
from twistarm.support.errors import InputError, LimitError, NotConvergedError, UnknownNameError

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
    for how in ({"kind": kind}, {"times": [0.0]}):
        alone = plan_joint(ARM, [PATH[1]], stop_at_waypoints=stop, limits=RATES, **how)
        assert (alone.duration, alone.times.tolist(), alone(1.0).tolist()) == (0.0, [0.0], PATH[1].tolist())


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_repeated_waypoints_change_nothing(kind, stop):
    once = plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES)
    many = plan_joint(ARM, PATH[[0, 0, 1, 1, 1, 2, 3, 3]], kind=kind, stop_at_waypoints=stop, limits=RATES)
    assert many.duration == once.duration
    assert many.times.tolist() == once.times[[0, 0, 1, 1, 1, 2, 3, 3]].tolist()
    assert np.allclose(many(many.times), PATH[[0, 0, 1, 1, 1, 2, 3, 3]])
    assert "1, 3, 4, 7" in many.notes[0]


def test_steps_too_small_each_but_not_together_are_not_lost():
    points = np.linspace([0, 0, 0], [0, 1e-5, 0], 101)
    motion = plan_joint(ARM, points, limits=RATES, stop_at_waypoints=True)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert motion(motion.duration)[1] == 1e-5


@pytest.mark.parametrize(
    ("waypoints", "kind_of_error", "text"),
    [
        ([], InputError, "at least one"),
        ("ready", InputError, "waypoints must be a sequence"),
        ({"slide": 0}, InputError, "waypoints must be a sequence"),
        (None, InputError, "waypoints must be a sequence"),
        ([0, 1], InputError, "waypoint 0 must have shape"),
        ([[0, 0, 0], [[0, 0, 0]]], InputError, "waypoint 1 must be one configuration"),
        ([[0, 0, 0], [0, np.nan, 0]], InputError, "waypoint 1 must be finite"),
        (["zero", "raedy"], UnknownNameError, "'raedy'"),
        (["zero", {"slide": 0, "elbow": 1}], InputError, "'shoulder'"),
    ],
)
def test_waypoints_that_are_none(waypoints, kind_of_error, text):
    with pytest.raises(kind_of_error, match=text):
        plan_joint(ARM, waypoints, limits=RATES)


def test_a_waypoint_outside_the_limits_is_named():
    with pytest.raises(LimitError, match="waypoint 1 .* 'shoulder' at 2.3 rad, 0.3 rad beyond its upper limit 2 rad"):
        plan_joint(ARM, [[0, 0, 0], [0, 2.3, 0]], limits=RATES)
    with pytest.raises(LimitError, match=r"'slide' at -0.51 m, 0.01 m beyond its lower limit -0.5 m"):
        plan_joint(ARM, [[0, 0, 0], [-0.51, 0, 0]], limits=RATES)
    plan_joint(ARM, [[0, 0, 0], [0, 2.3, 0]], limits=RATES | {"upper": {"shoulder": 2.5}})


def test_targets_are_waypoints_and_the_motion_stays_near():
    arm = load_arm("rover_arm_6dof")
    goal = arm.ready + [0.1, -0.1, 0.1, 0.1, -0.1, 0.2]
    pose = arm.fk(goal)
    targets = [pose, Pose(pose), Position(pose[:3, 3]), Approach(pose[:3, 3], pose[:3, 2])]
    motion = plan_joint(arm, ["ready", *targets], limits=with_defaults(arm))
    assert np.abs(motion.waypoints[1] - goal).max() < 1e-4
    assert np.abs(np.diff(motion.waypoints[1:], axis=0)).max() < 1e-3
    far = pose.copy()
    far[0, 3] += 9.0
    with pytest.raises(NotConvergedError, match="^waypoint 1 .*out of reach"):
        plan_joint(arm, ["ready", far], limits=with_defaults(arm))


# -- position limits between waypoints ----------------------------------------------------------------------------

SWINGING = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.95, 2.4], [0.0, -1.0, 0.0]])
"""The shoulder comes to its limit 2.0 at speed: any smooth curve through these goes beyond."""


ORDERS = {"cubic": 2, "quintic": 4, "s_curve": 2, "time_optimal": 1}
"""How many derivatives of a motion of each kind are continuous."""


def assert_inside_and_smooth(motion, points, kind):
    """By SciPy's polynomials: sampled between all breakpoints, and compared on both sides of each."""
    grid = np.concatenate([np.linspace(a, b, 30) for a, b in itertools.pairwise(motion.breakpoints)])
    curve = PPoly(motion.coefficients, motion.breakpoints)
    assert ARM.limits.contains(curve(grid), tol=PASSES).all()
    assert np.abs(curve(motion.times) - points).max() <= MERGE_TOL + PASSES
    lengths = np.diff(motion.breakpoints)[:-1, None]
    for order in range(ORDERS[kind] + 1):
        rows = PPoly(motion.coefficients, motion.breakpoints).derivative(order).c
        before = sum(row * lengths ** (len(rows) - 1 - i) for i, row in enumerate(rows[:, :-1]))
        assert np.allclose(before, rows[-1, 1:], rtol=0, atol=1e-7 * max(np.abs(curve(grid, order)).max(), 1e-3))


@pytest.mark.parametrize("kind", ["cubic", "quintic"])
def test_a_spline_that_would_leave_the_limits_is_pulled_in(kind):
    times = [0, 10, 20, 30]
    free = plan_joint(ARM, SWINGING, kind=kind, times=times, limits=RATES | {"upper": 9.0, "lower": -9.0})
    assert free(np.linspace(0, free.duration, 999)).max(0)[1] > 2.01
    motion = plan_joint(ARM, SWINGING, kind=kind, times=times, limits=RATES)
    assert_inside_and_smooth(motion, SWINGING, kind)
    assert motion.times.tolist() == times


@pytest.mark.parametrize("kind", LAWS)
def test_no_waypoints_inside_the_limits_are_refused(kind):
    rng = np.random.default_rng(2)
    lower, upper = ARM.limits.lower, ARM.limits.upper
    for _ in range(5):
        points = rng.uniform(lower, upper, (5, 3))
        points = np.where(
            rng.random(points.shape) < 0.3, np.where(rng.random(points.shape) < 0.5, lower, upper), points
        )
        motion = plan_joint(ARM, points, kind=kind, limits=RATES)
        assert_inside_and_smooth(motion, points, kind)


# -- limits -------------------------------------------------------------------------------------------------------


def test_limits_may_be_the_arms_or_given_whole_or_as_changes():
    arm = make_arm(velocity=0.5, acceleration=1.0)
    whole = plan_joint(ARM, PATH, limits=arm.limits)
    assert plan_joint(arm, PATH).duration == whole.duration
    assert plan_joint(ARM, PATH, limits={"velocity": 0.5, "acceleration": 1.0}).duration == whole.duration
    assert plan_joint(arm, PATH, limits={"velocity": {"elbow": 0.1}}).duration > whole.duration


@pytest.mark.parametrize("kind", LAWS)
def test_for_a_missing_limit_the_usual_one_is_kept_and_said(kind):
    """1 rad/s, 0.25 m/s, 3 rad/s², 1 m/s²: what the command line and streams assume."""
    usual = {"velocity": {"slide": 0.25, "shoulder": 1.0, "elbow": 1.0}}
    usual["acceleration"] = {"slide": 1.0, "shoulder": 3.0, "elbow": 3.0}
    told = plan_joint(ARM, PATH, kind=kind, limits=usual)
    assert told.notes == ()
    for given in ({}, {"velocity": {"slide": 0.25, "shoulder": 1.0}}, {"acceleration": usual["acceleration"]}):
        motion = plan_joint(ARM, PATH, kind=kind, limits=given)
        assert motion.duration == told.duration
        (note,) = motion.notes
        assert ("acceleration" in note) == ("acceleration" not in given)
        assert "elbow" in note


@pytest.mark.parametrize(
    ("limits", "kind_of_error", "text"),
    [
        ({"speed": 1.0}, UnknownNameError, "no limit 'speed'"),
        ({"velocity": -1.0}, InputError, "must not be negative"),
        (JointLimits.unbounded(2), InputError, "JointLimits of 3 joints"),
    ],
)
def test_limits_that_make_no_sense(limits, kind_of_error, text):
    with pytest.raises(kind_of_error, match=text):
        plan_joint(ARM, PATH, limits=limits)


def test_limits_in_the_wrong_unit_are_noticed_before_they_overflow():
    for kind, stop in WAYS:
        with pytest.raises(InputError, match=r"make a motion of .* s; 1e-09 s to 1e\+09 s can be planned"):
            plan_joint(
                ARM, PATH, kind=kind, stop_at_waypoints=stop, limits={"velocity": 1e-300, "acceleration": 1e-300}
            )
        # So great a number is no limit, wherever it stands.
        huge = plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits={"velocity": 1e300, "acceleration": 1e6})
        assert "velocity 0.25 m/s for slide" in huge.notes[0]
