"""`reachable`: the verdicts of patient searches and of geometry, and the same bits however a call is divided."""

from dataclasses import replace

import numpy as np
import pytest

from catalogue import load
from ik_targets import KINDS, errors, is_reached, pinocchio_poses, require_core, target_from
from joint_arms import KINDS as JOINT_KINDS
from joint_arms import by_hand, random_chain
from twistarm import (
    Approach,
    InputError,
    JointLimits,
    Pose,
    Position,
    arm_from_screws,
    joints,
    reachable,
    solve_ik_batch,
)
from twistarm.arm.arm_data import Coupling
from twistarm.ik.reached import CHUNK, reach_ball

DOWN = [0.0, 0.0, -1.0]
LENGTHS = 0.4, 0.3  # Of rr_planar's links [m]; nothing limits its joints.


def locked():
    """A panda whose third joint stands at 0.4 rad."""
    arm = load("panda")
    still = {"panda_joint3": 0.4}
    return replace(arm, limits=arm.limits.with_({"lower": still, "upper": still}, arm.joint_names))


def follower():
    """A ur5 whose first wrist joint follows the elbow at half its speed, backwards."""
    arm, kept = load("ur5"), [0, 1, 2, 4, 5]
    A = np.eye(6)[:, kept]
    A[3, 2] = -0.5
    names, types = tuple(arm.joint_names[i] for i in kept), ("revolute",) * 5
    bounds = {"lower": dict.fromkeys(names, -2.5), "upper": dict.fromkeys(names, 2.5)}
    limits = JointLimits.unbounded(5).with_(bounds, names)
    return replace(arm, coupling=Coupling(A, np.zeros(6)), joint_names=names, joint_types=types, limits=limits)


ARMS = {"locked": locked, "follower": follower}


@pytest.fixture(params=["panda", "ur5", "rover_arm", "so101", "locked", "follower"])
def arm(request):
    arm = ARMS[request.param]() if request.param in ARMS else load(request.param)
    require_core(arm)
    return arm


def voxels(arm, side):
    """Centres (side³, 3) of voxels of a box around what the arm reaches."""
    axis = np.linspace(-1.0, 1.0, side) * arm.reach
    return np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3) + [0.0, 0.0, 0.2]


def test_the_verdicts_are_those_of_patient_searches(arm):
    """Of a grid of approaches, and of mixed kinds within reach and beyond. Forward kinematics judges each theta."""
    rng, p = np.random.default_rng(3), voxels(arm, 5)
    g = arm.fk(arm.random_theta(rng, 60))
    g[::3, :3, 3] *= rng.uniform(0.5, 1.5, size=(20, 1))
    mixed = [target_from(KINDS[i % 4], pose, rng) for i, pose in enumerate(g)]
    down = [Approach(point, DOWN).of(arm) for point in p]
    for asked, found in ((down, reachable(arm, p, direction=DOWN)), (mixed, reachable(arm, mixed))):
        assert (found.converged == solve_ik_batch(arm, asked).converged).all()
        assert np.isnan(found.theta[~found.converged]).all()
        theta = found.theta[found.converged]
        assert arm.limits.contains(theta).all()
        assert len(theta) or asked is down
        reached = arm.fk(theta) if arm.n != len(arm.coupling.A) else pinocchio_poses(arm, theta)
        missed = [errors(asked[i], pose) for i, pose in zip(np.flatnonzero(found.converged), reached, strict=True)]
        assert is_reached(*np.reshape(missed, (-1, 2)).T).all()


def test_two_links_reach_a_ring():
    arm = load("rr_planar")
    require_core(arm)
    x, y = np.meshgrid(np.linspace(-0.8, 0.8, 41), np.linspace(-0.8, 0.8, 41))
    p = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=-1)
    radius = np.linalg.norm(p, axis=1)
    clear = np.minimum(np.abs(radius - sum(LENGTHS)), np.abs(radius - 0.1)) > 1e-5
    ring = (radius > LENGTHS[0] - LENGTHS[1]) & (radius < sum(LENGTHS))
    assert (reachable(arm, p).converged == ring)[clear].all()
    assert not reachable(arm, p + [0.0, 0.0, 1e-3]).converged.any(), "its plane is z = 0"


def test_the_same_bits_however_a_call_is_divided():
    arm, fractions = load("panda"), []
    require_core(arm)
    p = np.repeat(voxels(arm, 5)[:, None], 80, axis=1).reshape(-1, 3) + np.linspace(0.0, 0.02, 10_000)[:, None]
    reached, theta = reachable(arm, p, direction=DOWN, progress=fractions.append)
    parts = [slice(0, CHUNK), slice(CHUNK, None)]
    for threads in (1, 2):
        answers = [reachable(arm, p[part], direction=DOWN, threads=threads) for part in parts]
        np.testing.assert_array_equal(np.concatenate([part.converged for part in answers]), reached)
        np.testing.assert_array_equal(np.concatenate([part.theta for part in answers]), theta)
    poses = arm.fk(theta[reached])
    np.testing.assert_array_equal(reachable(arm, poses).theta, reachable(arm, [*map(Pose, poses)]).theta)
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


@pytest.mark.parametrize(
    ("targets", "how", "text"),
    [
        (np.zeros((2, 3)), {"direction": np.ones((3, 3))}, "direction must have shape (3,) or (2, 3); got (3, 3)"),
        ([Position([0.0] * 3)], {"direction": DOWN}, "direction goes with targets that are positions (N, 3)"),
        (np.full((1, 3), 1e7), {}, "beyond 1e+06 m: lengths are in metres"),
        (np.array([[0.0, np.nan, 0.0]]), {}, "targets must be finite; it holds nan at index [0, 1]"),
        (np.stack([np.eye(4), np.ones((4, 4))]), {}, "targets[1]: "),
        (np.zeros((2, 5)), {}, "targets must be poses of shape (N, 4, 4)"),
    ],
)
def test_misuse_is_refused(targets, how, text):
    with pytest.raises(InputError) as caught:
        reachable(load("panda"), targets, **how)
    assert text in str(caught.value)


def test_no_targets_have_no_verdicts():
    for nothing in ([], np.zeros((0, 3)), np.zeros((0, 4, 4))):
        found = reachable(load("panda"), nothing)
        assert found.converged.shape == (0,)
        assert found.theta.shape == (0, 7)


# `reach_ball`: no configuration of any arm is outside, and it is as small as known arms allow.


def farthest(arm, like, ball, seed):
    """The greatest distance from the ball's centre, over random configurations and corners of the limits."""
    rng, ends = np.random.default_rng(seed), np.array(arm.sampling_bounds)
    corners = ends[rng.integers(2, size=(1000, arm.n)), np.arange(arm.n)]
    g = arm.fk(np.vstack([arm.random_theta(rng, 3000), corners]))
    return np.linalg.norm(g[:, :3, :3] @ ball.x + g[:, :3, 3] - ball.centre, axis=1).max()


def kinds_of(arm):
    return Position([0.0] * 3), Approach([0.0] * 3, [0.0, 0.0, -1.0]).of(arm), Pose(np.eye(4))


def test_no_configuration_of_a_known_arm_is_outside(catalogue_arm):
    for like in kinds_of(catalogue_arm):
        ball = reach_ball(catalogue_arm, like)
        assert farthest(catalogue_arm, like, ball, 4) <= ball.radius <= 1.5 * farthest(catalogue_arm, like, ball, 5)


@pytest.mark.parametrize("seed", range(40))
def test_no_configuration_of_a_random_arm_is_outside(seed):
    """Joints of all six kinds, some coupled to others, and limits about any middle or missing."""
    rng = np.random.default_rng(seed)
    arm = by_hand(*random_chain(rng.choice(JOINT_KINDS, size=rng.integers(1, 6)), seed))
    m, n = arm.n, rng.integers(1, arm.n + 1)
    A = np.eye(m)[:, :n]
    A[n:] = rng.normal(size=(m - n, n)) * (rng.random((m - n, n)) < 0.5)
    middle, half = 2.0 * rng.normal(size=n), rng.uniform(0.0, 3.0, n)
    lower, upper = (np.where(rng.random(n) < 0.2, sign * np.inf, middle + sign * half) for sign in (-1.0, 1.0))
    names, limits = arm.joint_names[:n], replace(JointLimits.unbounded(n), lower=lower, upper=upper)
    coupling, types = Coupling(A, np.zeros(m)), arm.joint_types[:n]
    arm = replace(arm, coupling=coupling, joint_names=names, joint_types=types, limits=limits)
    for like in kinds_of(arm):
        ball = reach_ball(arm, like, arm.sampling_bounds)
        assert farthest(arm, like, ball, seed) <= ball.radius < np.inf
        assert ball.radius <= reach_ball(arm, like).radius


def test_slides_alone_stay_in_the_ball_about_the_middle_of_their_box():
    limits = {"lower": {"a": -0.3, "b": 0.0}, "upper": {"a": 0.5, "b": 0.2}}
    home = np.eye(4)
    home[:3, 3] = [0.1, 0.0, 0.2]
    screws = np.hstack([joints.prismatic([1, 0, 0]), joints.prismatic([0, 1, 0])])
    ball = reach_ball(arm_from_screws(screws, home, joints=["a", "b"], limits=limits), Position([0.0] * 3))
    assert ball.centre == pytest.approx([0.2, 0.1, 0.2])
    assert ball.radius == pytest.approx(0.4 + 0.1, abs=1e-6)


def test_two_links_reach_their_sum():
    assert reach_ball(load("rr_planar"), Position([0.0] * 3)).radius == pytest.approx(0.7, abs=1e-6)
