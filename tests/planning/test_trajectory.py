import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest
from scipy.interpolate import PPoly

from twistarm.planning import Samples, Trajectory
from twistarm.support.errors import InputError

ROUNDING = 1e-13  # Values of order 1 after a handful of operations.


def motion(n=2):
    """Two quintic rest-to-rest pieces written out by hand: 0 → 1 in 2 s, 1 → −0.5 in 3 s; joint j scaled by j + 1."""
    unit = np.array([6.0, -15.0, 10.0, 0.0, 0.0, 0.0])
    first, second = unit / 2.0 ** np.arange(5, -1, -1), -1.5 * unit / 3.0 ** np.arange(5, -1, -1)
    second[-1] = 1.0
    scale = np.arange(1.0, n + 1)
    return Trajectory(
        joint_names=tuple(f"joint{j + 1}" for j in range(n)),
        units=("rad",) * n,
        waypoints=np.array([[0.0], [1.0], [-0.5]]) * scale,
        times=np.array([0.0, 2.0, 5.0]),
        breakpoints=np.array([0.0, 2.0, 5.0]),
        coefficients=np.stack([first, second], axis=1)[:, :, None] * scale,
    )


def standstill():
    return Trajectory(("a",), ("m",), np.full((2, 1), 0.3), np.zeros(2), np.zeros(2), np.full((1, 1, 1), 0.3))


@pytest.mark.parametrize("order", range(4))
@pytest.mark.parametrize("shape", [(), (2, 3), (0,)])
def test_inside_it_is_scipys_piecewise_polynomial(order, shape):
    trajectory = motion()
    t = np.random.default_rng(0).uniform(0.01, 4.99, shape)
    reference = PPoly(trajectory.coefficients, trajectory.breakpoints).derivative(order)
    assert trajectory(t, order).shape == (*shape, 2)
    assert np.allclose(trajectory(t, order), reference(t), atol=ROUNDING, rtol=ROUNDING)


@pytest.mark.parametrize("t", [-1.0, 0.0, 5.0, 5.5, 1e9])
def test_the_ends_are_held(t):
    trajectory = motion()
    assert trajectory(t).tolist() == trajectory.waypoints[0 if t <= 0 else -1].tolist()
    assert trajectory(t, 1).tolist() == [0.0, 0.0]
    outside = t < 0 or t > 5
    assert (trajectory(t, 3) == 0).all() == outside


def test_peaks_are_those_of_the_textbook():
    # Lynch & Park §9.2.2.1: velocity 15/8 d/T, acceleration 10/√3 d/T².
    trajectory = motion()
    assert trajectory.peak(0) == pytest.approx([1.0, 2.0])
    assert trajectory.peak(1) == pytest.approx(np.array([1.0, 2.0]) * 15 / 8 / 2)
    assert trajectory.peak(2) == pytest.approx(np.array([1.0, 2.0]) * 10 / np.sqrt(3) / 4)
    assert trajectory.peak(3) == pytest.approx(np.array([1.0, 2.0]) * 60 / 8)


@pytest.mark.parametrize("dt", [0.01, 1 / 3, 2.5, 100.0])
def test_samples_increase_strictly_and_end_on_the_duration(dt):
    samples = motion().sample(dt)
    assert isinstance(samples, Samples)
    assert samples.t[0] == 0.0
    assert samples.t[-1] == 5.0
    assert (np.diff(samples.t) > 0).all()
    assert np.allclose(np.diff(samples.t)[:-1], dt)
    assert len(samples.t) == np.ceil(round(5.0 / dt, 9)) + 1
    assert samples.theta[-1].tolist() == [-0.5, -1.0]
    assert samples.theta_dot[-1].tolist() == [0.0, 0.0]
    for order, values in enumerate(samples[1:]):
        assert np.array_equal(values, motion()(samples.t, order))


@pytest.mark.parametrize(("duration", "dt", "count"), [(3 * 0.1, 0.1, 4), (0.7, 0.1, 8), (1e-9, 0.1, 2)])
def test_a_rounding_is_no_sample_of_its_own(duration, dt, count):
    line = Trajectory(
        ("a",), ("m",), [[0.0], [duration]], [0, duration], [0, duration], np.ones((2, 1, 1)) * [[[1]], [[0]]]
    )
    samples = line.sample(dt)
    assert len(samples.t) == count
    assert (np.diff(samples.t) > 0.5 * min(dt, duration)).all()
    assert samples.theta[[0, -1], 0].tolist() == [0.0, duration]


def test_it_is_plain_read_only_data():
    trajectory = motion()
    copy = pickle.loads(pickle.dumps(trajectory))
    assert np.array_equal(copy(np.linspace(0, 5, 9)), trajectory(np.linspace(0, 5, 9)))
    with pytest.raises(FrozenInstanceError):
        trajectory.times = np.zeros(3)
    with pytest.raises(ValueError, match="read-only"):
        trajectory.coefficients[0] = 1.0


@pytest.mark.parametrize(
    ("ask", "name", "bad"),
    [
        (lambda order: motion()(0.0, order), "order", [-1, 4, 1.0, None]),
        (lambda order: motion().peak(order), "order", [4]),
        (lambda dt: motion().sample(dt), "dt", [0.0, -0.1, np.nan, 1e-320, "x", [0.1]]),
        (lambda t: motion()(t), "t", [np.nan, "now", [0.0, np.inf]]),
    ],
)
def test_what_is_no_order_step_or_time_is_refused(ask, name, bad):
    for value in bad:
        with pytest.raises(InputError, match=f"{name} must be"):
            ask(value)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (
            {"joint_names": ("a",), "units": ("rad",)},
            r"needs waypoints \(3, 1\) and coefficients \(degree \+ 1, 2, 1\)",
        ),
        ({"breakpoints": [0.0, 2.0, 2.0]}, "must increase from 0"),
        ({"coefficients": motion().coefficients * np.nan}, "coefficients must be finite"),
        ({"labels": [(1.0, "open"), (0.5, "close")]}, "must not decrease .* got 0.5 s of 'close'"),
        ({"labels": [(5.1, "open")]}, r"lie within \[0, 5\] s; got 5.1 s"),
        ({"labels": [(np.nan, "open")]}, "the time of a label"),
        ({"labels": [(1.0, "two\nlines")]}, "a label must be one line of text"),
        ({"labels": [(1.0, None)]}, "a label must be one line of text"),
        ({"labels": "open"}, "labels must be pairs"),
    ],
)
def test_parts_that_do_not_fit_are_refused(parts, message):
    with pytest.raises(InputError, match=message):
        replace(motion(), **parts)
