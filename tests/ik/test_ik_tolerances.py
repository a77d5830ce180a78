"""Tolerances of inverse kinematics: rounded axes, tolerances that are used, answers near the start."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import KINDS, at_some_limits, errors, judged, pinocchio_fk, require_core, target_from
from twistarm import Approach, Pose, load_arm, solve_ik, solve_ik_all, solve_ik_batch
from urdf_text import joint, robot, write

HALF = 0.2  # How far [rad, m] from the start an answer is near.


@pytest.fixture(autouse=True)
def _core():
    require_core(load("rover_arm"))


# rounded axes -----------------------------------------------------------------------------------------------------

# A quarter turn as exports write it.
QUARTER = {4: "1.5708", 5: "1.57080", 6: "1.570796", 16: "1.5707963267948966"}


def five_joints(digits):
    """Yaw, three pitches and a roll, whose frames are turned by quarter turns of so many digits."""
    q = QUARTER[digits]
    origins = [("0 0 0.1", "0 0 0"), ("0.05 0 0.1", f"{q} 0 0"), ("0.3 0 0", "0 0 0"), ("0 0.28 0", f"0 0 {q}")]
    origins.append(("0.06 0 0.01", f"0 {q} 0"))
    limit = '<limit lower="-2.6" upper="2.6" velocity="2" effort="3"/>'
    links = ("base", *(f"link{k}" for k in range(5)))
    parts = [
        joint(f"j{k}", links[k], links[k + 1], inside=limit, xyz=xyz, rpy=rpy) for k, (xyz, rpy) in enumerate(origins)
    ]
    return robot(*parts, links=links)


def test_a_rounded_arm_reaches_what_the_exact_one_reaches(tmp_path):
    """Within the tolerances, and never an answer outside them."""
    exact = load_arm(write(tmp_path, five_joints(16), "exact.urdf"))
    rng = np.random.default_rng(5)
    axis = exact.tool_axis
    targets = [Approach(g[:3, 3], g[:3, :3] @ axis, axis) for g in map(exact.fk, exact.random_theta(rng, 60))]
    for digits in (4, 5, 6):
        arm = load_arm(write(tmp_path, five_joints(digits), f"rounded{digits}.urdf"))
        batch = solve_ik_batch(arm, targets)
        for target, solution_in_batch in zip(targets, batch, strict=True):
            for solution in (solve_ik(arm, target), solution_in_batch):
                position, angle = errors(target, pinocchio_fk(arm, solution.theta))
                assert solution.converged == (position <= 1e-5 and angle <= 5e-5)  # another arm's limits are near
        assert batch.converged.mean() > 0.95
    assert all(solve_ik(exact, target).converged for target in targets)


def test_every_branch_of_a_rounded_arm_is_listed_within_the_tolerances(tmp_path):
    """As many as the exact arm has, whose closed form says that these are all."""
    exact, arm = (load_arm(write(tmp_path, five_joints(k), f"arm{k}.urdf")) for k in (16, 4))
    axis, listed = exact.tool_axis, 0
    for g in map(exact.fk, exact.random_theta(np.random.default_rng(6), 4)):
        target = Approach(g[:3, 3], g[:3, :3] @ axis, axis)
        found = solve_ik_all(arm, target)
        for theta in found:
            position, angle = errors(target, pinocchio_fk(arm, theta))
            assert position <= 1e-5
            assert angle <= 5e-5
            assert arm.limits.contains(theta)
        assert len(found)
        assert not found.complete
        listed += len(found) == len(solve_ik_all(exact, target))
    assert listed >= 3


def test_an_exact_arm_keeps_its_tolerance(tmp_path):
    """A direction 2e-5 rad out of the arm's plane is impossible for exact axes."""
    arm = load_arm(write(tmp_path, five_joints(16)))
    g = pinocchio_fk(arm, [0.0, 0.6, -1.0, 0.4, 0.0])
    out = Rotation.from_rotvec([2e-5 * c for c in np.cross(g[:3, :3] @ arm.tool_axis, [0.0, 1.0, 0.0])]).as_matrix()
    target = Approach(g[:3, 3], out @ g[:3, :3] @ arm.tool_axis)
    assert not solve_ik(arm, target, orientation_tol=1e-5).converged
    assert solve_ik(arm, target, orientation_tol=3e-5).converged


# tolerances are used ----------------------------------------------------------------------------------------------


def inside_tolerance(rng, g, position, orientation):
    """A pose that g (4, 4) misses by no more than the tolerances."""
    there, step = g.copy(), rng.normal(size=3)
    there[:3, 3] += position * rng.uniform() ** (1 / 3) * step / np.linalg.norm(step)
    axis = rng.normal(size=3)
    turn = Rotation.from_rotvec(orientation * rng.uniform() * axis / np.linalg.norm(axis))
    there[:3, :3] = turn.as_matrix() @ g[:3, :3]
    return there


@pytest.mark.parametrize(("name", "position_tol", "orientation_tol"), [
    ("so101", 0.01, 1e-3), ("so101", 1e-4, 0.02), ("rover_arm", 5e-3, 1e-4), ("ur5", 0.01, 1e-3), ("panda", 1e-4, 0.02),
])  # fmt: skip
def test_whatever_has_a_configuration_within_both_tolerances_is_reached(name, position_tol, orientation_tol):
    arm, rng = load(name), np.random.default_rng(8)
    thetas = arm.random_theta(rng, 200)
    poses = [inside_tolerance(rng, pinocchio_fk(arm, theta), position_tol, orientation_tol) for theta in thetas]
    batch = solve_ik_batch(arm, np.array(poses), position_tol=position_tol, orientation_tol=orientation_tol)
    assert batch.converged.all()
    assert arm.limits.contains(batch.theta).all()
    for g, theta in zip(poses, batch.theta, strict=True):
        position, angle = errors(Pose(g), pinocchio_fk(arm, theta))
        assert position <= position_tol + 1e-9
        assert angle <= orientation_tol + 1e-9


@pytest.mark.parametrize("name", ["ur5", "rover_arm", "so101", "panda"])
def test_a_search_aims_at_the_target_itself_however_wide_the_tolerances_are(name):
    arm = load(name)
    poses = arm.fk(arm.random_theta(np.random.default_rng(3), 200))
    batch = solve_ik_batch(arm, poses, position_tol=1e-2, orientation_tol=0.1)
    worst = np.maximum(batch.position_error, batch.orientation_error)
    assert worst.max() < 1e-6
    assert np.quantile(worst, 0.95) < 1e-9


@pytest.mark.parametrize(("position_tol", "orientation_tol"), [(1e-6, 1e-6), (1e-5, 5e-5), (1e-3, 1e-6), (5e-3, 0.05)])
@pytest.mark.parametrize("name", ["rr_planar", "so101", "ur5"])
def test_what_the_start_reaches_is_never_refused(name, position_tol, orientation_tol):
    """Poses that theta0 misses by 0.92 to 0.98 of the tolerances, by one search."""
    arm, rng = load(name), np.random.default_rng(7)
    how = {"position_tol": position_tol, "orientation_tol": orientation_tol, "restarts": 1}
    for theta in arm.random_theta(rng, 60):
        step, axis, share = rng.normal(size=3), rng.normal(size=3), rng.uniform(0.92, 0.98)
        there = pinocchio_fk(arm, theta)
        there[:3, 3] += share * position_tol * step / np.linalg.norm(step)
        turn = Rotation.from_rotvec(share * orientation_tol * axis / np.linalg.norm(axis))
        there[:3, :3] = turn.as_matrix() @ there[:3, :3]
        assert solve_ik(arm, Pose(there), theta, **how).converged


@pytest.mark.parametrize("name", ["kinova", "rover_arm"])
def test_the_size_of_an_arm_changes_no_verdict(name):
    """The same arm drawn a hundred times smaller and larger, at configurations with joints at their limits."""
    arm, verdicts = load(name), []
    for size in (0.01, 1.0, 100.0):
        other = resized(arm, size)
        poses = other.fk(at_some_limits(other, np.random.default_rng(17), 60))
        poses[::3, :3, 3] *= 1.2
        batch = solve_ik_batch(other, poses, np.zeros(arm.n), position_tol=1e-5 * size, restarts=20)
        verdicts.append([stop.name for stop in batch.stop])
    assert verdicts[0] == verdicts[1] == verdicts[2]


def resized(arm, size):
    """The arm with lengths `size` times as great."""
    screws, home, unit = arm.screws.copy(), arm.home.copy(), np.where(arm.prismatic, size, 1.0)
    turns = screws[3:].any(axis=0)
    screws[:3, turns] *= size
    home[:3, 3] *= size
    limits = replace(arm.limits, lower=arm.limits.lower * unit, upper=arm.limits.upper * unit)
    return replace(
        arm, screws=screws, home=home, reach=arm.reach * size, limits=limits, description=None, named_states={},
        known_ready=arm.ready * unit,
    )  # fmt: skip


def test_a_list_is_never_empty_where_a_configuration_within_the_tolerances_was_found():
    """Poses half a tolerance off what an arm of five joints reaches: one configuration of each branch, and no proof."""
    arm, rng = load("so101"), np.random.default_rng(13)
    for theta in arm.random_theta(rng, 10):
        target = Pose(inside_tolerance(rng, pinocchio_fk(arm, theta), 5e-6, 2.5e-5))
        alone, found = solve_ik(arm, target), solve_ik_all(arm, target)
        assert bool(len(found)) == alone.converged
        assert not (len(found) and found.complete)
        for answer in found:
            position, angle = errors(target, pinocchio_fk(arm, answer))
            assert position <= 1e-5 + 1e-9
            assert angle <= 5e-5 + 1e-9


# near the start ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["panda", "ur5", "so101"])
def test_an_answer_is_near_the_start_where_one_is(name, kind):
    """Targets that some configuration within 0.2 of theta0 reaches, however far the tool has to go."""
    arm, rng = load(name), np.random.default_rng([33, KINDS.index(kind)])
    for theta in arm.random_theta(rng, 60):
        theta0 = np.clip(theta + rng.uniform(-HALF, HALF, arm.n), arm.limits.lower, arm.limits.upper)
        target = target_from(kind, pinocchio_fk(arm, theta), rng)
        solution = solve_ik(arm, target, theta0)
        assert judged(arm, target, solution)
        assert np.abs(solution.theta - theta0).max() <= HALF + 1e-9
        assert not any("another branch" in note for note in solution.notes)


@pytest.mark.parametrize("name", ["ur5", "stanford"])
def test_a_small_step_is_answered_on_the_nearest_branch(name):
    """Steps of up to 2 % of the reach and 3°; the branches by many searches of one start each."""
    arm, rng = load(name), np.random.default_rng(35)
    for theta0 in arm.random_theta(rng, 50):
        target = Pose(inside_tolerance(rng, pinocchio_fk(arm, theta0), 0.02 * arm.reach, np.radians(3.0)))
        solution = solve_ik(arm, target, theta0)
        moved = np.abs(solution.theta - theta0).max()
        if not solution.converged or moved <= HALF:
            continue
        assert any("another branch" in note for note in solution.notes)
        starts = theta0 + rng.normal(size=(100, arm.n)) * rng.uniform(0.05, 1.0, (100, 1))
        others = solve_ik_batch(arm, [target] * 100, starts, restarts=1)
        nearest = np.abs(others.theta[others.converged] - theta0).max(axis=1).min(initial=np.inf)
        assert moved <= 1.3 * nearest + 0.1, (moved, nearest)


def test_a_list_has_the_tolerances_of_its_call_and_claims_no_proof_by_a_closed_form_that_has_not():
    """1 mm beyond the reach of the rover arm in x, which solve_ik reaches within 2 cm."""
    arm, target = load("rover_arm"), Approach([1.075, 0.02, 0.7], [1, 0, 0])
    found, off = solve_ik_all(arm, target, position_tol=0.02, orientation_tol=0.05), solve_ik(arm, target)
    assert len(found)
    assert not found.complete
    position, angle = errors(Approach(target.p, target.direction, arm.tool_axis), pinocchio_fk(arm, found[0]))
    assert position <= 0.02
    assert angle <= 0.05
    none = solve_ik_all(arm, target, position_tol=off.position_error / 5, orientation_tol=1e-3)
    assert not len(none)
    assert f"the tolerance is {off.position_error / 5:.6g} m" in none.explain()
