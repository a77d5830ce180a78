"""SE(3) and its screws, against exact arithmetic, SciPy, Pinocchio, finite differences and the group's laws."""

import pickle

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from strategies import (
    BATCHES,
    EPS,
    HARD_ANGLES,
    angles,
    batches,
    close,
    directions,
    exact_exp,
    poses,
    scales,
    twists,
    vectors,
)
from twistarm import screws
from twistarm.support.errors import InputError

ROUNDING = 8 * EPS  # A pose after a handful of operations, relative to its translation (1 for its rotation).
# After products of several poses or Adjoints, relative to the larger of 1 and the translations' product.
PRODUCTS = 64 * EPS
LIBRARY = 1e-13  # SciPy's expm and Pinocchio's series take more steps than ours; relative.
DERIVATIVE = 1e-10  # Sixth-order differences with h = 1e-3, relative to the derivative.

AXES = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 1], [-1, 2, 0.5], [0, -3, 1], [1e-3, -1, 2]]])
AXES = AXES / np.linalg.norm(AXES, axis=1, keepdims=True)
V = np.array([0.7, -1.3, 0.4])  # A linear part of order 1, along none of the axes.


def size(*arrays):
    """The largest entry of all, at least 1."""
    return max(1.0, *(np.abs(array).max(initial=0.0) for array in arrays))


# hat, vee, bracket ------------------------------------------------------------------------------------


@given(st.data())
def test_vee_undoes_hat(data):
    batch, scale = data.draw(batches), data.draw(scales)
    for length in (3, 6):
        xi = data.draw(vectors(batch, length, scale))
        matrix = screws.hat(xi)
        assert matrix.shape == ((*batch, 3, 3) if length == 3 else (*batch, 4, 4))
        assert (screws.vee(matrix) == xi).all()
    xi, h = np.array([0.3, -0.2, 0.5, 1.0, -2.0, 0.7]), 1e-6
    one_sided = (screws.exp(xi, h) - np.eye(4)) / h  # not quite in se(3)
    close(screws.vee(one_sided), xi, 1e-5)
    with pytest.raises(InputError, match="so"):  # each matrix by its own size
        screws.vee([1e6 * screws.hat([1.0, 0.0, 0.0]), np.eye(3)])


@given(vectors(size=6))
def test_hat_gives_the_velocity_of_a_point(xi):
    p = np.array([0.3, -2.0, 1.0])
    close((screws.hat(xi) @ [*p, 1.0])[:3], xi[:3] + np.cross(xi[3:], p), ROUNDING * 10)
    close(screws.hat(xi[3:]), pin.skew(xi[3:]), 0)


@given(st.data())
def test_bracket_is_the_commutator(data):
    batch = data.draw(batches)
    a, b = (data.draw(vectors(batch, 6)) for _ in range(2))
    A, B = screws.hat(a), screws.hat(b)
    close(screws.bracket(a, b), screws.vee(A @ B - B @ A), PRODUCTS * size(a) * size(b))


def test_angular_first():
    V_lynch_park = np.array([1.0, 2, 3, 4, 5, 6])
    assert screws.from_angular_first(V_lynch_park).tolist() == [4, 5, 6, 1, 2, 3]
    assert screws.to_angular_first([4, 5, 6, 1, 2, 3]).tolist() == [1, 2, 3, 4, 5, 6]
    columns = np.arange(18.0).reshape(6, 3)
    assert (columns[[3, 4, 5, 0, 1, 2]] == screws.from_angular_first(columns.T).T).all()


# exponential ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", HARD_ANGLES)
def test_exp_is_the_exponential_series(angle):
    for axis in AXES:
        for v in (V, axis, np.cross(axis, V), 1e6 * V, 1e-9 * V, 0 * V):
            xi = np.concatenate([v, angle * axis])
            g, exact = screws.exp(xi), exact_exp(screws.hat(xi))
            close(g[:3, :3], exact[:3, :3], ROUNDING)
            close(g[:3, 3], exact[:3, 3], ROUNDING * np.linalg.norm(v))
            assert g[3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("angle", [1e-12, 1e-9, 1e-5, 1e-3])
def test_the_second_order_near_zero_is_there(angle):
    # Taking p = v near 0 would lose ½ w × v, which is five orders above the rounding even at 1e-9.
    xi = np.array([1.0, 0, 0, 0, 0, angle])
    assert screws.exp(xi)[1, 3] == pytest.approx(angle / 2, rel=angle**2 / 6 + ROUNDING)


@given(st.data())
def test_theta_scales_the_twist(data):
    batch, scale = data.draw(batches), data.draw(st.sampled_from([1e-12, 1e-3, 1.0, 1e6, 1e12]))
    xi = data.draw(twists(batch))
    close(screws.exp(xi / scale, scale), screws.exp(xi), PRODUCTS * size(xi))


def test_theta_broadcasts_against_the_batch():
    rng = np.random.default_rng(2)
    xi, theta = rng.normal(size=(4, 1, 6)), rng.normal(size=5)
    close(screws.exp(xi, theta), expm(screws.hat(xi * theta[:, None])), LIBRARY)
    assert screws.exp(xi[:, 0], 2.0).shape == (4, 4, 4)
    assert screws.exp(xi[0, 0], theta).shape == (5, 4, 4)


# logarithm --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [angle for angle in HARD_ANGLES if angle < np.pi - 2e-15])
def test_log_undoes_the_exact_exponential(angle):
    for axis in AXES:
        for v in (V, axis, np.cross(axis, V), 1e6 * V, 0 * V):
            xi = np.concatenate([v, angle * axis])
            found = screws.log(exact_exp(screws.hat(xi)))
            close(found[3:], xi[3:], ROUNDING)
            # At π a unit of rounding in the rotation moves v by π/2 times that, hence the 2.
            close(found[:3], xi[:3], 2 * ROUNDING * np.linalg.norm(v))


@given(st.data())
def test_exp_undoes_log(data):
    batch, scale = data.draw(batches), data.draw(scales)
    g = data.draw(poses(batch, scale))
    xi = screws.log(g)
    assert xi.shape == (*batch, 6)
    assert (np.linalg.norm(xi[..., 3:], axis=-1) <= np.pi * (1 + EPS)).all()
    again = screws.exp(xi)
    close(again[..., :3, :3], g[..., :3, :3], ROUNDING)
    close(again[..., :3, 3], g[..., :3, 3], 4 * ROUNDING * np.abs(g[..., :3, 3]).max(initial=0.0))


@pytest.mark.parametrize("batch", BATCHES)
def test_a_batch_is_its_elements_one_by_one(batch):
    xi = np.random.default_rng(3).normal(size=(*batch, 6))
    g = screws.exp(xi)
    for function, argument in ((screws.exp, xi), (screws.log, g), (screws.adjoint, g), (screws.inverse, g)):
        whole = function(argument)
        assert whole.shape[: len(batch)] == batch
        for index in np.ndindex(batch):
            close(whole[index], function(argument[index]), ROUNDING)


# the group and its Adjoint ----------------------------------------------------------------------------


@given(st.data())
def test_inverse(data):
    g = data.draw(poses(data.draw(batches), data.draw(scales)))
    close(g @ screws.inverse(g), np.broadcast_to(np.eye(4), g.shape), PRODUCTS * size(g))


@given(poses())
def test_the_adjoint_agrees_with_pinocchio(g):
    close(screws.adjoint(g), pin.SE3(g).action, ROUNDING * size(g))


@given(st.data())
def test_conjugation_is_the_exponential_of_the_adjoint(data):
    batch, scale = data.draw(batches), data.draw(st.sampled_from([1e-3, 1.0, 1e3]))
    g, xi = data.draw(poses(batch, scale)), data.draw(twists(batch))
    moved = screws.transform_twist(g, xi)
    close(screws.exp(moved), g @ screws.exp(xi) @ screws.inverse(g), PRODUCTS * size(g) * size(xi) * 4)
    close(moved, (screws.adjoint(g) @ xi[..., None])[..., 0], PRODUCTS * size(g) * size(xi))


@given(st.data())
def test_power_does_not_depend_on_the_frame(data):
    batch, scale = data.draw(batches), data.draw(scales)
    g, xi, F = data.draw(poses(batch, scale)), data.draw(vectors(batch, 6)), data.draw(vectors(batch, 6))
    power = np.sum(screws.transform_wrench(g, F) * screws.transform_twist(g, xi), axis=-1)
    close(power, np.sum(F * xi, axis=-1), PRODUCTS * size(g) * size(xi) * size(F))
    dual = np.swapaxes(screws.adjoint(screws.inverse(g)), -1, -2)
    close(screws.transform_wrench(g, F), (dual @ F[..., None])[..., 0], PRODUCTS * size(g) * size(F))


def test_one_pose_moves_many_twists_and_many_poses_one():
    rng = np.random.default_rng(4)
    g, xi = screws.exp(rng.normal(size=(5, 6))), rng.normal(size=(5, 6))
    for transform in (screws.transform_twist, screws.transform_wrench):
        every = transform(g[:, None], xi)
        assert every.shape == (5, 5, 6)
        close(transform(g[0], xi), every[0], ROUNDING * 10)
        close(transform(g, xi[0]), every[:, 0], ROUNDING * 10)


# screws -----------------------------------------------------------------------------------------------


@given(st.data())
def test_a_screw_leads_back_to_its_twist(data):
    batch, scale = data.draw(batches), data.draw(scales)
    xi = data.draw(twists(batch, scale))
    screw = screws.to_screw(xi)
    assert screw.axis.shape == screw.point.shape == (*batch, 3)
    assert screw.pitch.shape == screw.magnitude.shape == batch
    close(screw.twist, xi, PRODUCTS * max(scale, np.abs(xi).max(initial=0.0)))


@given(st.data())
def test_the_screw_of_a_line_and_a_pitch(data):
    batch = data.draw(batches)
    u, q, h = data.draw(directions(batch)), data.draw(vectors(batch)), data.draw(vectors(batch, 1))[..., 0]
    rate = 0.1 + np.asarray(data.draw(angles(batch)))
    v = np.cross(q, u) + h[..., None] * u
    screw = screws.to_screw(np.concatenate([v, u], axis=-1) * rate[..., None])
    close(screw.axis, u, PRODUCTS)
    close(screw.pitch, h, PRODUCTS * size(q, h))
    close(screw.magnitude, rate, PRODUCTS)
    close(np.cross(screw.point - q, u), 0.0, PRODUCTS * size(q))  # on the line
    close(np.sum(screw.point * u, axis=-1), 0.0, PRODUCTS * size(q))  # its nearest point to the origin


def test_screws_without_a_turn():
    screw = screws.to_screw([0, 3, 4, 0, 0, 0])
    assert screw.axis.tolist() == [0, 0.6, 0.8]
    assert screw.point.tolist() == [0, 0, 0]
    assert (screw.pitch, screw.magnitude) == (np.inf, 5)
    assert screw.twist.tolist() == [0, 3, 4, 0, 0, 0]
    nothing = screws.to_screw(np.zeros(6))
    assert nothing.axis.tolist() == [0, 0, 0]
    assert nothing.twist.tolist() == [0] * 6
    by_hand = screws.Screw(axis=[0, 0, 1], point=[1, 2, 3], pitch=np.inf, magnitude=2.0)
    assert by_hand.twist.tolist() == [0, 0, 2, 0, 0, 0]


@pytest.mark.parametrize(("rate", "pitch"), [(0.9e-15, np.inf), (1.1e-15, 1 / 1.1e-15)])
def test_both_sides_of_the_translation_tolerance(rate, pitch):
    xi = 2 * np.array([0.6, 0.8, 0, 0.6 * rate, 0.8 * rate, 0])
    screw = screws.to_screw(xi)
    np.testing.assert_allclose(screw.pitch, pitch, rtol=ROUNDING)
    close(screw.twist, xi, 2e-15)


def test_a_screw_is_read_only_and_picklable():
    screw = screws.to_screw([1, 2, 3, 0, 0, 1])
    with pytest.raises(ValueError, match="read-only"):
        screw.axis[0] = 1.0
    with pytest.raises(AttributeError):
        screw.pitch = 0.0
    assert (pickle.loads(pickle.dumps(screw)).twist == screw.twist).all()


# rows and columns -----------------------------------------------------------------------------------------


def test_six_twists_in_a_square_are_not_guessed_to_be_rows_or_columns():
    V, swapped = np.arange(36.0).reshape(6, 6), [3, 4, 5, 0, 1, 2]
    for convert in (screws.from_angular_first, screws.to_angular_first):
        with pytest.raises(InputError, match='twists="rows" or "columns"'):
            convert(V)
        assert np.array_equal(convert(V, twists="rows"), V[:, swapped])
        assert np.array_equal(convert(V, twists="columns"), V[swapped])
        assert np.array_equal(convert(V[:, :5], twists="columns"), V[swapped, :5])
        with pytest.raises(InputError, match="closest: 'columns'"):
            convert(V, twists="colums")
