"""Lines in space, by SciPy and by trigonometry."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from twistarm.theory import joints, rotations
from twistarm.theory.lines import axis_points, least_turn


def test_the_least_turn_takes_one_direction_to_another():
    """By the angle of the two directions; for opposite ones about some axis, for equal ones not at all."""
    rng = np.random.default_rng(5)
    for _ in range(50):
        a, b = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        turn = least_turn(a, b)
        np.testing.assert_allclose(rotations.exp(turn) @ a, b, atol=1e-15)
        assert np.linalg.norm(turn) == pytest.approx(np.arccos(a @ b), abs=1e-9)
        np.testing.assert_allclose(rotations.exp(least_turn(a, -a)) @ a, -a, atol=1e-15)
        assert not least_turn(a, a).any()


def test_points_of_successive_axes_are_each_nearest_to_the_one_before():
    """By SciPy's minimum of the distance along each line; a slide repeats the point before."""
    rng = np.random.default_rng(3)
    axes, points, start = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), rng.normal(size=3)
    columns = [joints.helical(axes[0], points[0], 0.3), joints.prismatic(axes[1]), joints.revolute(axes[2], points[2])]
    first, repeated, last = axis_points(np.hstack(columns), start)
    for found, before, i in ((first, start, 0), (last, first, 2)):
        along = minimize_scalar(lambda t, i=i, at=before: np.linalg.norm(points[i] + t * axes[i] - at)).x
        np.testing.assert_allclose(found, points[i] + along * axes[i], atol=1e-6)
    assert (repeated == first).all()
