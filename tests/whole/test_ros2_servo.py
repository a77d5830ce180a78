"""The package twistarm_servo without ROS 2, on simulated time; on a real one it is tested in tests/ros."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

import ros_stand_ins as msg
import twistarm
from stream_stand_ins import FakeClock

PACKAGE = Path(__file__).parents[2] / "examples" / "ros2" / "twistarm_servo"

TWIST, JOG, POSE = "~/delta_twist_cmds", "~/delta_joint_cmds", "~/pose_target_cmds"
VELOCITIES = {"command_out_type": "std_msgs/Float64MultiArray", "publish_joint_positions": False}
PERIOD = 0.01


@pytest.fixture
def package(monkeypatch):
    """Imports a module of the package, and what it imports, anew: on the stand-ins of the moment."""
    monkeypatch.syspath_prepend(str(PACKAGE))

    def anew(name):
        for old in [old for old in sys.modules if old.split(".")[0] == "twistarm_servo"]:
            monkeypatch.delitem(sys.modules, old)
        return importlib.import_module(f"twistarm_servo.{name}")

    return anew


class Drive:
    """Spins the node for some cycles of simulated time, with joint states of an arm that follows; then Ctrl-C."""

    def __init__(self, monkeypatch, package, theta, cycles, each, joints, clock, parameters):
        msg.install(monkeypatch, self.spin_once)
        monkeypatch.setattr(msg.Node, "overrides", {**VELOCITIES, **parameters})
        node = package("node")
        self.clock = clock or FakeClock()  # the system's
        monkeypatch.setattr(node, "MonotonicClock", lambda: self.clock)
        self.node, self.cycle, self.cycles, self.theta = None, 0, cycles, theta.copy()
        self.each, self.joints = each or (lambda drive: None), joints or Drive.follow
        try:
            self.code = node.main()
        except SystemExit as ended:
            self.code = ended.code

    @property
    def now(self):
        return self.node.get_clock().seconds

    @property
    def arm(self):
        return self.node.streaming.arm

    @property
    def commands(self):
        return self.node.published["~/commands"]

    @property
    def rates(self):
        return np.array([message.data for message in self.commands]).reshape(-1, 5)

    @property
    def log(self):
        return [text for _, text in self.node.get_logger().said]

    def spin_once(self, node):
        self.node = node
        if self.cycle == self.cycles:
            raise KeyboardInterrupt
        self.cycle += 1
        node.get_clock().seconds += PERIOD
        self.clock.time += PERIOD
        if self.node.streaming is not None:
            self.joints(self)
        self.each(self)
        for period, callback in list(node.ticks):
            if period < 1.0 or self.cycle % round(period / PERIOD) == 0:
                callback()

    def follow(self):
        if len(self.commands):
            self.theta = self.theta + PERIOD * self.rates[-1]
        names = ["wheel", *reversed(self.arm.joint_names)]
        self.hear("/joint_states", msg.JointState(name=names, position=[7.0, *self.theta[::-1].tolist()]))

    def hear(self, topic, message, stamped=True):
        kind, callback = self.node.subscribed[topic]
        assert type(message) is kind
        if stamped and hasattr(message, "header"):
            message.header.stamp = self.node.get_clock().now().to_msg()
        callback(message)

    def twist(self, frame_id="base_link", **changes):
        fields = {"linear": msg.Vector3(z=0.05), **changes}
        self.hear(TWIST, msg.TwistStamped(header=msg.Header(frame_id=frame_id), twist=msg.Twist(**fields)))


@pytest.fixture(scope="module")
def baked(rover, tmp_path_factory):
    """The rover arm in a file that is read in no time."""
    return str(twistarm.bake(rover, tmp_path_factory.mktemp("baked") / "arm.json"))


@pytest.fixture
def drive(monkeypatch, package, rover, baked):
    """Drives for some cycles; `each(drive)` before each of them, `joints(drive)` in place of an arm that follows."""

    def driven(cycles, each=None, joints=None, clock=None, **parameters):
        parameters = {"description": baked, **parameters}
        return Drive(monkeypatch, package, rover.ready, cycles, each, joints, clock, parameters)

    return driven


@pytest.mark.parametrize(
    ("parameters", "speed"), [({}, 0.2), ({"command_in_type": "unitless", "scale_joint": 0.4}, 0.5)]
)
def test_jogs_move_the_arm_in_rates_or_shares(drive, parameters, speed):
    jog = msg.JointJog(joint_names=["elbow"], velocities=[speed])
    it = drive(30, lambda it: it.hear(JOG, jog), **parameters)
    assert it.rates[28] == pytest.approx([0.0, 0.0, 0.2, 0.0, 0.0], abs=1e-3)


def test_poses_move_the_arm(drive, rover):
    x, y, z = rover.fk("ready")[:3, 3].tolist()
    at = msg.Pose(position=msg.Vector3(x=x, y=y, z=z + 0.02), orientation=msg.Quaternion(w=1.0))
    pose = msg.PoseStamped(header=msg.Header(frame_id="base_link"), pose=at)
    it = drive(20, lambda it: it.hear(POSE, pose))
    assert np.abs(it.rates).max() > 0.01


NONSENSE = {
    "a foreign frame": (lambda it: it.twist("world"), "got frame_id 'world'"),
    "NaN": (lambda it: it.twist(linear=msg.Vector3(x=np.nan)), "finite"),
    "another arm's joint": (lambda it: it.hear(JOG, msg.JointJog(joint_names=["j9"], velocities=[0.1])), "j9"),
    "no rotation": (lambda it: it.hear(POSE, msg.PoseStamped(header=msg.Header(frame_id="base_link"))), "length 1"),
    "a stamp of the future": (
        lambda it: it.hear(TWIST, msg.TwistStamped(header=msg.Header(stamp=msg.Time(sec=2000))), stamped=False),
        "use_sim_time"),
    "a stamp of the past": (
        lambda it: it.hear(TWIST, msg.TwistStamped(header=msg.Header(stamp=msg.Time(sec=900))), stamped=False),
        "s old"),
}  # fmt: skip


@pytest.mark.parametrize("nonsense", NONSENSE)
def test_nonsense_stops_a_moving_arm_and_is_said(drive, nonsense):
    say, why = NONSENSE[nonsense]
    it = drive(60, lambda it: it.twist() if it.cycle <= 20 else say(it))
    assert np.abs(it.rates[19]).max() > 0.01
    assert not it.rates[55].any()
    assert any(why in text for text in it.log), it.log


@pytest.mark.parametrize("position", [[np.nan] * 5, []])
def test_a_joint_state_that_is_none_stops_a_moving_arm(drive, position):
    def joints(it):
        if it.cycle <= 20:
            it.follow()
            return
        it.hear("/joint_states", msg.JointState(name=list(it.arm.joint_names), position=position))

    it = drive(80, Drive.twist, joints)
    assert np.abs(it.rates[19]).max() > 0.01
    assert not it.rates[75].any()


def test_joint_states_in_parts_are_merged(drive):
    """A message for each joint, and wheels that have another clock, fail, and tell of themselves twice."""

    def joints(it):
        other_clock = msg.Header(stamp=msg.Time(sec=90_000))
        wheels = msg.JointState(header=other_clock, name=["wheel", "wheel"], position=[np.nan])
        it.hear("/joint_states", wheels, stamped=False)
        if len(it.commands):
            it.theta = it.theta + PERIOD * it.rates[-1]
        for name, value in zip(it.arm.joint_names, it.theta.tolist(), strict=True):
            it.hear("/joint_states", msg.JointState(name=[name, "fan"], position=[value, 1.0]))
        it.hear("/joint_states", msg.JointState(name=list(it.arm.joint_names), velocity=[0.0] * it.arm.n))

    it = drive(30, Drive.twist, joints)
    assert np.abs(it.rates[28]).max() > 0.01


@pytest.mark.parametrize("jump", [-500.0, 30.0])
def test_a_simulation_that_is_set_back_or_jumps_stops_the_arm_and_goes_on(drive, jump):
    def each(it):
        if it.cycle == 20:
            it.node.get_clock().seconds += jump
        if it.cycle < 20 or it.cycle > 60:
            it.twist()

    it = drive(90, each)
    assert it.code == 0
    assert np.abs(np.diff(it.rates, axis=0)).max() <= it.arm.limits.acceleration.max() * PERIOD * 1.001
    assert not it.rates[55].any()
    assert np.abs(it.rates[80]).max() > 0.01


@pytest.mark.parametrize(
    ("system", "late"), [(999.99, {1: 0.0004, 2: 0.03, 4: 0.2}), (1000.05, {}), (1e6, {1: 0.0004, 4: 0.2})]
)
def test_no_step_to_rest_is_over_more_time_than_passed(drive, system, late):
    """The node drives on the simulation's clock, from 1000 s on, and comes to rest on the system's."""
    told = []

    def each(it):
        it.twist()
        if not told:
            sink, told[:] = it.node.streaming.sink, [(it.clock.now(), np.zeros(5))]
            write = sink.write
            sink.write = lambda setpoint: (told.append((it.clock.now(), setpoint.theta_dot)), write(setpoint))

    it = drive(20, each, clock=FakeClock(system, late))
    times, rates = map(np.array, zip(*told[1:], strict=True))
    assert np.abs(rates[18]).max() > 0.01
    assert not rates[-1].any()
    assert (np.abs(np.diff(rates, axis=0)) <= np.outer(np.diff(times), it.arm.limits.acceleration) + 1e-12).all()


# -- a joystick ----------------------------------------------------------------------------------------------------

STICK_AND_TRIGGER = {
    "frame": "base",
    "joy_axes": [-1, -1, 1, -1, -1, -1],
    "joy_rest": [0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    "joy_scale": [0.1, 0.1, -0.1, 0.5, 0.5, 0.5],
    "joy_dead_man": 0,
}


def joystick(it, trigger, held):
    it.hear("joy", msg.Joy(axes=[0.0, trigger], buttons=[int(held)]))


def test_a_trigger_at_rest_moves_nothing_and_pressed_it_does(drive):
    it = drive(40, lambda it: joystick(it, 1.0 if it.cycle < 20 else -1.0, held=it.cycle > 5), **STICK_AND_TRIGGER)
    assert not it.rates[:18].any()
    assert it.arm.fk(it.theta)[2, 3] > it.arm.fk("ready")[2, 3] + 0.003


@pytest.mark.parametrize(
    ("trigger", "held", "why"),
    [
        (lambda cycle: -1.0, lambda cycle: cycle > 5, "axis 1 reads -1, at rest 1"),
        (lambda cycle: 1.0 if cycle < 10 else -1.0, lambda cycle: True, "let go of button 0"),
    ],
)
def test_a_joystick_that_was_never_seen_at_rest_moves_nothing(drive, trigger, held, why):
    it = drive(40, lambda it: joystick(it, trigger(it.cycle), held(it.cycle)), **STICK_AND_TRIGGER)
    assert not it.rates.any()
    assert any(why in text for text in it.log)


def test_a_joystick_that_was_silent_is_asked_again(drive):
    """It may have been unplugged: the driver says 0 of every axis then, half pressed for a trigger."""

    def each(it):
        if it.cycle < 20 or it.cycle > 60:
            joystick(it, 1.0 if it.cycle < 10 else 0.0, held=it.cycle > 5)

    it = drive(80, each, **STICK_AND_TRIGGER)
    assert np.abs(it.rates[18]).max() > 0.001
    assert not it.rates[60:].any()


def test_the_button_let_go_stops_at_once_and_what_is_held_is_not_moved(drive):
    def each(it):
        joystick(it, 1.0 if it.cycle < 10 else -1.0, held=5 < it.cycle < 30)

    it = drive(50, each, **STICK_AND_TRIGGER, hold="position")
    assert not it.rates.any()
    assert not any("refused" in text for text in it.log)
    it = drive(50, each, **STICK_AND_TRIGGER)
    assert np.abs(it.rates[28]).max() > 0.001
    assert not it.rates[45].any()


# -- the package's files -------------------------------------------------------------------------------------------


def test_the_yaml_names_parameters_and_gives_values_of_their_types(package, monkeypatch):
    msg.install(monkeypatch, lambda node: None)
    parameters = package("parameters")
    (given,) = yaml.safe_load((PACKAGE / "config" / "servo.yaml").read_text("utf-8")).values()
    monkeypatch.setattr(msg.Node, "overrides", given["ros__parameters"])
    assert given["ros__parameters"].keys() <= vars(parameters.declared(msg.Node("servo_node"))).keys()
