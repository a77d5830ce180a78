"""The waypoints of `plan_joint`, the limits it takes, and what a curve does between them."""

import numpy as np
import pytest

from joint_space_cases import ARM, KINDS, PASSES, PATH, RATES, WAYS, make_arm, with_rates
from twistarm import JointLimits, arm_from_screws
from twistarm.planning import plan_joint, timing
from twistarm.planning.joint_space import FITS, MERGE_TOL
from twistarm.support.errors import InputError, LimitError, UnknownNameError

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
        (["zero", "raedy"], UnknownNameError, "no pose 'raedy' in arm; closest: 'ready'.*'ready', 'zero'"),
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
def test_a_spline_beyond_a_limit_is_refused_and_the_advice_helps(kind):
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


@pytest.mark.parametrize("kind", ["cubic", pytest.param("quintic", marks=pytest.mark.slow)])
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
