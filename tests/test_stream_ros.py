"""What ROS messages mean, and the example node, without ROS."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import ros_stand_ins as msg
from stream_stand_ins import FakeClock, answer
from twistarm.errors import InputError
from twistarm.servo import ServoStatus
from twistarm.stream import Cycle, Ending, Setpoint, ros
from twistarm.stream.report import Tally

FILE = Path(__file__).parents[1] / "examples" / "ros2" / "servo_node.py"


def test_a_joint_state_by_name(rover):
    names = ["gripper", *reversed(rover.joint_names), "wheel"]
    theta = ros.theta_of(rover, msg.JointState(name=names, position=[9.0, 5.0, 4.0, 3.0, 2.0, 1.0, 9.0]))
    assert theta.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]


@pytest.mark.parametrize(
    ("names", "position", "why"),
    [
        (["slide"], [0.0], "lacks 'shoulder'"),
        (["slide", "shoulder"], [0.0], "2 names, 1 values"),
        (["slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"], [0.0, np.nan, 0.0, 0.0, 0.0], "finite"),
    ],
)
def test_a_joint_state_that_is_none(rover, names, position, why):
    with pytest.raises(InputError, match=why):
        ros.theta_of(rover, msg.JointState(name=names, position=position))


def test_a_twist_in_the_frame_of_its_header(rover):
    message = msg.TwistStamped(twist=msg.Twist(msg.Vector(1.0, 2.0, 3.0), msg.Vector(4.0, 5.0, 6.0)))
    for frame_id, frame in ((rover.base, "base"), (rover.tip, "tool")):
        command = ros.twist_of(rover, message.twist, ros.frame_of(rover, frame_id, "neither"))
        assert command.twist.tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
        assert command.frame == frame


@pytest.mark.parametrize("unsaid", ["tool", "base"])
def test_a_header_without_a_frame_means_the_parameters(rover, unsaid):
    assert ros.frame_of(rover, "", unsaid) == unsaid


@pytest.mark.parametrize("frame_id", [" ", "world", "forearm"])
def test_another_frame_is_not_guessed_at(rover, frame_id):
    with pytest.raises(InputError, match=f"'base_link' .base. or 'tool0' .tool.; got frame_id '{frame_id}'"):
        ros.frame_of(rover, frame_id, "tool")


def test_stamps_are_numbers_that_increase():
    assert ros.number_of(msg.Stamp()) is None
    assert ros.number_of(msg.Stamp(1, 999_999_999)) < ros.number_of(msg.Stamp(2, 0))
    assert ros.number_of(msg.Stamp(2**31 - 1, 0)) == (2**31 - 1) * 10**9


MAPPING = ros.JoyMapping([1, 0, 4, -1, -1, 3], [0.1, 0.1, -0.2, 0.5, 0.5, 0.5], dead_man=5, deadband=0.1)


def test_a_joystick_moves_the_tool_while_its_dead_mans_button_is_held():
    pressed, released = [0, 0, 0, 0, 0, 1], [1, 1, 1, 1, 1, 0]
    axes = [0.55, 1.0, 0.0, -1.0, 0.1, 0.0]
    command = MAPPING.command(msg.Joy(axes, pressed))
    # (0.55 − 0.1) / 0.9 = 0.5; 0.1 is inside the deadband; full deflections stay full.
    assert command.twist == pytest.approx([0.1, 0.05, 0.0, 0.0, 0.0, -0.5])
    assert command.frame == "tool"
    assert MAPPING.command(msg.Joy(axes, released)) is None


def test_a_joystick_without_the_axis_is_named():
    with pytest.raises(InputError, match="has 2 axes and 6 buttons; the mapping asks for axis 4 and button 5"):
        MAPPING.command(msg.Joy([0.0, 0.0], [0] * 6))


def test_a_joystick_that_says_nan_is_refused():
    with pytest.raises(InputError, match="finite"):
        MAPPING.command(msg.Joy([np.nan] * 6, [1] * 6))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"axes": [0, 1]}, "six axes"),
        ({"axes": [0, 1, 2, 3, 4, -2]}, "six axes"),
        ({"dead_man": -1}, "dead man's button"),
        ({"deadband": 1.0}, "deadband"),
        ({"frame": "world"}, "frame must be"),
        ({"scale": [1.0]}, "scale must have shape"),
    ],
)
def test_a_mapping_that_cannot_be(changes, why):
    with pytest.raises(InputError, match=why):
        ros.JoyMapping(**({"axes": [0, 1, 2, 3, 4, 5], "scale": [1.0] * 6, "dead_man": 0} | changes))


def test_a_trajectorys_point_lies_ahead(rover):
    setpoint = Setpoint(0, 1.0, np.arange(5.0), np.ones(5), answer(np.ones(5)))
    point = ros.trajectory_point(setpoint, 1.02)
    assert point == ([0.0, 1.0, 2.0, 3.0, 4.0], 1, 20_000_000)
    with pytest.raises(InputError, match="ahead"):
        ros.trajectory_point(setpoint, 0.0)


def test_diagnostics():
    def cycle(output, theta=np.zeros(5), **more):  # noqa: B008
        setpoint = None if output is None else Setpoint(0, 1.0, np.zeros(5), output.theta_dot, output)
        return Cycle(1.0, None, theta, setpoint, **more)

    tally = Tally(100.0)
    assert ros.diagnosis_of(cycle(answer(np.zeros(5))), tally).level == b"\x00"
    slowed = answer(np.zeros(5), ServoStatus.SLOWED_LIMIT, 0.5, "elbow", "slowed by elbow")
    level, text, values = ros.diagnosis_of(cycle(slowed), tally)
    assert (level, text, values["joint"], values["scale"]) == (b"\x01", "slowed by elbow", "elbow", "0.500")
    assert ros.diagnosis_of(cycle(None, None, reason="no joint state has arrived"), tally)[:2] == (
        b"\x02", "no joint state has arrived",
    )  # fmt: skip
    strayed = ros.diagnosis_of(cycle(slowed, reason="elbow is away", ending=Ending.STRAYED), tally)
    assert strayed.level == b"\x02"
    assert "elbow is away" in strayed.message
    assert all(isinstance(value, str) for value in strayed.values.values())


# -- the node ------------------------------------------------------------------------------------------------------


class Drive:
    """Feeds the node's callbacks and timers for `cycles` real periods, then Ctrl-C."""

    def __init__(self, monkeypatch, cycles=20, **parameters):
        self.cycles, self.node = cycles, None
        self.joints, self.clock = True, None
        self.message = lambda node: None
        self.said = msg.install(monkeypatch, self.spin_once)
        monkeypatch.setattr(msg.Node, "parameters", parameters)
        self.module = runpy.run_path(str(FILE))

    def spin_once(self, node):
        if self.node is None and self.clock is not None:
            node.clock = self.clock
        self.node = node
        if self.cycles == 0:
            raise KeyboardInterrupt
        self.cycles -= 1
        if self.joints:
            names = list(reversed(node.arm.joint_names))
            state = msg.JointState(name=names, position=node.arm.ready[::-1].tolist())
            node.subscribed["joint_states"][1](state)
        self.message(node)
        node.clock.sleep_until(node.metronome.next)
        for _, callback in node.timers_:
            callback()

    def run(self):
        return self.module["main"]()


def stamped(node, frame_id):
    message = msg.TwistStamped(twist=msg.Twist(msg.Vector(z=0.05)))
    message.header.frame_id = frame_id
    node.subscribed["~/twist"][1](message)


def test_the_node_streams_rates_and_leaves_the_arm_at_rest(monkeypatch):
    drive = Drive(monkeypatch)
    drive.message = lambda node: stamped(node, "base_link")
    assert drive.run() == 0
    rates = np.array([message.data for message in drive.node.published["~/commands"]])
    assert np.abs(rates).max() > 0.01
    assert not rates[-1].any()
    assert drive.node.destroyed
    assert drive.said == ["init", "shutdown"]
    (status,) = drive.node.published["/diagnostics"][5].status
    assert status.level in (b"\x00", b"\x01")
    assert {value.key for value in status.values} >= {"status", "missed cycles"}


def test_the_node_takes_twists_of_tools_that_name_no_frame(monkeypatch):
    rates = []
    for frame_id, frame in (("", "base"), ("base_link", "tool"), ("", "tool")):
        drive = Drive(monkeypatch, cycles=8, frame=frame)
        drive.message, drive.clock = (lambda node, frame_id=frame_id: stamped(node, frame_id)), FakeClock()
        drive.run()
        rates.append(drive.node.published["~/commands"][4].data)
    assert rates[0] == rates[1]
    assert rates[0] != rates[2]  # z of the tool is not z of the base


def test_the_node_says_at_once_what_changes(monkeypatch):
    drive = Drive(monkeypatch, cycles=12)
    drive.message = lambda node: stamped(node, "base_link") if drive.cycles < 6 else None
    monkeypatch.setattr(
        msg.Node, "create_timer", lambda node, period, callback: period < 1 and node.timers_.append((period, callback))
    )
    drive.run()
    values = [{each.key: each.value for each in m.status[0].values} for m in drive.node.published["/diagnostics"]]
    assert [(each["status"], each["cycles"]) for each in values][:2] == [("STALE", "1"), ("OK", "7")]


def test_the_node_streams_trajectories(monkeypatch):
    drive = Drive(monkeypatch, output="trajectory", stamped=False)
    drive.message = lambda node: node.subscribed["~/twist"][1](msg.Twist(msg.Vector(z=0.05)))
    assert drive.run() == 0
    messages = drive.node.published["~/joint_trajectory"]
    assert messages[0].joint_names == list(drive.node.arm.joint_names)
    (point,) = messages[0].points
    assert len(point.positions) == 5
    assert point.time_from_start.nanosec == 20_000_000
    assert messages[5].points[0].positions != messages[-1].points[0].positions


def test_the_node_refuses_foreign_frames_and_two_publishers(monkeypatch):
    drive = Drive(monkeypatch, cycles=5)
    drive.message = lambda node: stamped(node, "world")
    drive.run()
    assert not np.array([message.data for message in drive.node.published["~/commands"]]).any()
    assert "got frame_id 'world'" in drive.node.last.reason

    drive = Drive(monkeypatch, cycles=5)
    monkeypatch.setattr(msg.Node, "publishers_of", {"~/twist": 2})
    drive.message = lambda node: stamped(node, "base_link")
    drive.run()
    assert "2 publishers command on ~/twist" in drive.node.last.reason


def test_the_node_stops_when_the_joysticks_button_is_let_go(monkeypatch):
    drive = Drive(monkeypatch, cycles=30)
    held = [0, 0, 0, 0, 1]
    drive.message = lambda node: node.subscribed["joy"][1](
        msg.Joy([0.0, 0.0, 0.0, 0.0, 1.0], held if drive.cycles > 20 else [0] * 5)
    )
    drive.run()
    rates = np.array([message.data for message in drive.node.published["~/commands"]])
    assert np.abs(rates).max() > 0.01
    assert not rates[25].any()


def test_the_node_moves_nothing_without_joint_states(monkeypatch):
    drive = Drive(monkeypatch, cycles=5)
    drive.joints = False
    drive.message = lambda node: stamped(node, "base_link")
    drive.run()
    assert drive.node.published["~/commands"] == []
    (status,) = drive.node.published["/diagnostics"][0].status
    assert (status.level, status.message) == (b"\x02", "no joint state has arrived")


def test_the_node_ends_with_1_when_the_arm_strays(monkeypatch):
    drive = Drive(monkeypatch, cycles=100, tolerance=1e-4)
    drive.message = lambda node: stamped(node, "base_link")
    assert drive.run() == 1
    assert "the arm is not where it was commanded to be" in drive.node.said[0]
    assert not any(drive.node.published["~/commands"][-1].data)


@pytest.mark.parametrize(
    ("parameters", "why"), [({"arm": "no_such_arm"}, "no_such_arm"), ({"output": "torque"}, "velocity, trajectory")]
)
def test_parameters_that_cannot_be_end_it_in_one_line(monkeypatch, parameters, why):
    drive = Drive(monkeypatch, **parameters)
    with pytest.raises(SystemExit, match=why):
        drive.run()
    assert drive.said[-1] == "shutdown"
