"""The velocity along a path: core and NumPy agree, and nothing faster keeps the rows."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.optimize import linprog

from twistarm.arm import engine
from twistarm.limits import JointLimits
from twistarm.planning.joint_path import JointPath
from twistarm.planning.time_laws import PathBounds
from twistarm.planning.time_laws.interval_limits import LimitedPath
from twistarm.planning.time_laws.path_velocity import in_numpy, passes, path_velocity


@pytest.mark.parametrize("seed", range(4))
def test_no_faster_profile_exists(seed):
    rng = np.random.default_rng(seed)
    count, most = 12, 3.0
    a, b = rng.normal(size=(2, count, 9))
    x = passes(a, b, most)
    # By linear programming: the greatest x_i from which the rows can be kept to the end.
    for i in (1, count // 2, count - 1):
        unknowns = count - i + 1
        rows = np.zeros((count - i, a.shape[1], unknowns))
        for k in range(i, count):
            rows[k - i, :, k - i], rows[k - i, :, k - i + 1] = a[k], b[k]
        bounds = [(0.0, most)] * (unknowns - 1) + [(0.0, 0.0)]
        best = linprog(-np.eye(unknowns)[0], rows.reshape(-1, unknowns), np.ones(rows[..., 0].size), bounds=bounds)
        assert x[i] <= best.x[0] + 1e-7
    assert (a * x[:-1, None] + b * x[1:, None] <= 1.0 + 1e-9).all()


@pytest.mark.parametrize(("degree", "n"), [(1, 1), (2, 3), (3, 7), (5, 4)])
def test_core_and_numpy_agree(degree, n):
    rng = np.random.default_rng(degree)
    spline = make_interp_spline(np.linspace(0.0, 2.0, 8), rng.uniform(-1.0, 1.0, (8, n)), k=degree)
    knots = np.unique(spline.t)
    powers = [spline(knots[:-1], nu=order) / factorial(order) for order in range(degree, -1, -1)]
    path = JointPath(knots, np.stack(powers))
    ceiling = rng.uniform(0.1, 1.0, len(knots) - 1)
    limits = JointLimits.unbounded(n).with_({"velocity": 2.0, "acceleration": 5.0}, [str(j) for j in range(n)])
    limited = LimitedPath.of(path, PathBounds(limits, None, ceiling))
    grid = np.union1d(path.breakpoints, np.linspace(0.0, path.length, 50))
    assert engine.core() is not None
    core, numpy = path_velocity(limited, grid), in_numpy(limited, grid)
    np.testing.assert_allclose(core.x, numpy.x, rtol=1e-9)
    np.testing.assert_allclose(core.share, numpy.share, rtol=1e-9)


@pytest.mark.parametrize("search", [path_velocity, in_numpy])
def test_velocity_limits_that_limit_nothing_do_no_harm(search):
    """1e9 rad/s, as descriptions write it: 2 √(D/a) still (Lynch & Park §9.2.2.2)."""
    limits = JointLimits.unbounded(1).with_({"velocity": 1e9, "acceleration": 5.0}, ["a"])
    path = JointPath(np.array([0.0, 1.0]), np.array([[[3.0]], [[0.0]]]))
    x = search(LimitedPath.of(path, PathBounds(limits)), np.linspace(0.0, 1.0, 201)).x
    assert (0.01 / (np.sqrt(x[1:]) + np.sqrt(x[:-1]))).sum() == pytest.approx(2.0 * np.sqrt(3.0 / 5.0), rel=1e-6)


def test_nearly_upright_rows_are_kept():
    """x0 ≤ 1/a by a row whose b is rounding, where Newton's own step is lost; the other row wants x1 ≥ 2 a x0 − 1."""
    rng = np.random.default_rng(0)
    for a in rng.uniform(1.0, 1e4, 200):
        rows = np.array([[[a, 2.0 * a]]] * 3), np.array([[[1e-19 * a, -1.0]]] * 3)
        x = passes(rows[0][:, 0], rows[1][:, 0], 10.0)
        assert (rows[0][:, 0] * x[:-1, None] + rows[1][:, 0] * x[1:, None] <= 1.0 + 1e-9).all()
