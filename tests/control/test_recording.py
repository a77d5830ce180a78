"""Recordings of streams, as the reader of MCAP's own project sees them."""

import os
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from mcap_messages import read
from stream_stand_ins import Says, jog
from twistarm import load_trajectory, plan_joint
from twistarm.control.stream import Recorder, UndeliveredError, follow
from twistarm.support.errors import InputError


@pytest.fixture
def recorded(rover, robot, stream, tmp_path):
    """The report of a stream, and the messages of its recording by topic, each with its time [s]."""

    def made(during=lambda cycle: None, **options):
        file = tmp_path / "run.mcap"
        file.unlink(missing_ok=True)
        with Recorder(rover, file, robot) as recorder:

            def record(cycle):
                recorder(cycle)
                during(cycle)

            report = stream(sink=recorder, feedback=robot, on_cycle=record, **options)
            assert not file.exists()
        recorder.close()  # harmless when repeated
        assert os.listdir(tmp_path) == ["run.mcap"]
        return report, messages_of(file), file

    return made


def messages_of(file):
    found: dict[str, list] = {}
    for topic, time, message in read(file)[0]:
        found.setdefault(topic, []).append((time, message))
    return found


def test_every_setpoint_and_joint_state_is_recorded(rover, robot, recorded):
    theta = []
    report, messages, file = recorded(lambda cycle: theta.append(cycle.theta), duration=1.0)
    setpoints = [message.points[0] for _, message in messages["/setpoints"]]
    assert_array_equal([point.positions for point in setpoints], [setpoint.theta for setpoint in robot.setpoints])
    assert_array_equal([point.velocities for point in setpoints], robot.rates)
    assert_allclose(np.diff([time for time, _ in messages["/setpoints"]]), np.diff(robot.times), atol=1e-6)
    assert not any(setpoints[-1].velocities)  # coming to rest is recorded too
    assert_array_equal([state.position for _, state in messages["/joint_states"]], theta)
    assert len(messages["/tf"]) == report.cycles
    values = [{entry.key: entry.value for entry in message.status[0].values} for _, message in messages["/diagnostics"]]
    assert [row["status"] for row in values].count("OK") == report.statuses[next(iter(report.statuses))]
    assert messages["/diagnostics"][-1][1].status[0].level == 1
    assert messages["/diagnostics"][20][1].status[0].level == 0

    motion = load_trajectory(rover, file)
    before_last = robot.setpoints[:-1]  # the last two are of one instant
    assert_array_equal(motion.waypoints, [setpoint.theta for setpoint in before_last])
    assert_allclose(motion(motion.times[5], 1), robot.rates[5], atol=1e-6)


def test_what_did_not_reach_the_robot_is_recorded(robot, recorded):
    robot.broken = lambda now: UndeliveredError("nobody listens") if now < 100.495 else None
    _, messages, _ = recorded(duration=1.0)
    assert len(messages["/setpoints"]) == len(robot.setpoints) + 50
    robot.broken = lambda now: OSError("unplugged") if now > 101.6 else None
    report, messages, _ = recorded(duration=3.0)
    assert "unplugged" in report.reason
    assert len(messages["/joint_states"]) == report.cycles - 1  # the last one failed


def test_a_program_that_fails_leaves_what_was_recorded(rover, robot, recorded, tmp_path):
    def fails(cycle):
        if cycle.time > 100.5:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        recorded(fails)
    assert len(messages_of(tmp_path / "run.mcap")["/joint_states"]) == pytest.approx(51, abs=1)


def test_what_was_driven_by_hand_is_followed_again(rover, robot, clock, recorded):
    _, _, file = recorded(source=Says(lambda now: jog(rover, elbow=-0.4) if 100.1 < now < 101.0 else None))
    end, robot.theta = robot.theta, rover.ready
    assert follow(rover, load_trajectory(rover, file), robot, robot, clock=clock).completed
    assert_allclose(robot.theta, end, atol=1e-6)
    assert abs(end - rover.ready).max() > 0.2


def test_the_labels_of_a_followed_motion_are_recorded(rover, robot, clock, tmp_path):
    motion = plan_joint(rover, [rover.ready, rover.ready + 0.1])
    motion = replace(motion, labels=((0.2, "close gripper"),))
    with Recorder(rover, tmp_path / "run.mcap", robot) as recorder:
        assert follow(rover, motion, recorder, robot, clock=clock, on_cycle=recorder).completed
    ((time, text),) = load_trajectory(rover, tmp_path / "run.mcap").labels
    assert (time, text) == (pytest.approx(0.2, abs=0.011), "close gripper")


def test_a_file_that_cannot_be_written_is_refused_before_anything_moves(rover, robot, tmp_path):
    bad = {"run.csv": "written to .*mcap; got", "none/run.mcap": "does not exist", ".": "it is a folder"}
    for path, why in bad.items():
        with pytest.raises(InputError, match=why):
            Recorder(rover, tmp_path / path, robot)
    with pytest.raises(InputError, match="sink"):
        Recorder(rover, tmp_path / "run.mcap", Says(jog(rover, elbow=0.1)))
    assert os.listdir(tmp_path) == []
