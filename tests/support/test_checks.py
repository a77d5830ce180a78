"""What is refused at the door, by argument and value, and what is let in."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from strategies import BATCHES, EPS, batches, poses, rotations
from twistarm.support import checks
from twistarm.support.errors import InputError, RoundedPoseWarning

CLEAN = 8 * EPS  # A cleaned rotation is orthonormal to a few roundings.


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


@pytest.mark.parametrize("batch", BATCHES)
def test_batches_pass(batch):
    assert checks.as_vector(np.ones((*batch, 3)), "p").shape == (*batch, 3)
    assert checks.as_twist(np.ones((*batch, 6))).shape == (*batch, 6)
    assert checks.as_theta(np.ones((*batch, 5)), 5).shape == (*batch, 5)
    assert checks.as_pose(np.broadcast_to(np.eye(4), (*batch, 4, 4))).shape == (*batch, 4, 4)


def test_theta_names_its_joints():
    with pytest.raises(InputError, match="shoulder, elbow"):
        checks.as_theta([1, 2, 3], 2, names=("shoulder", "elbow"))


@pytest.mark.parametrize(
    ("check", "value"),
    [
        (checks.as_vector, np.ones(())),
        (checks.as_vector, np.ones((3, 4))),
        (checks.as_twist, np.ones(3)),
        (checks.as_direction, [[1, 0, 0], [0, 0, 0]]),
        (checks.as_rotation, tilted(np.eye(3), 4e-3)),
        (checks.as_rotation, np.diag([1.0, 1.0, -1.0])),
        (checks.as_pose, np.eye(3)),
        (checks.as_pose, np.zeros((4, 4))),
        (checks.as_pose, np.diag([1.0, 1, -1, 1])),
        (checks.as_pose, np.full((4, 4), np.nan)),
        *((checks.as_positive, value) for value in (0.0, -1, np.inf, [1.0])),
    ],
)
def test_what_is_refused_is_named(check, value):
    with pytest.raises(InputError, match=r"\bthing\b"):
        check(value, "thing")


def test_directions_are_made_unit_vectors():
    np.testing.assert_allclose(checks.as_direction([[0, 0, 2], [3, 4, 0]], "a"), [[0, 0, 1], [0.6, 0.8, 0]])


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


def test_frozen_arrays_are_read_only_copies():
    original = np.arange(3.0)
    copy = checks.frozen(original)
    original[0] = 9.0
    assert copy[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        copy[0] = 1.0
