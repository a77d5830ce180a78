"""The tool's target: what a page asks for, what the arm shows, and what every page is told."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio
import pytest
from numpy.testing import assert_allclose

from ik_targets import require_core
from recorded_poses import ask, done, said
from twistarm import Arm, InputError, arm_from_screws, joints, load_arm, solve_ik
from twistarm.arm.engine import MOST_JOINTS
from twistarm.ik import Position
from twistarm.planning.joint_space import plan_joint
from twistarm.viewer.messages import SCHEMA
from twistarm.viewer.parts.target import AT_ONCE, MAX_TIME
from twistarm.viewer.stage import Stage

ROVER = load_arm("rover_arm")
SIX = load_arm("rover_arm_6dof")
MOTION = plan_joint(ROVER, [ROVER.ready, 0.9 * ROVER.ready], limits={"velocity": 1, "acceleration": 2})

MET = 2e-6  # The solver's tolerance [m, rad], and the rounding of forward kinematics.


def xyzw(R: Any) -> list[float]:
    """Pinocchio's quaternion of a rotation."""
    numbers: list[float] = pinocchio.Quaternion(np.array(R)).coeffs().tolist()
    return numbers


def begin(stage: Stage, position: Any, quaternion: Any, kind: str = "position") -> Any:
    """Ask for a target: the job, if it is one."""
    return ask(stage, "target", kind=kind, position=np.asarray(position).tolist(), xyzw=quaternion)


def aim(stage: Stage, kind: str, position: Any, quaternion: Any) -> dict[str, Any]:
    """Ask for a target, do the job at once, and return what the pages are told of it."""
    done(begin(stage, position, quaternion, kind))
    return told(stage)


@pytest.fixture
def in_the_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every target is a job, as on an arm that the core cannot hold."""
    monkeypatch.setattr("twistarm.viewer.parts.target.AT_ONCE", 1e-9)


def told(stage: Stage) -> dict[str, Any]:
    message = said(stage, "target")
    assert set(message) - {"type"} == set(SCHEMA["messages"]["target"])
    return message


def near(arm: Arm, by: tuple[float, float, float] = (0.05, 0.02, -0.03)) -> tuple[np.ndarray[Any, Any], list[float]]:
    """A position a little off the tool's, and the tool's quaternion."""
    g, _, _ = arm.by_pinocchio(arm.ready)
    return g[:3, 3] + by, xyzw(g[:3, :3])


@pytest.mark.parametrize("kind", ["pose", "position", "approach"])
def test_a_target_in_reach_is_met(kind: str) -> None:
    stage = Stage(SIX)
    position, quaternion = near(SIX)
    message = aim(stage, kind, position, quaternion)
    assert message["met"] is True
    assert message["given"] == {"kind": kind, "position": position.tolist(), "xyzw": quaternion}
    g, _, _ = SIX.by_pinocchio(stage.theta)
    before, _, _ = SIX.by_pinocchio(SIX.ready)
    assert_allclose(g[:3, 3], position, atol=MET)
    if kind != "position":
        assert_allclose(g[:3, 2], before[:3, 2], atol=MET)
    if kind == "pose":
        assert_allclose(g[:3, :3], before[:3, :3], atol=MET)


def test_out_of_reach_the_nearest_is_shown_and_the_reason_told() -> None:
    require_core(ROVER)
    stage = Stage(ROVER)
    position, quaternion = near(ROVER, (3.0, 0.0, 0.0))
    message = aim(stage, "position", position, quaternion)
    solution = solve_ik(ROVER, Position(position), ROVER.ready, posture="theta0", max_time=MAX_TIME)
    assert message["met"] is False
    assert message["words"] == solution.explain()
    g, _, _ = ROVER.by_pinocchio(stage.theta)
    distance = float(np.linalg.norm(g[:3, 3] - position))
    assert distance == pytest.approx(solution.position_error, abs=MET)
    assert ROVER.limits.contains(stage.theta)
    closer = [np.linalg.norm(ROVER.fk(ROVER.random_theta(seed))[:3, 3] - position) for seed in range(300)]
    assert distance < min(closer)


def test_tolerances_hold_for_targets_until_others_are_chosen() -> None:
    stage = Stage(ROVER)
    position, quaternion = near(ROVER, (0.4, 0.0, 0.0))
    assert not aim(stage, "position", position, quaternion)["met"]
    for tolerance, met in ((0.5, True), (1e-4, False), (0.0, False)):
        assert ask(stage, "tolerances", position=tolerance, orientation=0.0) is None
        assert said(stage, "tolerances") == {"type": "tolerances", "position": tolerance, "orientation": 0.0}
        assert aim(stage, "position", position, quaternion)["met"] is met
        g, _, _ = ROVER.by_pinocchio(stage.theta)
        assert (np.linalg.norm(g[:3, 3] - position) <= max(tolerance, 1e-6)) == met
    with pytest.raises(InputError, match="position"):
        ask(stage, "tolerances", position=-1.0, orientation=0.0)


def test_what_moves_the_arm_otherwise_lets_the_target_go() -> None:
    stage = Stage(ROVER)
    aim(stage, "position", *near(ROVER))
    kept = told(stage)
    assert told(stage) is kept
    ask(stage, "joint", name="wrist_roll", value=0.3)
    assert told(stage)["given"] is None
    aim(stage, "position", *near(ROVER))
    stage.load(MOTION).play(0.0)
    assert told(stage)["given"] is None


LATE: dict[str, Callable[[Stage], Any]] = {
    "slider": lambda stage: ask(stage, "joint", name="wrist_roll", value=0.3),
    "servo": Stage.take_commands,
    "release": lambda stage: ask(stage, "release"),
    "trajectory": lambda stage: stage.load(MOTION).play(0.0),
}
"""What may happen before an answer comes."""


@pytest.mark.usefixtures("in_the_thread")
@pytest.mark.parametrize("meanwhile", LATE.values(), ids=LATE)
def test_an_answer_that_comes_too_late_changes_nothing(meanwhile: Callable[[Stage], Any]) -> None:
    stage = Stage(ROVER)
    job = begin(stage, *near(ROVER))
    meanwhile(stage)
    theta = stage.theta
    done(job)
    assert stage.theta is theta
    assert told(stage)["given"] is None


def chain(n: int) -> Arm:
    """n joints, a tenth of a metre apart, about x and y in turn."""
    axes = [joints.revolute([i % 2, 1 - i % 2, 0], [0, 0, 0.1 * i]) for i in range(n)]
    home = np.eye(4)
    home[2, 3] = 0.1 * n
    return arm_from_screws(np.hstack(axes), home)


@pytest.mark.alone
@pytest.mark.parametrize("arm", [ROVER, SIX, chain(MOST_JOINTS)], ids=lambda arm: f"{arm.n} joints")
@pytest.mark.parametrize("kind", ["pose", "position", "approach"])
def test_no_search_holds_up_the_loop(arm: Arm, kind: str) -> None:
    stage, times = Stage(arm), []
    for _ in range(20):
        begin = time.perf_counter()
        job = ask(stage, "target", kind=kind, position=[90.0, 0.0, 0.0], xyzw=[0, 0, 0, 1])
        times.append(time.perf_counter() - begin)
        assert job is not None
    assert min(times) < 5 * AT_ONCE


def test_an_answer_that_a_later_target_has_overtaken_is_not_shown() -> None:
    stage = Stage(ROVER)
    position, quaternion = near(ROVER)
    slow = ask(stage, "target", kind="position", position=[9.0, 0.0, 0.0], xyzw=quaternion)
    assert aim(stage, "position", position, quaternion)["met"]
    theta = stage.theta
    done(slow)
    assert stage.theta is theta
    assert told(stage)["met"]


def test_what_can_be_no_target_is_refused() -> None:
    stage = Stage(ROVER)
    for length in (0, 2):
        with pytest.raises(InputError, match=f"length {length}"):
            begin(stage, [0, 0, 1], [0, 0, 0, length])
    assert told(stage)["given"] is None


def test_while_a_servo_drives_there_is_no_target() -> None:
    stage = Stage(ROVER)
    stage.take_commands()
    with pytest.raises(InputError, match="a servo drives rover_arm"):
        ask(stage, "target", kind="position", position=[0, 0, 1], xyzw=[0, 0, 0, 1])


def test_without_the_compiled_core(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twistarm.arm.engine.core", lambda: None)
    arm = load_arm("rover_arm")
    assert arm.compiled is None
    stage = Stage(arm)
    assert aim(stage, "approach", *near(arm))["met"]
    message = aim(stage, "position", [9.0, 0.0, 0.0], [0, 0, 0, 1])
    assert message["met"] is False
    assert arm.limits.contains(stage.theta)


@pytest.mark.usefixtures("in_the_thread")
def test_a_target_stops_what_plays_before_its_answer_comes() -> None:
    stage = Stage(ROVER)
    stage.load(MOTION, loop=True).play(0.0)
    job = begin(stage, *near(ROVER))
    assert not stage.running
    done(job)
    assert told(stage)["met"]


def test_dragged_beyond_its_reach_the_arm_on_show_does_not_flip() -> None:
    """Straight up, where the joints may be anyhow as long as the arm points there: a search alone turns by radians."""
    stage, thetas = Stage(ROVER), []
    p = ROVER.fk(ROVER.ready)[:3, 3]
    for k in range(30):
        done(ask(stage, "target", kind="position", position=[p[0], p[1], p[2] + 2.0 + 0.01 * k], xyzw=[0, 0, 0, 1]))
        assert told(stage)["met"] is False
        thetas.append(stage.theta)
    assert np.abs(np.diff(thetas, axis=0)).max() < 0.1
