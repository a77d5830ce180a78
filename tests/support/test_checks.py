"""What is refused at the door, by argument and value, and what is let in."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from strategies import BATCHES, EPS, batches, poses, rotations
from twistarm.support import checks
from twistarm.support.errors import InputError, RoundedPoseWarning

CLEAN = 8 * EPS
"""A cleaned rotation is orthonormal to a few roundings."""


def tilted(R, amount):
    """R with every entry off by up to `amount`."""
    return R + amount * np.sign(np.sin(1 + np.arange(9.0).reshape(3, 3)))


@pytest.mark.parametrize("value", [[1, 2, 3], (1.0, 2, 3), np.arange(3, dtype=np.float32), np.arange(3)])
def test_numbers_of_any_kind_become_float64(value):
    assert checks.as_floats(value, "x").dtype == np.float64


@pytest.mark.parametrize(
    ("value", "quoted"),
    [
        ("abc", "'abc'"),
        ([[1, 2], [3]], "[[1, 2], [3]]"),
        ([1 + 2j], "complex"),
        ("y" * 500, "..."),
        ([1.0, np.nan], "nan at index [1]"),
        ([[0.0, 1.0], [np.inf, 0.0]], "inf at index [1, 0]"),
    ],
)
def test_no_array_of_finite_numbers(value, quoted):
    with pytest.raises(InputError) as refusal:
        checks.as_floats(value, "x")
    assert str(refusal.value).startswith("x ")
    assert quoted in str(refusal.value)
    assert len(str(refusal.value)) < 200


@pytest.mark.parametrize(
    ("check", "shape"),
    [(checks.as_vector, ()), (checks.as_vector, (3, 4)), (checks.as_twist, (3,)), (checks.as_twist, (6, 7))],
)
def test_vectors_have_three_components_and_twists_six(check, shape):
    with pytest.raises(InputError, match="^x "):
        check(np.ones(shape), "x")


@pytest.mark.parametrize("batch", BATCHES)
def test_batches_pass(batch):
    assert checks.as_vector(np.ones((*batch, 3)), "p").shape == (*batch, 3)
    assert checks.as_twist(np.ones((*batch, 6))).shape == (*batch, 6)
    assert checks.as_theta(np.ones((*batch, 5)), 5).shape == (*batch, 5)
    assert checks.as_pose(np.broadcast_to(np.eye(4), (*batch, 4, 4))).shape == (*batch, 4, 4)


def test_theta_names_its_joints():
    with pytest.raises(InputError, match=r"theta.*shoulder, elbow.*\(3,\)"):
        checks.as_theta([1, 2, 3], 2, names=("shoulder", "elbow"))
    with pytest.raises(InputError, match="^theta "):
        checks.as_theta(1.0, 1)


def test_directions_are_made_unit_vectors():
    np.testing.assert_allclose(checks.as_direction([[0, 0, 2], [3, 4, 0]], "a"), [[0, 0, 1], [0.6, 0.8, 0]])
    with pytest.raises(InputError, match="^a "):
        checks.as_direction([[1, 0, 0], [0, 0, 0]], "a")


@given(st.data())
def test_rotations_and_poses_of_rounding_quality_pass_unchanged(data):
    R = data.draw(rotations(data.draw(batches)))
    assert np.abs(checks.as_rotation(R) - R).max(initial=0.0) <= CLEAN
    g = data.draw(poses(data.draw(batches)))
    assert np.abs(checks.as_pose(g) - g).max(initial=0.0) <= CLEAN


@pytest.mark.parametrize("amount", [1e-13, 2e-7])
def test_a_slightly_wrong_rotation_is_replaced_by_the_nearest(amount):
    R = Rotation.random(random_state=1).as_matrix()
    clean = checks.as_rotation(tilted(R, amount))
    assert np.abs(clean.T @ clean - np.eye(3)).max() <= CLEAN
    assert np.abs(clean - R).max() <= 2 * amount
    # The nearest rotation leaves a symmetric remainder: cleanᵀ (tilted) is the other polar factor.
    remainder = clean.T @ tilted(R, amount)
    assert np.abs(remainder - remainder.T).max() <= CLEAN


@pytest.mark.parametrize("decimals", [3, 5])
def test_a_printed_rotation_is_made_one_with_a_warning(decimals):
    """From three decimals on every one passes: half of RᵀR − I is then √3 · 5e-4 at most."""
    R = Rotation.random(200, random_state=3).as_matrix()
    with pytest.warns(RoundedPoseWarning, match="^R "):
        clean = checks.as_rotation(np.round(R, decimals), "R")
    assert np.abs(np.swapaxes(clean, 1, 2) @ clean - np.eye(3)).max() <= CLEAN
    assert np.abs(clean - R).max() <= 2 * 10.0**-decimals
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checks.as_rotation(np.round(R, 7))


@pytest.mark.parametrize(
    "R", [tilted(np.eye(3), 4e-3), tilted(np.eye(3), 0.1), np.diag([1.0, 1.0, -1.0])], ids=["bent", "wrong", "mirror"]
)
def test_no_rotation(R):
    with pytest.raises(InputError, match="^R "):
        checks.as_rotation(R, "R")


@pytest.mark.parametrize(
    "g", [np.eye(3), np.zeros((4, 4)), np.diag([2.0, 2, 2, 1]), np.diag([1.0, 1, -1, 1]), np.full((4, 4), np.nan)]
)
def test_no_pose(g):
    with pytest.raises(InputError, match="pose"):
        checks.as_pose(g)


def test_frozen_arrays_are_read_only_copies():
    original = np.arange(3.0)
    copy = checks.frozen(original)
    original[0] = 9.0
    assert copy[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        copy[0] = 1.0


@pytest.mark.parametrize(
    "value", [0.0, -1, float("nan"), float("inf"), "fast", None, [1.0], 10**400], ids=lambda each: repr(each)[:9]
)
def test_no_positive_number(value):
    with pytest.raises(InputError, match="^rate "):
        checks.as_positive(value, "rate")
    assert checks.as_positive(np.float32(0.5), "rate") == 0.5
