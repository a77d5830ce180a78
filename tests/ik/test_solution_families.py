"""A continuous family of configurations is one entry of the list, by a member that keeps theta0's value."""

from __future__ import annotations

import numpy as np
import pytest

import twistarm
from catalogue import load
from family_arms import family_arm, joint_distance, missed, pose_of, screws_of
from ik_targets import pinocchio_fk
from test_core_matches import gathered
from twistarm import Pose, Position, solve_ik_all, solve_ik_all_batch

EXACT = 1e-9
WRIST = ("joint4", "joint6")


def planar(lengths):
    """Links in a plane, by joints that turn within ± π."""
    ends = np.cumsum(lengths)
    axes = [["R", [0, 0, 1], [x, 0, 0]] for x in (0.0, *ends[:-1])]
    home = np.eye(4)
    home[0, 3] = ends[-1]
    names = [f"joint{i + 1}" for i in range(len(lengths))]
    limits = {"lower": dict.fromkeys(names, -np.pi), "upper": dict.fromkeys(names, np.pi)}
    return twistarm.arm_from_screws(screws_of(axes), home, joints=names, limits=limits)


LINKAGES = [
    ([0.5, 0.3, 0.4], 0.15), ([0.5, 0.45, 0.2], 0.6), ([0.3, 0.5, 0.4], 0.35), ([0.4, 0.4, 0.3], 0.35),
    ([0.5, 0.3, 0.4], 0.55), ([0.6, 0.2, 0.3], 0.5),
]  # fmt: skip


@pytest.mark.parametrize(("lengths", "distance"), LINKAGES)
def test_three_links_that_hold_a_point_have_a_family_for_each_circuit(lengths, distance):
    """They are a four-bar linkage, which by Grashof's rule has two circuits or one."""
    bars = sorted([*lengths, distance])
    circuits = 2 if bars[0] + bars[3] < bars[1] + bars[2] else 1
    arm, point = planar(lengths), distance * np.exp(0.4j)
    found = solve_ik_all(arm, Position([point.real, point.imag, 0.0]), [0.1, 0.2, 0.3])
    assert len(found) + len(found.outside) == circuits
    assert found.free == (tuple(arm.joint_names),) * len(found)
    assert np.abs((lengths * np.exp(1j * np.cumsum(found.theta, axis=1))).sum(axis=1) - point).max() < 1e-8


def straight_wrists(count, gap=0.0):
    """A spherical wrist bent by `gap`, so far from theta0: arm, pose, what made it, theta0."""
    arm, rng = family_arm("spherical wrist"), np.random.default_rng(5)
    for theta in arm.random_theta(rng, count):
        theta[4] = gap
        yield arm, pose_of(arm, theta), theta, arm.random_theta(rng)


@pytest.mark.parametrize("by", ["core", "gathered"])
def test_a_straight_wrist_keeps_its_first_joint_where_it_is(by, monkeypatch):
    for arm, g, _, near in straight_wrists(2):
        found = solve_ik_all(arm, Pose(g), near) if by == "core" else gathered(monkeypatch, arm, Pose(g), near=near)
        straight = [answer for answer, free in zip(found, found.free, strict=True) if free == WRIST]
        assert straight
        assert len({tuple(answer[:3].round(6)) for answer in straight}) == len(straight)
        for answer in straight:
            assert answer[3] == pytest.approx(near[3], abs=1e-9)
            for turn in (0.7, -2.0):
                assert missed(arm, g, answer + turn * np.array([0, 0, 0, 1, 0, -1])) < EXACT


def test_a_wrist_straight_but_for_1e_8_is_not_free():
    for arm, g, theta, near in straight_wrists(2, 1e-8):
        exact = solve_ik_all(arm, Pose(g), near)
        assert not any(exact.free)
        assert len(exact) + len(exact.outside) <= 8
        assert min(joint_distance(arm, answer, theta) for answer in exact) < 1e-6
        assert all(missed(arm, g, answer) < EXACT for answer in exact)


def test_a_ur_arm_with_a_singular_wrist_by_pinocchio():
    arm, rng = load("ur5"), np.random.default_rng(8)
    for theta in arm.random_theta(rng, 3):
        theta[4] = 0.0
        near = arm.random_theta(rng)
        g = pinocchio_fk(arm, theta)
        found = solve_ik_all(arm, Pose(g), near)
        moving = [answer for answer, free in zip(found, found.free, strict=True) if free]
        assert 1 <= len(moving) <= 2  # a four-bar linkage has two circuits at most
        for answer in moving:
            assert np.abs(pinocchio_fk(arm, answer) - g).max() < 1e-8
            assert np.abs(answer - near)[[1, 2, 3, 5]].min() < EXACT
        assert nearest_first(arm, found, near)


def test_a_position_for_six_joints_is_a_few_families():
    arm, rng = load("ur5"), np.random.default_rng(9)
    theta, near = arm.random_theta(rng, 2)
    p = pinocchio_fk(arm, theta)[:3, 3]
    found = solve_ik_all(arm, Position(p), near, redundancy_samples=6)
    assert 1 <= len(found) <= 8
    assert found.free == (tuple(arm.joint_names),) * len(found)
    assert nearest_first(arm, found, near)
    assert all(np.linalg.norm(pinocchio_fk(arm, answer)[:3, 3] - p) < 1e-8 for answer in found)
    batch = solve_ik_all_batch(arm, [Position(p)], near, redundancy_samples=6)
    np.testing.assert_array_equal(batch.theta[0], found.theta)


@pytest.mark.parametrize("by", ["core", "gathered"])
@pytest.mark.parametrize(("bend", "count"), [(1e-8, 1), (2e-5, 1), (1e-3, 2)])
def test_two_answers_are_one_where_halfway_between_them_the_target_is_reached(by, bend, count, monkeypatch):
    """Elbow up and down, ± bend from stretched: halfway the tip is bend² a b / 2 (a + b) too far out."""
    arm = load("rr_planar")
    theta = np.array([0.4, bend])
    target = Position(pinocchio_fk(arm, theta)[:3, 3])
    near = np.array([0.4, 1.0])
    found = solve_ik_all(arm, target, near) if by == "core" else gathered(monkeypatch, arm, target, near=near)
    assert len(found) == count
    assert np.abs(found[0] - theta).max() < 1e-4  # the one on theta0's side
    assert found.complete


def nearest_first(arm, found, near):
    """Whether each answer is as far as the one before or farther: the largest share of a joint's range."""
    share = (np.abs(found.theta - near) / (arm.limits.upper - arm.limits.lower)).max(axis=1)
    return (np.diff(share) >= 0.0).all()
