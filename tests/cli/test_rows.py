"""Rows of numbers as strangers write them, and back; every configuration of a target."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from catalogue import load
from ik_targets import pinocchio_fk, require_core
from test_cli import Capture, answer, error_of, printed
from twistarm import load_arm
from twistarm.cli.application import run

# Roll, pitch, yaw about the base's axes, by SciPy.
ROTATION = Rotation.from_euler("xyz", [170, 5, 40], degrees=True)

QX, QY, QZ, QW = ROTATION.as_quat()

AS_WRITTEN = {
    "header, commas, quaternions": f"x,y,z,qx,qy,qz,qw\n0.4,0.1,0.3,{QX},{QY},{QZ},{QW}\n",
    "scalar first, in another order": f"qw,qx,qy,qz,z,y,x\n{QW},{QX},{QY},{QZ},0.3,0.1,0.4\n",
    "names of ROS, semicolons, a byte-order mark": "\ufeffposition.x;position.y;position.z;orientation.x;orientation.y;"
    f"orientation.z;orientation.w\r\n0.4;0.1;0.3;{QX};{QY};{QZ};{QW}\r\n",
    "units, tabs, a column of words": "name\tX [mm]\tY [mm]\tz (m)\troll_deg\tpitch [deg]\tyaw [°]\n"
    "pick\t400\t100\t0.3\t170\t5\t40\n",
    "a comment, spaces": "# picks\nx y z roll pitch yaw\n0.4 0.1 0.3 {} {} {}\n".format(*np.radians([170, 5, 40])),
}


@pytest.mark.parametrize("case", AS_WRITTEN)
def test_a_strangers_targets_are_read(case: str, tmp_path: Path, capsys: Capture) -> None:
    arm, file = load("ur5"), tmp_path / "targets.csv"
    file.write_text(AS_WRITTEN[case], "utf-8")
    (found,) = answer(capsys, "ik", "ur5", "--targets", str(file))["answers"]
    g = pinocchio_fk(arm, np.array(found["theta"]))
    assert np.allclose(g[:3, 3], [0.4, 0.1, 0.3], atol=2e-6)
    assert np.linalg.norm(pin.log3(g[:3, :3] @ ROTATION.as_matrix().T)) < 3e-6


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_standard_input_is_read_as_a_file_is(encoding: str, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    data = AS_WRITTEN["units, tabs, a column of words"].encode(encoding)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(data), "utf-8"))
    (found,) = answer(capsys, "ik", "ur5", "--targets", "-")["answers"]
    assert np.allclose(pinocchio_fk(load("ur5"), np.array(found["theta"]))[:3, 3], [0.4, 0.1, 0.3], atol=2e-6)


def test_positions_without_a_header_take_the_orientation_that_is_typed(tmp_path: Path, capsys: Capture) -> None:
    arm, file, out = load("ur5"), tmp_path / "targets.csv", tmp_path / "answers.csv"
    require_core(arm)
    file.write_text("# picks\n0.4,0.1,0.3\n\n9,9,9\n0.4,-0.1,0.3\n", "utf-8")
    typed = ["--targets", str(file), "--direction", "0", "0", "-1", "--axis", "-x", "-o", str(out)]
    assert answer(capsys, "ik", "ur5", *typed, code=1)["converged"] == 2
    rows = list(csv.DictReader(io.StringIO(out.read_text())))
    assert [(row["line"], row["answer"]) for row in rows] == [
        ("2", "CONVERGED"), ("4", "OUT_OF_REACH"), ("5", "CONVERGED"),
    ]  # fmt: skip
    theta = np.array([[float(row[f"{name} [rad]"]) for name in arm.joint_names] for row in rows])
    g = pinocchio_fk(arm, theta[2])
    assert np.allclose(g[:3, 3], [0.4, -0.1, 0.3], atol=2e-6)
    assert np.allclose(-g[:3, 0], [0, 0, -1], atol=2e-6)


def test_answers_are_postures_and_poses_are_targets(here: Path, capsys: Capture) -> None:
    arm = load("rover_arm")
    theta = arm.random_theta(2, 30)
    np.savetxt("theta.txt", theta)
    assert run(["fk", "rover_arm", "--configurations", "theta.txt", "-o", "poses.csv"]) == 0
    assert run(["ik", "rover_arm", "--targets", "poses.csv", "-o", "theta.csv"]) == 0
    capsys.readouterr()
    assert run(["fk", "rover_arm", "--configurations", "theta.csv", "--json"]) == 0
    out, err = capsys.readouterr()
    assert "warning" not in err
    for pose, x in zip(json.loads(out)["poses"], theta, strict=True):
        assert np.allclose(pose["matrix"], pinocchio_fk(arm, x), atol=1e-5)


def test_joints_may_be_left_out_and_be_in_degrees(tmp_path: Path, capsys: Capture) -> None:
    arm, file = load("rover_arm"), tmp_path / "p.csv"
    file.write_text("wrist_roll [deg],slide_mm\n90,100\n", "utf-8")
    assert run(["fk", "rover_arm", "--configurations", str(file), "--json"]) == 0
    out, err = capsys.readouterr()
    assert all(name in err for name in ("shoulder", "elbow", "wrist_pitch"))
    (pose,) = json.loads(out)["poses"]
    assert np.allclose(pose["theta"], [0.1, *arm.ready[1:4], np.pi / 2])
    file.write_text("elbow\n90\n", "utf-8")
    assert run(["fk", "rover_arm", "--configurations", str(file)]) == 0
    assert "line 2" in capsys.readouterr().err, "90 rad are outside the limits"


BAD = {
    "numbers that are none": ("x,y,z\n1,a,1\n1,1,1\n1,,1\n", "line 2: column 2"),
    "a row too short": ("x,y,z\n1,1,1\n1,1\n", "line 3"),
    "decimal commas": ("0,4;0,1;0,3\n", "line 1: column 1"),
    "no length": ("x,y,z,dx,dy,dz\n1,1,1,0,0,0\n", "line 2: direction"),
    "degrees": ("x,y,z,roll,pitch,yaw\n1,1,1,0,90,0\n", "line 2: an angle of 90"),
    "a rotation vector or not": ("x,y,z,rx,ry,rz\n1,1,1,0,0,0\n", "rx, ry, rz"),
    "half an orientation": ("x,y,z,roll\n1,1,1,0\n", "pitch, yaw"),
    "two orientations": ("x,y,z,dx,dy,dz,roll,pitch,yaw\n1,1,1,0,0,1,0,0,0\n", "t.csv"),
    "an unknown unit": ("x [ft],y,z\n1,1,1\n", "column x"),
    "a column twice": ("x,y,z,X\n1,1,1,1\n", "hold x"),
    "no names for so many": ("1,1,1,1\n", "x, y, z"),
    "nothing": ("", "t.csv"),
    "half a header": ("x,y,3\n1,1,1\n", "line 1"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_rows_are_named_and_nothing_is_written(case: str, tmp_path: Path, capsys: Capture) -> None:
    text, culprit = BAD[case]
    file, out = tmp_path / "t.csv", tmp_path / "out.csv"
    file.write_text(text, "utf-8")
    assert culprit in error_of(capsys, "ik", "ur5", "--targets", str(file), "-o", str(out))
    assert not out.exists()


@pytest.mark.parametrize("typed", ["--quaternion 0 1 0 0", "--quaternion-xyzw 1 0 0 0", "--rpy 540 0 0"])
def test_an_orientation_is_typed_in_three_ways(typed: str, capsys: Capture) -> None:
    theta = answer(capsys, "ik", "ur5", "--xyz", "0.4", "0.1", "0.3", *typed.split())["theta"]
    assert np.allclose(pinocchio_fk(load("ur5"), np.array(theta))[:3, :3], np.diag([1, -1, -1]), atol=3e-6)


@pytest.mark.parametrize(("angle", "code"), [("2.5", 0), ("1.5", 1), ("0.044 --rad", 0), ("0.026 --rad", 1)])
def test_a_tolerance_is_what_is_typed(angle: str, code: int, capsys: Capture) -> None:
    """The tool of this arm stays in a plane: a goal that is turned out of it by 2° is missed by 2°."""
    arm = load("rover_arm")
    g = pinocchio_fk(arm, np.array([0.1, 0.6, -1.1, 0.5, 0.0]))
    R = Rotation.from_euler("z", 2.0, degrees=True) * Rotation.from_matrix(g[:3, :3])
    goal = ["--xyz", *map(str, g[:3, 3]), "--quaternion-xyzw", *map(str, R.as_quat())]
    content = answer(capsys, "ik", "rover_arm", *goal, "--orientation-tol", *angle.split(), code=code)
    assert content["converged"] == (code == 0)


AT = ["ik", "rover_arm", "--all", "--xyz", "0.8", "0.1", "0.7"]
ROVER = [*AT, "--direction", "1", "0", "0"]  # Elbow up and elbow down.


def rows_at(p: list[float], out: Path) -> list[dict[str, str]]:
    """The rows of a CSV of configurations, each of which puts the tool at p (3,)."""
    arm = load_arm("rover_arm")
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        theta = [float(row[f"{name} [{unit}]"]) for name, unit in zip(arm.joint_names, arm.units, strict=True)]
        g, _, _ = arm.by_pinocchio(theta)
        assert np.allclose(g[:3, 3], p, atol=1e-9)
        assert arm.limits.contains(theta) == (row["within_limits"] == "yes")
    return rows


def test_all_of_them_nearest_first(capsys: Capture) -> None:
    arm = load_arm("rover_arm")
    content = answer(capsys, *ROVER)
    assert content["complete"]
    assert content["method"] == "closed form"
    assert content["free"] == [["wrist_roll"]] * 2
    for theta in content["theta"]:
        g, _, _ = arm.by_pinocchio(theta)
        np.testing.assert_allclose(g[:3, 2:].T, [[1, 0, 0], [0.8, 0.1, 0.7]], atol=1e-9)
    far = [np.abs(np.array(theta) - arm.ready).max() for theta in content["theta"]]
    assert far == sorted(far)
    assert content["theta"][0][2] * content["theta"][1][2] < 0, "elbow up and elbow down"


def test_it_is_a_table_that_can_be_pasted(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = printed(capsys, *ROVER).splitlines()
    assert max(map(len, lines[1:6])) <= 80
    typed = next(line for line in lines if line.startswith("--theta")).removeprefix("--theta ").strip('"')
    pose = answer(capsys, "fk", "rover_arm", "--theta", typed)
    assert np.allclose(pose["position"], [0.8, 0.1, 0.7], atol=1e-6)


def test_fixed_joints_stand_where_they_are_told(capsys: Capture) -> None:
    held = answer(capsys, *AT, "--fixed-joint", "wrist_pitch=10", "wrist_roll=30")
    assert held["complete"]
    assert np.allclose(np.array(held["theta"])[:, 3:], np.radians([10, 30]))


def test_csv_has_those_outside_the_limits_too(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    pose = ["--xyz", "0.2", "0.1", "0.7", "--direction", "-1", "0", "0"]
    found = answer(capsys, "ik", "rover_arm", "--all", *pose, "-o", str(out))
    assert (len(found["theta"]), len(found["outside"])) == (1, 1)
    assert [row["within_limits"] for row in rows_at([0.2, 0.1, 0.7], out)] == ["yes", "no"]


def test_a_position_is_a_family_with_one_row_and_its_free_joints(tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "all.csv"
    found = answer(capsys, *AT, "-o", str(out))
    assert not found["complete"]
    rows = [row for row in rows_at([0.8, 0.1, 0.7], out) if row["within_limits"] == "yes"]
    assert [int(row["number"]) for row in rows] == [*range(1, len(found["theta"]) + 1)] != []
    assert all("wrist_roll" in free for free in found["free"])


@pytest.mark.parametrize("asked", ["--xyz 5 0 0 --direction 1 0 0", "--xyz 0.6 0.1 0.7 --rpy 20 0 0"])
def test_none_is_an_answer_with_exit_code_1(asked: str, capsys: Capture) -> None:
    require_core(load_arm("rover_arm"))
    found = answer(capsys, "ik", "rover_arm", "--all", *asked.split(), code=1)
    assert (found["theta"], found["complete"]) == ([], True)
    assert printed(capsys, "ik", "rover_arm", "--all", *asked.split(), code=1)
