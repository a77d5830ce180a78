"""Calibration by simulated truth: what was put into an arm is found in its log."""

import numpy as np
import pytest

from family_arms import family_arm
from twistarm import load_arm
from twistarm.calibration.calibrate import calibrate
from twistarm.calibration.measurements import Measurements
from twistarm.theory import poe
from twistarm.theory.screws import adjoint, exp

NOISE = 5e-5


def moved(arm, rng, size=1.0):
    """The arm with every screw carried along by a small motion of its own (Okamura & Park), and a moved home."""
    d = rng.normal(scale=[5e-4] * 3 + [2e-3] * 3, size=(arm.screws.shape[1] + 1, 6)) * size
    screws = np.stack([adjoint(exp(each)) @ xi for each, xi in zip(d, arm.screws.T, strict=False)], axis=1)
    return screws, exp(d[-1]) @ arm.home


def away(rng):
    """The base in the frame of a tracker."""
    return exp(np.r_[rng.normal(size=3), rng.normal(size=3)])


@pytest.fixture(scope="module", params=["rover_arm", "family"])
def log(request):
    rng = np.random.default_rng(3)
    arm = load_arm("rover_arm") if request.param == "rover_arm" else family_arm("wrist", rng=rng)
    screws, home = moved(arm, rng)
    base, theta = away(rng), arm.random_theta(rng, 150)
    true = lambda x: base @ poe.fk(screws, home, x @ arm.coupling.A.T)  # noqa: E731
    positions = true(theta)[:, :3, 3] + rng.normal(scale=NOISE, size=(150, 3))
    return arm, theta, positions, true


def test_the_corrected_arm_predicts_what_was_not_measured(log):
    arm, theta, positions, true = log
    r = calibrate(arm, Measurements(theta, positions), position_noise=NOISE)
    fresh = arm.random_theta(99, 300)
    error = np.linalg.norm(r.predict(fresh) - true(fresh)[:, :3, 3], axis=1)
    assert error.max() < 5 * NOISE
    assert r.confirmed
    assert r.held_out < 2.5 * NOISE < r.held_out_before / 4
    assert not r.outliers
    assert not r.warnings
    assert np.allclose((r.base @ r.arm.fk(fresh) @ r.tool)[:, :3, 3], r.predict(fresh), atol=1e-12)
