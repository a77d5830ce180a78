"""A trajectory followed on a robot: limits and path held by differences of the commanded positions, every way out."""

from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from rate_plant import RateDrives
from servo_drives import WRIST, with_motors
from stream_stand_ins import PERIOD, FakeClock, Robot
from twistarm import load_arm, plan_joint
from twistarm.control.stream import Ending, FollowControl, FollowOptions, Interlock, Measured, SimulatedJoints, follow
from twistarm.support.errors import InputError, LimitError

EXACT = 1 + 1e-6


@pytest.fixture(scope="module")
def motion(rover):
    """Bang-bang: at each moment a joint accelerates or brakes at its limit, which is where clocks break limits."""
    way = [rover.ready, rover.ready + [0.1, 0.3, -0.4, 0.2, 1.0], rover.ready + [-0.1, 0.1, -0.6, -0.3, -1.0]]
    return plan_joint(rover, way, kind="time_optimal", stop_at_waypoints=True)


def commanded(robot):
    """Times, positions, and the rates and accelerations between them, of what was commanded."""
    kept = np.append(np.diff(robot.times) > 0, True)  # the last setpoint has the time of the one before
    t, theta = robot.times[kept], np.array([setpoint.theta for setpoint in robot.setpoints])[kept]
    rates = np.diff(theta, axis=0) / np.diff(t)[:, None]
    middle = 0.5 * (t[1:] + t[:-1])
    return t, theta, rates, np.diff(rates, axis=0) / np.diff(middle)[:, None]


def shares(arm, robot):
    """The largest commanded velocity and acceleration, as shares of the limits."""
    _, _, rates, accelerations = commanded(robot)
    return (np.abs(rates) / arm.limits.velocity).max(), (np.abs(accelerations) / arm.limits.acceleration).max()


def off_path(motion, theta):
    """How far each theta (k, n) is from the nearest of a dense row of the motion's positions."""
    path = motion(np.linspace(0.0, motion.duration, 4001))
    return max(np.abs(path - state).max(axis=1).min() for state in theta)


def followed(arm, motion, robot, clock, feedback=None, on_cycle=None, **options):
    """The report of `follow` on a robot that measures itself where there is no other feedback."""
    return follow(arm, motion, robot, feedback or robot, FollowOptions(**options), clock=clock, on_cycle=on_cycle)


def at(moment, act):
    """A callback that acts once, when the motion is at that moment of its own time."""
    left = [act]

    def on_cycle(cycle):
        if left and cycle.at >= moment:
            left.pop()()

    return on_cycle


def test_it_is_followed_as_it_was_planned(rover, motion, robot, clock):
    seen = []
    report = followed(rover, motion, robot, clock, on_cycle=seen.append)
    assert (report.ok, report.stream.ending, report.at) == (True, Ending.ARRIVED, motion.duration)
    t, theta, _, _ = commanded(robot)
    np.testing.assert_allclose(theta, motion(t + PERIOD - t[0]), atol=1e-12)
    assert max(shares(rover, robot)) <= EXACT
    assert [cycle.at for cycle in seen] == sorted(cycle.at for cycle in seen)
    assert not robot.rates[-1].any()


@pytest.mark.parametrize("name", ["rover_arm", pytest.param("ur5", marks=pytest.mark.slow)])
def test_however_it_is_paused_and_slowed_the_limits_hold_and_it_stays_on_its_path(name):
    arm, rng = load_arm(name, limits={"velocity": 1.0, "acceleration": 2.0}), np.random.default_rng(5)
    way, waited = [arm.ready, *(arm.ready + 0.4 * (arm.random_theta(rng, 2) - arm.ready))], []
    for kind, speed in (("time_optimal", 1.0), ("s_curve", 0.6)):
        motion = plan_joint(arm, way, kind=kind)
        clock, control = FakeClock(late={40: 3 * PERIOD, 90: 7 * PERIOD}), FollowControl()
        robot, asked = Robot(arm.ready, clock), [0.0]

        def operate(cycle, control=control, asked=asked):
            stands = cycle.setpoint is not None and not cycle.setpoint.theta_dot.any()
            if control.paused and (stands or rng.random() < 0.03):
                waited.append(cycle.time - asked[0])
                control.resume()
            elif not control.paused and rng.random() < 0.03:
                asked[0] = cycle.time
                control.pause()

        report = followed(arm, motion, robot, clock, speed=speed, control=control, on_cycle=operate)
        assert report.ok
        assert max(shares(arm, robot)) <= EXACT
        theta = commanded(robot)[1]
        assert off_path(motion, theta) <= motion.peak(1).max() * motion.duration / 4000
        np.testing.assert_allclose(robot.theta, motion.waypoints[-1], atol=1e-12)
    assert len(waited) > 10
    assert max(waited) < 2.0


def test_cycles_late_by_parts_of_a_period_or_missed_make_no_setpoint_leap(rover, motion):
    """Of a cycle that is late and the next one, which is not, each moves the arm by its own time."""
    rng = np.random.default_rng(8)
    late = {int(k): float(rng.uniform(0.05, 6.95)) * PERIOD for k in rng.choice(np.arange(5, 250), 60, replace=False)}
    clock = FakeClock(late=late)
    robot = Robot(rover.ready, clock)
    report = followed(rover, motion, robot, clock)
    assert report.ok
    assert report.stream.missed > 20
    t, theta, _, _ = commanded(robot)
    np.testing.assert_allclose(theta, motion(np.minimum(t + PERIOD - t[0], motion.duration)), atol=1e-9)
    assert np.diff(t).min() < 0.2 * PERIOD
    assert max(shares(rover, robot)) <= EXACT


def test_a_stop_ends_it_on_its_path(rover, motion, robot, clock):
    control = FollowControl()
    report = followed(rover, motion, robot, clock, control=control, on_cycle=at(0.8, control.stop))
    assert report.stream.ending is Ending.STOPPED
    assert (report.completed, report.ok, report.stream.at_rest) == (False, False, True)
    assert 0.8 < report.at < 1.2
    np.testing.assert_allclose(robot.theta, motion(report.at), atol=1e-12)
    assert max(shares(rover, robot)) <= EXACT


def test_an_arm_elsewhere_is_not_moved_and_its_joints_are_named(rover, motion, clock):
    robot = Robot(rover.ready + [0.0, 0.05, 0.0, -0.2, 0.0], clock)
    report = followed(rover, motion, robot, clock)
    assert (report.stream.ending, report.ok, robot.setpoints) == (Ending.ELSEWHERE, False, [])
    assert all(words in report.stream.reason for words in ("shoulder 0.05 rad", "wrist_pitch 0.2 rad", "approach=True"))
    assert "no joint state" not in report.explain()


@pytest.mark.parametrize("away", [[0.0, 0.5, -0.4, 0.3, 2.0], [0.004, -0.006, 0.008, 0.0, 0.002]])
def test_an_approach_begins_where_the_arm_is_measured_without_a_jump(rover, motion, clock, away):
    theta = rover.ready + away
    robot, seen = Robot(theta, clock), []
    report = followed(rover, motion, robot, clock, approach=max(np.abs(away)) > 0.01, on_cycle=seen.append)
    assert report.ok
    commanded_theta = commanded(robot)[1]
    first = np.vstack([theta, theta, commanded_theta])  # it stood there before
    assert (np.abs(np.diff(first, 2, axis=0)) <= rover.limits.acceleration * PERIOD**2 * EXACT).all()
    assert max(shares(rover, robot)) <= EXACT
    assert seen[0].at < 0.0
    assert report.at == motion.duration
    arrived = next(cycle for cycle in seen if cycle.at >= 0.0)
    np.testing.assert_allclose(arrived.theta, motion.waypoints[0], atol=1e-3)


def test_a_joint_that_does_not_follow_ends_it_and_is_named(rover, motion, robot, clock):
    robot.deaf = lambda now: now > 100.6
    report = followed(rover, motion, robot, clock, tolerance=0.05)
    assert report.stream.ending is Ending.STRAYED
    assert report.joint_names[int(np.argmax(report.largest_error))] in report.stream.reason
    assert 0.05 < report.largest_error.max() < 0.06  # what ended it counts too
    assert max(shares(rover, robot)) <= EXACT
    assert report.stream.at_rest


def test_drives_that_are_late_are_no_error(rover, motion, clock):
    joints, measured = SimulatedJoints(rover, rover.ready, latency=0.08, clock=clock), []
    report = followed(rover, motion, joints, clock, tolerance=0.02, on_cycle=measured.append)
    assert report.ok
    # A late drive lags by its delay times its rate: the report must not hide that behind its window.
    t = np.array([cycle.at for cycle in measured if cycle.theta is not None and cycle.rate > 0.99])
    theta = np.array([cycle.theta for cycle in measured if cycle.theta is not None and cycle.rate > 0.99])
    true = np.abs(motion(np.clip(t - PERIOD, 0.0, motion.duration)) - theta).max(axis=0)
    assert true.max() > 0.05
    np.testing.assert_allclose(report.largest_lag, true, atol=0.005)
    np.testing.assert_allclose(np.max([c.lag for c in measured if c.lag is not None], axis=0), report.largest_lag)
    assert (report.largest_error < 0.02).all()
    assert report.largest_lag.max() > 4 * report.largest_error.max()
    np.testing.assert_allclose(joints.theta, motion.waypoints[-1], atol=0.01)


@pytest.mark.parametrize("late", [0.04, 0.09])
def test_drives_that_keep_their_rates_through_a_late_cycle_are_no_error(rover, motion, late):
    class Keeping(Robot):
        def read(self, now):
            last = self.setpoints[-1] if self.setpoints else None
            return Measured(self.theta if last is None else last.theta + last.theta_dot * (now - last.time), now)

    clock = FakeClock(late={60: late})
    robot = Keeping(rover.ready, clock)
    assert followed(rover, motion, robot, clock, tolerance=0.02).ok
    assert np.abs(robot.rates).max(axis=1)[60] * late > 0.02  # so much farther than the setpoint before


def test_after_a_stall_it_speeds_up_from_rest(rover, motion):
    clock = FakeClock(late={60: 0.5, 140: -3.0})
    robot = Robot(rover.ready, clock)
    report = followed(rover, motion, robot, clock)
    assert report.ok
    theta = [setpoint.theta for setpoint in robot.setpoints]
    stalls = np.flatnonzero(np.abs(np.diff(robot.times)) > 0.3)
    assert len(stalls) >= 1
    for k in stalls:
        again = np.array([setpoint.theta for setpoint in robot.setpoints[k : k + 30]])
        np.testing.assert_array_equal(again[0], again[1])
        changes = np.abs(np.diff(again, 2, axis=0)) / (rover.limits.acceleration * PERIOD**2)
        assert changes.max() <= EXACT
    assert off_path(motion, theta) < 1e-3


def test_nan_slows_it_to_rest_on_its_path_and_it_goes_on(rover, motion, robot, clock):
    class Blinded:
        def read(self, now):
            return Measured(np.full(5, np.nan), now) if 100.5 <= now < 101.5 else robot.read(now)

    report = followed(rover, motion, robot, clock, Blinded())
    assert report.ok
    assert report.stream.blind == pytest.approx(1.0, abs=2 * PERIOD)
    assert "must be finite" in report.stream.blind_reason
    t, theta, rates, _ = commanded(robot)
    assert not rates[(t[:-1] > 101.2) & (t[:-1] < 101.45)].any()
    assert max(shares(rover, robot)) <= EXACT
    assert off_path(motion, theta) < 1e-3


@pytest.mark.parametrize("why", ["paused", "mute"])
@pytest.mark.parametrize("on_the_way", [False, True])
def test_a_motion_resumes_where_others_have_moved_the_resting_arm(rover, motion, clock, why, on_the_way):
    """Moved by less than the tolerance: it returns to where it was on its path, without a jump, and arrives."""
    robot, control, away, seen = Robot(rover.ready, clock), FollowControl(), 0.08 * np.eye(5)[1], []
    robot.theta = robot.theta + 0.5 * np.eye(5)[4] * on_the_way
    pause, move, resume = 100.2, 101.0, 101.5
    robot.mute = lambda now: why == "mute" and pause < now < resume

    def operate(cycle):
        seen.append(cycle)
        if pause < cycle.time < pause + 1.5 * PERIOD and why == "paused":
            control.pause()
        robot.deaf = lambda now: move < now < resume
        if move < cycle.time < move + 1.5 * PERIOD:
            robot.theta = seen[-2].setpoint.theta + away
        if cycle.time > resume:
            control.resume()

    report = followed(rover, motion, robot, clock, control=control, approach=on_the_way, on_cycle=operate)
    assert report.ok
    k = next(k for k, cycle in enumerate(seen) if cycle.time > resume)
    stood, back = seen[k - 2].at, [cycle for cycle in seen[k:] if cycle.setpoint is not None]
    np.testing.assert_allclose(back[1].setpoint.theta, seen[k].theta, atol=0.002)
    theta = np.array([back[0].theta, back[0].theta, *(cycle.setpoint.theta for cycle in back[1:])])
    assert (np.abs(np.diff(theta, 2, axis=0)) <= rover.limits.acceleration * PERIOD**2 * EXACT).all()
    assert on_the_way == (stood < 0.0)
    assert on_the_way or np.abs(theta - motion(stood)).max(axis=1).min() < 1e-3


def test_a_robot_that_is_gone_is_given_up(rover, motion, clock):
    robot = Robot(rover.ready, clock)
    robot.mute = lambda now: now > 100.5
    report = followed(rover, motion, robot, clock)
    assert report.stream.ending is Ending.FEEDBACK_FAILED
    assert report.stream.at_rest
    assert report.stream.duration < 4.5
    nobody = Robot(rover.ready, FakeClock())
    nobody.read = lambda now: None
    report = followed(rover, motion, nobody, nobody.clock)
    assert report.stream.ending is Ending.FEEDBACK_FAILED
    assert nobody.setpoints == []
    assert report.stream.duration < 3.5


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_ctrl_c_and_a_callbacks_error_end_it_at_rest_on_its_path(rover, motion, robot, clock, error):
    def fail():
        raise error

    with nullcontext() if error is KeyboardInterrupt else pytest.raises(error):
        report = followed(rover, motion, robot, clock, on_cycle=at(0.7, fail))
        assert (report.stream.ending, report.ok) == (Ending.INTERRUPTED, False)
    assert not robot.rates[-1].any()
    assert max(shares(rover, robot)) <= EXACT
    assert off_path(motion, commanded(robot)[1]) < 1e-3


def test_an_interlock_pauses_until_it_is_resumed_and_an_emergency_stop_ends_it(rover, motion, robot, clock):
    control, interlock = FollowControl(), Interlock()

    def operate(cycle):
        if 100.5 < cycle.time < 100.515:
            interlock.stop("a door")
        elif 101.5 < cycle.time < 101.515:
            interlock.enable()
        elif 102.0 < cycle.time < 102.015:
            assert not cycle.setpoint.theta_dot.any()  # enabled, and nobody has resumed it
            assert cycle.reason == "stopped: a door"
            control.resume()
        elif 102.5 < cycle.time < 102.515:
            interlock.emergency_stop("by hand")

    report = followed(rover, motion, robot, clock, interlock=interlock, control=control, on_cycle=operate)
    assert report.stream.ending is Ending.STOPPED
    assert report.stream.reason.startswith("emergency stop: by hand at ")
    assert robot.moving(102.5) <= (rover.limits.velocity / rover.limits.acceleration).max() + 3 * PERIOD
    assert max(shares(rover, robot)) <= EXACT


def test_a_motion_too_fast_for_the_arm_is_slowed_and_joints_may_be_in_any_order(rover, motion):
    weak = rover.limits.with_({"velocity": 0.7 * rover.limits.velocity, "acceleration": 1.0}, rover.joint_names)
    arm, clock = replace(rover, limits=weak), FakeClock()
    robot, order = Robot(rover.ready, clock), [3, 1, 4, 0, 2]
    other = replace(
        motion, joint_names=tuple(motion.joint_names[k] for k in order), units=tuple(motion.units[k] for k in order),
        waypoints=motion.waypoints[:, order], coefficients=motion.coefficients[..., order],
    )  # fmt: skip
    report = followed(arm, other, robot, clock)
    assert report.ok
    assert report.speed < 0.72
    velocity, acceleration = shares(arm, robot)
    assert max(velocity, acceleration) == pytest.approx(1.0, abs=0.01)


def test_the_motors_limits_hold_as_well(rover, motion, clock):
    """A differential wrist of which the plan, made for joints alone, asks too much."""
    wired = with_motors(rover, WRIST, velocity=3.0, acceleration=4.0)
    control, robot = FollowControl(), Robot(rover.ready, clock)

    def operate(cycle):
        if cycle.setpoint.number % 60 == 30 or (control.paused and cycle.rate == 0.0):
            control.toggle()

    report = followed(wired, motion, robot, clock, control=control, on_cycle=operate)
    assert report.ok
    assert report.speed < 0.9
    _, _, rates, accelerations = commanded(robot)
    assert np.abs(rates @ WRIST.T).max() <= 3.0 * EXACT
    assert 3.5 < np.abs(accelerations @ WRIST.T).max() <= 4.0 * EXACT
    assert max(shares(rover, robot)) <= EXACT


def test_drives_that_take_rates_alone_arrive(rover, motion):
    clock = FakeClock()
    drives = RateDrives(rover, rover.ready, clock, gain=1.05)
    report = followed(rover, motion, drives, clock, velocity_mode=True)
    assert report.ok
    np.testing.assert_allclose(drives.read(clock.now()).theta, motion.waypoints[-1], atol=0.012)


def test_labels_are_reported_once_as_they_are_passed_whatever_its_pace(rover, motion, robot, clock):
    labels, passed = ((0.0, "open"), (0.5, "close"), (0.5, "light"), (motion.duration, "done")), []
    followed(
        rover, replace(motion, labels=labels), robot, clock, speed=0.5,
        on_cycle=lambda cycle: passed.extend((label, cycle.at) for label in cycle.labels),
    )  # fmt: skip
    assert [label for label, _ in passed] == ["open", "close", "light", "done"]
    assert all(time <= at < time + PERIOD for (time, _), (_, at) in zip(labels, passed, strict=True))


def test_a_motion_to_where_the_arm_stands_is_done_at_once(rover, robot, clock):
    still = plan_joint(rover, [rover.ready, rover.ready])
    report = followed(rover, still, robot, clock)
    assert report.ok
    assert not robot.rates.any()


def jumping(motion):
    coefficients = motion.coefficients.copy()
    coefficients[-1, 3:, 0] += 0.1
    return replace(motion, coefficients=coefficients)


def already_moving(motion):
    start = motion.waypoints[:1]
    ends = np.vstack([start, start + 0.1])
    return replace(
        motion, waypoints=ends, times=[0, 1], breakpoints=[0, 1], coefficients=np.stack([0 * start + 0.1, start])
    )


def beyond(motion):
    coefficients = motion.coefficients.copy()
    coefficients[-1] += 9.0
    return replace(motion, waypoints=motion.waypoints + 9.0, coefficients=coefficients)


def misspelt(motion):
    return replace(motion, joint_names=("slide", "shoulder", "elbw", *motion.joint_names[3:]))


BAD = {
    "other joints": (misspelt, {}, InputError, "closest: 'elbow'"),
    "other units": (lambda m: replace(m, units=("rad",) * 5), {}, InputError, "'m', 'rad'"),
    "no trajectory": (lambda m: m.waypoints, {}, InputError, "trajectory"),
    "a jump": (jumping, {}, InputError, "'slide' jumps by 0.1 m at"),
    "moving": (already_moving, {}, InputError, "'slide' jumps by 0.1 m/s at t = 0 s"),
    "beyond a limit": (beyond, {}, LimitError, "rover_arm"),
    "no speed": (lambda m: m, {"speed": 0.0}, InputError, "speed"),
    "too fast": (lambda m: m, {"speed": 1.5}, InputError, "speed"),
    "a start in degrees": (lambda m: m, {"start_tolerance": 5}, InputError, "286°"),
    "no start": (lambda m: m, {"start_tolerance": -1}, InputError, "start_tolerance"),
    "no control": (lambda m: m, {"control": "space"}, InputError, "control"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_cannot_be_followed_is_refused_before_anything_moves(rover, motion, robot, clock, case):
    change, options, kind, why = BAD[case]
    with pytest.raises(kind) as caught:
        followed(rover, change(motion), robot, clock, **options)
    assert why in str(caught.value)
    assert robot.setpoints == []
