"""A recorded motion is followed on the clock, from where it begins, and read strictly."""

from __future__ import annotations

import numpy as np
import pytest

from stream_stand_ins import FakeClock, Robot
from twistarm import plan_joint
from twistarm.stream import Ending, Replay, SimulatedJoints, read_recording, run
from twistarm.support.errors import InputError, LimitError, TwistarmError

RATE = 100.0
LONG = 20.0
"""Seconds in which every replay here is over, by itself."""


@pytest.fixture(scope="module")
def motion(rover):
    waypoints = [rover.ready, rover.ready + [0.1, 0.3, -0.4, 0.2, 1.0], rover.ready + [-0.1, 0.1, -0.6, -0.3, -1.0]]
    return plan_joint(rover, waypoints, kind="trapezoid")


@pytest.fixture(scope="module")
def file(motion, tmp_path_factory):
    return motion.to_csv(tmp_path_factory.mktemp("replay") / "motion.csv", dt=0.02)


def changed(file, tmp_path, change):
    lines = change(file.read_text("utf-8").splitlines())
    copy = tmp_path / "changed.csv"
    copy.write_text("\n".join(lines) + "\n", "utf-8")
    return copy


def test_between_the_samples_it_is_the_motion(rover, motion, file):
    recording = read_recording(rover, file)
    assert recording.duration == motion.duration
    times = np.linspace(-0.1, motion.duration + 0.1, 501)
    # Cubic pieces over 20 ms: exact inside a trapezoid's pieces, at its corners off by some a·dt²/32.
    off = max(np.abs(recording(time) - motion(time)).max() for time in times)
    assert off <= rover.limits.acceleration.max() * 0.02**2 / 8


def test_it_is_followed_on_the_clock(rover, motion, file):
    clock = FakeClock()
    robot = Robot(rover.ready, clock)
    replay = Replay(rover, read_recording(rover, file))
    report = run(rover, replay, robot, robot, rate=RATE, clock=clock, duration=LONG, until=lambda: replay.done)
    assert report.ending is Ending.DONE
    deviation = [np.abs(s.theta - motion(s.time + 1 / RATE - 100.01)).max() for s in robot.setpoints]
    assert max(deviation) < 2e-3
    assert np.abs(robot.theta - motion.waypoints[-1]).max() < 1e-3
    assert not robot.rates[-1].any()
    assert (np.abs(robot.rates) <= rover.limits.velocity * (1 + 1e-9)).all()


def test_simulated_joints_follow_it_50_ms_behind(rover, motion, file):
    clock = FakeClock()
    joints = SimulatedJoints(rover, rover.ready, latency=0.05, clock=clock)
    replay = Replay(rover, read_recording(rover, file))
    behind = []

    def look(cycle):
        if cycle.setpoint is not None and not replay.done:
            behind.append(np.abs(cycle.theta - motion(cycle.time - 100.01 - 0.05)).max())

    report = run(
        rover, replay, joints, joints, rate=RATE, clock=clock, duration=LONG, until=lambda: replay.done, on_cycle=look
    )
    assert report.ok
    assert max(behind) < 0.05


def test_an_arm_elsewhere_is_not_moved(rover, file):
    clock = FakeClock()
    robot = Robot(rover.ready + [0.0, 0.05, 0.0, 0.0, 0.0], clock)
    replay, seen = Replay(rover, read_recording(rover, file)), []
    run(rover, replay, robot, robot, rate=RATE, clock=clock, duration=0.5, on_cycle=seen.append)
    assert not robot.rates.any()
    assert "begins 0.05 rad from where joint shoulder is; bring the arm there first" in seen[-1].reason
    assert not replay.done


def test_an_arm_that_stays_elsewhere_ends_the_stream(rover, file):
    clock = FakeClock()
    robot = Robot(rover.ready + [0.0, 0.05, 0.0, 0.0, 0.0], clock)
    replay = Replay(rover, read_recording(rover, file))
    report = run(rover, replay, robot, robot, rate=RATE, clock=clock, duration=9.0, until=lambda: replay.done)
    why = "the recording begins 0.05 rad from where joint shoulder is; bring the arm there first"
    assert (report.ending, report.reason, report.ok) == (Ending.SOURCE_FAILED, why, False)
    assert report.duration == pytest.approx(2.0, abs=2 / RATE)
    assert f"had no command for 2.000 s, at last because: {why}" in report.explain()
    assert not robot.rates.any()


def test_an_arm_that_comes_in_time_is_followed(rover, file):
    clock = FakeClock()
    robot = Robot(rover.ready + [0.0, 0.05, 0.0, 0.0, 0.0], clock)
    robot.mute = lambda now: 100.5 < now < 101.5

    def bring(cycle):
        if 101.0 < cycle.time < 101.015:
            robot.theta = rover.ready

    replay = Replay(rover, read_recording(rover, file))
    robot.deaf = lambda now: now < 101.5
    report = run(
        rover, replay, robot, robot, rate=RATE, clock=clock, duration=LONG, until=lambda: replay.done, on_cycle=bring
    )
    assert report.ending is Ending.DONE
    assert report.ok


def test_an_arm_that_falls_behind_is_not_chased(rover, file):
    clock = FakeClock()
    robot = Robot(rover.ready, clock)
    robot.mute = lambda now: now > 100.2
    replay = Replay(rover, read_recording(rover, file))
    report = run(rover, replay, robot, robot, rate=RATE, clock=clock, duration=3.0, until=lambda: replay.done)
    assert report.ending is Ending.SOURCE_FAILED
    assert report.reason.endswith("the arm cannot follow it")
    assert replay.done
    with pytest.raises(TwistarmError, match="the arm cannot follow it"):
        replay.read(200.0, None)
    assert not robot.rates[-1].any()


def test_columns_in_another_order_and_more_of_them(rover, file, tmp_path):
    def turned(lines):
        return [",".join([*reversed(line.split(",")), "0"]) for line in lines]

    copy, recording = read_recording(rover, changed(file, tmp_path, turned)), read_recording(rover, file)
    assert np.array_equal(copy.theta, recording.theta)
    assert np.array_equal(copy.theta_dot, recording.theta_dot)


def line(number, change):
    return lambda lines: [change(text) if k == number else text for k, text in enumerate(lines, 1)]


BAD = {
    "no header": (lambda lines: lines[1:], "line 1: a recording of rover_arm has 'time \\[s\\]' once; here it is not"),
    "degrees": (line(1, lambda text: text.replace("elbow.position [rad]", "elbow.position [deg]")), "closest: 'elbow"),
    "twice": (line(1, lambda text: text.replace("acceleration [m/s^2]", "x").replace("slide.x", "time [s]")), "twice"),
    "short": (line(7, lambda text: text.rsplit(",", 1)[0]), "line 7: 16 numbers are needed"),
    "nan": (line(7, lambda text: "nan" + text[text.index(",") :]), "line 7: every number must be finite"),
    "word": (line(7, lambda text: "soon" + text[text.index(",") :]), "line 7: could not convert"),
    "back in time": (line(7, lambda text: "0.01" + text[text.index(",") :]), "line 7: time must increase; got 0.01"),
    "beyond": (line(7, lambda text: ",".join([text.split(",")[0], "9", *text.split(",")[2:]])), "joint 'slide' at 9 m"),
    "one line": (lambda lines: lines[:2], "two lines of numbers at least; got 1"),
    "empty": (lambda lines: [], "line 1"),
}


@pytest.mark.parametrize(("change", "why"), BAD.values(), ids=list(BAD))
def test_what_is_no_recording_is_refused_with_its_line(rover, file, tmp_path, change, why):
    with pytest.raises((InputError, LimitError), match=why) as caught:
        read_recording(rover, changed(file, tmp_path, change))
    assert "changed.csv" in str(caught.value)


def test_files_that_are_none(rover, tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_recording(rover, tmp_path / "none.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x81\x00")
    with pytest.raises(InputError, match="is no text"):
        read_recording(rover, tmp_path / "binary.csv")
