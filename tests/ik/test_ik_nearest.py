"""Targets that cannot be reached: the nearest against SciPy's optimisers, the reasons, and the words for them."""

import itertools

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import urdf_text
from catalogue import load
from ik_targets import KINDS, errors, pinocchio_fk, require_core, target_from, turned
from reference.nearest import ANGLE_TOL, POSITION_TOL, by_slsqp
from reference.optimality import residual
from twistarm import arm_from_screws, load_arm
from twistarm.ik import Position, StopReason, TolerancedPose, solve_ik

# Residual of the optimality conditions, per rad or m; the solver stops at 1e-8 and stands 1e-11 m off its position.
STATIONARY = 1e-7
# Factors (x and y, z) by which positions of random configurations are moved: some in reach, some out of it.
STRETCH = ((0.9, 1.0), (0.5, 1.0), (1.0, 2.0))


@pytest.fixture(autouse=True)
def _core():
    require_core(load("rover_arm"))


# the nearest, against SciPy -----------------------------------------------------------------------------------


def hard_target(arm, kind, rng, k):
    """A target of `kind` at a position the arm may reach, in a random orientation."""
    g = arm.fk(arm.random_theta(rng))
    g[:2, 3] *= STRETCH[k % 3][0]
    g[2, 3] *= STRETCH[k % 3][1]
    g[:3, :3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    if kind == "TolerancedPose":
        return TolerancedPose(g, [0.02, 0.0, 0.01, 0.1, np.inf, 0.0], frame=("target", "base")[k % 2])
    return target_from(kind, g, rng)


NEAREST = [("rover_arm", "Pose", 0), ("rover_arm", "Approach", 1), ("rover_arm", "TolerancedPose", 2),
           ("so101", "Pose", 1),
           ("so101", "Approach", 2), ("so101", "TolerancedPose", 0), ("so101", "TolerancedPose", 1), ("ur5", "Pose", 2),
           ("panda", "Pose", 2), ("z1", "Pose", 2)]  # fmt: skip


@pytest.mark.parametrize(("name", "kind", "k"), NEAREST)
def test_no_optimiser_comes_nearer(name, kind, k):
    arm, rng = load(name), np.random.default_rng([17, k])
    target = hard_target(arm, kind, rng, k)
    solution = solve_ik(arm, target)
    least, turn = by_slsqp(arm, target, rng, 8)
    position, rotation = errors(target, pinocchio_fk(arm, solution.theta))
    assert solution.within_limits
    assert position <= least + POSITION_TOL
    if least < position + POSITION_TOL:
        assert rotation <= turn + ANGLE_TOL
    assert solution.stop not in (StopReason.EXHAUSTED, StopReason.TIMED_OUT)


@pytest.mark.parametrize("name", ["rover_arm", "so101"])
@pytest.mark.parametrize("seed", range(2))
def test_the_least_rotation_meets_the_conditions_of_optimality(name, seed):
    arm, rng = load(name), np.random.default_rng([23, seed])
    g = turned(arm.fk(arm.random_theta(rng)), [0.6, 0.8, 0], 0.5)
    solution = solve_ik(arm, g)
    assert solution.stop is StopReason.IMPOSSIBLE_DIRECTION
    assert solution.position_error < 1e-10
    J = arm.body_jacobian(solution.theta)
    w = pin.log3(g[:3, :3].T @ arm.fk(solution.theta)[:3, :3])
    assert np.linalg.norm(w) == pytest.approx(solution.orientation_error, abs=1e-9)
    assert residual(J[3:].T @ w / np.linalg.norm(w), J[:3], solution.theta, arm.limits) < STATIONARY


@pytest.mark.parametrize("name", ["ur5", "panda", "so101"])
def test_the_least_distance_meets_the_conditions_of_optimality(name):
    arm, rng = load(name), np.random.default_rng(1)
    g = arm.fk(arm.random_theta(rng))
    g[:3, 3] *= (arm.reach + 2.0) / np.linalg.norm(g[:3, 3])
    solution = solve_ik(arm, g)
    assert solution.stop is StopReason.OUT_OF_REACH
    reached = arm.fk(solution.theta)
    away = reached[:3, :3].T @ (reached[:3, 3] - g[:3, 3])
    slope = arm.body_jacobian(solution.theta)[:3].T @ away / np.linalg.norm(away)
    assert np.linalg.norm(away) == pytest.approx(solution.position_error)
    assert residual(slope, np.zeros((0, arm.n)), solution.theta, arm.limits) < STATIONARY


# reasons: a planar arm of two links, 0.4 m and 0.3 m, for which all of it can be told by hand --------------------


@pytest.fixture(scope="module")
def planar(tmp_path_factory):
    """Shoulder ±170°, elbow from 0 to 90°, both about z; the tool's z along the base's."""
    shoulder = urdf_text.joint(
        "shoulder", "base_link", "upper", xyz="0 0 0", inside='<limit lower="-3" upper="3" velocity="1" effort="1"/>'
    )
    elbow = urdf_text.joint(
        "elbow", "upper", "fore", xyz="0.4 0 0", inside='<limit lower="0" upper="1.5707963" velocity="1" effort="1"/>'
    )
    tool = urdf_text.joint("flange", "fore", "tool0", kind="fixed", xyz="0.3 0 0")
    text = urdf_text.robot(shoulder, elbow, tool, links=("base_link", "upper", "fore", "tool0"), name="planar")
    return load_arm(urdf_text.write(tmp_path_factory.mktemp("planar"), text))


def test_blocked_by_a_limit(planar):
    # 0.2 m from the shoulder takes the elbow to 151°; at its bound of 90° the tool is 0.5 m away from it.
    solution = solve_ik(planar, Position([0.2, 0.0, 0.0]))
    assert solution.stop is StopReason.BLOCKED_BY_LIMITS
    assert solution.position_error == pytest.approx(0.3, abs=1e-6)
    assert solution.theta[1] == planar.limits.upper[1]
    needed = np.arccos((0.2**2 - 0.4**2 - 0.3**2) / (2 * 0.4 * 0.3))
    assert abs(solution.unlimited[1]) == pytest.approx(needed, abs=1e-5)
    text = solution.explain()
    assert "reason: blocked by joint limits" in text
    assert "elbow 151.0° (upper bound 90.0°)" in text or "elbow -151.0° (lower bound 0.0°)" in text
    assert "at the upper position limit of elbow (90.0°)" in text


@pytest.mark.parametrize("name", ["rover_arm", "kinova"])
def test_more_time_is_never_worse_than_the_race_alone(name):
    """Cut short in the search for the nearest, the answer is at least as near as the searches before it."""
    arm, target = load(name), Position([3.0, 0.0, 0.0])
    errors = [solve_ik(arm, target, max_time=t).position_error for t in (0.005, 0.08, 0.1, 0.12, 2.0)]
    assert max(errors[1:]) <= errors[0] + 1e-9


# Targets beyond the reach that are followed, each answer the next start; and targets far along a slide.

ARMS = ("panda", "so101", "kinova", "stanford")

JUMP = 0.2  # A coordinate that moves by more [rad, m] for a step of a millimetre has jumped.

STEPS = 60


def path(arm, rng, shape):
    """Positions (STEPS, 3) a millimetre apart, on a line, a circle or an eight beyond the arm's reach."""
    d, e, f = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix()
    s, r = 1e-3 * np.arange(STEPS), rng.uniform(0.03, 0.1)
    along, across = {
        "line": (s, 0 * s),
        "circle": (r * np.sin(s / r), r * np.cos(s / r)),
        "eight": (r * np.sin(s / r), r * np.sin(2 * s / r) / 2),
    }[shape]
    reached = arm.fk(arm.random_theta(np.random.default_rng(0), 500))[:, :3, 3]
    middle = reached.mean(0)
    radius = np.linalg.norm(reached - middle, axis=1).max()
    return middle + rng.uniform(1.3, 2.0) * radius * d + np.outer(along, e) + np.outer(across, f)


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_that_follows_a_target_beyond_its_reach_does_not_jump(name):
    arm, rng, jumps, silent = load(name), np.random.default_rng(41), 0, 0
    require_core(arm)
    for kind, shape in itertools.product(KINDS, ("line", "circle", "eight")):
        theta, seed = arm.random_theta(rng), int(rng.integers(2**31))
        R = Rotation.random(random_state=seed).as_matrix()
        for i, p in enumerate(path(arm, rng, shape)):
            g = np.eye(4)
            g[:3, :3], g[:3, 3] = R, p
            solution = solve_ik(arm, target_from(kind, g, np.random.default_rng(seed)), theta)
            assert not solution.converged
            jumped = i > 0 and np.abs(solution.theta - theta).max() > JUMP
            jumps += jumped
            silent += jumped and not any("another branch" in note for note in solution.notes)
            theta = solution.theta
    assert jumps <= 0.01 * len(KINDS) * 3 * STEPS
    assert silent == 0


@pytest.mark.parametrize("name", ["ur5", "panda", "rover_arm_6dof"])
def test_no_configuration_as_near_is_nearer_to_the_start(name):
    """SciPy's SLSQP, along the configurations that are as near to the target, finds none by more than a hair."""
    arm, rng = load(name), np.random.default_rng(43)
    require_core(arm)
    for _ in range(3):
        p = rng.normal(size=3)
        target, start = Position(p * (arm.reach + 0.5) / np.linalg.norm(p)), arm.random_theta(rng)
        solution = solve_ik(arm, target, start)

        def beyond(theta, target=target, least=solution.position_error):
            return 1e3 * (least + 1e-11 - errors(target, pinocchio_fk(arm, theta))[0])

        peer = minimize(
            lambda theta, start=start: 0.5 * np.sum((theta - start) ** 2), solution.theta, method="SLSQP",
            bounds=list(zip(arm.limits.lower, arm.limits.upper, strict=True)),
            constraints={"type": "ineq", "fun": beyond}, options={"ftol": 1e-12, "maxiter": 200},
        ).x  # fmt: skip
        found, by_peer = (np.linalg.norm(theta - start) for theta in (solution.theta, peer))
        assert beyond(peer) < -1e-6 or found <= by_peer + 0.01


@pytest.mark.parametrize("distance", [30.0, 1000.0, 90_000.0])
@pytest.mark.parametrize("kind", KINDS)
def test_a_slide_whose_limits_are_only_written_down_is_followed_along(kind, distance):
    elbow, rail = load("elbow"), np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    limits = {"lower": np.r_[-999_999.0, elbow.limits.lower], "upper": np.r_[999_999.0, elbow.limits.upper]}
    arm = arm_from_screws(np.column_stack([rail, elbow.screws]), elbow.home, limits=limits)
    require_core(arm)
    rng = np.random.default_rng(47)
    for side in (-distance, distance):
        theta = np.r_[side, elbow.random_theta(rng)]
        assert solve_ik(arm, target_from(kind, arm.fk(theta), rng)).converged
    off = solve_ik(arm, Position([0.0, distance, 10 * elbow.reach]))
    assert off.position_error < 11 * elbow.reach
