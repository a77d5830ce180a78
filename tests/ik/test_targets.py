"""Targets: their errors against SciPy, their rows against finite differences, their refusals."""

import pickle

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ik_targets import KINDS, errors, target_from
from strategies import HARD_ANGLES, derivative, generators
from twistarm.ik import Approach, Pose, Position, TolerancedPose, rotation_errors
from twistarm.ik.targets import as_target
from twistarm.ik.task_space import excess_rows
from twistarm.support.errors import InputError

# SciPy's logarithm and arcsin near 0 and π lose half the digits of an angle in the worst of these cases.
ERROR_TOL = 1e-9
ROW_TOL = 1e-7  # Finite differences of sixth order with a step of 1e-3.
ANGLE_TOL = 1e-14  # A few roundings; the angle itself is at most π.


def random_pose(rng):
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix(), rng.normal(size=3)
    return g


def body_motion(g, xi, t):
    """g e^{ξ̂t} by Pinocchio."""
    return g @ pin.exp6(t * xi).homogeneous


# errors -----------------------------------------------------------------------------------------------


@given(generators, st.sampled_from(KINDS))
def test_errors_are_those_of_the_definitions(rng, kind):
    target, g = target_from(kind, random_pose(rng), rng), random_pose(rng)
    np.testing.assert_allclose(
        (target.position_error(g), target.orientation_error(g)), errors(target, g), atol=ERROR_TOL
    )


@given(generators, st.sampled_from(KINDS))
def test_a_target_of_the_same_kind_can_be_put_anywhere(rng, kind):
    target, g = target_from(kind, random_pose(rng), rng), random_pose(rng)
    there = target.at(g)
    assert type(there) is type(target)
    assert max(there.position_error(g), there.orientation_error(g)) == pytest.approx(0, abs=ANGLE_TOL)
    assert there._rotation_rows(g, np.eye(6))[1].shape == target._rotation_rows(g, np.eye(6))[1].shape


def test_the_frame_of_a_task_turns_its_tolerances():
    g = np.eye(4)
    g[:3, :3] = Rotation.from_rotvec([0, 0, np.pi / 2]).as_matrix()
    beside = np.eye(4)
    beside[:3, :3], beside[0, 3] = g[:3, :3], 0.5
    # The base's x axis is the target's −y axis.
    assert TolerancedPose(g, [0, np.inf, 0, 0, 0, 0], frame="target").position_error(beside) == pytest.approx(0)
    assert TolerancedPose(g, [np.inf, 0, 0, 0, 0, 0], frame="base").position_error(beside) == pytest.approx(0)
    assert TolerancedPose(g, [np.inf, 0, 0, 0, 0, 0], frame="target").position_error(beside) == pytest.approx(0.5)


# rows -------------------------------------------------------------------------------------------------


@given(generators, st.sampled_from(KINDS))
def test_position_rows_are_the_gradient_of_half_the_squared_distance(rng, kind):
    target, g, xi = target_from(kind, random_pose(rng), rng), random_pose(rng), rng.normal(size=6)

    def half_square(t):
        return 0.5 * target.position_error(body_motion(g, xi, t)) ** 2

    error, rows = excess_rows(target._position_rows(g, np.eye(6)), target._position_tolerance)
    assert len(rows) == 3
    assert 0.5 * error @ error == pytest.approx(half_square(0.0), abs=ROW_TOL)
    assert error @ rows @ xi == pytest.approx(derivative(half_square), abs=ROW_TOL)


@given(generators, st.sampled_from(("Pose", "Approach")))
def test_chordal_rows_are_the_gradient_of_what_grows_with_the_angle(rng, kind):
    target, g, xi = target_from(kind, random_pose(rng), rng), random_pose(rng), rng.normal(size=6)

    def potential(t):
        return 4 * (1 - np.cos(0.5 * target.orientation_error(body_motion(g, xi, t))))

    error, rows = target._rotation_rows(g, np.eye(6))
    assert np.linalg.norm(error) == pytest.approx(2 * np.sin(0.5 * target.orientation_error(g)), abs=ERROR_TOL)
    if target.orientation_error(g) < 3.0:  # the potential has its kink at a half turn
        assert error @ rows @ xi == pytest.approx(derivative(potential), abs=ROW_TOL)


@given(generators)
def test_task_rows_are_the_derivative_of_the_logarithm(rng):
    target, xi = target_from("TolerancedPose", random_pose(rng), rng), rng.normal(size=6)
    g = body_motion(target.g, rng.normal(size=6), 0.7)
    error, rows = target._rotation_rows(g, np.eye(6))

    def logarithm(t):
        return target._rotation_rows(body_motion(g, xi, t), np.eye(6))[0]

    assert error.shape == (2,), "what is free has no row"
    np.testing.assert_allclose(rows @ xi, derivative(logarithm), atol=ROW_TOL)


def test_inside_its_tolerance_a_component_does_not_pull():
    error, rows = excess_rows((np.array([0.5, -0.05, 0.2]), np.ones((3, 2))), np.array([0.1, 0.1, 0.0]))
    np.testing.assert_allclose(error, [0.4, 0.0, 0.2])
    np.testing.assert_array_equal(rows, [[1, 1], [0, 0], [1, 1]])


def test_an_opposite_approach_still_has_a_way_back():
    target = Approach([0, 0, 0], [0, 0, -1], [0, 0, 1])
    error, _ = target._rotation_rows(np.eye(4), np.eye(6))
    assert np.linalg.norm(error) == pytest.approx(2)
    assert target.orientation_error(np.eye(4)) == pytest.approx(np.pi)


# rotations --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phi", HARD_ANGLES)
def test_angle_chord_and_logarithm_of_hard_angles(phi):
    u = np.array([0.36, -0.48, 0.8])
    u_hat = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    R = np.eye(3) + np.sin(phi) * u_hat + 2 * np.sin(phi / 2) ** 2 * u_hat @ u_hat
    assert rotation_errors.angle(R) == pytest.approx(phi, abs=ANGLE_TOL)
    assert np.linalg.norm(rotation_errors.chord(R)) == pytest.approx(2 * np.sin(phi / 2), abs=ANGLE_TOL)
    # Whether a half turn is about u or −u is rounding.
    log = rotation_errors.log(R)
    np.testing.assert_allclose(log * (np.sign(log @ u) if phi > 3 else 1), phi * u, atol=ANGLE_TOL)


@pytest.mark.parametrize("size", [1e-12, 1e-5, 0.99e-4, 1.01e-4, 1e-3, 0.5, 3.0])
def test_the_rate_of_the_logarithm_is_its_derivative(size):
    phi, w = size * np.array([0.6, 0.0, -0.8]), np.array([0.3, -1.1, 0.4])
    R = Rotation.from_rotvec(phi).as_matrix()

    def logarithm(t):
        return rotation_errors.log(R @ Rotation.from_rotvec(t * w).as_matrix())

    np.testing.assert_allclose(rotation_errors.log_rate(phi) @ w, derivative(logarithm, h=3e-3), atol=ROW_TOL)


# what is refused --------------------------------------------------------------------------------------

REFLECTION = np.diag([1.0, 1.0, -1.0, 1.0])
REFUSED = (
    (lambda: Pose(np.eye(3)), "pose g must have shape (..., 4, 4)"),
    (lambda: Pose(np.zeros((2, 4, 4)) + np.eye(4)), "one pose (4, 4)"),
    (lambda: Pose(REFLECTION), "determinant"),
    (lambda: Position([0.0, np.nan, 0.0]), "p must be finite"),
    (lambda: Position(np.zeros((2, 3))), "p must be one vector (3,)"),
    (lambda: Position([0.0, 2e6, 0.0]), "beyond 1e+06 m"),
    (lambda: Approach([0, 0, 0], [0, 0, 0]), "direction"),
    (lambda: Approach([0, 0, 0], [0, 0, 1], tool_axis=[0, 0, 0]), "tool_axis"),
    (lambda: TolerancedPose(np.eye(4), np.zeros(5)), "six numbers"),
    (lambda: TolerancedPose(np.eye(4), [0, 0, 0, 0, 0, -0.1]), "negative"),
    (lambda: TolerancedPose(np.eye(4), [0, 0, 0, 0, 0, np.nan]), "NaN"),
    (lambda: TolerancedPose(np.eye(4), [0, 0, 0, 5, 5, 5]), "286°"),
    (lambda: TolerancedPose(np.eye(4), [np.inf] * 3 + [4.0] * 3), "free"),
    (lambda: TolerancedPose(np.eye(4), np.zeros(6), frame="world"), "frame"),
    (lambda: as_target("forward"), "target must be a Pose"),
    (lambda: as_target([0.5, 0, 0.3]), "Position("),
    (lambda: as_target(np.zeros(6)), "Pose.from_rpy("),
    (lambda: as_target(np.zeros(7)), "Pose.from_quaternion("),
    (lambda: Pose.from_rpy([0.5, 0, 0.3], [0, 90, 0]), "degrees"),
    (lambda: Pose.from_quaternion([0.5, 0, 0.3], xyzw=[0, 0, 0, 2]), "length"),
    (lambda: Pose.from_quaternion([0.5, 0, 0.3], wxyz=[1, 0, 0, 0], xyzw=[0, 0, 0, 1]), "one quaternion"),
)


@pytest.mark.parametrize(("build", "text"), REFUSED)
def test_what_is_no_target_is_refused(build, text):
    with pytest.raises(InputError) as caught:
        build()
    assert text in str(caught.value)


@given(generators)
def test_a_pose_by_angles_or_by_a_quaternion_is_that_of_scipy(rng):
    p, R = rng.normal(size=3), Rotation.random(random_state=int(rng.integers(2**31)))
    xyzw = R.as_quat()
    for pose in (
        Pose.from_rpy(p, R.as_euler("xyz")),
        Pose.from_quaternion(p, xyzw=xyzw),
        Pose.from_quaternion(p, wxyz=np.roll(xyzw, 1)),
    ):
        np.testing.assert_allclose(pose.g[:3, :3], R.as_matrix(), atol=1e-12)
        np.testing.assert_array_equal(pose.g[:3, 3], p)


@pytest.mark.parametrize("kind", KINDS)
def test_targets_are_read_only_and_picklable(kind):
    rng = np.random.default_rng(1)
    target, g = target_from(kind, random_pose(rng), rng), random_pose(rng)
    with pytest.raises(ValueError, match="read-only"):
        (target.p if hasattr(target, "p") else target.g)[0] = 1.0
    assert pickle.loads(pickle.dumps(target)).position_error(g) == target.position_error(g)
    assert target.describe()
