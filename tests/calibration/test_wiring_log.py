"""Logs as CSV: read strictly, every error with its line; and `twistarm wiring` with its exit codes."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from twistarm import Arm, InputError, load_arm
from twistarm.calibration import read_log
from twistarm.cli.application import run
from twistarm.support.checks import Array
from twistarm.theory.rotations import to_xyzw
from wiring_logs import fitted

Capture = pytest.CaptureFixture[str]

MOTORS = """
[actuators.rail]
ratio = { slide = 400.0 }
unit = "turn"
[actuators.shoulder]
ratio = { shoulder = 100.0 }
offset = 0.4
limits = { velocity = 90.0 }
[actuators.elbow]
ratio = { elbow = -80.0 }
[actuators.left]
ratio = { wrist_pitch = 60.0, wrist_roll = 60.0 }
unit = "tick"
ticks_per_turn = 4096
limits = { velocity = 120.0, effort = 0.2 }
[actuators.right]
ratio = { wrist_pitch = 60.0, wrist_roll = -60.0 }
unit = "tick"
ticks_per_turn = 4096
limits = { velocity = 120.0, effort = 0.2 }
"""

HEADER = "rail [turn],shoulder,elbow [rad],left [tick], right [tick] ,x [m],y,z"
ROW = "1.5,2,-3,100,-100,0.5,0.1,0.7"


@pytest.fixture
def toml(tmp_path: Path) -> Path:
    """The rover arm with motors, in a folder of its own."""
    folder = tmp_path / "arm"
    shutil.copytree(Path(__file__).parents[2] / "robots" / "rover_arm", folder)
    path = folder / "arm.toml"
    path.write_text(path.read_text("utf-8") + MOTORS, "utf-8")
    return path


def csv(folder: Path, *lines: str) -> Path:
    path = folder / "log.csv"
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def written(arm: Arm, folder: Path, *, factor: Array | None = None, poses: bool = True) -> Path:
    """15 moments as drives and a camera would log them; `factor` (5,) multiplies the counts."""
    rng = np.random.default_rng(0)
    theta = arm.random_theta(rng, 15)
    counts = fitted(arm).to_counts(fitted(arm).to_motor(theta)) * (1.0 if factor is None else factor)
    g = arm.by_pinocchio(theta)[0]
    columns = [counts, g[:, :3, 3] + rng.normal(scale=0.001, size=(15, 3))]
    columns += [to_xyzw(g[:, :3, :3])] if poses else []
    lines = [",".join(f"{x:.6f}" for x in row) for row in np.hstack(columns)]
    return csv(folder, HEADER + (",qx,qy,qz,qw" if poses else ""), *lines)


def test_columns_by_name_in_any_order(toml: Path, tmp_path: Path) -> None:
    motors = fitted(load_arm(toml))
    path = csv(tmp_path, "# by tape", "z,y,x,left,right,elbow,shoulder,rail", "", "3,2,1,40,50,30,20,10", "  # end")
    log = read_log(path, motors)
    assert log.names == ("rail", "shoulder", "elbow", "left", "right")
    assert log.counts.tolist() == [[10, 20, 30, 40, 50]]
    assert log.measured.tolist() == [[1, 2, 3]]
    for separator in (";", "\t"):
        lines = [line.replace(",", separator) for line in (HEADER, ROW)]
        assert read_log(csv(tmp_path, *lines), motors).counts.tolist() == [[1.5, 2, -3, 100, -100]]
    # A quarter turn about z: qz = qw = √½.
    turned = read_log(csv(tmp_path, HEADER + ",qw,qx,qy,qz", ROW + ",0.7071,0,0,0.7071"), motors)
    assert np.allclose(turned.measured[0], np.array([[0, -1, 0, 0.5], [1, 0, 0, 0.1], [0, 0, 1, 0.7], [0, 0, 0, 1]]))


REFUSED = {
    "nothing": ((), "no line but comments; the first names the columns: the columns are rail, shoulder"),
    "no such motor": ((HEADER.replace("left", "lefty"),), "line 1: unknown column 'lefty'; closest: 'left'"),
    "a motor is missing": ((HEADER.replace("elbow [rad],", ""),), "line 1: no column 'elbow'; the columns are"),
    "a column twice": ((HEADER + ",x",), "line 1: column 'x' stands there twice"),
    "another unit": ((HEADER.replace("[turn]", "[rad]"),), "line 1: column 'rail' is in [turn]"),
    "millimetres": ((HEADER.replace("x [m]", "x [mm]"),), "line 1: column 'x' is in [m]; got [mm]"),
    "decimal commas": ((HEADER.replace(",", ";"), ROW.replace(",", ";").replace(".", ",")), "line 2: column 1"),
    "too few": ((HEADER, ROW, "1,2,3"), "line 3: 3 values where there are 8 columns"),
    "no number": ((HEADER, "#", ROW.replace("100", "1O0", 1)), "line 3: column 4"),
    "no rotation": ((HEADER + ",qx,qy,qz,qw", ROW + ",0,0,0,0"), "line 2: qx qy qz qw must be of length 1; got 0"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_log_that_cannot_be_used_is_refused_in_one_line(
    case: str, toml: Path, tmp_path: Path, capsys: Capture
) -> None:
    lines, message = REFUSED[case]
    path = csv(tmp_path, *lines)
    motors = fitted(load_arm(toml))
    with pytest.raises(InputError) as caught:
        read_log(path, motors)
    assert message in str(caught.value)
    assert run(["wiring", str(toml), str(path)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.count("\n") == 1


def test_a_file_that_is_not_there(toml: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read .*no.csv: no such file"):
        read_log(tmp_path / "no.csv", fitted(load_arm(toml)))


def test_a_sound_arm(toml: Path, tmp_path: Path, capsys: Capture) -> None:
    path = written(load_arm(toml), tmp_path)
    assert run(["wiring", str(toml), str(path)]) == 0
    shown = capsys.readouterr().out
    assert "sound: signs, ratios and zeros fit the log" in shown
    assert "15 rows; measured against computed: 1." in shown


def test_a_fault_is_named_with_the_entries_to_write(toml: Path, tmp_path: Path, capsys: Capture) -> None:
    path = written(load_arm(toml), tmp_path, factor=np.array([1.0, 1.0, -1.0, 1.0, 1.0]))
    assert run(["wiring", str(toml), str(path)]) == 1
    fault = "elbow: its sign is flipped; as wired, [actuators.elbow] has ratio = { elbow = 80 }, offset = 0"
    assert fault in capsys.readouterr().out
    assert run(["wiring", str(toml), str(path), "--json"]) == 1
    content = json.loads(capsys.readouterr().out)
    assert (content["ok"], content["verdict"], content["rows"]) == (False, "fault", 15)
    assert [motor["faults"] for motor in content["motors"]] == [[], [], ["flipped sign"], [], []]
    assert content["motors"][2]["ratio"] == {"elbow": 80.0}


def test_a_log_that_cannot_tell(toml: Path, tmp_path: Path, capsys: Capture) -> None:
    path = written(load_arm(toml), tmp_path, poses=False)
    assert run(["wiring", str(toml), str(path)]) == 1
    shown = capsys.readouterr().out
    unseen = "the log does not show its zero, nor whether it is swapped with 'right'"
    assert f"left: {unseen}; measure the tool's orientation too" in shown
    assert "± ?" in shown
    assert shown.splitlines()[-1] == (
        "cannot tell: the log does not show the zero of 'left' and 'right', "
        "nor whether 'left' and 'right' are swapped; what it does show is sound"
    )


def test_info_shows_what_the_motors_allow(toml: Path, capsys: Capture) -> None:
    assert run(["info", str(toml), "--rad"]) == 0
    shown = capsys.readouterr().out
    assert "limits of the motors" in shown
    row = next(line for line in shown[shown.index("moving alone") :].splitlines() if "wrist_roll" in line)
    assert row.split() == ["wrist_roll", "rad", "2", "24"]
    assert run(["info", str(toml), "--json"]) == 0
    motors = json.loads(capsys.readouterr().out)["actuators"]
    assert motors["limits"]["velocity"] == [None, 90.0, None, 120.0, 120.0]
    assert motors["joint_limits"]["velocity"] == [None, 0.9, None, 2.0, 2.0]
    assert motors["names"] == ["rail", "shoulder", "elbow", "left", "right"]
