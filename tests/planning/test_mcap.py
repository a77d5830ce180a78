"""MCAP files of motions, as other programs read them, and recordings of others."""

import os
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio
import pytest
import yaml
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from mcap_messages import read
from twistarm import arm_from_screws, load_arm, load_trajectory, plan_joint, save_trajectory
from twistarm.support.errors import InputError, MissingExtraError

ROS = get_typestore(Stores.ROS2_HUMBLE)
RATES = {"velocity": 1.0, "acceleration": 2.0}


def planned(arm):
    way = [arm.ready, arm.ready + 0.1, arm.ready]
    return replace(plan_joint(arm, way, limits=RATES), labels=((0.0, "open"), (0.25, "close")))


def placed(model, data, transform):
    """The pose that Pinocchio has of the child in its parent, and the one of the message."""
    parent, child = (model.getFrameId(name) for name in (transform.header.frame_id, transform.child_frame_id))
    p, q = transform.transform.translation, transform.transform.rotation
    written = pinocchio.SE3(pinocchio.Quaternion(q.w, q.x, q.y, q.z), np.array([p.x, p.y, p.z]))
    return (data.oMf[parent].inverse() * data.oMf[child]).homogeneous, written.homogeneous


@pytest.mark.parametrize("name", ["rover_arm", "ur5"])
def test_others_read_the_motion_and_where_pinocchio_has_each_link(name, tmp_path):
    arm = load_arm(name)
    motion = planned(arm)
    messages, kinds, channels = read(save_trajectory(motion, tmp_path / "motion.mcap", arm=arm, dt=0.05))
    assert kinds == {
        "/robot_description": "std_msgs/msg/String", "/joint_trajectory": "trajectory_msgs/msg/JointTrajectory",
        "/joint_states": "sensor_msgs/msg/JointState", "/tf": "tf2_msgs/msg/TFMessage",
        "/labels": "std_msgs/msg/String",
    }  # fmt: skip
    (quality,) = yaml.safe_load(channels["/robot_description"].metadata["offered_qos_profiles"])
    assert (quality["reliability"], quality["durability"]) == (1, 1)  # RMW's reliable and transient local

    model = pinocchio.buildModelFromXML(arm.description.repaired)
    data, seen = model.createData(), 0
    samples = motion.sample(0.05)
    states = [(time, state) for topic, time, state in messages if topic == "/joint_states"]
    np.testing.assert_allclose([time for time, _ in states], samples.t, atol=1e-9)
    np.testing.assert_array_equal([state.position for _, state in states], samples.theta)
    np.testing.assert_array_equal([state.velocity for _, state in states], samples.theta_dot)
    for topic, _, message in messages:
        if topic == "/joint_states":
            q = pinocchio.neutral(model)
            for joint, value in zip(message.name, message.position, strict=True):
                at = model.joints[model.getJointId(joint)]
                q[at.idx_q : at.idx_q + at.nq] = value if at.nq == 1 else (np.cos(value), np.sin(value))
            pinocchio.framesForwardKinematics(model, data, q)
        elif topic == "/tf":
            children = {transform.child_frame_id for transform in message.transforms}
            assert children | {arm.description.root} == set(arm.frame_names)
            for expected, written in (placed(model, data, transform) for transform in message.transforms):
                np.testing.assert_allclose(written, expected, atol=1e-12)
                seen += 1
    assert seen > len(samples.t)
    (trajectory,) = (transform for topic, _, transform in messages if topic == "/joint_trajectory")
    assert tuple(trajectory.joint_names) == arm.joint_names
    np.testing.assert_array_equal([point.accelerations for point in trajectory.points], samples.theta_ddot)
    assert [(time, point.data) for topic, time, point in messages if topic == "/labels"] == list(motion.labels)
    (text,) = (point.data for topic, _, point in messages if topic == "/robot_description")
    assert ElementTree.fromstring(text).tag == "robot"


def test_an_arm_without_a_description_has_its_tool_alone(tmp_path):
    arm = arm_from_screws(np.eye(6)[:, 5:], np.eye(4), name="wheel")
    messages, kinds, _ = read(
        save_trajectory(plan_joint(arm, [[0.0], [0.5]], limits=RATES), tmp_path / "wheel.mcap", arm=arm, dt=0.1)
    )
    assert "/robot_description" not in kinds
    last = [point for topic, _, point in messages if topic == "/tf"][-1]
    ((turned, frame),) = ((transform.transform.rotation, transform.header.frame_id) for transform in last.transforms)
    assert frame == arm.base
    np.testing.assert_allclose((turned.w, turned.z), (np.cos(0.25), np.sin(0.25)), atol=1e-12)


# -- recordings of others ------------------------------------------------------------------------------------------


def stamped(kind, seconds, *fields):
    stamp = ROS.types["builtin_interfaces/msg/Time"](seconds, 0)
    return ROS.types[kind](ROS.types["std_msgs/msg/Header"](stamp, ""), *fields)


def bag(folder, messages):
    """A recording of (topic, kind, seconds, message), with zstd and an index as rosbag2 makes them."""
    recording = Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP)
    recording.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
    with recording as writer:
        topics = {
            topic: writer.add_connection(topic, kind, typestore=ROS)
            for topic, kind in {topic: kind for topic, kind, *_ in messages}.items()
        }
        for topic, kind, seconds, message in messages:
            writer.write(topics[topic], seconds * 10**9, ROS.serialize_cdr(message, kind))
    return folder / f"{folder.name}.mcap"


def joints(names, position, seconds=0):
    numbers = np.array(position, dtype=float)
    return stamped("sensor_msgs/msg/JointState", seconds, list(names), numbers, np.zeros(0), np.zeros(0))


STATE = "sensor_msgs/msg/JointState"


def test_joint_states_of_a_robot_are_its_motion(rover, tmp_path):
    """Joints in another order, a gripper's among them, and messages of the gripper alone."""
    names, gripper = [*reversed(rover.joint_names), "gripper"], joints(["gripper"], [0.3])
    states = [(1000 + k, joints(names, [*(rover.ready[::-1] + 0.02 * k), 0.5])) for k in range(5)]
    messages = [("/arm/joint_states", STATE, *state) for state in states] + [
        ("/arm/joint_states", STATE, 1002, gripper)
    ]
    motion = load_trajectory(rover, bag(tmp_path / "run", messages))
    np.testing.assert_allclose(motion.times, np.arange(5.0))
    np.testing.assert_allclose(motion([0.0, 2.5, 4.0]), rover.ready + np.array([[0.0], [0.05], [0.08]]), atol=1e-12)


BAD = {
    "cut": lambda data: data[: len(data) // 2],
    "a byte": lambda data: data[:1],
    "empty": lambda data: b"",
    "foreign": lambda data: b"time [s],slide.position [m]\n" * 20,
    "of ROS 1": lambda data: data.replace(b"ros2", b"ros1", 1),
    "another chunk": lambda data: data[:200] + bytes(99) + data[299:],
    "another bit": lambda data: data[:5000] + bytes([data[5000] ^ 1]) + data[5001:],
}


@pytest.mark.parametrize("what", BAD)
def test_a_damaged_file_is_refused_in_a_sentence(rover, tmp_path, what):
    file = save_trajectory(planned(rover), tmp_path / "motion.mcap", arm=rover, dt=0.05)
    file.write_bytes(BAD[what](file.read_bytes()))
    with pytest.raises(InputError, match="no whole recording of ROS 2 .*; copy it again, or .*recover") as refused:
        load_trajectory(rover, file)
    assert "\n" not in str(refused.value)


def test_files_without_a_motion_of_the_arm_are_refused(rover, tmp_path):
    other = load_arm("rr_planar")
    with pytest.raises(InputError, match="moves another arm, with 'joint_1', 'joint_2'; rover_arm has 'slide'"):
        load_trajectory(rover, save_trajectory(planned(other), tmp_path / "other.mcap", arm=other))
    with pytest.raises(InputError, match="neither one JointTrajectory nor joint states of 'slide'"):
        load_trajectory(rover, bag(tmp_path / "fan", [("/joint_states", STATE, 1, joints(["fan"], [0.1]))]))
    back = [("/joint_states", STATE, k, joints(rover.joint_names, rover.ready)) for k in (1, 1)]
    with pytest.raises(InputError, match=r"points\[1\]: time must increase"):
        load_trajectory(rover, bag(tmp_path / "twice", back))
    os.mkfifo(tmp_path / "pipe.mcap")
    with pytest.raises(InputError, match="not a regular file"):
        load_trajectory(rover, tmp_path / "pipe.mcap")
    os.truncate(save_trajectory(planned(rover), tmp_path / "huge.mcap", arm=rover), 2**40)
    with pytest.raises(InputError, match="no whole recording"):
        load_trajectory(rover, tmp_path / "huge.mcap")


def test_a_motion_that_cannot_be_written_leaves_what_was_there(rover, tmp_path):
    file = save_trajectory(planned(rover), tmp_path / "motion.mcap", arm=rover)
    before = file.read_bytes()
    with pytest.raises(InputError, match="give the motion's arm"):
        save_trajectory(planned(rover), file, arm=load_arm("rr_planar"))
    with pytest.raises(InputError, match="dt must be"):
        save_trajectory(planned(rover), file, arm=rover, dt=0.0)
    assert file.read_bytes() == before
    assert os.listdir(tmp_path) == ["motion.mcap"]


def test_without_rosbags_the_extra_is_named(rover, tmp_path, monkeypatch):
    file = save_trajectory(planned(rover), tmp_path / "motion.mcap", arm=rover)
    monkeypatch.setitem(__import__("sys").modules, "rosbags", None)
    for call in (
        lambda: load_trajectory(rover, file),
        lambda: save_trajectory(planned(rover), Path("x.mcap"), arm=rover),
    ):
        with pytest.raises(MissingExtraError, match=r"pip install 'twistarm\[mcap\]'"):
            call()
