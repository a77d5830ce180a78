"""How long `plan_joint` takes, and times that are given."""

import numpy as np
import pytest

from joint_space_cases import ARM, KINDS, MET, PASSES, PATH, RATE, RATES, STRAIGHT, WAYS, use
from twistarm.planning import plan_joint
from twistarm.support.errors import InputError, LimitError

# -- durations ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("distance", "velocity", "acceleration"), [(1.0, 0.5, 1.0), (1.0, 1.0, 1.0), (0.1, 1.0, 2.0), (2.0, 0.1, 50.0)]
)
def test_a_trapezoid_takes_the_textbooks_time(distance, velocity, acceleration):
    # Lynch & Park §9.2.2.2: d/v + v/a, or 2 √(d/a) where v²/a > d and the speed limit is not reached.
    coasts = velocity**2 / acceleration <= distance
    expected = distance / velocity + velocity / acceleration if coasts else 2 * np.sqrt(distance / acceleration)
    limits = {"velocity": velocity, "acceleration": acceleration}
    motion = plan_joint(ARM, [[0, 0, 0], [0, distance, -distance / 2]], kind="trapezoid", limits=limits)
    assert motion.duration == pytest.approx(expected, rel=MET)
    assert motion.peak(1)[1] == pytest.approx(min(velocity, np.sqrt(acceleration * distance)), rel=MET)
    assert motion(motion.duration / 2)[1] == pytest.approx(distance / 2)


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize(
    ("kind", "velocity", "acceleration", "jerk"), [("cubic", 3 / 2, 6.0, 12.0), ("quintic", 15 / 8, 10 / 3**0.5, 60.0)]
)
def test_a_single_segment_takes_the_textbooks_time(kind, stop, velocity, acceleration, jerk):
    # Peaks of a rest-to-rest polynomial: c d/T, c d/T², c d/T³ (Lynch & Park §9.2.2.1).
    for v, a, j in ((0.3, 9.0, np.inf), (5.0, 0.7, np.inf), (5.0, 9.0, 0.9)):
        limits = {"velocity": v, "acceleration": a, "jerk": j}
        motion = plan_joint(ARM, [[0, 0, 0], [0, 1.5, 0]], kind=kind, limits=limits, stop_at_waypoints=stop)
        expected = max(velocity * 1.5 / v, (acceleration * 1.5 / a) ** (1 / 2), (jerk * 1.5 / j) ** (1 / 3))
        assert motion.duration == pytest.approx(expected, rel=MET)


def test_a_trapezoid_does_not_look_at_jerk():
    free = plan_joint(ARM, PATH, kind="trapezoid", limits=RATES)
    assert plan_joint(ARM, PATH, kind="trapezoid", limits=RATES | {"jerk": 1e-3}).duration == free.duration


def test_rates_far_apart_are_no_trouble():
    for kind, stop in WAYS:
        for rates in ({"velocity": 1e-3, "acceleration": 1e6}, {"velocity": 1e6, "acceleration": 1e-3}):
            limits = ARM.limits.with_(rates, ARM.joint_names)
            motion = plan_joint(ARM, PATH, kind=kind, limits=limits, stop_at_waypoints=stop)
            assert use(motion, limits) == pytest.approx(1.0, rel=MET)


@pytest.mark.parametrize("acceleration", [10.0, 1e6])
def test_a_long_motion_keeps_its_short_segments_and_ramps(acceleration):
    rng = np.random.default_rng(1)
    points = np.repeat(rng.uniform(-0.4, 0.4, (60, 3)), 2, axis=0)
    points[1::2] += 3e-6
    limits = ARM.limits.with_({"velocity": 0.01, "acceleration": acceleration}, ARM.joint_names)
    for kind in KINDS:
        motion = plan_joint(ARM, points, kind=kind, limits=limits, stop_at_waypoints=True)
        assert use(motion, limits) == pytest.approx(1.0, rel=MET)
        assert np.abs(motion(motion.times) - points).max() <= PASSES


# -- times given --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_given_times_are_kept_and_missing_rates_not_asked_for(kind, stop):
    times = [0.0, 2.0, 5.0, 9.0]
    motion = plan_joint(ARM, PATH, kind=kind, times=times, stop_at_waypoints=stop)
    assert motion.times.tolist() == times
    assert motion.duration == 9.0
    assert np.allclose(motion(times), PATH)


@pytest.mark.parametrize(("kind", "stop"), WAYS)
def test_times_that_are_too_short_are_refused_with_the_factor_that_helps(kind, stop):
    first = plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop)
    short = 0.8 * first.times
    with pytest.raises(LimitError, match="its (velocity|acceleration) limit is") as error:
        plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=short)
    factor = float(str(error.value).split("multiply times by ")[1].split(",")[0])
    assert 1.2 < factor < 1.8
    plan_joint(ARM, PATH, kind=kind, limits=RATES, stop_at_waypoints=stop, times=factor * short)


def test_a_ramp_is_chosen_that_keeps_both_limits_at_a_given_time():
    line = [[0, 0, 0], [0, 1, 0]]
    for limits in ({"velocity": 1.0, "acceleration": 1.01}, {"velocity": 0.55, "acceleration": 5.0}, {"velocity": 0.6}):
        motion = plan_joint(ARM, line, kind="trapezoid", times=[0, 2.0], limits=limits)
        assert motion.peak(1)[1] <= limits["velocity"] * (1 + RATE)
        assert motion.peak(2)[1] <= limits.get("acceleration", np.inf) * (1 + RATE)


def test_equal_waypoints_at_different_times_are_a_dwell():
    for kind, stop in STRAIGHT:
        motion = plan_joint(
            ARM, [PATH[0], PATH[1], PATH[1], PATH[2]], kind=kind, times=[0, 3, 5, 8], stop_at_waypoints=stop
        )
        assert np.allclose(motion(np.linspace(3, 5, 9)), PATH[1], atol=1e-12)


@pytest.mark.parametrize(
    ("times", "text"),
    [
        ([0, 1], "one instant per waypoint"),
        ([1, 2, 3, 4], "start at 0"),
        ([0, 2, 2, 3], "increase strictly"),
        ([0, 1, np.nan, 3], "finite"),
        ([0, 1e-9, 2, 3], "no segment under"),
        ([0, 1e300, 2e300, 3e300], "must span"),
        ("soon", "real numbers"),
    ],
)
def test_times_that_make_no_sense(times, text):
    with pytest.raises(InputError, match=text):
        plan_joint(ARM, PATH, times=times)
