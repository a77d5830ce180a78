"""`plan_joint`: the laws of every kind, and the motion of a real arm."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from joint_space_cases import ARM, MET, PASSES, PATH, RATE, RATES, STRAIGHT, WAYS, use
from strategies import generators
from twistarm.planning import plan_joint
from twistarm.planning.joint_space import MERGE_TOL
from twistarm.support.errors import InputError

few = settings(max_examples=15)


@st.composite
def tasks(draw):
    """Waypoints inside ARM's position limits, some repeated or nearly so, and limits of several orders."""
    rng = draw(generators)
    k = int(rng.integers(2, 8))
    points = rng.uniform(0.6 * ARM.limits.lower, 0.6 * ARM.limits.upper, (k, 3))
    for i in range(1, k):
        if rng.random() < 0.25:
            points[i] = points[i - 1] + rng.choice([0.0, 1e-9, 1e-5, 1e-3]) * rng.normal(size=3)
    still = rng.random(3) < 0.2
    points[:, still] = points[0, still]
    rates = {name: 10.0 ** rng.uniform(-1.5, 1.5, 3) for name in ("velocity", "acceleration")}
    return points, ARM.limits.with_(rates, ARM.joint_names)


# -- the laws of every kind ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_limits_are_kept_and_one_is_met(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    assert (motion.peak(1) <= limits.velocity * (1 + RATE)).all()
    assert (motion.peak(2) <= limits.acceleration * (1 + RATE)).all()
    t = np.linspace(0, motion.duration, 3001)
    assert (np.abs(motion(t, 1)) <= limits.velocity * (1 + RATE)).all()
    assert (np.abs(motion(t, 2)) <= limits.acceleration * (1 + RATE)).all()
    if motion.duration > 0:
        assert use(motion, limits) == pytest.approx(1.0, rel=MET)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
@few
@given(task=tasks())
def test_waypoints_are_passed_at_their_times_from_rest_to_rest(kind, stop, task):
    points, limits = task
    wide = limits.with_({"lower": -10.0, "upper": 10.0}, ARM.joint_names)
    motion = plan_joint(ARM, points, kind=kind, limits=wide, stop_at_waypoints=stop)
    assert np.array_equal(motion.waypoints, points)
    assert np.abs(motion(motion.times) - points).max() <= MERGE_TOL + PASSES
    assert np.array_equal(motion(-1.0), points[0])
    assert np.array_equal(motion(motion.duration), points[-1])
    assert motion.duration == 0 or np.array_equal(motion(0.0), points[0])
    assert motion.times[0] == 0
    assert motion.times[-1] == motion.duration
    ends = [0.0, motion.duration]
    near = 1e-12 * motion.duration
    assert (motion(ends, 1) == 0).all()
    speed = np.abs(motion([near, motion.duration - near], 1))
    assert (speed <= 2 * near * motion.peak(2) + PASSES * motion.peak(1)).all()
    if kind == "quintic":
        assert np.abs(motion(ends, 2)).max() <= 1e-6 * motion.peak(2).max()
    if (kind, stop) in STRAIGHT:
        assert np.abs(motion(motion.times, 1)).max() <= 1e-6 * motion.peak(1).max()


@pytest.mark.parametrize(("kind", "stop"), STRAIGHT)
@few
@given(task=tasks())
def test_motions_that_stop_go_straight_and_stay_among_their_waypoints(kind, stop, task):
    points, limits = task
    motion = plan_joint(ARM, points, kind=kind, limits=limits, stop_at_waypoints=stop)
    theta = motion(np.linspace(0, motion.duration, 501))
    assert (theta >= points.min(0) - PASSES).all()
    assert (theta <= points.max(0) + PASSES).all()
    for a, b, start, goal in zip(motion.times[:-1], motion.times[1:], points[:-1], points[1:], strict=True):
        line = motion(np.linspace(a, b, 7)[1:-1]) - start
        step = goal - start
        across = line - np.outer(line @ step, step) / max(step @ step, 1e-300)
        assert b == a or np.abs(across).max() <= MERGE_TOL + PASSES


# -- the rest -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["Cubic", "spline", "s-curve", None, 3])
def test_an_unknown_kind_lists_the_known(kind):
    with pytest.raises(
        InputError, match=r"kind must be 'cubic', 'quintic', 'trapezoid', 'time_optimal' or 's_curve'; got"
    ):
        plan_joint(ARM, PATH, kind=kind, limits=RATES)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_progress_rises_to_one(kind, stop):
    seen = []
    plan_joint(ARM, PATH, kind=kind, stop_at_waypoints=stop, limits=RATES, progress=seen.append)
    assert all(0 < a <= b for a, b in itertools.pairwise(seen))
    assert seen[-1] == 1.0
