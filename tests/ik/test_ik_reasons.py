"""What `solve_ik` says of targets whose reason is known by construction (`reason_targets`)."""

import re
import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import reason_targets
from catalogue import load
from ik_targets import at_some_limits, errors, judged, judged_batch, pinocchio_fk, require_core, target_from
from reason_targets import CASES, arms_of, draw
from twistarm import ArmBuilder, NotConvergedError
from twistarm.cli.wording import words
from twistarm.ik import Approach, Pose, Position, StopReason, TolerancedPose, solve_ik, solve_ik_batch
from twistarm.ik.solution import split_rotation

WRONG = 0.01  # The share of targets of a case and an arm that may be given another reason.

FEW, BOXES = 3, 5

PAIRS = [(case, name) for case in CASES for name in case.arms]
IDS = [f"{case.name}-{name}" for case, name in PAIRS]

TIGHT = (1e-4, 1e-4, 1e-4, 1e-3, 1e-3, np.inf)

LATE = 0.05  # How much later [s] than `max_time` an answer may come.
UNENDING = 10**6  # More searches than any deadline here leaves time for.


@pytest.fixture(autouse=True)
def _core():
    require_core(load("rover_arm"))


def check_one(arm, g, solution):
    """What holds of every answer: inside the limits, converged if and only if Pinocchio finds the target reached, and
    an answer without limits where, and only where, they block: it reaches the target, or misses less of its rotation.
    """
    assert solution.within_limits
    assert arm.limits.contains(solution.theta)
    assert judged(arm, Pose(g), solution) == solution.converged, solution
    assert (solution.unlimited is not None) == (solution.stop is StopReason.BLOCKED_BY_LIMITS), solution
    if solution.unlimited is not None:
        position, angle = errors(Pose(g), pinocchio_fk(arm, solution.unlimited))
        assert position < 2e-6
        assert angle < 2e-6 or (solution.position_error < 1e-6 and angle < 0.7 * solution.orientation_error)


@pytest.mark.parametrize(("case", "name"), PAIRS, ids=IDS)
def test_the_reason_is_the_true_one(case, name):
    arm = arms_of(case, name, 1)[0]
    for g in draw(case.builder, arm, np.random.default_rng(1), FEW):
        solution = solve_ik(arm, g)
        check_one(arm, g, solution)
        assert solution.stop is case.stop, solution


def of_every_kind(g):
    return (
        Pose(g),
        Position(g[:3, 3]),
        Approach(g[:3, 3], g[:3, 2]),
        TolerancedPose(g, TIGHT),
        TolerancedPose(g, TIGHT, frame="base"),
    )


def test_the_reason_does_not_hang_on_the_kind_of_target():
    """scara, whose reach without limits is a ring about its first axis, at any height: l₁ − l₂ ≤ r ≤ l₁ + l₂.

    Heights are those outside the slide's range, so that nothing is reached inside; the tool is asked for tilted.
    """
    arm, rng = load("scara"), np.random.default_rng(8)
    a, b = (np.linalg.norm(step[:3, 3]) for step in reason_targets.placements(arm)[1:3])
    slides = (arm.limits.lower[3], arm.limits.upper[3])
    lowest, highest = np.sort([pinocchio_fk(arm, [0, 0, 0, slide])[2, 3] for slide in slides])
    axis = reason_targets.placements(arm)[0][:2, 3]
    for k in range(60):
        reached = k % 2 == 0
        r = rng.uniform(a - b + 1e-4, a + b - 1e-4) if reached else rng.choice([a - b - 1e-3, a + b + 1e-3])
        angle, z = rng.uniform(-np.pi, np.pi), rng.choice([lowest - rng.exponential(), highest + rng.exponential()])
        g = np.eye(4)
        g[:3, :3] = Rotation.random(random_state=k).as_matrix()
        g[:3, 3] = [*(axis + r * np.array([np.cos(angle), np.sin(angle)])), z]
        for target in of_every_kind(g):
            solution = solve_ik(arm, target)
            if not reached:
                assert solution.stop is StopReason.OUT_OF_REACH, (r, z, target)
                continue
            assert solution.stop is StopReason.BLOCKED_BY_LIMITS, (r, z, target)
            assert np.abs(pinocchio_fk(arm, solution.unlimited)[:3, 3] - g[:3, 3]).max() < 2e-4


UPPER, FORE, HAND, SHOULDER = 0.4, 0.3, 0.2, 0.15


def pan_pitch_roll(roll=True, bound=3.0):
    """An arm that turns about the vertical and then in a plane through it: three pitches, and a roll about the hand."""
    pitch, reach = [0, -1, 0], UPPER + FORE
    builder = ArmBuilder("planar").revolute("pan", [0, 0, 1], [0, 0, 0], lower=-bound, upper=bound)
    for name, x in (("shoulder", 0.0), ("elbow", UPPER), ("wrist", reach)):
        builder = builder.revolute(name, pitch, [x, 0, SHOULDER], lower=-bound, upper=bound)
    if roll:
        builder = builder.revolute("roll", [1, 0, 0], [reach, 0, SHOULDER], lower=-bound, upper=bound)
    home = np.eye(4)
    home[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    home[:3, 3] = [reach + HAND, 0, SHOULDER]
    return builder.tool(home).build()


def in_the_plane(azimuth, r, z):
    """The vector of horizontal length r and height z at an azimuth."""
    return np.array([r * np.cos(azimuth), r * np.sin(azimuth), z])


@pytest.mark.parametrize("roll", [True, False])
def test_beyond_the_reach_for_a_direction_is_out_of_reach(roll):
    """The wrist stands `HAND` behind the tool: it comes no farther than `UPPER + FORE` from the shoulder.

    The position itself is reached, by another direction, and the direction nearer to the arm.
    """
    arm, rng = pan_pitch_roll(roll), np.random.default_rng(3)
    for _ in range(20):
        azimuth, up, along = rng.uniform(-2.5, 2.5), rng.uniform(-0.9, 0.9), rng.uniform(1.8, 2.6)
        beyond = rng.uniform(0.02, 0.1)
        wrist = (UPPER + FORE + beyond) * np.array([np.cos(up), np.sin(up)])
        direction = in_the_plane(azimuth, np.cos(up + along), np.sin(up + along))
        p = in_the_plane(azimuth, wrist[0], wrist[1] + SHOULDER) + HAND * direction
        solution = solve_ik(arm, Approach(p, direction, [0, 0, 1]))
        assert solution.position_error < 1e-6
        assert solution.stop is StopReason.OUT_OF_REACH, solution
        assert split_rotation(solution, solution.theta)[0] < 1e-3
        nearer = p - in_the_plane(azimuth, *(wrist * (beyond + 1e-3) / np.linalg.norm(wrist)))
        assert solve_ik(arm, Approach(nearer, direction, [0, 0, 1])).converged


def test_a_direction_out_of_the_arms_plane_is_impossible_wherever_it_is_asked_for():
    arm, rng = pan_pitch_roll(), np.random.default_rng(4)
    for _ in range(20):
        azimuth, r, z = rng.uniform(-2.5, 2.5), rng.uniform(0.3, 0.6), rng.uniform(0.0, 0.4)
        across, angle = in_the_plane(azimuth + np.pi / 2, 1, 0), rng.uniform(0.1, 1.4)
        direction = np.cos(angle) * in_the_plane(azimuth, *np.array([np.cos(z), np.sin(z)])) + np.sin(angle) * across
        solution = solve_ik(arm, Approach(in_the_plane(azimuth, r, z), direction, [0, 0, 1]))
        assert solution.stop is StopReason.IMPOSSIBLE_DIRECTION, solution
        assert split_rotation(solution, solution.theta)[0] == pytest.approx(angle, abs=0.01)


@pytest.mark.parametrize("aside", [1e-5, 0.1, 0.5])
def test_limits_are_blamed_for_what_they_add_to_a_direction_that_is_lacking(aside):
    """The rover arm's tool stays square to y: without limits it misses a direction by its angle out of that plane."""
    arm, target = load("rover_arm"), Approach([0.5, 0.02, 0.7], [1.0, aside, 0.0])
    solution = solve_ik(arm, target)
    lacking, missed = np.arctan(aside), solution.orientation_error
    assert missed > np.radians(37)
    if lacking > missed - lacking:
        assert solution.stop is StopReason.IMPOSSIBLE_DIRECTION
        return
    assert solution.stop is StopReason.BLOCKED_BY_LIMITS
    assert not arm.limits.contains(solution.unlimited)
    position, angle = errors(solution.target, pinocchio_fk(arm, solution.unlimited))
    assert position < 1e-6
    assert angle == pytest.approx(lacking, abs=1e-6)
    text = solution.explain()
    assert f"{np.degrees(missed - lacking):.1f}°" in text
    assert aside < 1e-2 or ("no joint turns" in text and f"{np.degrees(lacking):.1f}°" in text)


def test_a_position_out_of_reach_hides_no_direction_that_is_lacking():
    """SCARA turns its tool about the vertical alone: of a tilt all is missing, wherever the position is."""
    arm = load("scara")
    tilted = Pose.from_rpy([9.0, 0.0, 0.1], [np.radians(34), 0.0, 0.0])
    above = arm.fk(arm.ready)
    above[2, 3] += 5.0
    above[:3, :3] = above[:3, :3] @ Rotation.from_euler("x", 34, degrees=True).as_matrix()
    for target, stop in ((tilted, StopReason.OUT_OF_REACH), (Pose(above), StopReason.BLOCKED_BY_LIMITS)):
        solution = solve_ik(arm, target)
        assert solution.stop is stop
        assert "34.0° of the rotation are missing" in solution.explain()


def test_a_wider_position_tolerance_is_named_where_the_rotation_is_missed():
    """Poses of five joints moved aside by some tolerances: position and rotation can be traded for each other."""
    arm, rng, named = load("so101"), np.random.default_rng(16), 0
    for g in arm.fk(arm.random_theta(rng, 40)):
        aside = rng.normal(size=3)
        g[:3, 3] += 1e-3 * rng.uniform(1.5, 9) * aside / np.linalg.norm(aside)
        solution = solve_ik(arm, Pose(g), position_tol=1e-3, orientation_tol=1e-4)
        if solution.converged or not solve_ik(arm, Pose(g), position_tol=1e-2, orientation_tol=1e-4).converged:
            continue
        wider = re.search(r"position_tol=([\d.e-]+)", solution.explain())
        assert wider or "orientation_tol=" in solution.explain()
        if wider and wider[1]:
            named += 1
            assert solve_ik(arm, Pose(g), position_tol=float(wider[1]), orientation_tol=1e-4).converged
    assert named > 10


CORNERS = [("z1", "Approach"), ("panda", "Pose"), ("so101", "Pose"), ("ur5", "Approach")]


@pytest.mark.parametrize(("name", "kind"), CORNERS)
def test_corners_of_the_limits_are_reached(name, kind):
    """Every joint at a bound, and most: the race alone misses one in a thousand of the six joints' approaches."""
    arm, rng = load(name), np.random.default_rng(10)
    theta = at_some_limits(arm, rng, 5000)
    bounds = np.array(arm.sampling_bounds)
    corner = bounds[rng.integers(2, size=theta.shape), np.arange(arm.n)]
    theta[::2] = corner[::2]
    g = arm.fk(theta)
    targets = g if kind == "Pose" else [target_from(kind, pose, rng) for pose in g]
    assert solve_ik_batch(arm, targets, arm.random_theta(rng, len(theta))).converged.all()


def test_no_configuration_reaches_what_is_certain_not_to_be_reached():
    """A configuration inside the limits that misses a target by no more than the tolerances refutes certainty."""
    arm, rng = load("ur5"), np.random.default_rng(13)
    narrow = replace(arm, limits=replace(arm.limits, lower=np.full(6, -1.0), upper=np.full(6, 1.0)), named_states={})
    counts = Counter()
    for theta in rng.uniform(-1, 1, (100, 6)):
        theta[rng.integers(6)] = rng.choice([-1.0, 1.0])
        g = narrow.fk(theta + rng.choice([0.0, 1e-3, 0.1, 1.0]) * rng.normal(size=6))
        for target in (Pose(g), Position(g[:3, 3]), Approach(g[:3, 3], g[:3, 2], [0, 0, 1])):
            for tolerance in (1e-6, 1e-3, 0.1):
                solution = solve_ik(narrow, target, position_tol=tolerance, orientation_tol=tolerance)
                missed = errors(target, pinocchio_fk(arm, theta))
                assert not (solution.certain and max(missed) <= tolerance)
                counts[solution.certain, tolerance] += 1
    assert min(counts[True, tolerance] for tolerance in (1e-6, 1e-3)) > 20


def test_an_approach_of_four_joints_that_limits_alone_prevent_is_blocked():
    """Poses of configurations outside the limits: without them each is reached where it was made."""
    arm, rng = pan_pitch_roll(roll=False, bound=0.6), np.random.default_rng(14)
    theta = rng.uniform(-3, 3, (500, 4))
    targets = [Approach(g[:3, 3], g[:3, 2], [0, 0, 1]) for g in arm.fk(theta)]
    batch = solve_ik_batch(arm, targets)
    assert set(batch.stop) <= {StopReason.CONVERGED, StopReason.BLOCKED_BY_LIMITS}


def test_what_is_hardly_missed_names_the_tolerance_and_what_widens_it():
    arm = load("ur5")
    g = arm.fk(arm.ready)
    far = Position(g[:3, 3] * 3.0)
    off = solve_ik(arm, far).position_error
    near = solve_ik(arm, far, position_tol=off / 5)
    assert "position_tol=" in near.explain()
    with pytest.raises(NotConvergedError, match="position_tol="):
        near.require()
    assert "position_tol=" not in solve_ik(arm, far, position_tol=off / 20).explain()
    planar = pan_pitch_roll()
    aside = Approach([0.5, 0.0, 0.3], [1.0, 0.05, 0.0], [0, 0, 1])
    turned = solve_ik(planar, aside).orientation_error
    assert "orientation_tol=" in solve_ik(planar, aside, orientation_tol=turned / 5).explain()
    assert "--orientation-tol" in words(solve_ik(planar, aside, orientation_tol=turned / 5).explain())


def test_arms_of_many_joints_may_come_nearer_and_say_so():
    builder = ArmBuilder("snake")
    for i in range(17):
        axis = [[0, 0, 1], [0, 1, 0]][i % 2]
        builder = builder.revolute(f"j{i}", axis, [0.2 * i, 0, 0], lower=-0.5, upper=0.5)
    home = np.eye(4) + 3.4 * np.eye(4, k=3)
    arm = builder.tool(home).build()
    missed = solve_ik(arm, Position([0.0, -6.0, 0.0]))
    assert not missed.converged
    assert any("nearer" in note for note in missed.notes)
    assert not any("nearer" in note for note in solve_ik(arm, Position(arm.fk(arm.middle)[:3, 3])).notes)
    assert not any("nearer" in note for note in solve_ik(load("ur5"), Position([9.0, 0, 0])).notes)


@pytest.mark.slow
@pytest.mark.parametrize(("case", "name"), PAIRS, ids=IDS)
def test_a_thousand_reasons(case, name):
    """All at once, and each of a part alone."""
    rng, stops, alone, differing = np.random.default_rng(2), Counter(), Counter(), 0
    arms = arms_of(case, name, BOXES)
    for arm in arms:
        count = 1000 // len(arms)
        poses = draw(case.builder, arm, rng, count)
        batch = solve_ik_batch(arm, poses, arm.random_theta(rng, count))
        stops.update(batch.stop)
        assert arm.limits.contains(batch.theta).all()
        assert (judged_batch(arm, poses, batch) == batch.converged).all()
        for i in range(0, count, 10):
            solution = solve_ik(arm, poses[i], batch.theta0[i])
            check_one(arm, poses[i], solution)
            alone[solution.stop] += 1
            differing += solution.stop is not batch.stop[i]
    assert stops[case.stop] >= (1 - WRONG) * stops.total(), stops
    assert alone[case.stop] >= (1 - 2 * WRONG) * alone.total(), alone
    assert differing <= 2 * WRONG * alone.total(), (stops, alone)


@pytest.mark.parametrize("name", ["so101", "panda"])
@pytest.mark.parametrize("searches", [1, 3])
def test_few_searches_exclude_nothing(name, searches):
    """A target that can be reached is never called out of reach, blocked or impossible, however short the search."""
    arm, rng = load(name), np.random.default_rng(3)
    for builder in (reason_targets.inside, reason_targets.at_limits):
        for g in draw(builder, arm, rng, 100):
            solution = solve_ik(arm, g, arm.random_theta(rng), restarts=searches)
            assert solution.stop in (StopReason.CONVERGED, StopReason.EXHAUSTED), solution
            check_one(arm, g, solution)


@pytest.mark.alone
@pytest.mark.parametrize("seconds", [1e-6, 0.02])
@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_a_deadline_is_kept(case, seconds):
    """In time but for `LATE`, the best of three calls, and what is said is true or that the time was up."""
    arm = arms_of(case, case.arms[-1], 1)[0]
    for g in draw(case.builder, arm, np.random.default_rng(4), 1):
        durations = []
        for _ in range(3):
            begun = time.perf_counter()
            solution = solve_ik(arm, g, max_time=seconds, restarts=UNENDING)
            durations.append(time.perf_counter() - begun)
            check_one(arm, g, solution)
            assert solution.stop in (case.stop, StopReason.TIMED_OUT), solution
        assert min(durations) <= seconds + LATE
    targets = draw(case.builder, arm, np.random.default_rng(5), 50)
    begun = time.perf_counter()
    batch = solve_ik_batch(arm, targets, max_time=seconds)
    assert time.perf_counter() - begun <= seconds + 2 * LATE
    assert set(batch.stop) <= {case.stop, StopReason.TIMED_OUT}
