"""The waypoints of `plan_joint`, the limits it takes, and what a curve does between them."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PPoly

from ik_targets import pinocchio_fk
from joint_space_cases import ARM, LAWS, PASSES, PATH, RATES, WAYS, make_arm
from twistarm import (
    Approach,
    ArmBuilder,
    Dwell,
    JointLimits,
    JointMove,
    LineMove,
    Pose,
    Position,
    load_arm,
    load_motion,
    plan,
    plan_joint,
)
from twistarm.arm.usual_limits import with_defaults
from twistarm.cli.application import run
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
@pytest.mark.parametrize("distance", [0.0, 1e-7])
def test_start_equal_to_goal_is_a_motion_of_no_length(kind, stop, distance):
    motion = plan_joint(ARM, [PATH[1], PATH[1] + distance, PATH[1]], kind=kind, stop_at_waypoints=stop, limits=RATES)
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


@pytest.mark.parametrize("beyond", [5e-7, 2.65e-6, 0.19])
@pytest.mark.parametrize("options", [{}, {"kind": "time_optimal"}, {"times": [0.0, 9.0, 20.0]}])
def test_a_measured_start_beyond_a_limit_only_returns(beyond, options):
    """From there on, no joint is farther beyond than before."""
    given = np.array([[0.02, 2.0 + beyond, -0.5], [0.0, 1.5, 0.0], [0.1, 1.0, 0.2]])
    for motion in (
        plan_joint(ARM, given, limits=RATES, **options),
        plan(ARM, [JointMove(given[1]), JointMove(given[2])], start=given[0], limits=RATES),
        plan(ARM, [Dwell(0.1), JointMove(given[2])], start=given[0], limits=RATES),
    ):
        theta = motion(np.linspace(0.0, motion.duration, 2000))[:, 1]
        assert theta[0] == pytest.approx(2.0 + beyond, abs=1e-6)
        assert (np.diff(np.maximum(theta - 2.0, 0.0)) <= 1e-9).all()
        assert motion(motion.duration) == pytest.approx(given[2])
        assert any("'shoulder'" in str(note) or "shoulder by" in str(note) for note in motion.notes) == (beyond > 1e-6)


def test_a_start_too_far_beyond_a_limit_is_refused():
    for start in ([0.0, 2.21, 0.0], [-0.521, 0.0, 0.0]):
        with pytest.raises(LimitError, match="^the start puts"):
            plan_joint(ARM, [start, [0.0, 0.0, 0.0]], limits=RATES)
        with pytest.raises(LimitError, match="^the start puts"):
            plan(ARM, JointMove([0.0, 0.0, 0.0]), start=start, limits=RATES)
    assert plan_joint(ARM, [[-0.519, 0.0, 0.0], [0.0, 0.0, 0.0]], limits=RATES).waypoints[0, 0] == -0.519
    alone = plan_joint(ARM, [[-0.519, 0.0, 0.0]], limits=RATES)  # it only returns
    assert alone.waypoints[:, 0].tolist() == [-0.519, -0.5]
    assert alone(alone.duration).tolist() == [-0.5, 0.0, 0.0]
    with pytest.raises(LimitError, match="'slide'"):
        plan_joint(ARM, [[-0.519, 0.0, 0.0]], limits=RATES, times=[0.0])  # no time to return


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

# The shoulder comes to its limit 2.0 at speed: any smooth curve through these goes beyond.
SWINGING = np.array([[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.95, 2.4], [0.0, -1.0, 0.0]])
# How many derivatives of a motion of each kind are continuous.
ORDERS = {"cubic": 2, "quintic": 4, "s_curve": 2, "time_optimal": 1}


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
    explicit = plan_joint(ARM, PATH, kind=kind, limits=usual)
    (swings,) = explicit.notes
    assert "elbow 0." in swings
    assert "slide" not in swings
    assert plan_joint(ARM, PATH, kind=kind, limits=usual, stop_at_waypoints=True).notes == ()
    for given in ({}, {"velocity": {"slide": 0.25, "shoulder": 1.0}}, {"acceleration": usual["acceleration"]}):
        motion = plan_joint(ARM, PATH, kind=kind, limits=given)
        assert motion.duration == explicit.duration
        note, again = motion.notes
        assert again == swings
        assert ("acceleration" in note) == ("acceleration" not in given)
        assert "elbow" in note


@pytest.mark.parametrize(
    ("limits", "kind_of_error", "text"),
    [
        ({"speed": 1.0}, UnknownNameError, "no limit 'speed'"),
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


TURN = 2 * np.pi
LIMITS = {"velocity": 1.0, "acceleration": 3.0}


def arm_of(pitch: float = 0.0, lower: float | None = None, upper: float | None = None):
    """A yaw, endless unless it is bounded, or a screw of some pitch; and a shoulder."""
    builder = ArmBuilder("yaw")
    if pitch:
        builder = builder.helical("yaw", [0, 0, 1], [0, 0, 0], pitch)
    else:
        builder = builder.revolute("yaw", [0, 0, 1], [0, 0, 0], lower=lower, upper=upper)
    g = np.eye(4)
    g[:3, 3] = [0.5, 0.0, 0.2]
    return builder.revolute("shoulder", [0, 1, 0], [0, 0, 0.2], lower=-2, upper=2).tool(g).build()


ENDS = [[3.1, 0.0], [-3.1, 0.1], [3.0, 0.0]]


@pytest.mark.parametrize("bounds", [(None, None), (-7.0, 7.0)])
def test_unwrapped_waypoints_are_the_same_places_by_the_shorter_way(bounds: tuple[float | None, float | None]) -> None:
    arm = arm_of(lower=bounds[0], upper=bounds[1])
    plain, short = (plan_joint(arm, ENDS, limits=LIMITS, unwrap=unwrap) for unwrap in (False, True))
    assert plain.waypoints[:, 0].tolist() == [3.1, -3.1, 3.0]
    np.testing.assert_allclose(short.waypoints[:, 0], [3.1, TURN - 3.1, 3.0])
    for before, after in zip(plain.waypoints, short.waypoints, strict=True):
        np.testing.assert_allclose(pinocchio_fk(arm, before), pinocchio_fk(arm, after), atol=1e-12)
    assert short.duration < 0.2 * plain.duration
    assert "turns by 6.2 rad; unwrap=True makes that 0.08319 rad" in plain.notes[0]
    assert "'yaw' goes to 3.18319 rad in place of -3.1 rad" in short.notes[0]
    moves = [JointMove(end) for end in ENDS[1:]]
    for unwrap, planned in ((False, plain), (True, short)):
        motion = plan(arm, moves, start=ENDS[0], limits=LIMITS, unwrap=unwrap)
        np.testing.assert_allclose(motion.waypoints, planned.waypoints)
        assert len(motion.notes) == len(planned.notes)


@pytest.mark.parametrize(("pitch", "bounds"), [(0.01, (None, None)), (0.0, (-3.15, 3.15))])
def test_joints_that_a_whole_turn_moves_or_their_limits_hold_are_left(pitch: float, bounds: tuple) -> None:
    arm = arm_of(pitch, *bounds)
    motion = plan_joint(arm, ENDS, limits=LIMITS, unwrap=True)
    assert motion.waypoints[:, 0].tolist() == [3.1, -3.1, 3.0]
    assert motion.notes == ()


def test_to_a_target_the_shorter_way_is_the_default() -> None:
    arm = arm_of()
    there, on = (pinocchio_fk(arm, np.array(theta))[:3, 3] for theta in ([-3.1, 0.1], [-3.05, 0.1]))
    to_it = plan_joint(arm, [ENDS[0], Position(there)], limits=LIMITS)
    line = LineMove(Position(on), position_tol=1e-3)
    through = plan(arm, [JointMove(Position(there)), line], start=ENDS[0], limits=LIMITS)
    for motion in (to_it, through):
        assert motion.waypoints[1, 0] == pytest.approx(TURN - 3.1, abs=1e-3)
        assert motion.notes == ()


URDF = """<robot name="yaw"><link name="base_link"/><link name="a"/><link name="tool0"/>
<joint name="yaw" type="continuous"><parent link="base_link"/><child link="a"/><axis xyz="0 0 1"/></joint>
<joint name="shoulder" type="revolute"><parent link="a"/><child link="tool0"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint></robot>"""


def test_a_file_and_the_command_line_ask_for_it(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("arm.urdf").write_text(URDF, "utf-8")
    arm = load_arm("arm.urdf")
    Path("m.toml").write_text("unwrap = true\n[[segment]]\njoint = [-3.1, 0.1]\n", "utf-8")
    assert load_motion("m.toml", arm).unwrap
    start = ["--from", "3.1 0", "--rad", "--json"]
    for how, end in ((["m.toml"], TURN - 3.1), (["--to=-3.1 0.1", "--unwrap"], TURN - 3.1), (["--to=-3.1 0.1"], -3.1)):
        assert run(["plan", "arm.urdf", *how, *start]) == 0
        printed = capsys.readouterr()
        assert json.loads(printed.out)["waypoints"][-1][0] == pytest.approx(end, abs=1e-5)
        assert ("makes that" in printed.err) == (end < 0)
