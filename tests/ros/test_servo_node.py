"""The package twistarm_servo on a real ROS 2: two processes, a simulated arm, and what it is told."""

import signal
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="no ROS 2 here: `make test-ros` has one on Linux x86-64")

from geometry_msgs.msg import Point, PoseStamped, Quaternion
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Joy
from std_msgs.msg import Float64MultiArray, String
from std_srvs.srv import SetBool, Trigger

from ros_client import LATEST, SOON, Robot, Stick
from twistarm import rotations

CONFIG = Path(__file__).parents[2] / "examples" / "ros2" / "twistarm_servo" / "config" / "servo.yaml"

UP = (0.0, 0.0, 0.03)


@pytest.fixture
def driven(client, robot, stick, start):
    """A node that has its joint states."""
    process = start()
    client.until(lambda: robot.told, LATEST)
    return process


@pytest.mark.usefixtures("driven")
def test_a_twist_moves_the_tool_as_far_as_its_speed_says(client, robot, stick, rover):
    begin = rover.fk(robot.theta)
    stick.linear = UP
    client.during(5.0)
    stick.linear = None
    client.until(lambda: not robot.moves)
    end = rover.fk(robot.theta)
    moved = end[:3, 3] - begin[:3, 3]
    assert 0.13 <= moved[2] <= 0.165  # 5 s at 0.03 m/s, the start, the time-out and the way to rest
    assert np.abs(moved[:2]).max() < 2e-3
    theta = np.array([message.points[0].positions for message in robot.told])
    heights = rover.fk(theta)[:, 2, 3]
    assert (np.diff(heights) >= -1e-6).all()
    assert all(not any(message.points[-1].velocities) for message in robot.told)
    assert list(robot.told[0].joint_names) == list(rover.joint_names)
    assert robot.told[0].points[0].time_from_start.nanosec == 20_000_000
    rates = np.array([message.points[0].velocities for message in robot.told])
    assert (np.abs(rates) <= rover.limits.velocity + 1e-9).all()


def endpoints(client, find, topic):
    client.until(lambda: find(topic))
    return find(topic)[0].qos_profile


@pytest.mark.usefixtures("driven")
def test_topics_and_their_quality_of_service(client):
    heard, said = client.node.get_subscriptions_info_by_topic, client.node.get_publishers_info_by_topic
    for topic in ("/joint_states", "/servo_node/delta_twist_cmds", "/servo_node/pose_target_cmds"):
        assert endpoints(client, heard, topic).reliability is ReliabilityPolicy.BEST_EFFORT
    for topic in ("/servo_node/commands", "/diagnostics"):
        assert endpoints(client, said, topic).reliability is ReliabilityPolicy.RELIABLE
    kinds = {topic: kind for topic, (kind, *_) in client.node.get_topic_names_and_types()}
    assert kinds["/servo_node/commands"] == "trajectory_msgs/msg/JointTrajectory"
    assert kinds["/servo_node/delta_twist_cmds"] == "geometry_msgs/msg/TwistStamped"
    services = {name: kind for name, (kind, *_) in client.node.get_service_names_and_types()}
    for name in ("enable", "stop", "emergency_stop", "clear"):
        assert services[f"/servo_node/{name}"] == "std_srvs/srv/Trigger"


@pytest.mark.usefixtures("driven")
def test_silence_of_commands_or_joints_stops_a_moving_arm(client, robot, stick):
    stick.linear = UP
    client.until(lambda: robot.moves)
    stick.linear = None
    client.until(lambda: not robot.moves, 2.0)
    client.until(lambda: client.status[2].get("status") == "STALE", 2.0)
    stick.linear = UP
    client.until(lambda: robot.moves and client.status[0] == b"\x00")
    robot.mute = True
    client.until(lambda: not robot.moves, 2.0)
    client.until(lambda: client.status[0] == b"\x02", 2.0)
    robot.mute = False
    client.until(lambda: robot.moves, 5.0)


@pytest.mark.usefixtures("driven")
@pytest.mark.parametrize(
    ("nonsense", "why"),
    [
        ({"frame": "world"}, "got frame_id 'world'"),
        ({"linear": (np.nan, 0.0, 0.0)}, "finite"),
        ({"ahead": 2.0}, "use_sim_time"),
        ({"ahead": -100.0}, "s old"),
    ],
)
def test_nonsense_stops_a_moving_arm_and_is_told(client, robot, stick, nonsense, why):
    stick.linear = UP
    client.until(lambda: robot.moves)
    before = {name: getattr(stick, name) for name in nonsense}
    vars(stick).update(nonsense)
    client.until(lambda: not robot.moves and why in client.status[1])
    vars(stick).update(before)
    client.until(lambda: robot.moves)


@pytest.mark.usefixtures("driven")
def test_a_pose_is_reached(client, robot, rover):
    goal = rover.fk(robot.theta)
    goal[2, 3] += 0.02
    (w, x, y, z), pose = rotations.to_quaternion_wxyz(goal[:3, :3]).tolist(), PoseStamped()
    pose.header.frame_id, pose.pose.orientation = rover.base, Quaternion(w=w, x=x, y=y, z=z)
    pose.pose.position = Point(**dict(zip("xyz", goal[:3, 3].tolist(), strict=True)))
    publisher = client.node.create_publisher(PoseStamped, "/servo_node/pose_target_cmds", 10)

    def say():
        pose.header.stamp = client.stamp()
        publisher.publish(pose)

    client.node.create_timer(0.02, say)
    client.until(lambda: np.abs(rover.fk(robot.theta) - goal).max() < 1e-3)


def test_shares_of_a_speed(client, robot, stick, start, rover):
    start(command_in_type="unitless", scale_linear=0.06)
    client.until(lambda: robot.told, LATEST)
    stick.linear = (0.0, 0.0, 0.5)
    client.until(lambda: robot.moves)
    client.during(1.0)
    point = robot.told[-1].points[0]
    np.testing.assert_allclose((rover.hybrid_jacobian(point.positions) @ point.velocities)[:3], UP, atol=2e-3)
    stick.linear = (0.0, 0.0, 1.5)
    client.until(lambda: not robot.moves and "from -1 to 1" in client.status[1])


@pytest.mark.parametrize("jump", [-500.0, 30.0])
def test_a_simulation_that_is_set_back_or_jumps_stops_the_arm_and_goes_on(client, robot, stick, start, rover, jump):
    start(use_sim_time="true")
    client.until(lambda: robot.told, LATEST)
    stick.linear = UP
    client.until(lambda: robot.moves)
    stick.linear, client.ahead = None, jump
    client.until(lambda: not robot.moves)
    client.during(0.5)
    stick.linear = UP
    client.until(lambda: robot.moves)
    rates = np.array([message.points[0].velocities for message in robot.told])
    assert (np.abs(np.diff(rates, axis=0)) <= rover.limits.acceleration * 0.05).all()


@pytest.mark.parametrize("hold", ["''", "position"])
def test_a_joystick_moves_what_is_not_held_while_its_button_is(client, robot, start, hold):
    axes, rest, scale = "[-1, -1, 1, -1, -1, -1]", "[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]", "[0.1, 0.1, -0.1, 0.5, 0.5, 0.5]"
    start(frame="base", hold=hold, joy_axes=axes, joy_rest=rest, joy_scale=scale, joy_dead_man=0)
    client.until(lambda: robot.told, LATEST)
    said = Joy(axes=[0.0, 1.0], buttons=[0])
    publisher = client.node.create_publisher(Joy, "/joy", 10)

    def say():
        said.header.stamp = client.stamp()
        publisher.publish(said)

    client.node.create_timer(0.02, say)
    client.during(0.5)
    said.axes, said.buttons = [0.0, -1.0], [1]
    if hold == "position":
        client.during(0.5)
        assert not robot.moves
        assert "refused" not in client.status[1]
        return
    client.until(lambda: robot.moves)
    said.buttons = [0]
    client.until(lambda: not robot.moves)


@pytest.mark.usefixtures("driven")
def test_services_stop_and_enable_a_held_stick(client, robot, stick):
    def ask(name):
        answer = client.call(Trigger, f"/servo_node/{name}")
        return answer.success, answer.message

    stick.linear = UP
    client.until(lambda: robot.moves)
    assert ask("stop")[0]
    client.until(lambda: not robot.moves)
    assert ask("enable")[0]
    client.during(0.5)
    assert not robot.moves  # the stick is held since before
    stick.linear = (0.0, 0.0, 0.0)
    client.during(0.2)
    stick.linear = UP
    client.until(lambda: robot.moves)
    ask("emergency_stop")
    client.until(lambda: not robot.moves)
    assert ask("enable") == (False, "emergency stop: the service emergency_stop was called")
    assert ask("clear")[0]
    assert ask("enable")[0]
    assert client.call(SetBool, "/servo_node/pause_servo", data=True).success
    client.until(lambda: client.status[2]["interlock"] != "enabled")


@pytest.mark.usefixtures("driven")
def test_parameters_are_described_and_two_of_them_are_set(client):
    def set_to(name, value):
        asked = [Parameter(name, value=value).to_parameter_msg()]
        (result,) = client.call(SetParameters, "/servo_node/set_parameters", parameters=asked).results
        return result

    assert set_to("frame", "base").successful
    assert set_to("hold", "orientation").successful
    client.until(lambda: (client.status[2]["frame"], client.status[2]["hold"]) == ("base", "orientation"))
    refused = set_to("frame", "world")
    assert not refused.successful
    assert "frame must be" in refused.reason
    assert not set_to("rate", 50.0).successful
    (told,) = client.call(GetParameters, "/servo_node/get_parameters", names=["rate"]).values
    assert told.double_value == 100.0
    (described,) = client.call(DescribeParameters, "/servo_node/describe_parameters", names=["rate"]).descriptors
    assert described.read_only
    assert "Hz" in described.description


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_brings_a_moving_arm_to_rest_and_ends_the_node(client, robot, stick, driven, number, rover):
    stick.linear = UP
    client.until(lambda: robot.moves)
    driven.send_signal(number)
    client.until(lambda: driven.poll() is not None)
    client.during(0.2)
    assert driven.returncode == 0
    rates = np.array([message.points[0].velocities for message in robot.told])
    assert not rates[-1].any()
    assert (np.abs(np.diff(rates[-20:], axis=0)) <= rover.limits.acceleration * 0.05).all()


def test_an_arm_that_strays_ends_the_node_with_1(client, robot, stick, start):
    process = start(tolerance=0.02)
    client.until(lambda: robot.told, LATEST)
    robot.stands = True
    stick.linear = UP
    client.until(lambda: process.poll() is not None)
    assert process.returncode == 1
    assert not robot.moves
    assert "the arm is not where it was commanded to be" in process.communicate(timeout=SOON)[1]


@pytest.mark.parametrize(
    ("parameters", "why"),
    [
        ({"command_out_type": "torque"}, "command_out_type must be one of trajectory_msgs"),
        ({"hold": "breath"}, "hold must be"),
        ({"rate": 100}, "DOUBLE"),
        ({"joy_axes": "[0, -1, -1, -1, -1, -1]"}, "joy_rest must say"),
        ({"command_out_topic": "'arm commands'"}, "Invalid topic name"),
        ({"description": "''", "robot_description": "<robot/>"}, "robot"),
    ],
)
def test_parameters_that_cannot_be_end_it_in_one_line(start, parameters, why):
    process = start(**parameters)
    _, error = process.communicate(timeout=LATEST)
    assert process.returncode == 1
    assert why in error.strip().splitlines()[-1]
    assert "Traceback" not in error


def test_the_description_comes_by_its_latched_topic(client, robot, start, rover):
    latched = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.node.create_publisher(String, "/robot_description", latched).publish(String(data=rover.description.text))
    start(description="''", tip="tool0")
    client.until(lambda: robot.told, LATEST)
    assert list(robot.told[0].joint_names) == list(rover.joint_names)


def test_the_file_of_parameters_to_copy_starts_a_node(client, start):
    robot = Robot(client, "/arm_controller/joint_trajectory")
    start("--params-file", str(CONFIG))
    client.until(lambda: robot.told, LATEST)
    names = set(client.call(ListParameters, "/servo_node/list_parameters").result.names)
    (given,) = yaml.safe_load(CONFIG.read_text("utf-8")).values()
    assert given["ros__parameters"].keys() <= names


def test_arrays_hold_velocities_for_a_controller_of_rates(client, robot, stick, start, rover):
    told = []
    client.node.create_subscription(Float64MultiArray, "/rates", lambda message: told.append(list(message.data)), 10)
    how = {"command_out_type": "std_msgs/Float64MultiArray", "publish_joint_positions": "false"}
    start(command_out_topic="/rates", **how)
    client.until(lambda: told, LATEST)
    stick.linear = UP
    client.until(lambda: np.abs(told[-1]).max() > 0.005)
    assert len(told[-1]) == rover.n


def test_two_nodes_beside_each_other_drive_an_arm_each(client, robot, stick, start):
    other = Robot(client, "/left/servo_node/commands", "/left/joint_states")
    start()
    start("-r", "__ns:=/left", joint_topic="joint_states", diagnostics_topic="diagnostics")
    client.until(lambda: robot.told and other.told, LATEST)
    stick.linear = UP
    client.until(lambda: robot.moves)
    client.during(0.3)
    assert not any(any(message.points[0].velocities) for message in other.told)
    stick.linear, left = None, Stick(client, "/left/servo_node/delta_twist_cmds")
    left.linear = UP
    client.until(lambda: other.moves and not robot.moves)


def test_two_publishers_of_one_topic_move_nothing(client, robot, stick, driven):
    second = Stick(client)
    stick.linear = second.linear = UP
    client.until(lambda: "2 publishers command on" in client.status[1], SOON)
    assert not robot.moves
    assert driven.poll() is None
