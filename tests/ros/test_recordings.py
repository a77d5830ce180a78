"""Recordings of ours in the serialisation of a real ROS 2, and messages of its own in ours."""

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS 2 here: `make test-ros` has one on Linux x86-64")

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectory

from twistarm import load_trajectory, plan_joint, save_trajectory
from twistarm.control.stream import Inbox, Recorder, SimulatedJoints, run

KINDS = {
    "/robot_description": String,
    "/joint_states": JointState,
    "/joint_trajectory": JointTrajectory,
    "/setpoints": JointTrajectory,
    "/diagnostics": DiagnosticArray,
    "/labels": String,
}
"""What the wheels have: tf2_msgs is not among them."""


def messages_of(file):
    found: dict[str, list] = {}
    with Reader(file) as reader:
        for connection, time, data in reader.messages():
            if connection.topic in KINDS:
                found.setdefault(connection.topic, []).append(
                    (time, deserialize_message(data, KINDS[connection.topic]))
                )
    return found


def test_ros_reads_a_motion(rover, tmp_path):
    motion = plan_joint(rover, [rover.ready, rover.ready + 0.1])
    messages = messages_of(save_trajectory(motion, tmp_path / "motion.mcap", arm=rover, dt=0.05))
    samples = motion.sample(0.05)
    ((_, told),) = messages["/joint_trajectory"]
    assert list(told.joint_names) == list(rover.joint_names)
    for name, values in zip(("positions", "velocities", "accelerations"), samples[1:], strict=True):
        np.testing.assert_array_equal([getattr(point, name) for point in told.points], values)
    np.testing.assert_array_equal([state.position for _, state in messages["/joint_states"]], samples.theta)
    stamps = [state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for _, state in messages["/joint_states"]]
    assert stamps == [time for time, _ in messages["/joint_states"]]
    assert messages["/robot_description"][0][1].data == rover.description.text


def test_ros_reads_a_recorded_stream(rover, tmp_path):
    joints = SimulatedJoints(rover, rover.ready)
    with Recorder(rover, tmp_path / "run.mcap", joints) as recorder:
        report = run(rover, Inbox(), recorder, joints, duration=0.3, on_cycle=recorder)
    messages = messages_of(tmp_path / "run.mcap")
    assert len(messages["/joint_states"]) == report.cycles
    for (_, setpoint), (_, diagnosis) in zip(messages["/setpoints"], messages["/diagnostics"], strict=True):
        np.testing.assert_array_equal(setpoint.points[0].positions, rover.ready)
        (status,) = diagnosis.status
        assert (status.level, status.hardware_id) == (b"\x01", "rover_arm")
        assert {entry.key: entry.value for entry in status.values}["status"] == "STALE"


def test_joint_states_that_ros_serialised_are_a_motion(rover, tmp_path):
    with Writer(tmp_path / "ros", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        store = get_typestore(Stores.ROS2_KILTED)
        topic = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for k in range(3):
            position, still = (rover.ready[::-1] + 0.02 * k).tolist(), [0.0] * rover.n
            state = JointState(name=[*reversed(rover.joint_names)], position=position, velocity=[], effort=still)
            writer.write(topic, k * 10**9, serialize_message(state))
    motion = load_trajectory(rover, tmp_path / "ros" / "ros.mcap")
    np.testing.assert_allclose(motion([0.0, 1.5]), rover.ready + np.array([[0.0], [0.03]]), atol=1e-12)
