"""Torque limits in time: Pinocchio's inverse dynamics alone exceeds no effort, and the law is as short as can be."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from reference.phase_plane import least_time
from twistarm import (
    Approach,
    Arm,
    Dwell,
    FreeMove,
    InputError,
    JointMove,
    LimitError,
    LineMove,
    Scene,
    Trajectory,
    active_limits,
    load_arm,
    plan,
    plan_joint,
)
from twistarm.limits import Actuators, JointLimits
from twistarm.planning.piecewise import JointPath
from twistarm.planning.time_law import PathBounds, quintic
from twistarm.planning.time_optimal import time_optimal
from twistarm.planning.torque_limits import TorqueLimits

FAST = {"velocity": 8.0, "acceleration": 120.0}
LOAD = (4.0, (0.02, -0.01, 0.05))
OVERRUN = 1e-3


@pytest.fixture(scope="module")
def rover() -> Arm:
    return load_arm("rover_arm", limits=FAST)


def torques(arm: Arm, motion: Trajectory, load: Any, count: int = 10_001) -> np.ndarray:
    """Joint efforts (count, n) of a motion, with a model that Pinocchio reads and loads by itself."""
    assert arm.description is not None
    model = pin.buildModelFromXML(arm.description.repaired)
    frame = model.frames[model.getFrameId(arm.tip_link)]
    place = arm.tool[:3, :3] @ np.asarray(load[1]) + arm.tool[:3, 3]
    model.appendBodyToJoint(frame.parentJoint, pin.Inertia(load[0], place, np.zeros((3, 3))), frame.placement)
    data, at = model.createData(), [model.joints[model.getJointId(name)].idx_v for name in arm.joint_names]
    rows = np.zeros((3, count, model.nv))
    t = np.linspace(0.0, motion.duration, count)
    rows[:, :, at] = [motion(t, order) for order in range(3)]
    return np.array([pin.rnea(model, data, *states)[at] for states in zip(*rows, strict=True)])


def used(arm: Arm, motion: Trajectory, load: Any) -> float:
    return float(np.abs(torques(arm, motion, load) / arm.limits.effort).max())


@pytest.mark.parametrize("kind", ["time_optimal", "s_curve", "quintic"])
def test_lines_rounded_corners_dwells_and_joint_moves_keep_the_efforts(rover: Arm, kind: Any) -> None:
    g = rover.fk(rover.ready)
    there, axis = g[:3, 3] + [0.0, 0.2, 0.1], g[:3, 2]
    moves = [
        LineMove(Approach(there, axis), blend=0.03),
        LineMove(Approach(there + [0.1, -0.1, 0.0], axis)),
        Dwell(0.1),
        JointMove("ready"),
    ]
    motion = plan(rover, moves, kind=kind, torques=True, payload=LOAD)
    free = plan(rover, moves, kind=kind)
    assert used(rover, free, LOAD) > 1.2  # without torque limits the efforts are exceeded
    assert 0.98 < used(rover, motion, LOAD) < 1.0 + OVERRUN
    assert motion.duration > free.duration


@pytest.mark.parametrize("kind", ["time_optimal", "s_curve"])
@pytest.mark.parametrize("stop", [False, True])
def test_motions_through_waypoints_keep_the_efforts(rover: Arm, kind: Any, stop: bool) -> None:
    points = rover.ready + np.array(
        [[0, 0, 0, 0, 0], [0.1, -0.4, -0.5, 0.3, 1], [0.2, 0.3, 0.2, -0.3, 0], [0, 0, 0, 0, 2]]
    )
    motion = plan_joint(rover, points, kind=kind, stop_at_waypoints=stop, torques=True, payload=LOAD)
    assert 0.98 < used(rover, motion, LOAD) < 1.0 + OVERRUN
    assert used(rover, plan_joint(rover, points, kind=kind, stop_at_waypoints=stop), LOAD) > 1.2


def test_a_free_move_stays_straight_and_keeps_the_efforts(rover: Arm) -> None:
    goal = rover.ready + [0.0, -0.4, -0.6, 0.2, 1.0]
    motion = plan(rover, FreeMove(goal), scene=Scene(rover), torques=True, payload=LOAD)
    assert used(rover, motion, LOAD) < 1.0 + OVERRUN
    away = motion(np.linspace(0.0, motion.duration, 101)) - rover.ready
    way = goal - rover.ready
    assert np.abs(away - (away @ way / (way @ way))[:, None] * way).max() < 1e-9


def test_efforts_of_a_differential_s_motors_are_kept(rover: Arm) -> None:
    G = 10.0 * np.array([[20, 0, 0, 0, 0], [0, 9, 0, 0, 0], [0, 0, 9, 0, 0], [0, 0, 0, 1, 1], [0, 0, 0, 1, -1]])
    names = ("lift", "a", "b", "left", "right")
    effort = {"lift": 2.0, "a": 1.2, "b": 0.6, "left": 0.4, "right": 0.4}
    motors = JointLimits.unbounded(5).with_({"effort": effort}, names)
    units = ("rad",) * 5
    arm = replace(
        rover, actuators=Actuators(names, rover.joint_names, G, np.zeros(5), units, np.full(5, np.nan), motors)
    )
    load = (1.0, (0.0, 0.0, 0.05))
    goal = arm.ready + [0.1, -0.3, 0.4, 0.5, 1.5]
    motion = plan_joint(arm, [arm.ready, goal], kind="time_optimal", torques=True, payload=load)
    drives = torques(arm, motion, load) @ np.linalg.inv(G)
    assert 0.99 < np.abs(drives / [effort[name] for name in names]).max() < 1.0 + OVERRUN
    names_used = {limit.describe() for limit in active_limits(arm, motion, torques=True, payload=load)}
    assert any(name.startswith("torque of motor") for name in names_used)


def test_a_slide_against_its_weight_takes_the_textbook_s_time(tmp_path: Any) -> None:
    """2 kg and a payload of 3 kg rise with E/m − g and fall with E/m + g: a parabola up, a parabola to rest."""
    arm = slide(tmp_path, effort=100.0)
    motion = plan_joint(arm, [[0.0], [1.0]], kind="time_optimal", torques=True, payload=3.0)
    up, down = 100.0 / 5.0 - 9.81, 100.0 / 5.0 + 9.81
    assert motion.duration == pytest.approx(np.sqrt(2.0 * (1.0 / up + 1.0 / down)), rel=1e-3)
    assert quintic(*line(arm, 3.0)).duration > motion.duration


def test_a_pendulum_takes_the_time_of_the_phase_plane(tmp_path: Any) -> None:
    """Without gravity m r² θ̈ alone counts: an acceleration limit of E / (m r²), as in Bobrow's phase plane."""
    arm = slide(tmp_path, effort=12.0, kind="revolute", gravity_free=True)
    inertia = 2.0 * 0.5**2 + 3.0 * 1.0**2
    path, bounds = line(arm, 3.0)
    best = least_time(lambda s, order: path(s, order), 1.0, 1e3, 12.0 / inertia)
    assert time_optimal(path, bounds).duration == pytest.approx(best, rel=2e-3)


def slide(tmp_path: Any, effort: float, kind: str = "prismatic", gravity_free: bool = False) -> Arm:
    """A mass of 2 kg half a metre out, the tool at one metre; along z, or about it."""
    axis = "0 0 1"
    text = f"""<robot name="r"><link name="base"/><link name="out"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
      <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="tool"/>
      <joint name="j" type="{kind}"><parent link="base"/><child link="out"/><axis xyz="{axis}"/>
      <limit lower="-2" upper="2" velocity="1000" effort="{effort}"/></joint>
      <joint name="f" type="fixed"><parent link="out"/><child link="tool"/><origin xyz="1 0 0"/></joint></robot>"""
    file = tmp_path / f"{kind}.urdf"
    file.write_text(text)
    return load_arm(file, limits={"acceleration": 9000.0})


def line(arm: Arm, mass: float) -> tuple[JointPath, PathBounds]:
    torque = TorqueLimits.of(arm, arm.limits.effort, mass)
    return JointPath.straight(np.zeros(1), np.ones(1)), PathBounds(arm.limits, torques=torque)


def test_what_cannot_be_held_is_refused_with_joint_and_place(rover: Arm, tmp_path: Any) -> None:
    moves = [JointMove("ready"), JointMove(rover.ready + [0.0, 0.3, -1.0, 0.0, 0.0])]
    with pytest.raises(LimitError, match=r"segment 1 \(JointMove\): joint '\w+' needs"):
        plan(rover, moves, torques=True, payload=60.0)
    with pytest.raises(LimitError, match="waypoint 0"):
        plan_joint(rover, [rover.ready, "stowed"], torques=True, payload=60.0)
    with pytest.raises(LimitError, match="exceed its effort limit.*multiply times"):
        plan_joint(slide(tmp_path, 100.0), [[0.0], [1.0]], times=[0.0, 0.2], torques=True, payload=3.0)


def test_without_masses_efforts_or_torques_it_says_what_to_do(rover: Arm, tmp_path: Any) -> None:
    for given, words in (
        ({"payload": 2.0}, "torques=True"),
        ({"torques": True, "payload": -1.0}, "0 or more"),
        ({"torques": True, "limits": {"effort": {"elbow": np.inf}}}, "no effort limit of 'elbow'"),
        ({"torques": 1}, "torques"),
    ):
        with pytest.raises(InputError, match=words):
            plan(rover, JointMove("stowed"), **given)
    with pytest.raises(InputError, match="no effort limit"):
        plan_joint(slide(tmp_path, 0.0), [[0.0], [1.0]], torques=True)
    bare = (tmp_path / "prismatic.urdf").read_text().replace('<mass value="2"/>', '<mass value="0"/>')
    (tmp_path / "bare.urdf").write_text(bare)
    with pytest.raises(InputError, match="mass"):
        plan_joint(load_arm(tmp_path / "bare.urdf"), [[0.0], [1.0]], torques=True)


def test_active_limits_name_the_joint_whose_torque_limits(rover: Arm) -> None:
    motion = plan(
        rover, JointMove(rover.ready + [0, -0.5, -0.5, 0, 0]), kind="time_optimal", torques=True, payload=LOAD
    )
    found = active_limits(rover, motion, torques=True, payload=LOAD)
    assert any(limit.rate == "torque" and limit.owner == "joint" and limit.share > 0.99 for limit in found)
    assert max(limit.share for limit in found) < 1.0 + OVERRUN


def test_a_grid_that_may_not_become_finer_keeps_the_efforts_too(rover: Arm, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twistarm.planning.time_optimal.ROUNDS", 1)
    points = rover.ready + np.array([[0, 0, 0, 0, 0], [0.1, -0.4, -0.5, 0.3, 1], [0.2, 0.3, 0.2, -0.3, 0]])
    motion = plan_joint(rover, points, kind="time_optimal", torques=True, payload=LOAD)
    assert 0.97 < used(rover, motion, LOAD) < 1.0 + OVERRUN
