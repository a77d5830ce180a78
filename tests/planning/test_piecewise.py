import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import PPoly

from strategies import generators
from twistarm.planning.piecewise import derivative, evaluate, extremes, shifted

ROUNDING = 1e-12
"""Relative: a dozen operations in double precision on values of one order."""


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
    for s, duration in enumerate(durations):
        for j in range(coefficients.shape[2]):
            polynomial = coefficients[:, s, j]
            roots = np.roots(np.polyder(polynomial))
            roots = np.clip(np.real(roots[np.abs(np.imag(roots)) < 1e-6 * duration]), 0.0, duration)
            sampled = np.polyval(polynomial, np.concatenate([np.linspace(0, duration, 1001), roots]))
            assert values[:, s, j].max() >= sampled.max() - ROUNDING * scale[s, j]
            assert values[:, s, j].min() <= sampled.min() + ROUNDING * scale[s, j]
            assert np.allclose(values[:, s, j], np.polyval(polynomial, tau[:, s, j]), atol=ROUNDING * scale[s, j])


@pytest.mark.parametrize(
    ("roots", "name"),
    [
        ((0.2, 0.5, 0.9), "three apart"),
        ((0.5, 0.5, 0.5), "a triple one"),
        ((0.5, 0.5 + 1e-7, 0.9), "two nearly equal"),
        ((0.0, 1.0, 0.5), "at the ends"),
        ((-1.0, 2.0, 3.0), "all outside"),
        ((0.3, 0.3 + 1e-3j, 0.3 - 1e-3j), "a pair just off the axis"),
    ],
)
def test_hard_stationary_points(roots, name):
    polynomial = np.polyint(np.real(np.poly(roots)))
    _, values = extremes(polynomial[:, None, None], np.ones(1))
    inside = [r.real for r in np.array(roots, dtype=complex) if r.imag == 0 and 0 <= r.real <= 1]
    expected = np.polyval(polynomial, [0.0, 1.0, *inside])
    assert values.max() == pytest.approx(expected.max(), abs=ROUNDING)
    assert values.min() == pytest.approx(expected.min(), abs=ROUNDING)
