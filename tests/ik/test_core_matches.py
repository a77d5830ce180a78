"""Every configuration as the core verifies it and as Python gathers it: the same roots, of every family."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import twistarm
from catalogue import load
from family_arms import CASES, family_arm, joint_distance, missed, pose_of, screws_of
from ik_targets import pinocchio_fk, require_core
from twistarm import Approach, Arm, Pose, Position, solve_ik_all, solve_ik_all_batch
from twistarm.arm import arm_data
from twistarm.ik import AllSolutions, AnyTarget, gathering
from twistarm.ik.answer import Configurations
from twistarm.ik.closed_form import methods
from twistarm.ik.closed_form.roots import joint_difference
from twistarm.ik.targets import target_for


@pytest.fixture(autouse=True)
def core() -> None:
    require_core(load("ur5"))


SAME = 1e-6  # [rad, m]: roots that stand alone.

KNOWN = [
    (load, 12, "ur5", "pose"), (load, 12, "elbow", "position"), (load, 12, "stanford", "approach"),
    (load, 12, "scara", "pose"), (load, 12, "rover_arm", "approach"), (load, 12, "kinova", "pose"),
    (load, 12, "so101", "pose"), (load, 12, "rr_planar", "position"), (load, 6, "panda", "pose"),
    *((family_arm, 4, name, "pose") for name in CASES),
]  # fmt: skip
"""How an arm is made, at how many postures it is tried, its name, the kind of target."""

SINGULAR = [0.0, np.pi / 2, -np.pi / 2]


def target_at(arm: Arm, kind: str, theta: np.ndarray) -> AnyTarget:
    g = arm.fk(theta)
    if kind == "pose":
        return Pose(g)
    return Position(g[:3, 3]) if kind == "position" else target_for(arm, Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis))


def postures(arm: Arm, count: int) -> Iterator[np.ndarray]:
    """Inside the limits at random, singular ones and stretched ones among them, and ones at a limit."""
    rng = np.random.default_rng(4)
    lower, upper = arm.sampling_bounds
    for i, theta in enumerate(arm.random_theta(4, count)):
        changed = np.array(theta)
        if i % 2:
            joints = rng.random(arm.n) < 0.5
            changed[joints] = np.clip(rng.choice(SINGULAR, arm.n), lower, upper)[joints]
        if i % 5 == 4:
            changed[i % arm.n] = upper[i % arm.n]
        yield changed


def gathered(
    monkeypatch: pytest.MonkeyPatch,
    arm: Arm,
    target: AnyTarget,
    given: dict[str, float] | None = None,
    near: np.ndarray | None = None,
) -> AllSolutions:
    """The answer by Python's own verification of candidates, and by searches beside elimination."""
    doubtful = Configurations(np.empty((0, 2, arm.n)), 0, 0, 0, families=1)
    with monkeypatch.context() as patch:
        patch.setattr(arm_data, "_KEPT", type(arm_data._KEPT)())
        patch.setattr(gathering.Gathering, "compiled", lambda self, values: None)
        patch.setattr(gathering.Gathering, "_verified", lambda self, candidates: doubtful)
        return solve_ik_all(arm, target, near, fixed_joints=given)


def assert_same(arm: Arm, core: AllSolutions, other: AllSolutions) -> None:
    """As many roots, and each with its like; of continuous families the same joints move."""
    assert np.all(core.position_error <= 1e-9)
    assert np.all(core.orientation_error <= 1e-9)
    assert arm.limits.contains(core.theta).all()
    if any(core.free) or any(other.free):
        assert {*core.free} == {*other.free}
        return
    for ours, theirs in ((core.theta, other.theta), (core.outside, other.outside)):
        assert len(ours) == len(theirs)
        distance = np.abs(joint_difference(arm, ours[:, None], theirs[None])).max(axis=2, initial=0.0)
        assert len(ours) == 0 or (distance.min(axis=0) < SAME).all()
        assert len(ours) == 0 or (distance.min(axis=1) < SAME).all()


@pytest.mark.parametrize(("made", "count", "name", "kind"), KNOWN)
def test_the_same_roots(made: Any, count: int, name: str, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    arm = made(name)
    for theta in postures(arm, count):
        target = target_at(arm, kind, theta)
        given = {arm.joint_names[6]: float(theta[6])} if name == "panda" else None  # it has one joint too many
        assert given or methods.method_for(arm, target).exact
        found = solve_ik_all(arm, target, fixed_joints=given)
        assert not given or (found.theta[:, 6] == theta[6]).all()
        assert_same(arm, found, gathered(monkeypatch, arm, target, given))


def test_sampled_joints() -> None:
    """Each value of the sampled joint is one more try; every answer is verified."""
    arm = load("panda")
    found = solve_ik_all(arm, Pose(arm.fk(arm.ready)))
    assert not found.complete
    assert 0 < found.hits <= found.starts
    assert np.abs(arm.fk(found.theta) - found.target.numbers).max() < 1e-8
    batch = solve_ik_all_batch(arm, [found.target])
    for theta, free, also in zip(found.theta, found.free, batch.free[0], strict=True):
        null = np.linalg.svd(arm.body_jacobian(theta))[2][6:]
        moving = {arm.joint_names[i] for i in np.flatnonzero(np.abs(null).max(axis=0) > 1e-6)}
        assert moving <= {*free}  # at a symmetric posture some joints move in second order alone
        np.testing.assert_array_equal(also, [name in free for name in arm.joint_names])
    assert np.abs(found.theta - arm.ready).max(axis=1).min() < SAME


def test_answers_are_read_only_and_pickled() -> None:
    arm = load("ur5")
    found = solve_ik_all(arm, arm.fk(arm.random_theta(9)))
    again = pickle.loads(pickle.dumps(found))
    for answer in (found, again):
        assert not answer.theta.flags.writeable
        assert not answer.outside.flags.writeable
        with pytest.raises(ValueError, match="read-only"):
            answer.theta[0, 0] = 1.0
    np.testing.assert_array_equal(again.theta, found.theta)
    assert again.explain() == found.explain()


@pytest.mark.parametrize("threads", [1, 3])
def test_batch(threads: int) -> None:
    """The batch is what each call alone gives, whatever the number of threads."""
    arm = load("ur5")
    poses = arm.fk(arm.random_theta(11, 700))
    poses[5, :3, 3] = 9.0
    batch = solve_ik_all_batch(arm, poses, threads=threads)
    assert batch.theta.shape == (700, batch.count.max(), arm.n)
    assert batch.count[5] == 0
    assert np.isnan(batch.theta[5]).all()
    assert batch.complete.all()
    for i in (0, 5, 255, 256, 699):
        alone = solve_ik_all(arm, poses[i])
        np.testing.assert_array_equal(batch.theta[i, : batch.count[i]], alone.theta)
        np.testing.assert_array_equal(batch[i].theta, alone.theta)
        np.testing.assert_array_equal(batch[i].outside, alone.outside)
        assert len(batch[i].outside) == batch.outside_count[i]
    assert len(solve_ik_all_batch(arm, [])) == 0


def test_batch_of_any_targets() -> None:
    arm = load("rover_arm")
    postures_tried = arm.random_theta(12, 4)
    targets = [target_at(arm, kind, theta) for theta in postures_tried for kind in ("pose", "approach")]
    batch = solve_ik_all_batch(arm, targets, postures_tried[0])
    assert (batch.count > 0).all()
    for i, target in enumerate(targets):
        np.testing.assert_allclose(batch[i].theta, solve_ik_all(arm, target, postures_tried[0]).theta, atol=1e-12)


def test_batch_with_a_joint_given() -> None:
    arm = load("panda")
    name = arm.joint_names[6]
    theta = np.array(arm.random_theta(13, 5))
    theta[:, 6] = 0.3
    batch = solve_ik_all_batch(arm, arm.fk(theta), fixed_joints={name: 0.3})
    assert (batch.count > 0).all()
    for i in range(5):
        assert (batch[i].theta[:, 6] == 0.3).all()
        assert np.abs(batch[i].theta - theta[i]).max(axis=1).min() < SAME


@pytest.mark.parametrize("name", ["ur5", "rover_arm", "panda"])
def test_every_joint_given(name: str) -> None:
    """The configuration that is given is the one answer, or there is none."""
    arm = load(name)
    theta, other = arm.random_theta(15, 2)
    for like in (Pose(arm.fk(theta)), Position(arm.fk(theta)[:3, 3])):
        for given, count in ((theta, 1), (other, 0)):
            found = solve_ik_all(arm, like, fixed_joints=dict(zip(arm.joint_names, given.tolist(), strict=True)))
            assert (len(found), found.complete, found.free) == (count, True, ((),) * count)
            assert (found.theta == given).all()


def test_joints_that_do_not_take_part_in_the_motion_left_are_not_free() -> None:
    """A rover arm holds a point while shoulder, elbow and wrist move: its base, which alone moves sideways, stands."""
    arm = load("rover_arm")
    found = solve_ik_all(arm, Position(arm.fk(arm.ready)[:3, 3]))
    assert len(found)
    assert {*found.free} == {arm.joint_names[1:]}


# A continuous family of configurations is one entry of the list, by a member that keeps theta0's value.

EXACT = 1e-9
WRIST = ("joint4", "joint6")


def planar(lengths):
    """Links in a plane, by joints that turn within ± π."""
    ends = np.cumsum(lengths)
    axes = [["R", [0, 0, 1], [x, 0, 0]] for x in (0.0, *ends[:-1])]
    home = np.eye(4) + ends[-1] * np.eye(4, k=3)
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
