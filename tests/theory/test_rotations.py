"""SO(3) and its parametrisations, against SciPy, Pinocchio, exact arithmetic and finite differences."""

from __future__ import annotations

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
    derivative,
    directions,
    exact_exp,
    scales,
    vectors,
)
from strategies import rotations as any_rotation
from twistarm import rotations
from twistarm.support.errors import InputError

ROUNDING = 4 * EPS
"""A matrix entry or an angle after a handful of operations on numbers of order 1."""

SCIPY = 1e-14
"""Both sides round, and SciPy's conversions take more steps than ours."""

PI_ROUNDING = 8 * EPS
"""Rotation vectors near π: a few units in the last place of π."""

DERIVATIVE = 1e-10
"""Sixth-order differences with h = 1e-3 on functions of order 1."""

AXES = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 1], [-1, 2, 0.5], [0, -3, 1], [1e-3, -1, 2], [0, 1, -1e-9]]])
AXES = AXES / np.linalg.norm(AXES, axis=1, keepdims=True)


def close(a, b, tol):
    np.testing.assert_allclose(a, b, rtol=0, atol=tol)


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


@pytest.mark.parametrize("angle", [1e-190, 1e-160, 1e-16, 1e-12, 1e-9])
def test_small_rotations_keep_every_digit(angle):
    w = angle * np.array([0.6, -0.48, 0.64])
    R = rotations.exp(w)
    # So near 0 the skew-symmetric part of R is ŵ to more than sixteen digits.
    np.testing.assert_allclose([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]], 2 * w, rtol=ROUNDING)
    np.testing.assert_allclose(rotations.log(R), w, rtol=ROUNDING)


@pytest.mark.parametrize("angle", [1e-7, 1e-9, 1e-12])
def test_small_rotations_keep_their_second_order(angle):
    # 1 − cos φ, computed as it is written, would be 0 from 1e-8 down.
    R = rotations.exp(angle * np.array([0.6, 0.8, 0.0]))
    np.testing.assert_allclose(R[0, 1], 0.48 * angle**2 / 2, rtol=angle**2 + ROUNDING)


def test_below_the_shortest_length_there_is_no_rotation():
    assert (rotations.exp([0.9 * rotations.TINY, 0, 0]) == np.eye(3)).all()
    assert rotations.exp([1.1 * rotations.TINY, 0, 0])[2, 1] == 1.1 * rotations.TINY


@given(st.data())
def test_exp_agrees_with_scipy(data):
    batch = data.draw(batches)
    w = data.draw(vectors(batch, scale=data.draw(st.sampled_from([1e-8, 1e-3, 1.0, 10.0]))))
    close(rotations.exp(w), from_vector(w), SCIPY)


@given(st.data())
def test_w_need_not_be_a_unit_vector(data):
    batch = data.draw(batches)
    u, angle, scale = data.draw(directions(batch)), data.draw(angles(batch)), data.draw(scales)
    close(rotations.exp(u * scale, angle / scale), from_vector(u * np.asarray(angle)[..., None]), SCIPY)


def test_theta_broadcasts_against_the_batch():
    axes, turns = AXES[:4], np.linspace(-4, 4, 5)
    R = rotations.exp(axes[:, None], turns)
    assert R.shape == (4, 5, 3, 3)
    for i in range(4):
        for j in range(5):
            close(R[i, j], Rotation.from_rotvec(axes[i] * turns[j]).as_matrix(), SCIPY)


def test_the_zero_vector_is_the_identity():
    assert (rotations.exp([0, 0, 0], 5.0) == np.eye(3)).all()
    assert (rotations.log(np.eye(3)) == 0).all()


def test_vectors_of_extreme_length_neither_overflow_nor_vanish():
    close(rotations.exp([1e200, 0, 0], 1e-200), Rotation.from_rotvec([1, 0, 0]).as_matrix(), SCIPY)
    close(rotations.exp([0, 1e-190, 0], 1e190), Rotation.from_rotvec([0, 1, 0]).as_matrix(), SCIPY)


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


@given(any_rotation())
def test_log_agrees_with_pinocchio_away_from_pi(R):
    w = rotations.log(R)
    if np.linalg.norm(w) < 3:
        close(w, pin.log3(R), 1e-13)


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


def test_both_sides_of_the_half_turn_tolerance():
    q = np.array([0.0, -0.6, 0.48, 0.64])
    for scalar, sign in ((0.5, -1.0), (2.0, 1.0), (-0.5, -1.0), (-2.0, -1.0)):
        Q = np.array([scalar * rotations.HALF_TURN_TOL, *q[1:]])
        close(rotations._canonical(Q)[1:], sign * q[1:], 0)


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


def test_no_rotation_is_about_z():
    axis, angle = rotations.to_axis_angle(np.eye(3))
    assert axis.tolist() == [0, 0, 1]
    assert angle == 0


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_angle_between_is_accurate_near_0_and_pi(angle):
    R, turn = Rotation.random(random_state=3).as_matrix(), from_vector(angle * AXES)
    close(rotations.angle_between(R, R @ turn), angle, PI_ROUNDING)
    close(rotations.angle_between(np.eye(3), turn), angle, PI_ROUNDING)


def test_angle_between_broadcasts():
    R = Rotation.random(5, random_state=4)
    expected = [R[0].inv().__mul__(other).magnitude() for other in R]
    close(rotations.angle_between(R[0].as_matrix(), R.as_matrix()), expected, SCIPY)


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


@pytest.mark.parametrize(
    "Q", [[1, 1, 1, 1], [1, 1, 0, 0], [0, 1, 1, 0], [0, 1, 1, 1], [1, -1, 1, -1], [1, 1, 1, 1 + 1e-9]]
)
def test_quaternions_where_the_largest_component_changes(Q):
    Q = np.array(Q) / np.linalg.norm(Q)
    close(rotations.to_quaternion_wxyz(rotations.from_quaternion_wxyz(Q)), Q, ROUNDING)


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
    one = np.broadcast_to([1.0, 0, 0, 0], Q.shape)
    close(rotations.quaternion_product_wxyz(Q, inverse), one, SCIPY)
    close(rotations.quaternion_product_wxyz(inverse, Q), one, SCIPY)


# Euler angles -----------------------------------------------------------------------------------------


def test_there_are_24_orders():
    assert len(set(rotations.EULER_ORDERS)) == 24


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_every_order_agrees_with_scipy(order):
    rng = np.random.default_rng(5)
    given_angles = rng.uniform(-4, 4, size=(200, 3))
    expected = Rotation.from_euler(order, given_angles)
    close(rotations.from_euler(order, given_angles), expected.as_matrix(), SCIPY)
    found = rotations.to_euler(order, expected.as_matrix())
    close(rotations.from_euler(order, found), expected.as_matrix(), SCIPY)
    # Near lock the outer angles are ill-conditioned; 200 random rotations stay 1e-3 away from it.
    close(found, expected.as_euler(order), 1e-11)


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
@pytest.mark.parametrize("off", [0.0, 1e-16, 3e-15, 0.9e-14, 1.1e-14, 1e-13, 1e-9, 1e-6])
def test_euler_angles_at_and_near_gimbal_lock(order, off):
    low, high = (0.0, np.pi) if order[0] == order[2] else (-np.pi / 2, np.pi / 2)
    for middle in (low + off, high - off):
        R = rotations.from_euler(order, [0.4, middle, -1.1])
        found = rotations.to_euler(order, R)
        close(rotations.from_euler(order, found), R, 3 * rotations.GIMBAL_LOCK_TOL)
        close(found[1], middle, ROUNDING * 2)
        if off <= 1e-16:
            assert found[2] == 0
        if off >= 1e-6:
            # The outer angles move by the rounding of R over the distance from lock.
            close(found, [0.4, middle, -1.1], 1e-9)


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_euler_angles_stay_in_their_ranges(order):
    right_angles = np.pi / 2 * np.array(list(np.ndindex(4, 4, 4)))
    random = Rotation.random(200, random_state=6).as_matrix()
    R = np.concatenate([random, rotations.from_euler(order, right_angles)])
    found = rotations.to_euler(order, R)
    low, high = (0.0, np.pi) if order[0] == order[2] else (-np.pi / 2, np.pi / 2)
    assert (np.abs(found) <= np.pi).all()
    assert ((found[:, 1] >= low) & (found[:, 1] <= high)).all()
    close(rotations.from_euler(order, found), R, SCIPY)


@pytest.mark.parametrize("order", rotations.EULER_ORDERS)
def test_euler_rate_map_is_the_angular_velocity(order):
    rng = np.random.default_rng(7)
    at, rate = rng.uniform(-2, 2, size=(2, 3))
    R_dot = derivative(lambda t: Rotation.from_euler(order, at + rate * t).as_matrix())
    W = R_dot @ Rotation.from_euler(order, at).as_matrix().T
    close(rotations.euler_rate_map(order, at) @ rate, [W[2, 1], W[0, 2], W[1, 0]], DERIVATIVE)


@pytest.mark.parametrize("batch", BATCHES)
def test_euler_rate_map_takes_batches(batch):
    at = np.random.default_rng(8).uniform(-2, 2, size=(*batch, 3))
    B = rotations.euler_rate_map("zyx", at)
    assert B.shape == (*batch, 3, 3)
    for index in np.ndindex(batch):
        close(B[index], rotations.euler_rate_map("zyx", at[index]), ROUNDING)


@pytest.mark.parametrize("beta", [1e-1, 1e-3, 1e-6])
def test_the_rate_map_loses_its_condition_towards_gimbal_lock(beta):
    B = rotations.euler_rate_map("ZYZ", [0.3, beta, 1.0])
    # The first and third axis enclose beta and the second is across both: singular values √(1 ± cos β) and 1.
    expected = np.sqrt((1 + np.cos(beta)) / (2 * np.sin(beta / 2) ** 2))
    np.testing.assert_allclose(np.linalg.cond(B), expected, rtol=1e-6)


@given(st.data())
def test_rpy_is_that_of_urdf(data):
    rpy = data.draw(vectors(data.draw(batches)))
    R = rotations.from_rpy(rpy)
    for index in np.ndindex(rpy.shape[:-1]):
        close(R[index], pin.rpy.rpyToMatrix(*rpy[index]), SCIPY)
    close(rotations.from_rpy(rotations.to_rpy(R)), R, SCIPY)


def test_rpy_at_gimbal_lock_has_no_yaw():
    close(rotations.to_rpy(rotations.from_rpy([0.3, np.pi / 2, 0.2])), [0.1, np.pi / 2, 0.0], SCIPY)
    close(rotations.to_rpy(rotations.from_rpy([0.3, -np.pi / 2, 0.2])), [0.5, -np.pi / 2, 0.0], SCIPY)


# batches and refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_its_elements_one_by_one(batch):
    R = Rotation.random(24, random_state=9).as_matrix()[: int(np.prod(batch))].reshape(*batch, 3, 3)
    for function in (
        rotations.log,
        rotations.to_quaternion_wxyz,
        rotations.to_rpy,
        lambda R: rotations.to_euler("ZXZ", R),
    ):
        whole = function(R)
        assert whole.shape[:-1] == batch
        for index in np.ndindex(batch):
            close(whole[index], function(R[index]), ROUNDING)


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: rotations.exp([1, 2]), r"w must have shape \(\.\.\., 3\); got \(2,\)"),
        (lambda: rotations.exp([1, 2, 3], "x"), "theta must be an array of real numbers"),
        (
            lambda: rotations.exp(np.ones((2, 3)), np.ones(5)),
            r"leading axes do not match: w \(2,\) and theta \(5,\); they",
        ),
        (lambda: rotations.log(np.ones((3, 3))), r"rotation is not in SO\(3\)"),
        (lambda: rotations.angle_between(np.eye(3), np.eye(4)), r"R2 must have shape \(\.\.\., 3, 3\)"),
        (lambda: rotations.from_axis_angle([0, 0, 0], 1.0), "axis must not be the zero vector"),
        (lambda: rotations.from_axis_angle(np.eye(3), np.ones(2)), r"axis \(3,\) and angle \(2,\)"),
        (lambda: rotations.from_xyzw([0, 0, 0, 0]), "quaternion must not be zero: it is no rotation"),
        (lambda: rotations.from_quaternion_wxyz([1, 0, 0]), r"quaternion must have shape \(\.\.\., 4\)"),
        (lambda: rotations.quaternion_inverse_wxyz([0, 0, 0, 0]), "quaternion must not be zero"),
        (lambda: rotations.from_euler("ZZY", [1, 2, 3]), "no Euler order 'ZZY': give three letters of XYZ"),
        (lambda: rotations.to_euler("xYz", np.eye(3)), "no Euler order 'xYz'"),
        (lambda: rotations.from_euler("ZYZ", [1, 2]), r"angles must have shape \(\.\.\., 3\)"),
        (lambda: rotations.from_rpy([1, np.nan, 2]), r"rpy must be finite; it holds nan at index \[1\]"),
    ],
)
def test_bad_input_is_refused(call, text):
    with pytest.raises(InputError, match=text):
        call()


# the nearest rotation ---------------------------------------------------------------------------------

MATRICES = np.random.default_rng(5).normal(size=(300, 3, 3)) * 10.0 ** np.linspace(-200, 200, 300)[:, None, None]
"""Half of them mirror; none is near a rotation."""


def test_the_nearest_rotation_is_the_one_that_aligns_the_axes():
    """SciPy's least squares Σ |A eᵢ − R eᵢ|² is ‖A − R‖²."""
    for A in MATRICES[100:200]:
        expected, _ = Rotation.align_vectors(A.T / np.abs(A).max(), np.eye(3))
        close(rotations.nearest(A), expected.as_matrix(), SCIPY)


def test_no_turn_brings_the_nearest_rotation_nearer():
    R, A = rotations.nearest(MATRICES), MATRICES / np.abs(MATRICES).max(axis=(1, 2), keepdims=True)
    close(np.swapaxes(R, 1, 2) @ R, np.broadcast_to(np.eye(3), R.shape), SCIPY)
    assert (np.linalg.det(R) > 0).all()
    least = np.linalg.norm(A - R, axis=(1, 2))
    for angle in (1e-3, 0.5, np.pi):
        for axis in np.vstack([np.eye(3), -np.eye(3)]):
            turned = R @ rotations.exp(axis, angle)
            assert (np.linalg.norm(A - turned, axis=(1, 2)) >= least - 1e-12).all()


@given(any_rotation(), st.floats(1e-100, 1e100))
def test_a_rotation_is_its_own_nearest_whatever_it_is_multiplied_by(R, factor):
    close(rotations.nearest(factor * R), R, SCIPY)


@pytest.mark.parametrize("A", [np.zeros((3, 3)), np.diag([1.0, 0, 0]), np.diag([1.0, 1, -1]), -np.eye(3)])
def test_where_many_rotations_are_equally_near_none_is_taken(A):
    with pytest.raises(InputError, match="A has no one nearest rotation"):
        rotations.nearest(A)


def test_a_flat_matrix_has_one_and_a_mirror_that_is_uneven_too():
    close(rotations.nearest(np.diag([2.0, 1.0, 0.0])), np.eye(3), SCIPY)
    close(rotations.nearest(np.diag([1.0, 1.0, -0.5])), np.eye(3), SCIPY)
