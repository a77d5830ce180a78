"""Messages mean exactly what they say, or are refused in one line."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stream_stand_ins import answer
from twistarm.control.servo import JogCommand, PoseCommand, ServoReason, TwistCommand
from twistarm.control.stream import Setpoint, command_of, parse_command, parse_state, setpoint_message
from twistarm.support.errors import InputError
from twistarm.support.strict_json import LARGEST_MESSAGE, decoded, encode

TWIST = [0.1, 0.0, -0.05, 0.0, 0.2, 0.0]


def test_a_twist_with_held_components(rover):
    message = {"twist": [0.1, 0, 0, 0, 0, 0], "frame": "base", "hold": "orientation"}
    command, number = parse_command(rover, json.dumps(message | {"number": 4}))
    assert isinstance(command, TwistCommand)
    assert (command.twist.tolist(), command.frame, number) == ([0.1, 0, 0, 0, 0, 0], "base", 4)
    assert command.held == (False, False, False, True, True, True)
    command = command_of(rover, message | {"hold": [False, True, False, False, False, True]})
    assert command.held == (False, True, False, False, False, True)
    assert not any(command_of(rover, {"twist": TWIST, "frame": "tool"}).held)


@pytest.mark.parametrize(
    ("message", "rates"), [({"jog": {"elbow": 0.3, "slide": -0.1}}, [-0.1, 0, 0.3, 0, 0]), ({"stop": True}, [0] * 5)]
)
def test_a_jog_by_name_and_a_stop_which_is_one_of_nothing(rover, message, rates):
    command, number = parse_command(rover, json.dumps(message).encode())
    assert isinstance(command, JogCommand)
    assert (command.theta_dot.tolist(), number) == (rates, None)


def test_a_pose_both_ways(rover):
    R = Rotation.from_euler("xyz", [0.3, -0.8, 2.0])
    x, y, z, w = R.as_quat()
    parts = {"position": [0.5, 0.1, 0.4], "quaternion_wxyz": [w, x, y, z]}
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R.as_matrix(), parts["position"]
    for pose in (parts, g.tolist()):
        command = parse_command(rover, json.dumps({"pose": pose, "linear_speed": 0.05})).command
        assert isinstance(command, PoseCommand)
        assert np.allclose(command.g, g, rtol=0, atol=1e-15)
        assert command.linear_speed == 0.05


BAD = {
    "": "object",
    '{"stop": true} {"stop": true}': "object",
    "[" * 50_000: "object",
    "{}": "'twist', 'jog', 'pose', 'stop'",
    '{"twist": [0,0,0,0,0,0]}': "needs 'frame'",
    '{"twist": [0,0,0,0,0,0], "frame": "tool", "frame": "base"}': "each name once",
    '{"twist": [0,0,0,0,0,0], "frame": "world"}': "'tool' or 'base'",
    '{"twist": [0,0,0,0,0,0], "frame": "tool", "hold": "nothing"}': "hold",
    '{"twist": [0,0,0,1,0,0], "frame": "tool", "hold": "orientation"}': "held component",
    '{"jog": {}}': "jog",
    '{"jog": {"elbo": 1}}': "closest: 'elbow'",
    '{"pose": [[1,0,0,0],[0,1,0,0],[0,0,1],[0,0,0,1]]}': r"pose\[2\]",
    '{"pose": [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}': "not in SO",
    '{"pose": {"position": [0,0,0]}}': "needs 'quaternion_wxyz'",
    '{"pose": {"position": [0,0,0], "quaternion_wxyz": [0,0,0,0]}}': "length 1",
    '{"pose": {"position": [0,0,0], "quaternion_wxyz": [1,0,0,0]}, "linear_speed": 0}': "linear_speed",
    '{"interlock": "go"}': "'emergency stop'",
    '{"interlock": "enable", "stop": true}': "'interlock'",
    '{"stop": false}': "stop",
}


NO_TEXT = [b"\xff\xfe\x00{", '{"stop": true}'.encode("utf-16"), b" " * (LARGEST_MESSAGE + 1)]


@pytest.mark.parametrize(("text", "why"), [*BAD.items(), *zip(NO_TEXT, ("object", "object", "65537"), strict=True)])
def test_what_is_not_exactly_a_command_is_refused_in_one_line(rover, text, why):
    for message in (text, text.encode() if isinstance(text, str) else text):
        with pytest.raises(InputError, match=why) as caught:
            parse_command(rover, message)
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) < 1000


def test_a_joint_state_by_name_in_any_order(rover):
    names = ["gripper", *reversed(rover.joint_names)]
    values, number, _ = parse_state(rover, json.dumps({"joint_names": names, "theta": [9, 5, 4, 3, 2, 1], "number": 3}))
    assert [values[name] for name in rover.joint_names] == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert number == 3


NAMES = ["slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll"]
BAD_STATES = [
    ({"theta": [1, 2, 3, 4, 5]}, "needs 'joint_names'"),
    ({"joint_names": NAMES, "theta": [1, 2, 3, 4]}, "4 values"),
    ({"joint_names": [*NAMES, "elbow"], "theta": [1, 2, 3, 4, 5, 6]}, "twice: 'elbow'"),
    ({"joint_names": [1, 2, 3, 4, 5], "theta": [1, 2, 3, 4, 5]}, r"joint_names\[0\]"),
    ({"joint_names": NAMES, "theta": [1, 2, None, 4, 5]}, r"theta\[2\]"),
    ({"joint_names": NAMES, "theta": [1, 2, 3, 4, 5], "velocity": []}, "'velocity'"),
    ({"joint_names": NAMES, "theta": [1, 2, 3, 4, 5], "interlock": "off"}, "interlock"),
]


@pytest.mark.parametrize(("message", "why"), BAD_STATES, ids=[why for _, why in BAD_STATES])
def test_what_is_no_joint_state_is_refused(rover, message, why):
    with pytest.raises(InputError, match=why):
        parse_state(rover, json.dumps(message))


def test_a_setpoint_goes_out_as_documented(rover):
    output = answer(np.full(5, 0.25), ServoReason.SINGULARITY, 0.5, "elbow", "in words")
    message = decoded(encode(setpoint_message(rover, Setpoint(8, 1.5, np.arange(5.0), output.theta_dot, output))))
    assert message == {
        "number": 8,
        "time": 1.5,
        "joint_names": NAMES,
        "theta": [0.0, 1.0, 2.0, 3.0, 4.0],
        "theta_dot": [0.25] * 5,
        "status": "SLOWED_SINGULARITY",
        "joint": "elbow",
        "scale": 0.5,
        "reason": "SINGULARITY",
        "interlock": "enabled",
    }
