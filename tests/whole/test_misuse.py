"""One wrong argument at a time to every public call: an answer or an error of ours, never one of Python or NumPy."""

from __future__ import annotations

import enum
import inspect
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest

import twistarm
from catalogue import load
from stream_stand_ins import Says
from twistarm import calibration, stream
from twistarm.design import Panel, PanelTask

ARM, OTHER = load("rover_arm"), load("ur5")
N, G = ARM.n, ARM.fk(ARM.ready)
STATE = twistarm.ServoState.at(ARM, ARM.ready)
MOTION = twistarm.plan_joint(ARM, ["ready", "stowed"])
SOLUTION = twistarm.solve_ik(ARM, G)
SOLUTIONS = twistarm.solve_ik_all(ARM, G, redundancy_samples=2)
BATCH = twistarm.solve_ik_batch(ARM, [G])
ALL = twistarm.solve_ik_all_batch(ARM, [G], redundancy_samples=2)
OUTPUT = twistarm.servo_step(ARM, STATE, None, 0.01)[1]
SETPOINT = stream.Setpoint(1, 0.0, ARM.ready, np.zeros(N), OUTPUT)
SIMULATED = stream.SimulatedJoints(ARM, ARM.ready)
STOPPED = stream.FollowControl()
STOPPED.stop()
BUILDER = twistarm.ArmBuilder("x").revolute("i", [0, 0, 1], [0, 0, 0])
KEY = b"x" * 16
DRIVES = twistarm.Actuators(
    names=("a", "b"), joint_names=("j", "k"), G=np.eye(2), offset=np.zeros(2), units=("rad", "rad"),
    ticks_per_turn=np.full(2, np.nan),
)  # fmt: skip


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
    "too few numbers": [1.0],
    "too many numbers": [0.5] * 11,
    "a ragged list": [[1.0], [1.0, 2.0]],
    "NaNs": [float("nan")] * 5,
    "texts": ["a", "b"],
    "a dict": {"a": 1.0},
    "another arm": OTHER,
    "another arm's theta": OTHER.ready,
    "a path": Path("nowhere/x"),
    "a 0-d array": np.array(3.0),
    "an array of objects": np.array([object()], dtype=object),
    "many rows": np.zeros((2, 3, 4)),
    "no rows": np.zeros((0, 5)),
    "a set": {1, 2},
    "an object": object(),
    "one without words": Nameless(),
    "a solution": SOLUTION,
    "no name of a file": "a\0b",
}

# -- what each argument may be -----------------------------------------------------------------------------------------

GOOD: dict[str, Any] = {
    "arm": ARM, "theta": ARM.ready, "theta_dot": [0.0] * N, "rates": {ARM.joint_names[0]: 0.1}, "frame": "tool",
    "g": G, "g_ab": G, "g_tip_tool": np.eye(4), "home": ARM.home, "to": G, "target": G, "targets": [G],
    "screws": ARM.screws, "body_screws": ARM.body_screws, "x": ARM.ready, "motion": MOTION, "trajectory": MOTION,
    "axis": [0, 0, 1.0], "point": [0, 0, 0.1], "centre": [0, 0, 0.1], "pitch": 0.1, "normal": [0, 0, 1.0],
    "w": [0, 0, 1.0], "R": G[:3, :3], "A": G[:3, :3], "R1": G[:3, :3], "R2": G[:3, :3], "angle": 0.2,
    "offset": [0, 0, 0.1], "Q": [1.0, 0, 0, 0], "P": [1.0, 0, 0, 0], "order": "xyz", "angles": [0.1, 0.2, 0.3],
    "rpy": [0.1, 0.2, 0.3], "xi": [0, 0, 0, 0, 0, 1.0], "a": [0, 0, 0, 0, 0, 1.0], "b": [0, 0, 0, 0, 0, 1.0],
    "V": [0, 0, 0, 0, 0, 1.0], "xi_1": [0, 0, 0, 0, 0, 1.0], "xi_2": [0, 0, 0, 0, 1.0, 0], "xi_b": [0.0] * 6,
    "F_b": [0.0] * 6, "twist": [0.0] * 6, "matrix": np.zeros((4, 4)), "p": [1.0, 0, 0], "q": [0, 1.0, 0],
    "distance": 1.0, "direction": [0, 0, 1.0], "via": [0.4, 0, 0.4], "wrench_body": [0.0] * 6,
    "values": ARM.joint_names, "name": "j", "names": ARM.joint_names, "path": "new.csv", "rng": 0, "samples": 1,
    "segments": [twistarm.Dwell(1.0)], "seconds": 1.0, "waypoints": ["ready", "zero"], "state": STATE,
    "command": None, "dt": 0.05, "t": 0.1, "half": np.full(N, 3.0), "changes": {}, "against": "golden.json",
    "log": "log.csv", "source": Says(None), "sink": SIMULATED, "feedback": SIMULATED, "rate": 100.0, "now": 1.0,
    "sender": "me", "reason": "none", "number": None, "word": "stop", "who": "me", "key": KEY, "text": b"{}",
    "datagram": b"x", "line": b"x", "period": 0.01, "moment": 0.0, "setpoint": SETPOINT, "message": {"stop": True},
    "motor": [0.0, 0.0], "motor_dot": [0.0, 0.0], "tau": [0.0, 0.0], "tau_motor": [0.0, 0.0], "directions": 3,
    "engine": "Pinocchio", "size": None, "port": 9871, "solutions": SOLUTIONS, "answer": None, "visible": True,
    "load": lambda: ARM, "files": [], "closed_form": False, "restarts": 2, "threads": 1, "handle_signals": False,
    "host": "127.0.0.1", "loop": stream.Streaming(ARM, Says(None), SIMULATED, SIMULATED),
    "metronome": stream.Metronome(0.01), "clock": stream.MonotonicClock(), "n": 3, "motors": None, "theta0": None,
    "arms": [ARM, OTHER], "mass": 1.0,
}  # fmt: skip
"""An example of each argument, by its name."""

MEASURED = calibration.Measurements(ARM.random_theta(0, 40), ARM.fk(ARM.random_theta(0, 40))[:, :3, 3])
CALIBRATION = calibration.calibrate(ARM, MEASURED)

TABLE = twistarm.DhTable(np.array([[0.3, 0.0, 0.1, 0.0], [0.2, 0.5, 0.0, 0.1]]), "standard")

MAP = twistarm.reach_map(ARM, 0.5, method="fk", samples=1000)
DESIGNS = twistarm.sweep({"a": ARM}, None, lambda arm: {"n": arm.n})

PRESSED = PanelTask("key", "press", np.array([0.95, 0.0, 0.8]), np.eye(3)[0], 0.004 * np.eye(6)[0], "approach", True)
PANEL = {"panel": Panel((PRESSED,), np.eye(4)), "base": np.eye(4), "scene": None}

BY_CALL: dict[str, dict[str, Any]] = {
    "check_panel": PANEL,
    "arm_from_dh": {"table": TABLE.rows, "convention": "standard", "base": np.eye(4), "tool": np.eye(4)},
    "DhTable": vars(TABLE),
    "to_urdf": {"folder": "."},
    "best_parking": PANEL,
    "load_panel": {"path": "panel.toml"},
    "reach_map": {"voxel": 0.5, "directions": "down", "method": "fk", "samples": 10, "folder": "chunks"},
    "ReachMap.slice": {"axis": "z", "at": 0.5},
    "sweep": {"arms": {"a": ARM}, "parameters": None, "measure": lambda arm: {"n": arm.n}, "folder": "designs"},
    "DesignTable.pareto": {"most": ["n"]},
    "DesignTable.column": {"name": "n"},
    "calibrate": {"measurements": MEASURED},
    "corrected_urdf": {"calibration": CALIBRATION},
    "Viewer.show_reach": {"m": MAP},
    "Viewer.slider": {"lo": 0.0, "hi": 1.0, "on_change": print, "value": 0.5},
    "Viewer.button": {"on_click": print},
    "Viewer.text": {"value": "good"},
    "Draw.frame": {"pose": G, "length": 0.1},
    "Draw.arrow": {"start": [0, 0, 0], "end": [0, 0, 1]},
    "Draw.points": {"points": [[0, 0, 0]], "size": 0.01},
    "Draw.line": {"points": [[0, 0, 0], [0, 0, 1]]},
    "Draw.box": {"size": [1, 1, 1]},
    "Draw.mesh": {"vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "faces": [[0, 1, 2]]},
    "Draw.text": {"text": "good", "position": [0, 0, 0]},
    "reachable": {"targets": G[None, :3, 3]},
    "Arm.theta_from": {"values": ARM.joint_names, "numbers": [0.0] * N, "name": "theta"},
    "Arm.pose": {"frame": "tool0"},
    "Arm.random_theta": {"size": None},
    "Inbox.put": {"value": [0.0] * 6},
    "StateInbox.put": {"state": ARM.ready},
    "Interlock.mirror": {"state": None},
    "TolerancedPose": {"frame": "target", "tolerance": [0.0] * 6},
    "LineMove": {"offset": None},
    "Actuators.from_counts": {"counts": [0, 0]},
    "Pose.from_quaternion": {"xyzw": [0, 0, 0, 1.0]},
    "subproblem_4": {"offset": 0.1},
    "SimulatedJoints": {"clock": time.monotonic},
    "Signer": {"now": time.time_ns},
    "Verifier": {"now": time.time_ns},
    "UdpSource": {"port": 0},
    "UdpFeedback": {"port": 0},
    "SerialRobot": {"port": "nowhere"},
    "SerialSource": {"port": "nowhere"},
    "Following.cycle": {"periods": 1},
    "Streaming.cycle": {"periods": 1},
    "Trajectory.to_motors": {"actuators": DRIVES},
    "parse_state": {"text": b'{"joint_names": ["elbow"], "theta": [0.1]}'},
    "parse_command": {"text": b'{"stop": true}'},
    "Trajectory": vars(MOTION),
    "Trajectory.peak": {"order": 1},
    "Trajectory.__call__": {"order": 0},
    "save_trajectory": {"trajectory": MOTION, "path": "new.json"},
    "Recorder": {"path": "new.mcap"},
    "bake": {"arm": ARM, "path": "new.json"},
    "save_html": {"path": "new.html"},
    "save_png": {"path": "new.png"},
    "Viewer.save_html": {"path": "new.html"},
    "load_trajectory": {"path": "motion.csv"},
    "load_motion": {"path": "motion.toml"},
    "read_key": {"path": "key"},
    "load_arm": {"source": "rr_planar"},
    "diagnose": {"source": "rr_planar"},
    "assert_arm": {"source": "rr_planar", "against": None},
    "run": {"duration": 0.001, "until": lambda: True},
    "follow": {"control": STOPPED},
    "rotations.exp": {"theta": 0.3},
    "screws.exp": {"theta": 0.3},
    "JointLimits": vars(ARM.limits),
    "Actuators": vars(DRIVES),
    "ServoState": vars(STATE),
    "Arm": {name: getattr(ARM, name) for name in inspect.signature(twistarm.Arm).parameters},
    "Actuators.to_motor": {"theta": [0.0, 0.0]},
    "Actuators.motion_limits": {
        "joints": type(ARM.limits)(**{name: row[:2] for name, row in vars(ARM.limits).items()})
    },
    "Actuators.velocity_to_motor": {"theta_dot": [0.0, 0.0]},
    "Following.report": {"ending": stream.Ending.ARRIVED, "reason": "", "duration": 1.0, "at_rest": True},
    "Streaming.report": {"ending": stream.Ending.ARRIVED, "reason": "", "duration": 1.0, "at_rest": True},
}

OBJECTS: dict[type, Any] = {
    type(made): made
    for made in (
        ARM, DRIVES, BUILDER, STATE, MOTION, SOLUTION, SOLUTIONS, BATCH, ALL, OUTPUT, SIMULATED, SETPOINT, ARM.limits,
        ARM.manipulability(ARM.ready), twistarm.Pose(G), twistarm.Position(G[:3, 3]),
        twistarm.TolerancedPose(G, [0.0] * 6),
        twistarm.Approach(G[:3, 3], [0, 0, 1], [0, 0, 1]), stream.Inbox(), stream.StateInbox(ARM), stream.Interlock(),
        stream.FollowControl(), stream.Metronome(0.01), stream.MonotonicClock(), stream.Signer(KEY),
        stream.Verifier(KEY),
        stream.Streaming(ARM, Says(None), SIMULATED, SIMULATED), stream.Following(ARM, MOTION, SIMULATED, SIMULATED),
        twistarm.CrossCheck("x", ()), MAP, DESIGNS, TABLE,
    )
}  # fmt: skip
"""An object of each class whose methods are called."""

UNCHECKED = {
    "Arm", "AllSolutionsBatch", "IKBatch", "Roots", "screws.Screw",
    "rotations.cross", "rotations.split", "rotations.log_of", "screws.adjoint_of",
    "screws.inverse_of", "screws.exp_along", "screws.turn_and_slide",
    "poe.columns", "poe.motions", "poe.products",
    "Arm.joint_values", "Arm.require_core", "Arm.walked_poses",
}  # fmt: skip
"""Results, which functions make, and calls for inner loops, whose callers have checked."""

SLOW = {"save_png", "save_site", "Viewer.save_png", "Viewer"}  # A browser or a server for each call.


NOT_CALLED = (BaseException, enum.Enum)

# -- every public call, and its arguments ------------------------------------------------------------------------------


def public_calls() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Functions, classes, and the methods of the objects above."""
    for space in (
        twistarm,
        *filter(inspect.ismodule, (getattr(twistarm, name) for name in twistarm.__all__)),
        calibration,
    ):
        prefix = {"rotations": "rotations.", "screws": "screws.", "poe": "poe."}.get(space.__name__.split(".")[-1], "")
        for name in getattr(space, "__all__", None) or vars(space):
            value = getattr(space, name)
            own = hasattr(space, "__all__") or getattr(value, "__module__", "") == space.__name__
            if name.startswith("_") or not own:
                continue
            if inspect.isfunction(value):
                yield prefix + name, value
            elif inspect.isclass(value) and not issubclass(value, NOT_CALLED) and Protocol not in value.__bases__:
                yield prefix + name, value
                yield from methods(value)


def methods(kind: type) -> Iterator[tuple[str, Callable[..., Any]]]:
    for name in dir(kind):
        function = getattr(kind, name)
        public = name == "__call__" or not name.startswith("_")
        if public and (inspect.isfunction(function) or inspect.ismethod(function)):
            bound = getattr(OBJECTS.get(kind, kind), name)
            if inspect.ismethod(bound):  # without an object, those of the class
                yield f"{kind.__name__}.{name}", bound


def arguments_of(name: str, call: Callable[..., Any]) -> dict[str, Any]:
    """{argument: a good value}: of this call, of an object of the class, of this name, or its default."""
    found = {}
    for argument, parameter in inspect.signature(call).parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        known = BY_CALL.get(name, {})
        if argument in known:
            found[argument] = known[argument]
        elif inspect.isclass(call) and hasattr(OBJECTS.get(call), argument):
            found[argument] = getattr(OBJECTS[call], argument)
        elif argument in GOOD:
            found[argument] = GOOD[argument]
        elif parameter.default is not parameter.empty:
            found[argument] = parameter.default
        else:
            assert inspect.isclass(call), f"{name}: no example of {argument!r} in GOOD"
            found[argument] = None
    return found


CALLS = {name: call for name, call in public_calls() if name not in UNCHECKED | SLOW}


@pytest.mark.parametrize("name", sorted(CALLS))
def test_nonsense_is_answered_in_our_words(name: str, here: Path) -> None:
    arguments = arguments_of(name, CALLS[name])
    answers = [(key, what, said(CALLS[name], {**arguments, key: value})) for key, value, what in tried(arguments)]
    assert [answer for answer in answers if answer[-1] is not None] == []


def test_a_view_answers_in_our_words_too(here: Path) -> None:
    with twistarm.Viewer(ARM, open_browser=False) as viewer:
        members = [member for of in (viewer.draw, viewer) for member in inspect.getmembers(of, inspect.ismethod)]
        for name, function in members:
            call = f"{type(function.__self__).__name__}.{name}"
            if not name.startswith("_") and call not in SLOW:
                arguments = arguments_of(call, function)
                for key, value, what in tried(arguments):
                    assert said(function, {**arguments, key: value}) is None, (name, key, what)


def tried(arguments: dict[str, Any]) -> Iterator[tuple[str, Any, str]]:
    for name in (key for key in arguments if not key.startswith("_")):
        for what, value in NONSENSE.items():
            yield name, value, what
        yield name, (number for number in (1.0, 2.0)), "a generator"


def said(call: Callable[..., Any], arguments: dict[str, Any]) -> str | None:
    """None for an answer or an error of ours, which has words; else the error."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            call(**arguments)
    except (twistarm.TwistarmError, AssertionError) as error:  # assert_arm raises the latter
        return None if str(error) else "no words"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return None
