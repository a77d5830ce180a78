"""Screws of joints by Pinocchio's exponential, and the pairs that are recognised in them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from joint_arms import DEGREES, KINDS, Joint, Reference, by_hand, random_chain, screws_of
from strategies import close, directions, rotations, vectors
from twistarm import joints, poe
from twistarm.theory.lower_pairs import lower_pairs


@pytest.mark.parametrize("kind", KINDS)
@given(rotations(), vectors(), vectors(scale=2.0), st.sampled_from([-0.3, 0.0, 1e-3, 0.005 / (2 * np.pi), 2.0]))
def test_a_joint_moves_as_in_pinocchio(kind, R, point, x, pitch):
    """A ball also keeps its centre, and the slide and the turn of a cylindrical joint commute."""
    joint, x = Joint(kind, R, point, pitch), x[: DEGREES[kind]]
    for length in (0.2, 5.0):
        columns = screws_of(joint, length)
        g = poe.fk(columns, np.eye(4), x)
        close(g, Reference([joint], np.eye(4))(x)[0])
    if kind == "spherical":
        close(g @ [*point, 1.0], [*point, 1.0])
    if kind == "cylindrical":
        close(poe.fk(columns[:, ::-1], np.eye(4), x[::-1]), g)


@pytest.mark.parametrize(
    ("normal", "x"),
    [
        ([0, 0, 1], [1, 0, 0]),
        ([0, 0, -1], [1, 0, 0]),
        ([0, 1, 0], [1, 0, 0]),
        ([1, 0, 0], [0, 1, 0]),
        ([-1, 0, 0], [0, 1, 0]),
        ([0.91, 0, np.sqrt(1 - 0.91**2)], [0, 1, 0]),  # where x lies too nearly along the normal
    ],
)
def test_the_default_axes_of_a_plane(normal, x):
    close(joints.plane_axes(normal), np.transpose([x, np.cross(normal, x), normal]))


@given(directions(), vectors())
def test_the_axes_of_a_plane_are_a_rotation(normal, x_axis):
    for R in (joints.plane_axes(normal), joints.plane_axes(7 * normal, x_axis + np.cross(normal, [0.3, 2, 5]))):
        close(R.T @ R, np.eye(3))
        assert np.linalg.det(R) > 0
        close(R[:, 2], normal)


X, Y, Z, O = [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]  # noqa: E741


def kinds(*columns, A=None):
    screws = np.hstack(columns)
    return [pair.kind for pair in lower_pairs(screws, np.eye(screws.shape[1]) if A is None else np.array(A, float))]


@pytest.mark.parametrize("seed", range(5))
def test_what_joints_makes_is_found_again(seed: int) -> None:
    order = np.random.default_rng(seed).permutation(KINDS).tolist()
    chain, home = random_chain(order, seed)
    pairs = lower_pairs(by_hand(chain, home).screws, np.eye(11))
    assert [pair.kind for pair in pairs] == order
    for pair, j in zip(pairs, chain, strict=True):
        np.testing.assert_allclose(pair.axis, j.axis, atol=1e-14)
        assert pair.pitch == pytest.approx(j.pitch if j.kind == "helical" else 0, abs=1e-14)


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        ((joints.prismatic(Z), joints.revolute(Z, X)), ["cylindrical"]),
        ((joints.revolute(Z, X), joints.prismatic([0, 0, -1])), ["cylindrical"]),
        ((joints.revolute(Z, X), joints.prismatic([0, 1e-6, 1])), ["revolute", "prismatic"]),
        ((joints.helical(Z, O, 0.1), joints.prismatic(Z)), ["helical", "prismatic"]),
        ((joints.revolute(Z, O), joints.revolute(Y, O), joints.revolute(X, O)), ["spherical"]),
        ((joints.revolute(X, O), joints.revolute(Y, O), joints.revolute(Z, O)), ["revolute"] * 3),
        ((joints.revolute(Z, O), joints.revolute(Y, O), joints.revolute(X, [0, 1e-6, 0])), ["revolute"] * 3),
        ((joints.revolute(Z, O), joints.revolute(Y, O), joints.revolute(Z, O)), ["revolute"] * 3),
        ((joints.prismatic(X), joints.prismatic(Y), joints.revolute(Z, X)), ["planar"]),
        ((joints.prismatic(Y), joints.prismatic(X), joints.revolute(Z, X)), ["prismatic"] * 2 + ["revolute"]),
        ((joints.prismatic(X), joints.prismatic(Y), joints.prismatic(Z)), ["prismatic"] * 3),
        ((joints.revolute(Z, X), joints.prismatic(X), joints.prismatic(Y)), ["revolute"] + ["prismatic"] * 2),
        ((joints.prismatic(X), joints.prismatic(Z), joints.revolute(Z, X)), ["prismatic", "cylindrical"]),
    ],
)
def test_near_misses_are_no_pairs(columns: tuple[np.ndarray, ...], expected: list[str]) -> None:
    assert kinds(*columns) == expected


@pytest.mark.parametrize(
    ("A", "expected"),
    [
        ([[1, 0], [0, 1]], ["cylindrical"]),
        ([[1], [0.1]], ["helical"]),
        ([[1], [0]], ["revolute", "prismatic"]),
        ([[0], [1]], ["revolute", "prismatic"]),
        ([[2, 1], [0.2, 0.1]], ["helical"]),
        ([[2, 1], [1, 2]], ["cylindrical"]),
    ],
)
def test_the_coupling_decides_between_cylinder_and_thread(A: list[list[float]], expected: list[str]) -> None:
    assert kinds(joints.revolute(Z, X), joints.prismatic(Z), A=A) == expected


def test_a_ball_whose_turns_follow_each_other_is_none() -> None:
    ball = joints.spherical(O)
    assert kinds(ball, A=[[1, 0], [0, 1], [1, 0]]) == ["revolute"] * 3
