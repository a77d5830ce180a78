"""Wrong kinds of argument at every public door: a value or a TwistarmError, never an error of Python's own."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import twistarm
from catalogue import load
from stream_stand_ins import Says
from twistarm import joints, poe, rotations, screws, stream
from twistarm.wiring import read_log

ARM, OTHER = load("rover_arm"), load("ur5")
G = ARM.fk(ARM.ready)
STATE = twistarm.ServoState.at(ARM, ARM.ready)
MOTION = twistarm.plan_joint(ARM, ["ready", "stowed"])
SOLUTION = twistarm.solve_ik(ARM, G)
SIMULATED = stream.SimulatedJoints(ARM, ARM.ready)

STOPPED = stream.FollowControl()
STOPPED.stop()
MOTORS = {
    "names": ("a", "b"),
    "joint_names": ("j", "k"),
    "G": np.eye(2),
    "offset": np.zeros(2),
    "units": ("rad", "rad"),
    "ticks_per_turn": np.full(2, np.nan),
}
DRIVES = twistarm.Actuators(**MOTORS)


class Nameless:
    """An object whose own words and conversions fail."""

    def __repr__(self) -> str:
        raise RuntimeError

    def __array__(self, *_: object, **__: object) -> Any:
        raise RuntimeError


NONSENSE: dict[str, Any] = {
    "None": None,
    "a text": "banana",
    "bytes": b"x",
    "a number": 7,
    "an integer beyond float64": 10**400,
    "NaN": float("nan"),
    "a complex number": 1j,
    "a list of wrong length": [1.0, 2.0],
    "a ragged list": [[1.0], [1.0, 2.0]],
    "NaNs": [float("nan")] * 5,
    "texts": ["a", "b"],
    "a dict": {"a": 1.0},
    "a dict of numbers": {1: 2.0},
    "another arm": OTHER,
    "another arm's theta": OTHER.ready,
    "a path": Path("nowhere/x"),
    "a 0-d array": np.array(3.0),
    "an array of objects": np.array([object()], dtype=object),
    "many rows": np.zeros((2, 3, 4)),
    "no rows": np.zeros((0, 5)),
    "a set": {1, 2},
    "a class": twistarm.Arm,
    "an object": object(),
    "one without words": Nameless(),
    "a motion": MOTION,
    "no name of a file": "a\0b",
}

OF_POE = {"screws": ARM.screws, "body_screws": ARM.body_screws, "home": ARM.home, "x": ARM.ready}

GOOD: dict[str, Any] = OF_POE | {
    "axis": [0, 0, 1.0], "point": [0, 0, 0.1], "pitch": 0.1, "normal": [0, 0, 1.0], "x_axis": None, "axes": None,
    "w": [0, 0, 1.0], "theta": 0.3, "R": G[:3, :3], "A": G[:3, :3], "R1": G[:3, :3], "R2": G[:3, :3], "angle": 0.2,
    "Q": [1.0, 0, 0, 0], "P": [1.0, 0, 0, 0], "order": "xyz", "angles": [0.1, 0.2, 0.3], "rpy": [0.1, 0.2, 0.3],
    "xi": [0, 0, 0, 0, 0, 1.0], "g": G, "a": [0, 0, 0, 0, 0, 1.0], "b": [0, 0, 0, 0, 0, 1.0], "V": [0, 0, 0, 0, 0, 1.0],
    "twists": None, "matrix": np.zeros((4, 4)), "g_ab": G, "xi_b": [0.0] * 6, "F_b": [0.0] * 6,
}  # fmt: skip
"""What the functions of theory take, by the names of their arguments."""

UNCHECKED = {"cross", "split", "log_of", "adjoint_of", "inverse_of", "columns", "motions"}
"""For inner loops, whose callers have checked."""


def of_theory() -> Iterator[tuple[str, Callable[..., Any], dict[str, Any]]]:
    for module in (rotations, screws, joints, poe):
        for name, function in inspect.getmembers(module, inspect.isfunction):
            if not name.startswith("_") and name not in UNCHECKED and function.__module__ == module.__name__:
                known = [n for n in inspect.signature(function).parameters if n in GOOD]
                yield f"{module.__name__}.{name}", function, {n: GOOD[n] for n in known}


def of_the_builder() -> Iterator[tuple[str, Callable[..., Any], dict[str, Any]]]:
    builder = twistarm.ArmBuilder("x")
    limits = {"lower": -1.0, "upper": 1.0, "velocity": 1.0, "effort": 1.0}
    for name in ("revolute", "prismatic", "helical", "cylindrical", "spherical", "planar"):
        known = {"name": "j"} | GOOD | limits
        taken = inspect.signature(getattr(builder, name)).parameters
        yield name, getattr(builder, name), {n: known[n] for n in taken if n in known}
    yield "tool", builder.tool, {"home": np.eye(4), "name": "tool"}


def of_the_drives() -> Iterator[tuple[str, Callable[..., Any], dict[str, Any]]]:
    for name in ("to_motor", "to_theta", "velocity_to_motor", "velocity_to_theta", "torque_to_motor", "torque_to_theta",
                 "to_counts", "from_counts"):  # fmt: skip
        method = getattr(DRIVES, name)
        yield name, method, {n: np.zeros(2) for n in inspect.signature(method).parameters}
    yield "motion_limits", DRIVES.motion_limits, {"joints": None}


IK = {"arm": ARM, "theta0": None, "position_tol": 1e-6, "orientation_tol": 1e-6, "restarts": 2, "max_time": None,
      "rng": 0, "posture": None}  # fmt: skip
ALL = {"arm": ARM, "theta0": None, "given": None, "samples": 2, "copies": False, "position_tol": 1e-9,
       "orientation_tol": 1e-9}  # fmt: skip
LOADED = {"base": None, "tip": None, "package_dirs": (), "xacro_args": None, "limits": None, "locked": None,
          "srdf": None, "without": ()}  # fmt: skip
SETTINGS = twistarm.ServoSettings()
MOVE = {"blend": 0.0, "speed": 1.0, "tool_speed": None, "turn_speed": None, "label": ""}

DOORS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "load_arm": (twistarm.load_arm, {"source": "rr_planar", **LOADED}),
    "arm_from_screws": (
        twistarm.arm_from_screws, {"screws": ARM.screws, "home": ARM.home, "joints": None, "limits": None},
    ),
    "crosscheck": (partial(twistarm.crosscheck, samples=1), {"arm": ARM}),
    "crosscheck samples": (partial(twistarm.crosscheck, "no arm"), {"samples": 1, "rng": 0}),
    "freeze": (twistarm.freeze, {"arm": ARM, "path": "golden.json"}),
    "compare": (twistarm.compare, {"arm": ARM, "against": "golden.json"}),
    "solve_ik": (twistarm.solve_ik, {"target": G, **IK}),
    "solve_ik_batch": (twistarm.solve_ik_batch, {"targets": [G], "threads": 1, **IK}),
    "solve_ik_all": (
        twistarm.solve_ik_all, {"target": G, "closed_form": False, "max_time": None, "progress": None, **ALL},
    ),
    "solve_ik_all_batch": (twistarm.solve_ik_all_batch, {"targets": [G], "threads": 1, **ALL}),
    "Pose": (twistarm.Pose, {"g": G}),
    "Pose.from_rpy": (twistarm.Pose.from_rpy, {"p": [0, 0, 1], "rpy": [0, 0, 1]}),
    "Pose.from_quaternion": (twistarm.Pose.from_quaternion, {"p": [0, 0, 1], "wxyz": None, "xyzw": [0, 0, 0, 1]}),
    "Position": (twistarm.Position, {"p": [0, 0, 1]}),
    "Approach": (twistarm.Approach, {"p": [0, 0, 1], "direction": [0, 0, 1], "tool_axis": None}),
    "Approach.of": (twistarm.Approach([0, 0, 1], [0, 0, 1]).of, {"arm": ARM}),
    "Task": (twistarm.Task, {"g": G, "tolerance": [0.0] * 6, "frame": "target"}),
    "plan_joint": (
        twistarm.plan_joint,
        {"arm": ARM, "waypoints": ["ready", "zero"], "kind": "cubic", "limits": None, "stop_at_waypoints": False,
         "times": None},
    ),
    "plan": (
        twistarm.plan,
        {"arm": ARM, "segments": [twistarm.Dwell(1.0)], "start": None, "limits": None, "kind": "s_curve",
         "tool_speed": None, "turn_speed": None},
    ),
    "JointMove": (twistarm.JointMove, {"to": "ready", **MOVE}),
    "LineMove": (twistarm.LineMove, {"to": G, **MOVE}),
    "LineMove.by": (twistarm.LineMove.by, {"offset": [0, 0, 0.1], "frame": "tool", "constrain": None, **MOVE}),
    "ScrewMove": (twistarm.ScrewMove, {"to": G, **MOVE}),
    "ScrewMove.about": (
        twistarm.ScrewMove.about,
        {"axis": [0, 0, 1.0], "point": [0, 0, 0.1], "angle": 0.3, "pitch": 0.0, "constrain": None, **MOVE},
    ),
    "ArcMove": (twistarm.ArcMove, {"via": [0.4, 0, 0.4], "to": G, **MOVE}),
    "ArcMove.about": (
        twistarm.ArcMove.about,
        {"axis": [0, 0, 1.0], "centre": [0, 0, 0.1], "angle": 0.3, "turn": True, "constrain": None, **MOVE},
    ),
    "Dwell": (twistarm.Dwell, {"seconds": 1.0, "label": "close gripper"}),
    "a line": (lambda to: twistarm.plan(ARM, twistarm.LineMove(to)), {"to": G}),
    "a waypoint": (lambda to: twistarm.plan_joint(ARM, ["ready", to]), {"to": G}),
    "load_motion": (twistarm.load_motion, {"path": "motion.toml", "arm": ARM}),
    "binding_limits": (twistarm.binding_limits, {"arm": ARM, "motion": MOTION, "limits": None, "segments": ()}),
    "servo_step": (
        twistarm.servo_step, {"arm": ARM, "state": STATE, "command": None, "dt": 0.01, "settings": SETTINGS},
    ),
    "ServoState": (twistarm.ServoState, vars(STATE)),
    "ServoState.at": (twistarm.ServoState.at, {"arm": ARM, "theta": ARM.ready}),
    "ServoSettings": (twistarm.ServoSettings, vars(SETTINGS)),
    "TwistCommand": (twistarm.TwistCommand, {"twist": [0.0] * 6, "frame": "tool", "hold": None}),
    "JogCommand": (twistarm.JogCommand, {"theta_dot": [0.0] * 5}),
    "PoseCommand": (twistarm.PoseCommand, {"g": G}),
    "JointLimits": (twistarm.JointLimits, vars(ARM.limits)),
    "limits.contains": (ARM.limits.contains, {"theta": ARM.ready}),
    "limits.with_": (ARM.limits.with_, {"changes": {}, "names": ARM.joint_names}),
    "Actuators": (twistarm.Actuators, {**MOTORS, "limits": twistarm.JointLimits.unbounded(2)}),
    "fk": (ARM.fk, {"theta": ARM.ready}),
    "pose": (ARM.pose, {"theta": ARM.ready, "frame": "tool0"}),
    "poses": (ARM.poses, {"theta": ARM.ready, "others": None}),
    "spatial_jacobian": (ARM.spatial_jacobian, {"theta": ARM.ready}),
    "body_jacobian": (ARM.body_jacobian, {"theta": ARM.ready}),
    "hybrid_jacobian": (ARM.hybrid_jacobian, {"theta": ARM.ready}),
    "manipulability": (ARM.manipulability, {"theta": ARM.ready, "length": None}),
    "joint_torques": (ARM.joint_torques, {"theta": ARM.ready, "wrench_body": [0.0] * 6}),
    "gravity_torques": (ARM.gravity_torques, {"theta": ARM.ready, "gravity": [0, 0, -9.8], "payload": 1.0}),
    "random_theta": (ARM.random_theta, {"rng": 0, "size": None}),
    "theta_from": (ARM.theta_from, {"values": ARM.joint_names, "numbers": [0.0] * 5}),
    "theta_to_dict": (ARM.theta_to_dict, {"theta": ARM.ready}),
    "with_tool": (ARM.with_tool, {"g_tip_tool": np.eye(4), "name": "pen"}),
    "bake": (ARM.bake, {"path": "arm.json"}),
    "motion": (MOTION, {"t": 0.1, "order": 0}),
    "motion.peak": (MOTION.peak, {"order": 1}),
    "motion.sample": (MOTION.sample, {"dt": 0.1}),
    "motion.to_csv": (MOTION.to_csv, {"path": "motion.csv", "dt": 0.1}),
    "check_wiring": (twistarm.check_wiring, {"arm": ARM, "log": "log.csv"}),
    "read_log": (read_log, {"path": "log.csv", "motors": DRIVES}),
    "load_trajectory": (twistarm.load_trajectory, {"arm": ARM, "path": "motion.csv"}),
    "SimulatedJoints": (stream.SimulatedJoints, {"arm": ARM, "theta": ARM.ready, "latency": 0.0}),
    "stream.run": (
        partial(stream.run, duration=0.001),
        {"arm": ARM, "source": Says(None), "sink": SIMULATED, "feedback": SIMULATED, "rate": 100.0, "settings": None},
    ),
    "Inbox": (stream.Inbox, {"timeout": 0.2}),
    "Inbox.put": (
        stream.Inbox().put, {"sender": "me", "value": [0.0] * 6, "now": None, "number": None},
    ),
    "Inbox.refuse": (stream.Inbox().refuse, {"sender": "me", "reason": "none", "now": None}),
    "Inbox.read": (stream.Inbox().read, {"now": 1.0}),
    "StateInbox.put": (
        stream.StateInbox(ARM).put, {"sender": "me", "state": ARM.ready, "now": None, "number": None},
    ),
    "UdpSink": (stream.UdpSink, {"arm": ARM, "host": "127.0.0.1", "port": 9871, "key": None, "units": "joint"}),
    "UdpSource": (stream.UdpSource, {"arm": ARM, "host": "127.0.0.1", "port": 0, "timeout": 0.2, "key": None}),
    "UdpFeedback": (stream.UdpFeedback, {"arm": ARM, "host": "127.0.0.1", "port": 0, "key": None, "units": "joint"}),
    "SimulatedJoints.write": (stream.SimulatedJoints(ARM, ARM.ready).write, {"setpoint": None}),
    "SimulatedJoints.step": (stream.SimulatedJoints(ARM, ARM.ready).step, {"dt": 0.01}),
    "StateInbox.read": (stream.StateInbox(ARM).read, {"now": 1.0}),
    "come_to_rest": (
        stream.come_to_rest,
        {"cycles": stream.Streaming(ARM, Says(None), SIMULATED, SIMULATED), "metronome": stream.Metronome(0.01),
         "clock": stream.MonotonicClock()},
    ),
    "Interlock.stop": (stream.Interlock().stop, {"reason": ""}),
    "FollowControl.pause": (stream.FollowControl().pause, {"reason": ""}),
    "command_of": (stream.command_of, {"arm": ARM, "message": {"stop": True}}),
    "parse_command": (stream.parse_command, {"arm": ARM, "text": "{}"}),
    "parse_state": (stream.parse_state, {"arm": ARM, "text": "{}"}),
    "setpoint_message": (stream.setpoint_message, {"arm": ARM, "setpoint": None}),
    "Signer": (stream.Signer, {"key": b"x" * 16}),
    "Signer.sign": (stream.Signer(b"x" * 16).sign, {"text": b"x"}),
    "Verifier.verified": (stream.Verifier(b"x" * 16).verified, {"datagram": b"x"}),
    "stream.follow": (
        partial(stream.follow, control=STOPPED),
        {"arm": ARM, "trajectory": MOTION, "sink": SIMULATED, "feedback": SIMULATED, "rate": 100.0, "speed": 1.0,
         "approach": True, "tolerance": 0.1, "start_tolerance": 0.01},
    ),
    **{name: (call, arguments) for name, call, arguments in (*of_theory(), *of_the_builder(), *of_the_drives())},
}  # fmt: skip


@pytest.mark.parametrize("door", DOORS)
def test_nonsense_is_answered_in_our_words(door: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call, arguments = DOORS[door]
    assert arguments
    answers = [(name, what, said(call, {**arguments, name: value})) for name, value, what in tried(arguments)]
    assert [answer for answer in answers if answer[-1] is not None] == []


def tried(arguments: dict[str, Any]) -> Iterator[tuple[str, Any, str]]:
    for name in arguments:
        for what, value in NONSENSE.items():
            yield name, value, what
        yield name, (number for number in (1.0, 2.0)), "a generator"


def said(call: Callable[..., Any], arguments: dict[str, Any]) -> str | None:
    """None for an answer or an error of ours, which has words; else the error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call(**arguments)
    except twistarm.TwistarmError as error:
        return None if str(error) else "no words"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None


def test_a_view_answers_in_our_words_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with twistarm.Viewer(ARM, open_browser=False) as viewer:
        doors: dict[Callable[..., Any], dict[str, Any]] = {
            viewer.show: {"theta": ARM.ready},
            viewer.play: {"trajectory": MOTION, "speed": 1.0},
            viewer.show_path: {"motion": MOTION},
            viewer.show_servo: {"answer": None},
            viewer.show_screws: {"visible": True},
            viewer.inline: {"height": 480.0},
            viewer.watch: {"load": None, "files": []},
        }
        for call, arguments in doors.items():
            for name, value, what in tried(arguments):
                assert said(call, {**arguments, name: value}) is None, (call, name, what)
