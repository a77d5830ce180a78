"""The textbook's inverse kinematics, which answers without a core: reached or the best found, and what needs the
core."""

import time

import numpy as np
import pytest

from catalogue import load
from ik_targets import KINDS, errors, judged, moved, pinocchio_fk, target_from
from solvers import textbook_ik
from twistarm import JointMove, LineMove, TwistarmError, load_arm, plan, plan_joint
from twistarm.arm.engine import MOST_JOINTS
from twistarm.export.cpp_header import cpp_header
from twistarm.ik import Position, StopReason, solve_ik, solve_ik_all, solve_ik_all_batch, solve_ik_batch
from twistarm.ik.ranges import joint_ranges

HOW = "get a compiler"


@pytest.fixture
def bare(monkeypatch):
    """The rover arm where nothing was compiled."""
    monkeypatch.setattr("twistarm.arm.engine._found", lambda: (None, HOW))
    arm = load_arm("rover_arm")
    assert arm.compiled is None
    return arm


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["so101", "scara", "panda"])
def test_what_can_be_reached_is_reached(name, kind):
    arm, rng = load(name), np.random.default_rng([1, KINDS.index(kind)])
    for theta, theta0 in zip(arm.random_theta(rng, 10), arm.random_theta(rng, 10), strict=True):
        target = target_from(kind, arm.fk(theta), rng)
        assert judged(arm, target, textbook_ik(arm, target, theta0))


@pytest.mark.parametrize("name", ["rover_arm", "ur5", "panda"])
def test_out_of_reach_the_best_found_is_reported_with_its_errors(name):
    arm = load(name)
    target = Position([3.0 * arm.reach, 0.5, 0.4])
    best = textbook_ik(arm, target)
    assert best.stop is StopReason.EXHAUSTED
    assert best.within_limits
    assert best.position_error == pytest.approx(errors(target, pinocchio_fk(arm, best.theta))[0], abs=1e-12)
    assert (
        solve_ik(arm, target).position_error - 1e-9 <= best.position_error <= target.position_error(arm.fk(arm.ready))
    )


def test_a_near_start_stays_near_and_another_branch_is_noted():
    arm, rng = load("ur5"), np.random.default_rng(3)
    for theta in arm.random_theta(rng, 20):
        theta0 = joint_ranges(arm).inside(theta + rng.uniform(-0.01, 0.01, arm.n))
        solution = textbook_ik(arm, arm.fk(theta), theta0)
        far = np.abs(solution.theta - theta0).max() > 0.2
        assert any("another branch" in note for note in solution.notes) == far
        assert far == (solution.restarts > 1)


@pytest.mark.alone
def test_no_search_begins_when_the_time_is_up():
    arm, target = load("panda"), Position([3.0, 0.0, 0.0])
    begun = time.perf_counter()
    solution = textbook_ik(arm, target, max_time=0.05, restarts=10**6)
    assert time.perf_counter() - begun < 0.1
    assert solution.stop is StopReason.TIMED_OUT
    assert solution.within_limits
    assert "give a longer max_time" in solution.explain()
    assert textbook_ik(arm, target, max_time=1e-9).restarts == 1
    assert textbook_ik(arm, arm.fk(arm.ready), max_time=1e-9).converged


def test_what_needs_the_core_is_noted(bare):
    solution = solve_ik(bare, Position([3.0, 0.0, 0.5]))
    assert solution.stop is StopReason.EXHAUSTED
    assert solution.method == "damped least squares"
    *_, note = solution.explain().splitlines()
    assert "need the compiled core" in note
    assert "twistarm info" in note
    assert solve_ik(bare, bare.fk(bare.ready)).notes == ()


@pytest.mark.parametrize(
    "ask",
    [
        lambda arm: solve_ik_all(arm, arm.fk(arm.ready)),
        lambda arm: solve_ik_batch(arm, arm.fk(arm.random_theta(1, 3))),
        lambda arm: solve_ik_all_batch(arm, arm.fk(arm.random_theta(1, 3))),
        lambda arm: cpp_header(arm),
        lambda arm: solve_ik(arm, arm.fk(arm.ready), posture="middle"),
        lambda arm: plan(arm, LineMove.by([0.0, 0.0, 0.03])),
        lambda arm: plan_joint(arm, [arm.ready, arm.ready + 0.1, arm.ready]),
    ],
)
def test_what_only_the_core_does_says_how_to_get_it(bare, ask):
    with pytest.raises(TwistarmError, match=f"needs the compiled core: {HOW}"):
        ask(bare)


def test_some_motions_are_planned_without_a_core(bare):
    moves = [LineMove.by([0.0, 0.0, 0.03]), LineMove.by([0.0, 0.0, -0.03])]
    motion = plan(bare, moves, linear_speed=0.05, kind="quintic")
    assert motion.duration > 1.2
    lift = pinocchio_fk(bare, motion(motion.duration / 2)) - pinocchio_fk(bare, bare.ready)
    np.testing.assert_allclose(np.linalg.norm(lift[:3, 3]), 0.03, atol=1e-4)
    straight = [bare.ready, bare.ready + 0.1]
    assert plan(bare, JointMove(straight[1])).duration == plan_joint(bare, straight, kind="s_curve").duration


def test_more_joints_than_the_core_holds_are_solved_too():
    from twistarm import arm_from_screws, joints

    links = [joints.revolute([0, 0, 1] if i % 2 else [0, 1, 0], [0.025 * i, 0, 0]) for i in range(MOST_JOINTS + 1)]
    arm = arm_from_screws(np.hstack(links), moved(np.eye(4), [1.7, 0, 0]))
    assert arm.compiled is None
    target = Position([0.9, 0.3, 0.4])
    assert errors(target, arm.fk(solve_ik(arm, target).require()))[0] <= 1e-6
