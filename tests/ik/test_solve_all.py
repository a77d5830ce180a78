"""Every configuration that meets a target: the one that made it is among them, each is exact, none is there twice."""

import time

import numpy as np
import pytest
from scipy.optimize import brentq

import twistarm
from catalogue import load
from family_arms import CASES, assert_exact_and_different, family_arm, joint_distance, missed, pose_of, screws_of
from ik_targets import pinocchio_fk
from twistarm import Approach, Pose, Position, solve_ik_all

EXACT = 1e-9
QUARTER = np.pi / 2


def check(arm, theta, near):
    """One target, made by theta."""
    g = pose_of(arm, theta)
    found = solve_ik_all(arm, Pose(g), near)
    assert_exact_and_different(arm, g, theta, found)
    lower, upper = arm.limits.lower, arm.limits.upper
    assert ((found.theta >= lower) & (found.theta <= upper)).all()
    distances = (np.abs(found.theta - near) / (upper - lower)).max(axis=1) if len(found) else np.zeros(0)
    assert (np.diff(distances) >= 0).all()
    return found


def special(arm, rng):
    """A configuration of quarters and limits, where axes align, elbows stretch and joints stand at their limits."""
    theta = arm.random_theta(rng)
    lower, upper = arm.sampling_bounds
    turns = np.array(arm.units) != "m"
    quarter = np.where(turns, np.clip(np.round(theta / QUARTER) * QUARTER, lower, upper), np.round(4 * theta) / 4)
    limit = np.where(rng.random(arm.n) < 0.5, lower, upper)
    which = rng.integers(3, size=arm.n)
    return np.choose(which, [theta, quarter, limit])


@pytest.mark.parametrize("name", CASES)
def test_the_configuration_that_made_the_target_is_found(name):
    arm, rng = family_arm(name), np.random.default_rng(11)
    for i in range(2):
        found = check(arm, special(arm, rng) if i else arm.random_theta(rng), arm.random_theta(rng))
        assert found.complete


DELICATE = [
    ("parallel 2-3-4", [-1.0, 0.4, 0.8, -0.3, 1e-8, 0.6]),  # beside regular answers
    ("parallel 4-5-6", [np.pi - 1e-8, -1.1689, -np.pi + 1e-8, 2.68e-8, QUARTER - 1e-8, np.pi - 1e-8]),
    ("P-RRR-R", [0.3, -0.4, np.pi - 1e-8, 1.2, -1.4]),  # folded: axes 2 and 4 are one but for 1e-8
    ("R-RRR-R", [0.9, -QUARTER, np.pi - 5e-9, -1.0, np.pi - 5e-9]),
    *(("spherical wrist", [0.3, -0.5, 0.9, 0.7, gap, -0.2]) for gap in (1e-3, 1e-5, 3e-7, 3e-8, 3e-9)),  # in line
]


@pytest.mark.parametrize(("name", "posture"), DELICATE)
def test_answers_at_particular_values_of_a_joint_that_seems_free(name, posture):
    arm, theta = family_arm(name), np.array(posture)
    for near in arm.random_theta(16, 3):
        found = check(arm, theta, near)
        assert found.complete
        assert len(found) + len(found.outside) <= 12


@pytest.mark.parametrize("name", ["ur5", "stanford", "scara", "rover_arm", "so101"])
def test_arms_of_the_catalogue_by_pinocchio(name):
    arm, rng = load(name), np.random.default_rng(13)
    for _ in range(2):
        theta = arm.random_theta(rng)
        g = pinocchio_fk(arm, theta)
        found = solve_ik_all(arm, Pose(g))
        assert min(joint_distance(arm, answer, theta) for answer in found) < 1e-6
        for answer in [*found.theta, *found.outside]:
            assert np.abs(pinocchio_fk(arm, answer) - g).max() < EXACT
    # Shoulder, elbow and wrist, two ways each: Hawkins, Analytic inverse kinematics for the UR-5/10, 2013.
    assert name != "ur5" or len(found) + len(found.outside) == 8


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name]["kind"] != "elimination"][::2])
def test_nothing_more_is_found_by_searching(name):
    """Searches from many starts are the independent witness that a complete set is complete."""
    arm, rng = family_arm(name), np.random.default_rng(14)
    g = pose_of(arm, arm.random_theta(rng))
    found = solve_ik_all(arm, Pose(g))
    assert found.complete
    starts = arm.random_theta(rng, 50)
    batch = twistarm.solve_ik_batch(arm, [Pose(g)] * 50, starts, restarts=1, position_tol=1e-9, orientation_tol=1e-9)
    everything = [*found.theta, *found.outside]
    for theta in batch.theta[batch.converged]:
        assert min(joint_distance(arm, answer, theta) for answer in everything) < 1e-5


@pytest.mark.parametrize("name", [name for name in CASES if CASES[name]["kind"] != "decoupled"][::4])
def test_what_is_out_of_reach_has_no_answer_for_certain(name):
    arm = family_arm(name)
    g = np.array(arm.home)
    g[:3, 3] += [30.0, 20.0, 10.0]
    found = solve_ik_all(arm, Pose(g))
    assert len(found) == 0
    assert len(found.outside) == 0 or "m" in arm.units  # a slide would have to be tens of metres long
    assert found.complete
    assert "certain" in found.explain()


def test_a_family_met_outside_the_limits_is_followed_inside():
    """Of a singular wrist only the sum of two joints counts; the member nearest to theta0 may be out of limits."""
    arm = family_arm("spherical wrist", half_turns=0.5)
    theta = np.array([0.3, -0.5, 0.9, 1.5, 0.0, 1.5])  # their sum is 3 rad, so each has to be above 1.43
    found = solve_ik_all(arm, Pose(pose_of(arm, theta)), np.zeros(6))
    assert any(abs(answer[3] + answer[5] - 3.0) < 1e-7 for answer in found)


def test_a_folded_scara_turns_about_the_point_it_reaches():
    """Links of one length folded: the tool stands on the first axis, and any turn about that will do."""
    axes = [["R", [0, 0, 1], [0.3 * i, 0, 0]] for i in range(3)] + [["P", [0, 0, -1], [0, 0, 0]]]
    home = np.eye(4) + 0.6 * np.eye(4, k=3)
    bounds = {f"joint{i + 1}": bound for i, bound in enumerate([np.pi, np.pi, np.pi, 1.0])}
    limits = {"lower": {name: -bound for name, bound in bounds.items()}, "upper": bounds}
    arm, rng = twistarm.arm_from_screws(screws_of(axes), home, limits=limits), np.random.default_rng(3)
    for theta in arm.random_theta(rng, 20):
        theta[1] = np.pi
        assert len(solve_ik_all(arm, Position(pose_of(arm, theta)[:3, 3])))


def test_copies_by_whole_turns_are_counted_on_request():
    arm = family_arm("SCARA, slide last", half_turns=2.0)
    g = pose_of(arm, np.array([0.3, 0.8, -0.4, 0.2]))
    single, many = solve_ik_all(arm, Pose(g)), solve_ik_all(arm, Pose(g), include_turns=True)
    assert len(many) == 8 * len(single)  # three joints, two turns each
    assert all(missed(arm, g, answer) < EXACT for answer in many)
    share = np.abs(many.theta - arm.ready) / (arm.limits.upper - arm.limits.lower)
    assert (np.diff(share.max(axis=1)) >= -1e-12).all()


def test_targets_that_leave_something_free():
    rng, five = np.random.default_rng(15), family_arm("R-RRR-R")
    theta = five.random_theta(rng)
    g = pose_of(five, theta)
    found = solve_ik_all(five, Approach(g[:3, 3], g[:3, :3] @ [0, 0, 1], tool_axis=[0, 0, 1]))
    assert found.complete
    assert min(joint_distance(five, answer, theta) for answer in found) < 1e-6
    so101 = load("so101")
    theta = so101.random_theta(rng)
    p = pose_of(so101, theta)[:3, 3]
    found = solve_ik_all(so101, Position(p), theta, redundancy_samples=3)
    assert not found.complete
    assert len(found)
    for answer in found:
        assert np.linalg.norm(pose_of(so101, answer)[:3, 3] - p) < EXACT


def test_a_search_keeps_the_joints_that_are_given():
    """Six joints with a slide that have no family: what is given stands, whatever the search begins with."""
    axes = [
        ["R", [1, 0.2, 0.1], [0, 0.2, 0]], ["R", [0, 0, 1], [0, 0, 0]], ["R", [0.4, 1, 0], [0.1, 0, 0.2]],
        ["P", [1, 0.2, 0.6], [0, 0, 0]], ["R", [0.1, 1, 0.3], [0.3, 0.1, 0.2]], ["R", [0.5, 0, 1], [0.5, 0.1, 0]],
        ["R", [1, 0.7, 0.1], [0.6, 0, 0.2]],
    ]  # fmt: skip
    arm = twistarm.arm_from_screws(screws_of(axes), np.eye(4))
    theta = np.array([0.2, -0.4, 0.3, 0.1, 0.8, -0.5, 0.6])
    found = solve_ik_all(arm, Pose(pose_of(arm, theta)), fixed_joints={"joint1": 0.2})
    assert found.method == "search from many starts"
    assert min(joint_distance(arm, answer, theta) for answer in found) < 1e-6
    assert (found.theta[:, 0] == 0.2).all()


def test_a_joint_without_a_range_stands_and_is_not_sampled():
    limits = {"lower": {"joint2": 0.3}, "upper": {"joint2": 0.3}}
    axes = [["R", [0, 0, 1], [0.2 * i, 0, 0]] for i in range(4)]
    arm = twistarm.arm_from_screws(screws_of(axes), np.eye(4), limits=limits)
    theta = np.array([0.4, 0.3, -0.7, 1.1])
    found = solve_ik_all(arm, Pose(pose_of(arm, theta)))
    assert found.complete
    assert min(joint_distance(arm, answer, theta) for answer in found) < 1e-6
    assert len(twistarm.solve_ik_all_batch(arm, pose_of(arm, theta)[None])[0]) == len(found)


def test_samples_that_all_miss_are_helped_by_a_search():
    """A narrow range of the joints that are not sampled: few values of the one that is give an answer inside."""
    arm = load("panda")
    for theta in arm.random_theta(5, 6):
        assert len(solve_ik_all(arm, Pose(pose_of(arm, theta)), redundancy_samples=1))
    swept = solve_ik_all(arm, Pose(pose_of(arm, arm.ready)), redundancy_samples=1)
    assert swept.starts == 2, "theta0's value, and one"
    assert not swept.complete


def test_a_slide_that_changes_places_across_a_given_joint():
    """The slide along parallel axes stands in the group behind a joint that is given: the plane turns with that one."""
    axes = [["P", [0, 0, -1], [0, 0, 0]], ["R", [0, 0, -1], [0, 0.25, 0]], ["R", [0, 0, 1], [0, -0.3, 0]]]
    axes += [["R", [0, 0, -1], [0, 0, 0]], ["R", [-1, 0, 0], [0, 0, -0.1]], ["R", [1, 0, 0], [0, 0.55, -0.2]]]
    arm = twistarm.arm_from_screws(screws_of([*axes, ["R", [-1, 0, 0], [0, -0.45, 0.45]]]), np.eye(4))
    theta = np.array([0.026, -0.933, 1.474, -2.486, -2.761, -1.172, -2.58])
    found = solve_ik_all(arm, Pose(pose_of(arm, theta)), fixed_joints={"joint4": -2.486, "joint6": -1.172})
    assert min(joint_distance(arm, answer, theta) for answer in found) < 1e-6


@pytest.mark.parametrize(
    ("given", "error", "says"),
    [
        ({"joint9": 0.0}, twistarm.UnknownNameError, "joint9"),
        ({"joint1": 9.0}, twistarm.InputError, "outside its limits"),
        ({"joint1": np.nan}, twistarm.InputError, "joint1"),
        ([1.0], twistarm.InputError, "mapping"),
    ],
)
def test_bad_given_values_are_named(given, error, says):
    arm = family_arm("spherical wrist")
    with pytest.raises(error, match=says):
        solve_ik_all(arm, Pose(arm.home), fixed_joints=given)


def test_arms_that_no_joint_makes_mobile_or_whose_axes_coincide():
    """Zero lengths and coincident axes: an answer, and the joints that are one another's are told as free."""
    axis = np.array([0, 0, 0, 0, 0, 1.0])
    twice = twistarm.arm_from_screws(np.array([axis, axis]).T, np.eye(4))
    found = solve_ik_all(twice, Pose(pose_of(twice, np.array([0.3, 0.4]))))
    assert len(found)
    assert not found.complete
    assert all(abs(np.sin((answer.sum() - 0.7) / 2)) < EXACT for answer in found)
    idle = solve_ik_all(twice, Position([0.0, 0.0, 0.0]))
    assert len(idle)
    assert not len(solve_ik_all(twice, Position([0.1, 0.0, 0.0])))


@pytest.mark.alone
@pytest.mark.parametrize(("count", "seconds"), [(5, 0.5), (6, 1e-9), (8, 0.3)])
def test_time_is_kept(count, seconds):
    """Eight joints that turn, two of them sampled, take half a minute; what is found by then is exact.

    Six take a while only where two roots meet. A point leaves so101 one family, whatever the time: 1,089 values of two
    joints take half a minute to compare.
    """
    rng = np.random.default_rng(1)
    axes = [["R", rng.normal(size=3), rng.uniform(-0.5, 0.5, 3)] for _ in range(count)]
    arm = twistarm.arm_from_screws(screws_of(axes), np.eye(4)) if count > 5 else load("so101")
    fractions = []
    start, end = arm.random_theta(3), arm.random_theta(5)
    share = (
        0.0 if count != 6 else brentq(lambda t: np.linalg.det(arm.body_jacobian(start + t * (end - start))), 0.0, 1.0)
    )
    g = arm.fk(start + share * (end - start))
    target = Pose(g) if count > 5 else Position(g[:3, 3])
    solve_ik_all(arm, target, max_time=1e-9)  # the method is chosen once for each arm
    began = time.monotonic()
    found = solve_ik_all(arm, target, max_time=seconds, include_turns=True, progress=fractions.append)
    assert time.monotonic() - began < seconds + 0.5
    assert count > 5 or (len(found), "values of wrist_flex and wrist_roll" in found.explain()) == (1, True)
    assert found.timed_out
    assert not found.complete
    assert "the time was up" in found.explain()
    assert max(found.position_error.max(initial=0.0), found.orientation_error.max(initial=0.0)) <= EXACT
    assert fractions == sorted(fractions)
    assert all(0.0 < share < 1.0 for share in fractions)
