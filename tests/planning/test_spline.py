"""Piecewise polynomials: their values and extremes, splines through waypoints."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from strategies import generators
from twistarm.planning import spline
from twistarm.planning.piecewise import derivative, evaluate, extremes, shifted
from twistarm.support.errors import MissingExtraError

# Relative to distance over the shortest time to that power: the spline is solved for, and that loses digits.
SMOOTH = 1e-8

# Kind and stop; how many derivatives are continuous inside, and how many are zero at the ends.
FITS = [("cubic", False, 2, 1), ("quintic", False, 4, 2), ("cubic", True, 1, 1), ("quintic", True, 2, 2)]


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


@pytest.mark.parametrize(("kind", "stop", "smooth", "resting"), FITS)
@given(path=paths())
def test_it_passes_the_waypoints_smoothly_and_rests_at_the_ends(kind, stop, smooth, resting, path):
    waypoints, times = path
    coefficients = spline.at_times(kind, waypoints, times, stop)
    for order in range(smooth + 1):
        start, end = ends(coefficients, times, order)
        size = np.abs(waypoints).max() / np.diff(times).min() ** order
        if order == 0:
            assert np.allclose(start, waypoints[:-1], atol=SMOOTH * size)
            assert np.allclose(end, waypoints[1:], atol=SMOOTH * size)
        assert np.allclose(end[:-1], start[1:], atol=SMOOTH * size)
        if 0 < order <= resting:
            assert np.allclose([start[0], end[-1]], 0.0, atol=SMOOTH * size)


@pytest.mark.parametrize("degree", [3, 5])
@given(path=paths())
def test_a_natural_spline_passes_the_waypoints_and_is_smooth_wherever_they_lie(degree, path):
    waypoints, places = path
    if len(places) < 3:
        return
    breakpoints, coefficients = spline.natural(waypoints, places, degree)
    fit = PPoly(coefficients, breakpoints)
    size, least = np.abs(waypoints).max(), np.diff(breakpoints).min()
    np.testing.assert_allclose(fit(places), waypoints, atol=SMOOTH * size)
    for order in range(degree):
        start, end = ends(coefficients, breakpoints, order)
        np.testing.assert_allclose(end[:-1], start[1:], atol=SMOOTH * max(np.abs(start).max(), size / least**order))
        if order > degree // 2:
            np.testing.assert_allclose([start[0], end[-1]], 0.0, atol=SMOOTH * max(np.abs(start).max(), size))


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("degree", [3, 5])
def test_a_waypoint_very_near_another_leaves_a_natural_spline_smooth(degree, gap):
    places = np.sort(np.append(np.arange(8.0), 3.0 + gap))
    breakpoints, coefficients = spline.natural(np.sin(places)[:, None], places, degree)
    assert np.abs(PPoly(coefficients, breakpoints)(np.linspace(0.0, 7.0, 5000), 3)).max() < 5.0


@pytest.mark.parametrize("kind", spline.KINDS)
def test_without_scipy_the_command_that_installs_it_is_named(kind, monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.interpolate", None)
    with pytest.raises(MissingExtraError, match=r"planning needs SciPy.*pip install 'twistarm\[plan\]'"):
        spline.at_times(kind, np.zeros((3, 1)), np.arange(3.0), stop=False)


ROUNDING = 1e-12  # Relative: a dozen operations in double precision on values of one order.


@st.composite
def motions(draw):
    """Coefficients (d + 1, s, n), some zero, leading ones tiny or zero too, and durations (s,) of several orders."""
    rng, degree = draw(generators), draw(st.integers(0, 5))
    shape = (degree + 1, int(rng.integers(1, 4)), int(rng.integers(1, 4)))
    durations = 10.0 ** rng.uniform(-3, 2, shape[1])
    scale = rng.choice([0.0, 1e-14, 1e-7, 1.0, 1.0, 1.0], size=shape)
    powers = np.arange(degree, -1, -1.0)[:, None, None]
    return rng.normal(size=shape) * scale / durations[:, None] ** powers, durations


@given(motions(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_shifted_polynomials_are_the_same_further_on(motion, share, further):
    coefficients, durations = motion
    by, tau = share * durations, further * durations
    powers = np.arange(len(coefficients) - 1, -1, -1.0)[:, None, None]
    size = (np.abs(coefficients) * (2.0 * durations[:, None]) ** powers).sum(axis=0)
    moved = shifted(coefficients, by)
    for k in range(len(durations)):
        expected = [np.polyval(column, by[k] + tau[k]) for column in coefficients[:, k].T]
        actual = [np.polyval(column, tau[k]) for column in moved[:, k].T]
        np.testing.assert_allclose(actual, expected, rtol=0, atol=ROUNDING * size[k].max() + 1e-300)


@given(motions())
def test_value_and_derivatives_are_those_of_scipy(motion):
    coefficients, durations = motion
    breakpoints = np.concatenate([[0.0], np.cumsum(durations)])
    for order in range(4):
        expected = PPoly(coefficients, breakpoints).derivative(order)
        rows = derivative(coefficients, order)
        for fraction in (0.0, 0.3, 0.99):
            tau = fraction * durations
            size = np.abs(evaluate(np.abs(rows), tau[:, None])) + 1.0
            error = evaluate(rows, tau[:, None]) - expected(breakpoints[:-1] + tau)
            # The sum of times rounds, and the slope there carries it over.
            assert (np.abs(error) <= 1e-9 * size).all()


@given(motions())
def test_no_sample_and_no_root_exceeds_the_extremes(motion):
    coefficients, durations = motion
    tau, values = extremes(coefficients, durations)
    assert (tau >= 0).all()
    assert (tau <= durations[:, None]).all()
    scale = evaluate(np.abs(coefficients), durations[:, None])
    for s, length in enumerate(durations):
        for j in range(coefficients.shape[2]):
            polynomial = coefficients[:, s, j]
            roots = np.roots(np.polyder(polynomial))
            roots = np.clip(np.real(roots[np.abs(np.imag(roots)) < 1e-6 * length]), 0.0, length)
            sampled = np.polyval(polynomial, np.concatenate([np.linspace(0, length, 1001), roots]))
            assert values[:, s, j].max() >= sampled.max() - ROUNDING * scale[s, j]
            assert values[:, s, j].min() <= sampled.min() + ROUNDING * scale[s, j]
            assert np.allclose(values[:, s, j], np.polyval(polynomial, tau[:, s, j]), atol=ROUNDING * scale[s, j])
