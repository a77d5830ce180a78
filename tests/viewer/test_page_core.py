"""The core in the page against the compiled core of Python: core.js and arm.wasm in Node.js."""

from __future__ import annotations

import json
import subprocess
from importlib.resources import files
from itertools import accumulate, product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from catalogue import load
from twistarm import Arm, arm_from_screws, joints, load_arm, solve_ik, solve_ik_all
from twistarm.arm.engine import MOST_JOINTS
from twistarm.arm.usual_limits import usually_limited
from twistarm.control.servo import JogCommand, PoseCommand, ServoSettings, ServoState, TwistCommand, servo_step
from twistarm.description.catalog import model_arms, own_arms
from twistarm.ik import closed_form_of
from twistarm.theory.rotations import to_rpy, to_xyzw
from twistarm.theory.screws import exp
from twistarm.viewer.parts.target import target_from
from twistarm.viewer.scene.core_numbers import core_numbers
from twistarm.viewer.scene.drawing import link_path, screw_path
from twistarm.viewer.stage import Stage
from urdf_text import BRANCHED
from viewer_page import ARM

ROUNDING = 1e-12
SAME_ANSWER, SAME_ERROR, SAME_CONFIGURATION = 1e-6, 1e-6, 1e-9
HELD = 1e-10  # Where rotations are held, a unit in the last place of theta does as much in one step.

every_arm = pytest.mark.parametrize(
    "name", ["rover_arm", "scara", *(pytest.param(n, marks=pytest.mark.slow) for n in (*own_arms(), *model_arms()))]
)


def in_page(*questions: tuple[Arm, list[list[Any]]]) -> list[dict[str, Any]]:
    """What the page's core answers to each arm's calls."""
    driver = pytest.importorskip("playwright._impl._driver", reason="Node.js comes with playwright")
    script, page = Path(__file__).with_name("page_core.mjs"), files("twistarm.viewer").joinpath("page")
    asked = json.dumps([[Stage(arm).hello({}), calls] for arm, calls in questions], default=np.ndarray.tolist)
    command = [driver.compute_driver_executable()[0], "--no-warnings", script, page]
    done = subprocess.run(command, input=asked, stdout=subprocess.PIPE, text=True, timeout=300, check=True)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


def assert_near(value: Any, expected: Any, within: float = ROUNDING) -> None:
    assert_allclose(value, expected, rtol=0, atol=within)


def some(arm: Arm, count: int = 6) -> np.ndarray:
    return arm.random_theta(np.random.default_rng(3), count)


def targets(arm: Arm, theta: np.ndarray, scale: float, kinds: Any) -> list[dict[str, Any]]:
    g = arm.fk(theta)
    return [{"kind": k, "position": scale * g[:3, 3], "xyzw": to_xyzw(g[:3, :3])} for k in kinds]


def assert_placed(arm: Arm, theta: np.ndarray, others: dict[str, float], answer: dict[str, Any]) -> None:
    """A screw's node has the motion of space up to its joint."""
    poses, found = arm.poses(theta, others), answer["transforms"]
    g, steps = poses[arm.tip], exp(arm.screws.T, arm.coupling.A @ theta)
    links = [] if arm.description is None else [*arm.description.links]
    expected = {link_path(name): poses[name] for name in links} | {"/frames/tool": g}
    expected |= {screw_path(i): moved for i, moved in enumerate(accumulate(steps, np.matmul))}
    for path, pose in expected.items():
        assert_near(np.reshape(found[path], (4, 4)).T, pose)
    assert_near([*answer["tool"]["position"], *answer["tool"]["rpy"]], [*g[:3, 3], *to_rpy(g[:3, :3])])


@every_arm
def test_poses_and_jacobians(name: str) -> None:
    arm = load(name)
    others = dict.fromkeys(Stage(arm).others, 0.01)
    calls = [call for theta in some(arm) for call in (["place", theta, others], ["kinematics", theta])]
    (found,) = in_page((arm, calls))
    for theta, place, known in zip(some(arm), found["answers"][::2], found["answers"][1::2], strict=True):
        assert_placed(arm, theta, others, place)
        assert_near(known["g"], arm.fk(theta))
        assert_near([known["spatial"], known["body"]], [arm.spatial_jacobian(theta), arm.body_jacobian(theta)])


@every_arm
def test_inverse_kinematics_and_its_verdicts(name: str) -> None:
    arm, kinds = load(name), ("pose", "position", "approach")
    asked = [each for theta in some(arm) for scale in (1.0, 1.02, 1.7) for each in targets(arm, theta, scale, kinds)]
    (found,) = in_page((arm, [["solve", each, arm.ready, {"posture": arm.ready}] for each in asked]))
    for each, answer in zip(asked, found["answers"], strict=True):
        native = solve_ik(arm, target_from(arm, each), arm.ready, posture="theta0")
        assert answer["stop"] == native.stop.name
        assert (answer["unlimited"] is None) == (native.unlimited is None)
        assert abs(answer["positionError"] - native.position_error) < SAME_ERROR
        # Of two branches at one distance rounding chooses, and each turns to within the tolerance.
        assert abs(answer["orientationError"] - native.orientation_error) < native.tolerances.orientation
        if native.converged:
            assert_near(answer["theta"], native.theta, SAME_ANSWER)


@every_arm
def test_every_configuration_of_a_closed_form(name: str) -> None:
    arm, near = load(name), load(name).ready
    asked = [each for theta in some(arm, 4) for each in targets(arm, theta, 1.0, (core_numbers(arm) or {})["forms"])]
    (found,) = in_page((arm, [["configurations", each, near] for each in asked]))
    for each, answer in zip(asked, found["answers"], strict=True):
        target = target_from(arm, each)
        held = {joint: float(near[arm.joint_names.index(joint)]) for joint in closed_form_of(arm, target).held}
        native = solve_ik_all(arm, target, near, fixed_joints=held)
        if answer["families"] or not native.complete:
            continue  # Python looks for more members of continuous families
        assert answer["inside"] == len(native)
        inside = np.reshape(answer["theta"], (-1, arm.n))[: answer["inside"]]
        for theta in native.theta:
            assert np.abs(inside - theta).max(axis=1).min() < SAME_CONFIGURATION


@every_arm
def test_servo_steps(name: str) -> None:
    arm, six = load(name), [0.05, 0.02, -0.03, 0.1, 0.0, 0.05]
    g, still, turns = arm.fk(some(arm)[1]), [*six[:3], 0.0, 0.0, 0.0], [False] * 3 + [True] * 3
    commands: list[tuple[Any, Any, float]] = [
        ({"twist": six}, TwistCommand(six), ROUNDING), ({"rates": [0.3] * arm.n}, JogCommand([0.3] * arm.n), ROUNDING),
        ({"goal": g.ravel()}, PoseCommand(g), HELD), (None, None, ROUNDING),
        ({"twist": still, "frame": "base", "hold": turns}, TwistCommand(still, "base", "orientation"), HELD),
    ]  # fmt: skip
    calls, native, limited = list[list[Any]](), list[Any](), usually_limited(arm)
    for stops in ("slide", "stop"):
        for fields, command, within in commands:
            state = ServoState.at(arm, some(arm)[0])
            for _ in range(20):
                held = None if state.held_pose is None else state.held_pose.ravel()
                before = {"theta": state.theta, "thetaDot": state.theta_dot, "held": held, "period": state.period}
                calls.append(["step", stops, {**before, "flags": state.held_flags or 0}, fields, 0.01])
                state, output = servo_step(limited, state, command, 0.01, settings=ServoSettings(on_unreachable=stops))
                native.append((state.theta, output, within))
    (found,) = in_page((arm, calls))
    for answer, (theta, output, within) in zip(found["answers"], native, strict=True):
        assert_near(answer["state"]["theta"], theta, within)
        assert (answer["joint"], answer["halted"]) == (output.joint, output.halted)


def test_branches_followers_a_base_that_is_carried_a_thread_and_a_ball(tmp_path: Path) -> None:
    for name, text in (("small", ARM), ("branched", BRANCHED)):
        (tmp_path / f"{name}.urdf").write_text(text)
    parts = [joints.helical([0, 0, 1], [0.1, 0, 0], 0.05), joints.spherical([0.3, 0, 0.1]), joints.prismatic([1, 0, 0])]
    home = np.eye(4)
    home[:3, 3] = 0.6, 0.1, 0.2
    arms = [load_arm(tmp_path / "small.urdf", tip="tool0"), arm_from_screws(np.column_stack(parts), home)]
    for base, locked in product(("root", "base_link"), ({}, {"b": 0.4})):
        arms.append(load_arm(tmp_path / "branched.urdf", base=base, tip="tool0", locked_joints=locked))
    asks = [(arm, some(arm)[0], dict.fromkeys(Stage(arm).others, 0.03)) for arm in arms]
    found = in_page(*((arm, [["place", theta, others]]) for arm, theta, others in asks))
    for (arm, theta, others), answers in zip(asks, found, strict=True):
        assert_placed(arm, theta, others, answers["answers"][0])


def test_as_many_joints_as_the_core_holds_and_one_more() -> None:
    axes = [joints.revolute(np.eye(3)[i % 3], [0.02 * i, 0, 0]) for i in range(MOST_JOINTS + 1)]
    full, more = (arm_from_screws(np.hstack(axes[:count]), np.eye(4)) for count in (MOST_JOINTS, MOST_JOINTS + 1))
    asks = {arm: [["place", [0.01] * arm.n, {}]] for arm in (full, more)}
    (target,) = targets(full, np.full(full.n, 0.02), 1.0, ["pose"])
    asks[full] += [["solve", target, [0.01] * full.n], ["solve", {**target, "position": [9, 0, 0]}, [0.01] * full.n]]
    holds, lacks = in_page(*asks.items())
    for arm, found in ((full, holds), (more, lacks)):
        assert_placed(arm, np.full(arm.n, 0.01), {}, found["answers"][0])
    assert (holds["solves"], lacks["solves"]) == (True, False)
    assert [answer["converged"] for answer in holds["answers"][1:]] == [True, False]
