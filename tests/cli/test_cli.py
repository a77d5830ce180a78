"""The command line as a person and as a program uses it: answers, exit codes, one-line errors, nothing half-written."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import twistarm
from twistarm.arm.usual_limits import with_defaults
from twistarm.cli.application import run
from twistarm.theory.rotations import from_rpy
from urdf_text import two_joints, write

Capture = pytest.CaptureFixture[str]

PROGRAM = Path(sys.executable).with_name("twistarm")


def printed(capsys: Capture, *arguments: str, code: int = 0) -> str:
    """What a command prints; it must exit with `code`."""
    assert run(arguments) == code
    return capsys.readouterr().out


def answer(capsys: Capture, *arguments: str, code: int = 0) -> Any:
    """The JSON that a command prints."""
    return json.loads(printed(capsys, *arguments, "--json", code=code))


def error_of(capsys: Capture, *arguments: str, code: int = 2) -> str:
    """The one line that a command which cannot work prints on stderr; it must exit with `code`."""
    assert run(arguments) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("error: ")
    assert captured.err.count("\n") == 1
    return captured.err


# -- good answers ------------------------------------------------------------------------------------------------


def test_info_tells_what_was_loaded(capsys: Capture) -> None:
    content = answer(capsys, "info", "rover_arm")
    assert [joint["name"] for joint in content["joints"]] == [
        "slide", "shoulder", "elbow", "wrist_pitch", "wrist_roll",
    ]  # fmt: skip
    assert content["joints"][0] | {"effort": 0} == {
        "name": "slide", "type": "prismatic", "lower": -0.5, "upper": 0.5,
        "velocity": 0.5, "acceleration": content["joints"][0]["acceleration"], "jerk": None, "effort": 0,
    }  # fmt: skip
    assert content["joints"][4]["lower"] is None
    assert (content["base"], content["tip"], content["tool_axis"]) == ("base_link", "tool0", [0.0, 0.0, 1.0])
    for name, words in {"rover_arm": "wrist_roll turns the tool about it", "rr_planar": "a line 0.300 m"}.items():
        run(["info", name])
        assert words in capsys.readouterr().out


def test_arms_lists_the_catalogue(capsys: Capture) -> None:
    content = answer(capsys, "arms")
    assert set(content["own"]) | set(content["models"]) == set(twistarm.available_arms())


NUMBERS = ("-0.1", "-30", "45", "10", "-90")


@pytest.mark.parametrize(
    "words",
    [
        ["rover_arm", "--theta", "-0.1 -30 45 10 -90"],
        ["rover_arm", "--theta", "([-0.1; −30; 45; 10; -90])"],
        ["rover_arm", "--theta", "elbow=45 slide=-0.1 shoulder=-30 wrist_roll=-90 wrist_pitch=10"],
        ["rover_arm", "--rad", "--theta", "-0.1 -0.5235987755983 0.7853981633974 0.1745329251994 -1.5707963267949"],
        ["--theta", *NUMBERS, "rover_arm"],
        ["rover_arm", f"--theta={NUMBERS[0]}", *NUMBERS[1:]],
        ["rover_arm", "--theta", "[-0.1,", "-30,", "45,", "10,", "-90]"],
        ["rover_arm", "--theta", "elbow=45", "slide=-0.1", "shoulder=-30", "wrist_pitch=10", "wrist_roll=-90"],
    ],
)
def test_fk_takes_degrees_and_metres_with_and_without_quotes(
    words: list[str], capsys: Capture, rover: twistarm.Arm
) -> None:
    theta = np.array([-0.1, *np.radians([-30.0, 45.0, 10.0, -90.0])])
    content = answer(capsys, "fk", *words)
    assert np.allclose(content["theta"], theta, atol=1e-12)
    assert np.allclose(content["matrix"], rover.fk(theta), atol=1e-12)
    assert np.allclose(from_rpy(content["rpy"]), rover.fk(theta)[:3, :3], atol=1e-12)


def test_every_option_of_several_numbers_takes_them_without_quotes(capsys: Capture, rover: twistarm.Arm) -> None:
    content = answer(capsys, "ik", "--xyz", "0.8", "-0.1", "0.7", "--direction", "1", "0", "-0.1", "rover_arm",
                     "--start", *NUMBERS, "--posture", *NUMBERS)  # fmt: skip
    g = rover.fk(content["theta"])
    assert np.allclose(g[:3, 3], [0.8, -0.1, 0.7], atol=1e-5)
    assert np.allclose(g[:3, 2], np.array([1, 0, -0.1]) / np.sqrt(1.01), atol=1e-5)
    assert (content["converged"], content["joint_names"]) == (True, list(rover.joint_names))
    planned = answer(
        capsys, "plan", "rover_arm", "--to", "0", "-20", "45", "10", "0", "--to", "ready", "--from", *NUMBERS
    )
    assert np.allclose(planned["waypoints"][1], [0, *np.radians([-20, 45, 10, 0])])


def test_a_tool_stands_where_it_is_seen_from_the_tip(capsys: Capture, rover: twistarm.Arm) -> None:
    g = rover.fk(rover.ready)
    seen = np.array(answer(capsys, "fk", "rover_arm", "--tool", "0.01", "0", "0.12")["matrix"])
    np.testing.assert_allclose(seen[:3, :3], g[:3, :3], atol=1e-12)
    np.testing.assert_allclose(seen[:3, 3], g[:3, 3] + g[:3, :3] @ [0.01, 0.0, 0.12], atol=1e-12)


def test_a_folder_as_arm_names_the_descriptions_in_it(capsys: Capture, tmp_path: Path) -> None:
    write(tmp_path, two_joints())
    assert all(file.name in error_of(capsys, "info", str(tmp_path)) for file in tmp_path.glob("*.urdf"))


def test_ik_of_many_targets_tells_how_each_is_missed(capsys: Capture, tmp_path: Path, rover: twistarm.Arm) -> None:
    targets = tmp_path / "targets.csv"
    targets.write_text("x [m],y [m],z [m]\n0.8,0.1,0.7\n9,0,0.5\n", "utf-8")
    near, far = answer(capsys, "ik", "rover_arm", "--targets", str(targets), code=1)["answers"]
    assert (near["line"], near["stop"], far["line"], far["stop"]) == (2, "CONVERGED", 3, "OUT_OF_REACH")
    missed = np.linalg.norm(rover.fk(far["theta"])[:3, 3] - [9.0, 0.0, 0.5])
    assert far["position_error"] == pytest.approx(missed, abs=1e-9)


def test_joints_that_are_left_out_stay(capsys: Capture, rover: twistarm.Arm) -> None:
    assert answer(capsys, "fk", "rover_arm", "--theta", "elbow=60")["theta"] == [
        *rover.ready[:2],
        np.radians(60.0),
        *rover.ready[3:],
    ]
    planned = answer(capsys, "plan", "rover_arm", "--from", "stowed", "--to", "elbow=60", "--to", "slide=0.1")
    stowed = rover.theta_from("stowed")
    assert np.allclose(planned["waypoints"][1], [*stowed[:2], np.radians(60.0), *stowed[3:]])
    assert np.allclose(planned["waypoints"][2], [0.1, stowed[1], np.radians(60.0), *stowed[3:]])


def test_a_printed_theta_is_pasted_back(capsys: Capture, rover: twistarm.Arm) -> None:
    """At a limit too, which no decimals meet."""
    theta = rover.limits.upper[:4].tolist() + [1 / 3]
    typed = ["--rad", "--theta", *(repr(x) for x in theta)]
    for radians in ([], ["--rad"]):
        shown = printed(capsys, "ik", "rover_arm", "--xyz", "5", "1", "1", *radians, code=1)
        line = next(line for line in shown.splitlines() if line.startswith("--theta"))
        content = answer(capsys, "fk", "rover_arm", *shlex.split(line))
        captured = rover.limits.contains(content["theta"])
        assert captured, "nothing lies outside by rounding"
    assert answer(capsys, "fk", "rover_arm", *typed)["theta"][:4] == theta[:4]


def test_fk_warns_outside_the_limits(capsys: Capture) -> None:
    assert run(["fk", "rover_arm", "--theta", "0.7 0 0 0 0"]) == 0
    assert "slide = 0.7 m" in capsys.readouterr().err


def test_jacobian(capsys: Capture, rover: twistarm.Arm) -> None:
    content = answer(capsys, "jacobian", "rover_arm")
    assert np.allclose(content["spatial_jacobian"], rover.spatial_jacobian(rover.ready), atol=1e-12)
    assert np.allclose(content["body_jacobian"], rover.body_jacobian(rover.ready), atol=1e-12)
    assert set(answer(capsys, "jacobian", "rover_arm", "--kind", "hybrid")) >= {"hybrid_jacobian", "condition"}


def test_plan_says_where_it_starts_unless_told(capsys: Capture, rover: twistarm.Arm) -> None:
    """As it would be typed: the line, handed back as --from, plans the same motion."""
    assert run(["plan", "rover_arm", "--to", "reach"]) == 0
    typed = re.search(r'--from "(.*)"', capsys.readouterr().err)
    assert typed
    first, again = (
        answer(capsys, "plan", "rover_arm", "--to", "reach", *start) for start in ([], ["--from", typed[1]])
    )
    assert (first["start"], again["start"]) == ("ready", typed[1])
    assert np.allclose(first["waypoints"], again["waypoints"], atol=1e-6)
    assert np.array_equal(first["waypoints"][0], rover.ready)


def test_plan_caps_lower_the_arms_limits_and_never_raise_them(capsys: Capture, rover: twistarm.Arm) -> None:
    for cap in ("20", "0.2"):
        content = answer(capsys, "plan", "rover_arm", "--to", "stowed", "--velocity", cap, "--acceleration", cap)
        for rate in ("velocity", "acceleration"):
            limit = np.minimum(getattr(with_defaults(rover), rate), float(cap))
            assert (np.array(content[f"peak_{rate}"]) <= limit + 1e-9).all()


def test_check_and_freeze(capsys: Capture, here: Path) -> None:
    path = write(here, two_joints())
    assert run(["freeze", str(path)]) == 0
    capsys.readouterr()
    check = ["check", str(path), "--samples", "20", "--against", "tiny.golden.json"]
    assert answer(capsys, *check)["unchanged"]
    write(here, two_joints(xyz="0.012 0 0.5"))
    content = answer(capsys, *check, code=1)
    assert (content["ok"], content["unchanged"]) == (False, False)
    assert "joint a" in content["changes"][0]
    assert answer(capsys, "check", str(path), "--samples", "20")["ok"]


def test_demo_without_a_terminal_writes_both_files(capsys: Capture, here: Path) -> None:
    shown = printed(capsys, "demo", "--no-view")
    for station in ("spatial Jacobian", "all engines agree", "CONVERGED", "demo.html", "demo.csv"):
        assert station in shown
    assert (here / "demo.html").stat().st_size > 500_000
    assert (here / "demo.csv").read_text().count("\n") > 50


# -- bad input ---------------------------------------------------------------------------------------------------

IK = "ik rover_arm --xyz '1 0 0' "
PLAN = "plan rover_arm --to zero "
SERVO = "servo scara --no-browser "
FOLLOW = "follow rr_planar nowhere.json --no-browser "  # What is refused is refused before the file is read.

BAD = (
    ("info rover_amr", "'rover_amr'"),
    ("inof rover_arm", "inof"),
    ("info --tip tool0", "ARM"),
    ("info rover_arm --xacro deck=1", "--xacro deck:=1"),
    ("info rover_arm --package-dir nowhere", "nowhere"),
    ("fk rover_arm --theta '1 2'", "takes 5 values"),
    ("fk rover_arm --theta 1 -2 x 4 5", "'x'"),
    ("fk rover_arm 0 -30 0 0 0", "--theta 0 -30 0 0 0"),
    ("ik rover_arm 1 0 0", "--xyz 1 0 0"),
    ("fk rover_arm -theta 0", "--theta"),
    ("fk rover_arm --theta '0 0 nan 0 0'", "elbow"),
    ("fk rover_arm --theta 'slide=1 slide=2'", "slide, slide"),
    ("fk rover_arm --frame tol0", "'tool0'"),
    ("ik rover_arm", "--xyz"),
    ("ik rover_arm --xyz '1e300 0 0'", "metres"),
    (IK + "--rpy '0 0 0' --direction '1 0 0'", "--rpy or --direction"),
    (IK + "--targets t.csv", "--targets"),
    (IK + "--axis x", "--axis"),
    (IK + "--xyz '1 0 0' --position-tol 0.1 --position-tol=0.2", "--position-tol"),
    (PLAN + "--avoid self --keep level --scene self", "--avoid"),
    (IK + "--direction '1 0 0' --axis up", "'up'"),
    (IK + "--fixed-joint elbow=5", "--all"),
    (IK + "--include-turns", "--all"),
    (IK + "--all --fixed-joint 3", "--fixed-joint"),
    (IK + "--all --fixed-joint elbow=500", "500°"),
    (IK + "--all --posture middle", "--posture"),
    ("plan rover_arm", "--to"),
    ("guide print rotation", "closest: '2_1_1_rotation_matrices', '2_1_2_exponential_rotations' ("),
    (PLAN + "--avoid none.toml", "error: none.toml: no such file"),
    ("plan rover_arm --to '0.7 0 0 0 0'", "slide"),
    (PLAN + "x", "'x'"),
    ("plan rover_arm motion.toml --line --stop", "--line, --stop"),
    ("plan rover_arm motion.toml --direction '0 0 1'", "--xyz"),
    (PLAN + "--velocity 0", "--velocity"),
    (PLAN + "--to ready --blend 0.1", "--blend"),
    (PLAN + "--line --stop --blend 0.1", "--stop"),
    (PLAN + "--kind quintic", "--kind quintic"),
    ("plan rover_arm" + " --xyz '1 0 1'" * 3 + " --direction '0 0 1'" * 2, "got 2 for 3 --xyz"),
    (SERVO + "--theta '0 200 0 0'", "joint_2 = 200 °"),
    (SERVO + "--on-unreachable jump", "'jump'"),
    (SERVO + "--velocity-mode", "--udp or --serial"),
    (SERVO + "--udp 127.0.0.1:5005", "--listen"),
    (SERVO + "--serial /dev/ttyX --udp 127.0.0.1:5005 --listen 127.0.0.1:0", "not on both"),
    (SERVO + "--serial /dev/no_such_port", "'/dev/no_such_port'"),
    (SERVO + "--from 127.0.0.1", "--from"),
    (SERVO + "--units counts", "--units"),
    (SERVO + "--commands 127.0.0.1:70000", "--commands"),
    (SERVO + "--commands no.such.host.invalid:5005", "'no.such.host.invalid'"),
    (FOLLOW + "--theta '0 0' --udp 127.0.0.1:5005 --listen 127.0.0.1:0", "--theta"),
    (FOLLOW + "--speed 0", "--speed"),
    (FOLLOW + "--rate 1", "10 Hz"),
)
"""Command lines, and what the error names."""


@pytest.mark.parametrize(("line", "culprit"), BAD)
def test_bad_input_is_one_line_and_exit_code_2(line: str, culprit: str, capsys: Capture, here: Path) -> None:
    assert culprit in error_of(capsys, *shlex.split(line))
    assert list(here.iterdir()) == [], "nothing is written"


def test_planning_without_limits_assumes_the_usual_ones_and_says_so(capsys: Capture, tmp_path: Path) -> None:
    path = write(tmp_path, two_joints())
    content = answer(capsys, "plan", str(path), "--from", "zero", "--to", "10 10")
    assert "3 rad/s² for a, b" in content["assumed"]
    assert np.isclose(max(content["peak_acceleration"]), 3.0)
    given = answer(capsys, "plan", str(path), "--from", "zero", "--to", "10 10", "--acceleration", "2")
    assert given["assumed"] is None
    assert np.isclose(max(given["peak_acceleration"]), 2.0)


def test_without_a_stdout_or_with_one_that_is_full(tmp_path: Path) -> None:
    full = subprocess.run(f"'{PROGRAM}' arms > /dev/full", shell=True, capture_output=True, text=True, timeout=600)
    assert "Traceback" not in full.stderr
    assert full.returncode == 2
    ascii_only = subprocess.run(
        [PROGRAM, "info", "rover_arm"], capture_output=True, text=True, timeout=60, env={"PYTHONIOENCODING": "ascii"}
    )
    assert (ascii_only.returncode, ascii_only.stderr) == (0, "")


def test_debug_shows_the_traceback() -> None:
    with pytest.raises(twistarm.support.errors.UnknownNameError):
        run(["info", "rover_amr", "--debug"])


def test_version_commands_and_what_is_installed(capsys: Capture) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "twistarm.cli", "--version"], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (0, f"twistarm {twistarm.__version__}\n")
    content = answer(capsys, "info")
    assert content["twistarm"] == twistarm.__version__
    assert content["libraries"]["numpy"] == np.__version__
    assert all(f"  {command} " in printed(capsys) for command in ("fk", "ik", "plan", "calibrate", "guide"))
    assert {"pin", "meshcat", "yourdfpy", "example-robot-data", "scipy"} <= set(content["libraries"])


@pytest.mark.parametrize(
    ("line", "wanted"),
    [
        pytest.param("ja", "jacobian", marks=pytest.mark.slow),
        pytest.param("info --xa", "--xacro", marks=pytest.mark.slow),
        ("fk rover_arm_6", "rover_arm_6dof"),
    ],
)
def test_the_shell_completes_commands_options_and_arms(line: str, wanted: str) -> None:
    typed = {"COMP_WORDS": f"twistarm {line}", "COMP_CWORD": str(1 + line.count(" "))}
    asked = {"_TWISTARM_COMPLETE": "complete_bash", **typed}
    done = subprocess.run([PROGRAM], capture_output=True, text=True, timeout=60, env=asked)
    assert done.stdout.split() == [wanted]


def test_a_reader_that_leaves_early_is_no_error() -> None:
    command = f"'{PROGRAM}' info rover_arm --json | '{sys.executable}' -c 'input()'"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, timeout=60, check=True)
    assert "Traceback" not in done.stderr


def test_dh_shows_and_writes_the_table(tmp_path: Path, capsys: Capture) -> None:
    """The file is an ARM; rounded axes, which meet far away, can count as parallel."""
    file = str(tmp_path / "rover.csv")
    assert run(["dh", "rover_arm", "--convention", "modified", "-o", file]) == 0
    shown = capsys.readouterr().out
    assert "alpha [°]" in shown
    poses = [answer(capsys, "fk", arm, "--theta", "0.1 20 30 -40 50")["matrix"] for arm in ("rover_arm", file)]
    np.testing.assert_allclose(*poses, atol=1e-12)
    far, near = (answer(capsys, "dh", "so101", *more) for more in ((), ("--parallel", "0.01")))
    lengths = [max(abs(row["d"]) for row in said["rows"]) for said in (far, near)]
    assert (lengths[0] > 1000, lengths[1] < 1) == (True, True)
    assert far["residual"] < 1e-12 < near["residual"] < 1e-5
