"""The numbers of the theory, as the pages are told them: against finite differences, Pinocchio, NumPy and by hand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from joint_arms import Joint, by_hand, from_urdf, random_chain
from recorded_poses import ask
from twistarm import Arm, ArmBuilder, load_arm, plan_joint
from twistarm.planning.trajectory import Trajectory
from twistarm.viewer.parts.theory import axes, numbers
from twistarm.viewer.saved_page import sampled_theory
from twistarm.viewer.stage import Stage

Matrix = NDArray[np.float64]

NAMES = ("rover_arm", "rover_arm_6dof", "panda", "scara")
ARMS = {name: load_arm(name) for name in NAMES} | {
    "joints": by_hand(*random_chain(["helical", "planar", "revolute"], 4))
}

ELBOW = ArmBuilder("elbow")  # three parallel joints, 0.5 m apart, along x at rest
for i in range(3):
    ELBOW = ELBOW.revolute(f"j{i}", [0, 0, 1], [0.5 * i, 0, 0])
STRETCHED = ELBOW.tool(np.array([[1, 0, 0, 1.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])).build()

PAIR = """<robot name="pair"><link name="base"/><link name="a"/><link name="b"/><link name="tool"/>
  <joint name="lead" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="follow" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-9" upper="9" velocity="9" effort="1"/><mimic joint="lead" multiplier="{ratio}"/></joint>
  <joint name="mount" type="fixed"><parent link="b"/><child link="tool"/><origin xyz="0.3 0 0.1"/></joint></robot>"""


def posture(arm: Arm, seed: int = 3) -> Matrix:
    return arm.random_theta(np.random.default_rng(seed))


def differences(arm: Arm, theta: Matrix, step: float = 1e-6) -> tuple[Matrix, Matrix, Matrix]:
    """J^s, J^b and the hybrid Jacobian (6, n) by central differences of forward kinematics."""
    g = arm.fk(theta)
    found: list[tuple[Matrix, Matrix, Matrix]] = []
    for e in np.eye(arm.n) * step:
        rate = (arm.fk(theta + e) - arm.fk(theta - e)) / (2 * step)
        spatial, body = rate @ np.linalg.inv(g), np.linalg.inv(g) @ rate
        found.append((unhat(spatial), unhat(body), np.r_[rate[:3, 3], unhat(spatial)[3:]]))
    spatial, body, hybrid = (np.array(columns).T for columns in zip(*found, strict=True))
    return spatial, body, hybrid


def unhat(matrix: Matrix) -> Matrix:
    return np.r_[matrix[:3, 3], matrix[2, 1], matrix[0, 2], matrix[1, 0]]


def units(arm: Arm) -> Matrix:
    """What a coordinate's rate of 1 rad/s is, in its own unit."""
    return np.where(np.array(arm.units) == "m", arm.reach, 1.0)


def pair(folder: Path, ratio: float) -> Arm:
    path = folder / "pair.urdf"
    path.write_text(PAIR.format(ratio=ratio))
    return load_arm(path, tip="tool")


def twist_of(screw: Mapping[str, Any], i: int = 0) -> Matrix:
    """The twist of a screw by MLS §2.3.3: v = M (q × u + h u), w = M u; v = M u for infinite pitch."""
    axis, point = np.array(screw["axis"][i]), np.array(screw["point"][i])
    h, size = screw["pitch"][i], screw["magnitude"][i]
    if h is None:
        return size * np.r_[axis, 0, 0, 0]
    return size * np.r_[np.cross(point, axis) + h * axis, axis]


# the numbers ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_jacobians_are_the_derivatives_of_the_pose(arm: Arm) -> None:
    theta = posture(arm)
    told = numbers(arm, theta)
    for name, expected in zip(("spatial", "body", "hybrid"), differences(arm, theta), strict=True):
        assert_allclose(told[name], expected, atol=1e-8, err_msg=name)
    assert_allclose(told["g"], arm.poses(theta)[arm.tip], atol=1e-14)


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_singular_values_and_what_is_made_of_them(arm: Arm) -> None:
    theta = posture(arm)
    told = numbers(arm, theta)
    J = np.array(differences(arm, theta)[1]) * units(arm)
    J[:3] /= arm.reach
    values = np.sqrt(np.clip(np.linalg.eigvalsh(J @ J.T if arm.n >= 6 else J.T @ J)[::-1], 0, None))
    assert_allclose(told["singular_values"], values, atol=1e-7)
    assert told["smallest"] == told["singular_values"][-1]
    assert told["condition"] == pytest.approx(values[0] / values[-1], rel=1e-4)
    assert told["yoshikawa"] == pytest.approx(np.prod(values), rel=1e-5)
    assert told["rank"] == min(6, arm.n)


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_ellipsoids_are_those_of_the_hybrid_jacobian(arm: Arm) -> None:
    theta = posture(arm)
    told = numbers(arm, theta)
    J = differences(arm, theta)[2] * units(arm)
    for name, rows in (("linear", J[:3]), ("angular", J[3:])):
        semi_axes, directions = np.array(told[name]["semi_axes"]), np.array(told[name]["directions"])
        assert_allclose(directions @ np.diag(semi_axes**2) @ directions.T, rows @ rows.T, atol=1e-7, err_msg=name)
        assert_allclose(directions.T @ directions, np.eye(3), atol=1e-14)
        assert np.all(np.diff(semi_axes) <= 0)


def test_flat_ellipsoids() -> None:
    told = numbers(STRETCHED, np.array([0.3, 0.5, -0.4]))
    assert told["linear"]["semi_axes"][2] == pytest.approx(0, abs=1e-15)  # a disc in x and y
    assert_allclose(np.abs(told["linear"]["directions"])[:, 2], [0, 0, 1], atol=1e-14)
    assert_allclose(told["angular"]["semi_axes"], [np.sqrt(3), 0, 0], atol=1e-14)  # a line along z
    one = ArmBuilder("one").revolute("a", [0, 1, 0], [0, 0, 0]).tool(STRETCHED.home).build()
    alone = numbers(one, np.zeros(1))  # fewer than three joints
    assert_allclose(alone["linear"]["semi_axes"], [1.5, 0, 0], atol=1e-14)
    assert_allclose(np.abs(alone["linear"]["directions"])[:, 0], [0, 0, 1], atol=1e-14)


def test_a_singular_posture_has_no_condition_and_says_what_is_lost() -> None:
    told = numbers(STRETCHED, np.array([0.7, 0.0, 0.0]))  # stretched along the tool's x
    assert (told["rank"], told["condition"]) == (2, None)
    assert "its x axis" in told["standing"]
    near = numbers(STRETCHED, np.array([0.7, 0.02, -0.01]))
    assert (near["rank"], near["smallest"] < near["below"]) == (3, True)
    assert "nearly" in near["standing"]
    assert "singular" not in numbers(STRETCHED, np.array([0.7, 0.9, 0.8]))["standing"]


# screws --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arm", ARMS.values(), ids=ARMS)
def test_each_column_is_its_screw(arm: Arm) -> None:
    theta = posture(arm)
    columns, expected = numbers(arm, theta)["columns"], differences(arm, theta)[0]
    for i in range(arm.n):
        assert_allclose(twist_of(columns, i), expected[:, i], atol=1e-8)
        assert np.dot(columns["axis"][i], columns["point"][i]) == pytest.approx(0, abs=1e-12)  # the nearest point


def test_a_follower_that_turns_back_makes_a_translation_of_two_turns(tmp_path: Path) -> None:
    told = numbers(pair(tmp_path, -1.0), np.array([0.6]))
    # The second body keeps its direction and runs about the first axis on a circle of 0.4 m.
    assert told["columns"]["pitch"] == [None]
    assert_allclose(told["columns"]["axis"], [[-np.sin(0.6), np.cos(0.6), 0]], atol=1e-14)
    assert told["columns"]["magnitude"][0] == pytest.approx(0.4)
    assert told["axes"]["pitch"] == [0, 0]  # neither drawn axis is that screw
    assert_allclose(told["axes"]["point"], [[0, 0, 0], [0.4 * np.cos(0.6), 0.4 * np.sin(0.6), 0]], atol=1e-14)


def test_a_thread_made_of_two_joints_has_its_pitch(tmp_path: Path) -> None:
    chain, home = random_chain(["revolute", "helical"], 11)
    chain[1] = Joint("helical", chain[1].R, chain[1].point, 0.005)
    arm = from_urdf(chain, home, tmp_path)
    told = numbers(arm, posture(arm))
    assert told["columns"]["pitch"][1] == pytest.approx(0.005, rel=1e-9)
    assert [axis["pitch"] for axis in axes(arm)["joints"]] == [0, 0, None]
    assert axes(by_hand(chain, home))["joints"][1]["pitch"] == pytest.approx(0.005, rel=1e-9)


# the stage -----------------------------------------------------------------------------------------------------------


def told(stage: Stage, kind: str = "theory") -> dict[str, Any] | None:
    return next((message for message in stage.messages() if message["type"] == kind), None)


def switched_on(arm: Arm) -> Stage:
    stage = Stage(arm)
    stage.needed = frozenset({"theory"})
    return stage


def motion_of(arm: Arm) -> Trajectory:
    limits = {"velocity": 1.0, "acceleration": 2.0}
    return plan_joint(arm, [posture(arm, 1), posture(arm, 2)], limits=limits)


def test_nothing_is_computed_unless_somebody_looks() -> None:
    stage = Stage(ARMS["rover_arm"])
    assert told(stage) is None
    assert told(stage, "axes") is told(stage, "axes")
    stage.needed = frozenset({"theory"})
    assert told(stage) is not None
    stage.needed = frozenset({"collision", "reach"})
    assert told(stage) is None


def test_the_joint_that_moved() -> None:
    stage = switched_on(ARMS["rover_arm"])
    assert told(stage)["moved"] == 0  # type: ignore[index]
    ask(stage, "joint", name="elbow", value=0.3)
    assert told(stage)["moved"] == 2  # type: ignore[index]
    ask(stage, "joint", name="elbow", value=0.3)
    assert told(stage)["moved"] == 2  # type: ignore[index]


@pytest.mark.parametrize(("sigma", "near"), [
    (0.039, True), (0.041, False), (0.06, False), (0.0201, True),
])  # fmt: skip
def test_nearly_singular_begins_at_a_singular_value_of_a_25th(sigma: float, near: bool) -> None:
    """Two slides at an angle of 2 a to each other, about x: singular values √2 cos a and √2 sin a, along x and y."""
    a = np.arcsin(sigma / np.sqrt(2))
    builder = ArmBuilder("scissors").prismatic("p", [np.cos(a), np.sin(a), 0], lower=-1, upper=1)
    arm = builder.prismatic("q", [np.cos(a), -np.sin(a), 0], lower=-1, upper=1).tool(np.eye(4)).build()
    said = numbers(arm, np.zeros(2))
    assert said["smallest"] == pytest.approx(sigma, abs=1e-12)
    assert (said["below"], "its y axis" in said["standing"]) == (0.04, near)


def test_the_screw_of_a_motion() -> None:
    arm = ARMS["panda"]
    stage, trajectory = switched_on(arm), motion_of(ARMS["panda"])
    stage.load(trajectory).play(0.0)
    assert told(stage)["motion"] is None  # type: ignore[index]  # at rest
    t, step = 0.4, 1e-5
    stage.advance(t)
    motion = told(stage)["motion"]  # type: ignore[index]
    before, here, after = (arm.fk(trajectory(t + shift)) for shift in (-step, 0.0, step))
    rate = (after - before) / (2 * step)
    assert_allclose(motion["twist"], unhat(rate @ np.linalg.inv(here)), atol=1e-8)
    assert_allclose(motion["velocity"], rate[:3, 3], atol=1e-8)
    assert_allclose(twist_of(motion["screw"]), motion["twist"], atol=1e-13)
    ask(stage, "pause")
    assert told(stage)["motion"] == motion  # type: ignore[index]
    stage.show(stage.theta + 0.01)  # elsewhere: no longer the motion's
    assert told(stage)["motion"] is None  # type: ignore[index]


# the stand-alone page ------------------------------------------------------------------------------------------------


def test_a_recorded_motion_has_the_numbers_of_its_moments() -> None:
    arm, trajectory = ARMS["panda"], motion_of(ARMS["panda"])
    record = sampled_theory(arm, arm.ready, trajectory)
    assert record["times"][0] == 0
    assert record["times"][-1] == pytest.approx(trajectory.duration, abs=1e-6)
    k = len(record["times"]) // 2
    theta = trajectory(np.linspace(0, trajectory.duration, len(record["times"]))[k])
    assert_allclose(record["numbers"][k]["spatial"], differences(arm, theta)[0], atol=1e-6)
    assert record["numbers"][k]["motion"] is not None
    assert_allclose(record["aside"]["body"], differences(arm, arm.ready)[1], atol=1e-6)
    assert sampled_theory(arm, arm.ready, None)["numbers"] == [record["aside"]]
