"""What ROS messages mean, without ROS; the node is in tests/ros."""

import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace as Message

import numpy as np
import pytest

from stream_stand_ins import answer
from twistarm.control.servo import ServoReason
from twistarm.control.stream import Cycle, Ending, Setpoint
from twistarm.control.stream.report import Tally
from twistarm.support.errors import InputError

sys.path.append(str(Path(__file__).parents[2] / "examples" / "ros2" / "twistarm_servo"))

from twistarm_servo import messages as ros
from twistarm_servo.joystick import JoyMapping, Joystick


def test_positions_that_are_not_finite_are_refused(rover):
    names = ["slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"]
    assert ros.positions_of(rover, Message(name=names, position=[])) == {}  # rates alone
    with pytest.raises(InputError, match="finite"):
        ros.positions_of(rover, Message(name=names, position=[0.0, np.nan, 0.0, 0.0, 0.0]))


def test_a_frame_is_the_base_s_the_tool_s_or_the_default(rover):
    assert ros.frame_of(rover, rover.base, "neither") == "base"
    assert ros.frame_of(rover, rover.tip, "neither") == "tool"
    assert ros.frame_of(rover, "", "tool") == "tool"
    with pytest.raises(InputError, match="got frame_id 'world'"):
        ros.frame_of(rover, "world", "tool")


def test_stamps_are_numbers_that_increase():
    assert ros.number_of(Message(sec=0, nanosec=0)) is None
    assert ros.number_of(Message(sec=1, nanosec=999_999_999)) < ros.number_of(Message(sec=2, nanosec=0))
    assert ros.number_of(Message(sec=2**31 - 1, nanosec=0)) == (2**31 - 1) * 10**9


@pytest.mark.parametrize(
    ("names", "fields", "why"),
    [
        (["elbow"], {"velocities": [0.1, 0.2]}, "1 names, 2 velocities"),
        (["elbow", "elbow"], {"velocities": [0.1, 0.2]}, "each joint once"),
        (["elbow"], {"displacements": [0.1]}, "got displacements"),
        ([], {}, "jog must be"),
        (["j9"], {"velocities": [0.1]}, "j9"),
    ],
)
def test_a_jog_that_is_none(rover, names, fields, why):
    with pytest.raises(InputError, match=why):
        ros.jog_of(rover, jog(names, **fields))


def jog(names, velocities=(), displacements=()):
    return Message(joint_names=names, velocities=velocities, displacements=displacements)


def test_a_jog_is_rates_or_shares_of_a_speed(rover):
    assert ros.jog_of(rover, jog(["elbow"], [0.2])).theta_dot.tolist() == [0.0, 0.0, 0.2, 0.0, 0.0]
    assert ros.jog_of(rover, jog(["elbow"], [0.5]), 0.4).theta_dot.tolist() == [0.0, 0.0, 0.2, 0.0, 0.0]


def test_a_pose_needs_the_base_and_a_rotation(rover):
    def pose(frame, w):
        position, orientation = Message(x=0.1, y=0.2, z=0.3), Message(x=0.0, y=0.0, z=0.0, w=w)
        return Message(header=Message(frame_id=frame), pose=Message(position=position, orientation=orientation))

    np.testing.assert_array_equal(ros.pose_of(rover, pose(rover.base, 1.0)).g[:3, 3], [0.1, 0.2, 0.3])
    for wrong, why in ((pose("world", 1.0), "got 'world'"), (pose(rover.base, 0.0), "length 1")):
        with pytest.raises(InputError, match=why):
            ros.pose_of(rover, wrong)


# A trigger that rests at 1 moves the tool up. What it says at 0.0, 0.1, … s: its axis, whether the button is held, and
# the speed, None or the reason. A message of None is a silence.
STEPS = {
    "at rest, pressed, let go": [(1.0, False, None), (1.0, True, 0.0), (-1.0, True, 0.1), (-1.0, False, None)],
    "never at rest": [(-1.0, False, None), (-1.0, True, "axis 1 reads -1, at rest 1"), (1.0, True, 0.0)],
    "held from the start": [(1.0, True, "let go of button 0"), (-1.0, True, "let go"), (1.0, False, None)],
    "unplugged: 0 of every axis": [(1.0, False, None), (1.0, True, 0.0), None, None, None, (0.0, True, "axis 1")],
}


@pytest.mark.parametrize("case", STEPS)
def test_a_joystick_counts_once_it_was_seen_at_rest(case):
    mapping = JoyMapping([-1, -1, 1, -1, -1, -1], [0, 0, 1, 0, 0, 0], [0.1, 0.1, -0.1, 0.5, 0.5, 0.5], 0.1, 0)
    joystick = Joystick(mapping, 0.2)
    for number, step in enumerate(STEPS[case]):
        if step is None:
            continue
        axis, held, expected = step
        message = Message(axes=[0.0, axis], buttons=[int(held)])
        if isinstance(expected, str):
            with pytest.raises(InputError, match=expected):
                joystick.twist(message, 0.1 * number)
        else:
            twist = joystick.twist(message, 0.1 * number)
            assert twist == (None if expected is None else [0.0, 0.0, expected, 0.0, 0.0, 0.0])


def test_a_trajectory_ends_at_rest_within_the_limits(rover):
    limits = rover.limits
    theta, rates = rover.ready.copy(), np.array([0.1, -0.5, 0.3, 0.2, 0.0])
    first, last = ros.trajectory_points(rover, Setpoint(0, 1.0, theta, rates, answer(rates)), 1.02)
    assert (first.positions, first.velocities) == (theta.tolist(), rates.tolist())
    assert (first.sec, first.nanosec) == (1, 20_000_000)
    braking = last.sec + last.nanosec * 1e-9 - 1.02
    assert braking == pytest.approx((np.abs(rates) / limits.acceleration).max(), abs=1e-8)
    # A cubic from (θ, θ̇) to rest after T, Δθ = θ̇ T / 2, is the parabola that brakes evenly: no joint beyond its limit.
    np.testing.assert_allclose(last.positions, theta + rates * braking / 2.0, atol=1e-8)
    assert last.velocities == [0.0] * 5


def test_an_arm_at_rest_is_one_point_and_a_limit_is_kept(rover):
    still = Setpoint(0, 1.0, rover.ready, np.zeros(5), answer(np.zeros(5)))
    assert len(ros.trajectory_points(rover, still, 0.02)) == 1
    at_limit = rover.ready.copy()
    at_limit[1] = rover.limits.upper[1] - 1e-3
    fast = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    _, last = ros.trajectory_points(rover, Setpoint(0, 1.0, at_limit, fast, answer(fast)), 0.02)
    assert last.positions[1] == rover.limits.upper[1]
    with pytest.raises(InputError, match="ahead"):
        ros.trajectory_points(rover, still, 0.0)
    free = replace(rover, limits=rover.limits.with_({"acceleration": np.inf}, rover.joint_names))
    _, last = ros.trajectory_points(free, Setpoint(0, 1.0, rover.ready, fast, answer(fast)), 1.0)
    assert last.sec + last.nanosec * 1e-9 - 1.0 == pytest.approx(1.0 / 3.0)  # along the usual 3 rad/s²


def test_diagnostics():
    def cycle(output, theta=np.zeros(5), **more):  # noqa: B008
        setpoint = None if output is None else Setpoint(0, 1.0, np.zeros(5), output.theta_dot, output)
        return Cycle(1.0, None, theta, setpoint, **more)

    tally = Tally(rate=100.0)
    assert ros.diagnosis_of(cycle(answer(np.zeros(5))), tally).level == b"\x00"
    slowed = answer(np.zeros(5), ServoReason.VELOCITY_LIMIT, 0.5, "elbow", "slowed by elbow")
    level, text, values = ros.diagnosis_of(cycle(slowed), tally)
    assert (level, text, values["joint"], values["scale"]) == (b"\x01", "slowed by elbow", "elbow", "0.500")
    assert ros.diagnosis_of(cycle(None, None, reason="no joint state has arrived"), tally)[:2] == (
        b"\x02", "no joint state has arrived",
    )  # fmt: skip
    strayed = ros.diagnosis_of(cycle(slowed, reason="elbow is away", ending=Ending.STRAYED), tally)
    assert strayed.level == b"\x02"
    assert "elbow is away" in strayed.message
    assert all(isinstance(value, str) for value in strayed.values.values())
