"""SO(3) and its parametrisations, against SciPy, Pinocchio, exact arithmetic and finite differences."""

from functools import partial

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from strategies import (
    BATCHES,
    EPS,
    HARD_ANGLES,
    SCALES,
    angles,
    batches,
    close,
    derivative,
    directions,
    exact_exp,
    scales,
    vectors,
)
from strategies import rotations as any_rotation
from twistarm import rotations
from twistarm.support.errors import InputError

ROUNDING = 4 * EPS  # A matrix entry or an angle after a handful of operations on numbers of order 1.
SCIPY = 1e-14  # Both sides round, and SciPy's conversions take more steps than ours.
PI_ROUNDING = 8 * EPS  # Rotation vectors near π: a few units in the last place of π.
DERIVATIVE = 1e-10  # Sixth-order differences with h = 1e-3 on functions of order 1.

AXES = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 1], [-1, 2, 0.5], [0, -3, 1], [1e-3, -1, 2], [0, 1, -1e-9]]])
AXES = AXES / np.linalg.norm(AXES, axis=1, keepdims=True)


def from_vector(w):
    """SciPy's rotation for (..., 3), which takes no batch of more than one axis."""
    return Rotation.from_rotvec(w.reshape(-1, 3)).as_matrix().reshape(*w.shape, 3)


# exponential ------------------------------------------------------------------------------------------


@given(st.data())
def test_skew_is_the_cross_product(data):
    batch = data.draw(batches)
    w, q = data.draw(vectors(batch)), data.draw(vectors(batch))
    close((rotations.skew(w) @ q[..., None])[..., 0], np.cross(w, q), ROUNDING * 10)
    close(rotations.cross(w, q), np.cross(w, q), 0)


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_exp_is_the_exponential_series(angle):
    for w in angle * AXES:
        close(rotations.exp(w), exact_exp(rotations.skew(w)), ROUNDING)


@pytest.mark.parametrize("angle", [1e-190, 1e-16, 1e-12, 1e-9])
def test_small_rotations_keep_every_digit(angle):
    w = angle * np.array([0.6, -0.48, 0.64])
    R = rotations.exp(w)
    np.testing.assert_allclose([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]], 2 * w, rtol=ROUNDING)
    np.testing.assert_allclose(rotations.log(R), w, rtol=ROUNDING)
    # 1 − cos φ, computed as it is written, would be 0.
    second_order = rotations.exp(angle * np.array([0.6, 0.8, 0.0]))[0, 1]
    np.testing.assert_allclose(second_order, 0.48 * angle**2 / 2, rtol=angle**2 + ROUNDING)


def test_the_shortest_vectors_and_the_longest():
    assert (rotations.exp([0.9 * rotations.TINY, 0, 0], 5.0) == np.eye(3)).all()
    assert rotations.exp([1.1 * rotations.TINY, 0, 0])[2, 1] == 1.1 * rotations.TINY
    close(rotations.exp([1e200, 0, 0], 1e-200), Rotation.from_rotvec([1, 0, 0]).as_matrix(), SCIPY)
    close(rotations.exp([0, 1e-190, 0], 1e190), Rotation.from_rotvec([0, 1, 0]).as_matrix(), SCIPY)


@given(st.data())
def test_w_need_not_be_a_unit_vector(data):
    batch = data.draw(batches)
    u, angle, scale = data.draw(directions(batch)), data.draw(angles(batch)), data.draw(scales)
    close(rotations.exp(u * scale, angle / scale), from_vector(u * np.asarray(angle)[..., None]), SCIPY)


def test_theta_broadcasts_against_the_batch():
    axes, turns = AXES[:4], np.linspace(-4, 4, 5)
    close(rotations.exp(axes[:, None], turns), from_vector(axes[:, None] * turns[:, None]), SCIPY)


# logarithm --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [angle for angle in HARD_ANGLES if angle < np.pi - 2e-15])
def test_log_undoes_exp(angle):
    close(rotations.log(rotations.exp(angle * AXES)), angle * AXES, PI_ROUNDING)


@given(st.data())
def test_exp_undoes_log(data):
    R = data.draw(any_rotation(data.draw(batches)))
    w = rotations.log(R)
    assert (np.linalg.norm(w, axis=-1) <= np.pi * (1 + EPS)).all()
    close(rotations.exp(w), R, PI_ROUNDING)


@pytest.mark.parametrize("axis", AXES)
def test_at_a_half_turn_the_first_nonzero_component_is_positive(axis):
    first = axis[np.flatnonzero(axis)[0]]
    expected = np.pi * axis * np.sign(first)
    for R in (rotations.exp(np.pi * axis), 2 * np.outer(axis, axis) - np.eye(3)):
        close(rotations.log(R), expected, PI_ROUNDING)
        close(rotations.to_axis_angle(R)[0], expected / np.pi, ROUNDING)
        assert rotations.to_quaternion_wxyz(R)[0] == 0


@pytest.mark.parametrize("short", [4e-15, 1e-14, 1e-12])
def test_just_short_of_a_half_turn_the_sign_is_that_of_the_turn(short):
    for w in ((np.pi - short) * AXES, (short - np.pi) * AXES):
        close(rotations.log(from_vector(w)), w, PI_ROUNDING)


# axis and angle ---------------------------------------------------------------------------------------


@given(st.data())
def test_axis_and_angle(data):
    batch, scale = data.draw(batches), data.draw(scales)
    axis, angle = data.draw(directions(batch)), np.asarray(data.draw(angles(batch)))
    R = rotations.from_axis_angle(scale * axis, angle)
    close(R, from_vector(axis * angle[..., None]), SCIPY)
    found_axis, found_angle = rotations.to_axis_angle(R)
    close(found_angle, angle, PI_ROUNDING)
    assert found_axis.shape == axis.shape
    turned = (angle > 1e-100) & (angle < np.pi - 1e-14)
    close(found_axis[turned], axis[turned], ROUNDING)
    assert (found_axis[angle == 0] == [0, 0, 1]).all()


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_angle_between_is_accurate_near_0_and_pi(angle):
    R, turn = Rotation.random(random_state=3).as_matrix(), from_vector(angle * AXES)
    close(rotations.angle_between(R, R @ turn), angle, PI_ROUNDING)
    close(rotations.angle_between(np.eye(3), turn), angle, PI_ROUNDING)


# quaternions ------------------------------------------------------------------------------------------


@given(st.data())
def test_quaternions_agree_with_scipy(data):
    batch, scale = data.draw(batches), data.draw(st.sampled_from([*SCALES, 1e-150, 1e200]))
    Q = data.draw(vectors(batch, 4))
    Q = np.where(np.linalg.norm(Q, axis=-1, keepdims=True) > 0.1, Q, 1.0)
    expected = Rotation.from_quat(Q.reshape(-1, 4)).as_matrix().reshape(*batch, 3, 3)
    close(rotations.from_xyzw(Q * scale), expected, SCIPY)
    close(rotations.from_quaternion_wxyz(np.roll(Q, 1, axis=-1) * -scale), expected, SCIPY)


@given(st.data())
def test_quaternion_of_a_rotation(data):
    R = data.draw(any_rotation(data.draw(batches)))
    Q = rotations.to_quaternion_wxyz(R)
    assert (Q[..., 0] >= 0).all()
    close(np.linalg.norm(Q, axis=-1), 1.0, ROUNDING)
    close(rotations.from_quaternion_wxyz(Q), R, ROUNDING)
    close(rotations.to_xyzw(R), np.roll(Q, -1, axis=-1), 0)


@given(st.data())
def test_quaternion_products_are_products_of_rotations(data):
    batch = data.draw(batches)
    R1, R2 = data.draw(any_rotation(batch)), data.draw(any_rotation(batch))
    P, Q = rotations.to_quaternion_wxyz(R1), rotations.to_quaternion_wxyz(R2)
    close(rotations.from_quaternion_wxyz(rotations.quaternion_product_wxyz(P, Q)), R1 @ R2, SCIPY)


@given(st.data())
def test_quaternion_inverse_of_any_length(data):
    batch, scale = data.draw(batches), data.draw(st.sampled_from([*SCALES, 1e-150, 1e150]))
    Q = scale * (data.draw(vectors(batch, 4)) + np.array([5.0, 0, 0, 0]))
    inverse = rotations.quaternion_inverse_wxyz(Q)
    identity = np.broadcast_to([1.0, 0, 0, 0], Q.shape)
    close(rotations.quaternion_product_wxyz(Q, inverse), identity, SCIPY)
    close(rotations.quaternion_product_wxyz(inverse, Q), identity, SCIPY)


# Euler angles -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_every_order_agrees_with_scipy(order):
    rng = np.random.default_rng(5)
    given_angles = rng.uniform(-4, 4, size=(200, 3))
    expected = Rotation.from_euler(order, given_angles)
    close(rotations.from_euler(order, given_angles), expected.as_matrix(), SCIPY)
    # Near lock the outer angles are ill-conditioned; 200 random rotations stay 1e-3 away from it.
    close(rotations.to_euler(order, expected.as_matrix()), expected.as_euler(order), 1e-11)
    right_angles = rotations.from_euler(order, np.pi / 2 * np.array(list(np.ndindex(4, 4, 4))))
    found = rotations.to_euler(order, right_angles)
    low, high = (0.0, np.pi) if order[0] == order[2] else (-np.pi / 2, np.pi / 2)
    assert (np.abs(found) <= np.pi).all()
    assert ((found[:, 1] >= low) & (found[:, 1] <= high)).all()
    close(rotations.from_euler(order, found), right_angles, SCIPY)
    assert len(set(rotations.EULER_ORDERS)) == 24


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_euler_angles_at_and_near_gimbal_lock(order):
    low, high = (0.0, np.pi) if order[0] == order[2] else (-np.pi / 2, np.pi / 2)
    for off in (0.0, 1e-16, 0.9e-14, 1.1e-14, 1e-9, 1e-6):
        for middle in (low + off, high - off):
            R = rotations.from_euler(order, [0.4, middle, -1.1])
            found = rotations.to_euler(order, R)
            close(rotations.from_euler(order, found), R, 3 * rotations.GIMBAL_LOCK_TOL)
            close(found[1], middle, ROUNDING * 2)
            assert found[2] == 0 or off > 1e-16
            if off >= 1e-6:
                # The outer angles move by the rounding of R over the distance from lock.
                close(found, [0.4, middle, -1.1], 1e-9)


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_euler_rate_map_is_the_angular_velocity(order):
    rng = np.random.default_rng(7)
    at, rate = rng.uniform(-2, 2, size=(2, 3))
    R_dot = derivative(lambda t: Rotation.from_euler(order, at + rate * t).as_matrix())
    W = R_dot @ Rotation.from_euler(order, at).as_matrix().T
    close(rotations.euler_rate_map(order, at) @ rate, [W[2, 1], W[0, 2], W[1, 0]], DERIVATIVE)


@given(st.data())
def test_rpy_is_that_of_urdf(data):
    rpy = data.draw(vectors(data.draw(batches)))
    R = rotations.from_rpy(rpy)
    for index in np.ndindex(rpy.shape[:-1]):
        close(R[index], pin.rpy.rpyToMatrix(*rpy[index]), SCIPY)
    close(rotations.from_rpy(rotations.to_rpy(R)), R, SCIPY)


# batches -----------------------------------------------------------------------------------


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_its_elements_one_by_one(batch):
    R = Rotation.random(24, random_state=9).as_matrix()[: int(np.prod(batch))].reshape(*batch, 3, 3)
    euler, rates = partial(rotations.to_euler, "ZXZ"), lambda R: rotations.euler_rate_map("zyx", R[..., 0])
    functions = (rotations.log, rotations.to_quaternion_wxyz, euler, rates)
    for function in functions:
        whole = function(R)
        assert whole.shape[: len(batch)] == batch
        for index in np.ndindex(batch):
            close(whole[index], function(R[index]), ROUNDING)


# the nearest rotation ---------------------------------------------------------------------------------

# Half of them mirror; none is near a rotation.
MATRICES = np.random.default_rng(5).normal(size=(300, 3, 3)) * 10.0 ** np.linspace(-200, 200, 300)[:, None, None]


def test_the_nearest_rotation_is_the_one_that_aligns_the_axes():
    """SciPy's least squares Σ |A eᵢ − R eᵢ|² is ‖A − R‖²."""
    for A, R in zip(MATRICES, rotations.nearest(MATRICES), strict=True):
        expected, _ = Rotation.align_vectors(A.T / np.abs(A).max(), np.eye(3))
        close(R, expected.as_matrix(), SCIPY)


@given(any_rotation(), st.floats(1e-100, 1e100))
def test_a_rotation_is_its_own_nearest_whatever_it_is_multiplied_by(R, factor):
    close(rotations.nearest(factor * R), R, SCIPY)


@pytest.mark.parametrize("A", [np.zeros((3, 3)), np.diag([1.0, 0, 0]), np.diag([1.0, 1, -1]), -np.eye(3)])
def test_where_many_rotations_are_equally_near_none_is_chosen(A):
    with pytest.raises(InputError, match="no one nearest rotation"):
        rotations.nearest(A)
    for matrix in (np.diag([2.0, 1.0, 0.0]), np.diag([1.0, 1.0, -0.5])):  # flat, and a mirror that is uneven
        close(rotations.nearest(matrix), np.eye(3), SCIPY)
