"""Each subproblem: random problems made from their answer, the exactness of what is returned, tangents, free values.

The judge of every answer is the exponential of the twist by SciPy, and the residual that it leaves.
"""

import math

import numpy as np
import pytest

from family_arms import twist_motion
from twistarm.ik.subproblems import subproblem_1, subproblem_2, subproblem_3, subproblem_4
from twistarm.support.errors import InputError

PROBLEMS = 12
Z_TURN, Z_SLIDE = np.array([0.0, 0, 0, 0, 0, 1]), np.array([0.0, 0, 1, 0, 0, 0])


def moved(xi, x, p):
    return (twist_motion(xi, x) @ [*p, 1.0])[:3]


def random_twist(rng, slides=False):
    w = rng.normal(size=3)
    w /= np.linalg.norm(w)
    return np.r_[w, 0.0, 0.0, 0.0] if slides else np.r_[np.cross(rng.normal(size=3), w), w]


def random_value(rng, slides):
    return rng.uniform(-1, 1) if slides else rng.uniform(-math.pi, math.pi)


def made_1(rng, slides):
    """Arguments of a problem with an answer, that answer, and how far a value misses."""
    xi, p, x = random_twist(rng, slides), rng.normal(size=3), random_value(rng, slides)
    q = moved(xi, x, p)
    return (xi, p, q), x, lambda value: np.linalg.norm(moved(xi, value, p) - q)


def made_3(rng, slides):
    xi, p, q, x = random_twist(rng, slides), rng.normal(size=3), rng.normal(size=3), random_value(rng, slides)
    delta = np.linalg.norm(moved(xi, x, p) - q)
    return (xi, p, q, delta), x, lambda value: abs(np.linalg.norm(moved(xi, value, p) - q) - delta)


def made_4(rng, slides):
    xi, p, n, x = random_twist(rng, slides), rng.normal(size=3), rng.normal(size=3), random_value(rng, slides)
    n /= np.linalg.norm(n)
    d = n @ moved(xi, x, p)
    return (xi, p, n, d), x, lambda value: abs(n @ moved(xi, value, p) - d)


def made_2(rng, slides, meeting=False):
    first, second = random_twist(rng, slides[0]), random_twist(rng, slides[1])
    if meeting:
        o = rng.normal(size=3)
        first[:3], second[:3] = np.cross(o, first[3:]), np.cross(o, second[3:])
    p, x = rng.normal(size=3), np.array([random_value(rng, slide) for slide in slides])
    q = moved(first, x[0], moved(second, x[1], p))
    return (first, second, p, q), x, lambda y: np.linalg.norm(moved(first, y[0], moved(second, y[1], p)) - q)


def difference(a, b, slides):
    """The largest difference of two values, angles modulo whole turns."""
    d = np.atleast_1d(np.asarray(a) - np.asarray(b))
    return np.abs(np.where(slides, d, (d + np.pi) % (2 * np.pi) - np.pi)).max()


@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize(
    ("solve", "made", "most"), [(subproblem_1, made_1, 1), (subproblem_3, made_3, 2), (subproblem_4, made_4, 2)]
)
def test_one_joint_finds_the_value_that_made_the_problem(solve, made, most, slides):
    rng = np.random.default_rng(1)
    for _ in range(PROBLEMS):
        given, x, miss = made(rng, slides)
        roots = solve(*given)
        assert 1 <= len(roots.values) <= most
        assert not roots.free
        assert min(difference(value, x, slides) for value in roots.values) < 1e-6
        assert max(miss(value) for value in roots.values) < 1e-9
        assert roots.residual == pytest.approx(min(miss(value) for value in roots.values), abs=1e-13)


@pytest.mark.parametrize("slides", [(False, False), (True, False), (False, True)])
def test_two_joints_find_the_values_that_made_the_problem(slides):
    rng = np.random.default_rng(2)
    for i in range(PROBLEMS):
        meeting = not any(slides) and i % 2 == 0
        given, x, miss = made_2(rng, slides, meeting=meeting)
        roots = subproblem_2(*given)
        assert (2 if meeting else 1) <= len(roots.values) <= 2
        assert min(difference(value, x, slides) for value in roots.values) < 1e-6
        assert max(miss(value) for value in roots.values) < 1e-6
        assert roots.residual < 1e-9


AXIS_X, P = np.array([0.0, 0, 0, 1, 0, 0]), [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("roots", "value", "residual"),
    [
        (subproblem_1(Z_TURN, P, [0.0, 3.0, 0.5]), math.pi / 2, math.hypot(2.0, 0.5)),
        (subproblem_2(AXIS_X, Z_TURN, P, [0.0, 0.0, 3.0]), None, 2.0),
        (subproblem_3(Z_TURN, P, [3.0, 0, 0], 1.5), 0.0, 0.5),
        (subproblem_4(Z_TURN, P, [0, 1, 0], 1.25), math.pi / 2, 0.25),
    ],
)
def test_a_problem_without_an_answer_returns_the_nearest_value(roots, value, residual):
    """The residual is the distance that geometry leaves."""
    assert value is None or roots.values == pytest.approx([value], abs=1e-12)
    assert roots.residual == pytest.approx(residual)


@pytest.mark.parametrize("off", [0.0, 1e-16, -1e-16, 3e-16])
def test_a_tangent_has_one_root(off):
    assert len(subproblem_3(Z_TURN, [1, 0, 0], [3, 0, 0], 2.0 + off).values) == 1
    assert len(subproblem_4(Z_TURN, [1, 0, 0], [1, 0, 0], 1.0 + off).values) == 1
    assert len(subproblem_4(Z_TURN, [1, 0, 0], [1, 0, 0], -1.0 + off).values) == 1
    elbow = np.array([0.0, -1, 0, 0, 0, 1])  # parallel to Z_TURN through (1, 0, 0)
    stretched = subproblem_2(Z_TURN, elbow, [2, 0, 0], [0, 2 + off, 0])
    assert len(stretched.values) == 1
    assert stretched.values[0] == pytest.approx([math.pi / 2, 0.0], abs=1e-7)


def test_a_point_on_an_axis_is_free():
    on_axis = [0, 0, 0.7]
    assert subproblem_1(Z_TURN, on_axis, on_axis).free
    assert subproblem_3(Z_TURN, on_axis, [1, 0, 0.7], 1.0).free
    assert subproblem_4(Z_TURN, on_axis, [0, 0, 1], 0.7).free
    assert subproblem_2(Z_TURN, [0.0, 0, 0, 1, 0, 0], [0.3, 0, 0], [0.3, 0, 0]).free  # on the second axis
    assert subproblem_1(Z_TURN, on_axis, [1, 0, 0.7]).residual == pytest.approx(1.0)


def test_slides_meet_spheres_and_planes():
    """A line and a sphere, a line and a plane: by Pythagoras."""
    assert sorted(subproblem_3(Z_SLIDE, [3, 0, 0], [0, 0, 1], 5.0).values) == pytest.approx([-3.0, 5.0])
    assert subproblem_4(Z_SLIDE, [3, 0, 0], [0, 3, 4], 2.0).values == pytest.approx([2.5])
    assert subproblem_4(Z_SLIDE, [3, 0, 0], [1, 0, 0], 3.0).free
    assert subproblem_4(Z_SLIDE, [3, 0, 0], [1, 0, 0], 4.0).residual == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: subproblem_1([0, 0, 0, 0, 0, 2], [1, 0, 0], [0, 1, 0]), "divide it by 2"),
        (lambda: subproblem_1([0, 0, 1, 0, 0, 1], [1, 0, 0], [0, 1, 0]), "turns and slides"),
        (lambda: subproblem_1([0, 0, 0, 0, 0, 1], [np.nan, 0, 0], [0, 1, 0]), "p"),
        (lambda: subproblem_2(np.zeros(6), Z_TURN, [1, 0, 0], [0, 1, 0]), "xi_1"),
        (lambda: subproblem_3(Z_TURN, [1, 0, 0], [0, 1, 0], -1.0), "distance"),
        (lambda: subproblem_4(Z_TURN, [1, 0, 0], [0, 0, 0], 1.0), "normal"),
        (lambda: subproblem_4(Z_TURN, [[1, 0, 0]], [0, 0, 1], 1.0), "p"),
    ],
)
def test_bad_input_is_named(call, says):
    with pytest.raises(InputError, match=says):
        call()
