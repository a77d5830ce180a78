import itertools
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from strategies import generators
from twistarm.planning import spline
from twistarm.planning.piecewise import derivative, evaluate
from twistarm.support.errors import MissingExtraError

SMOOTH = 1e-8
"""Relative to distance over the shortest time to that power: the spline is solved for, and that loses digits."""

ORTHOGONAL = 1e-6
"""Relative: a product of twelve factors and a third derivative cancel in the integral."""

FITS = {
    # how many derivatives are continuous inside, and how many are zero at the ends
    spline.cubic: (2, 1),
    spline.quintic: (4, 2),
    spline.cubic_rests: (1, 1),
    spline.quintic_rests: (2, 2),
}


@st.composite
def paths(draw):
    """Waypoints (k, n) and times (k,), segments of unequal length."""
    rng = draw(generators)
    k, n = int(rng.integers(2, 9)), int(rng.integers(1, 5))
    return rng.normal(size=(k, n)), np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-1, 1, k - 1))])


def ends(coefficients, times, order):
    """The derivative of that order where each piece starts and where it ends, (s, n) each."""
    rows = derivative(coefficients, order)
    return evaluate(rows, np.zeros((len(times) - 1, 1))), evaluate(rows, np.diff(times)[:, None])


@pytest.mark.parametrize("fit", FITS, ids=lambda fit: fit.__name__)
@given(path=paths())
def test_it_passes_the_waypoints_smoothly_and_rests_at_the_ends(fit, path):
    waypoints, times = path
    smooth, resting = FITS[fit]
    coefficients = fit(waypoints, times)
    for order in range(smooth + 1):
        start, end = ends(coefficients, times, order)
        size = np.abs(waypoints).max() / np.diff(times).min() ** order
        if order == 0:
            assert np.allclose(start, waypoints[:-1], atol=SMOOTH * size)
            assert np.allclose(end, waypoints[1:], atol=SMOOTH * size)
        assert np.allclose(end[:-1], start[1:], atol=SMOOTH * size)
        if 0 < order <= resting:
            assert np.allclose([start[0], end[-1]], 0.0, atol=SMOOTH * size)


@given(paths())
def test_the_quintic_has_the_least_jerk_of_all_that_pass(path):
    # Orthogonality: against any C³ function that vanishes at the waypoints, with velocity and acceleration zero at
    # the ends, ∫ x⃛ f⃛ dt = 0. Here f = s³ with s = Π (t − t_i); more factors would drown it in rounding.
    waypoints, times = path[0][:4], path[1][:4]
    times = times / times[-1]
    jerk = PPoly(spline.quintic(waypoints, times), times).derivative(3)
    vanishing = np.poly1d(np.poly(times)) ** 3
    third = vanishing.deriv(3)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    total, size = np.zeros(waypoints.shape[1]), np.zeros(waypoints.shape[1])
    for a, b in itertools.pairwise(times):
        t = 0.5 * (b - a) * nodes + 0.5 * (a + b)
        product = jerk(t) * third(t)[:, None] * (0.5 * (b - a) * weights)[:, None]
        total, size = total + product.sum(0), size + np.abs(product).sum(0)
    assert (np.abs(total) <= ORTHOGONAL * size).all()


@pytest.mark.parametrize("fit", [spline.cubic, spline.quintic], ids=lambda fit: fit.__name__)
def test_without_scipy_the_command_that_installs_it_is_named(fit, monkeypatch):
    for part in ("interpolate", "linalg"):
        monkeypatch.setitem(sys.modules, f"scipy.{part}", None)
    with pytest.raises(MissingExtraError, match=r"planning needs SciPy.*pip install 'twistarm\[plan\]'"):
        fit(np.zeros((3, 1)), np.arange(3.0))
