"""What counts as one joint: grouped where the geometry is that of a lower pair, left apart where it is not."""

from __future__ import annotations

import numpy as np
import pytest

from joint_arms import KINDS, by_hand, random_chain
from twistarm import joints
from twistarm.theory.lower_pairs import lower_pairs

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
def test_near_misses_stay_apart(columns: tuple[np.ndarray, ...], expected: list[str]) -> None:
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
