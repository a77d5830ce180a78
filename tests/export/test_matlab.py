"""The MATLAB twin of an arm, run by Octave: against Pinocchio, and against the vectors in it."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from catalogue import load
from test_cpp_header import ARMS, reference
from twistarm import arm_from_screws, bake, load_arm
from twistarm.cli.application import run
from twistarm.export.matlab import matlab_text
from twistarm.support.errors import InputError

needs_octave = pytest.mark.skipif(
    shutil.which("octave") is None, reason="Octave is not installed: the MATLAB twin of an arm is not run"
)


def octave(folder: Path, program: str) -> subprocess.CompletedProcess[str]:
    command = ["octave", "--no-gui", "--norc", "--no-history", "--quiet", "--eval", program]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, check=False)


@needs_octave
@pytest.mark.parametrize("name", ["rover_arm", "mimic", "helical"])
def test_against_pinocchio(name: str, tmp_path: Path) -> None:
    arm = ARMS[name](tmp_path)
    (tmp_path / "twin.m").write_text(matlab_text(arm, "twin.m"))
    theta = arm.random_theta(np.random.default_rng(3), 4)
    rows = "; ".join(", ".join(map(repr, row)) for row in theta.tolist())
    program = f"""
        arm = twin(); arm.check(); theta = [{rows}];
        for k = 1:{len(theta)}
            printf('%.17g ', arm.fk(theta(k, :)), arm.spatial_jacobian(theta(k, :)'), arm.body_jacobian(theta(k, :)));
        end
        printf('|%s|%s', arm.name, strjoin(arm.joint_names, '/'));
    """
    done = octave(tmp_path, program)
    assert done.returncode == 0, done.stderr
    numbers, *words = done.stdout.split("|")
    finding = np.array(numbers.split(), float).reshape(len(theta), -1)
    for k, sizes in enumerate(zip(*reference(arm, theta), strict=True)):
        assert_allclose(finding[k], np.concatenate([matrix.ravel(order="F") for matrix in sizes]), atol=1e-12)
    assert words == [arm.name, "/".join(arm.joint_names)]


@needs_octave
def test_it_tests_itself_and_refuses_what_does_not_fit(tmp_path: Path) -> None:
    text = matlab_text(load("rover_arm"), "twin.m")
    wrong = re.sub(r"(arm\.screws = \[\n    0\.0, -0\.65)", r"\g<1>01", text)
    assert wrong != text
    (tmp_path / "wrong.m").write_text(wrong.replace("arm = twin()", "arm = wrong()"))
    done = octave(tmp_path, "arm = wrong(); arm.check()")
    assert done.returncode != 0
    assert "rover_arm is 0.000" in done.stderr
    assert "away from its test vectors" in done.stderr
    (tmp_path / "twin.m").write_text(text)
    done = octave(tmp_path, "arm = twin(); arm.fk([1 2 NaN 4 5])")
    assert "theta must be 5 finite numbers: slide, shoulder, elbow, wrist_pitch, wrist_roll" in done.stderr


@needs_octave
def test_an_arm_of_screws_with_a_name_of_quotes(tmp_path: Path) -> None:
    screws = np.array([[0, 0, 1.0, 0, 0, 0], [0, -0.5, 0, 0, 0, 1.0]]).T
    arm = arm_from_screws(screws, np.eye(4), joints=("it's %d", 'a"b'), name="l'arm % é")
    (tmp_path / "twin.m").write_text(matlab_text(arm, "twin.m"))
    done = octave(tmp_path, "arm = twin(); arm.check(); printf('%s|', arm.name, arm.joint_names{:})")
    assert done.stdout == "l'arm % é|it's %d|a\"b|", done.stderr


def test_a_file_whose_name_no_function_can_have() -> None:
    arm = load("rover_arm")
    for name, better in {"rover-arm.m": "rover_arm.m", "end.m": "arm_end.m", "3.m": "arm_3.m"}.items():
        with pytest.raises(InputError, match=f"letters, digits and _: .* is none; call the file {better}"):
            matlab_text(arm, name)


def test_limits_are_read_back_as_they_are(here: Path) -> None:
    """The URDF of another arm with the same joints: every limit comes from the file."""
    arm = load_arm("rover_arm", limits={"jerk": {"elbow": 1e-5}, "upper": {"wrist_roll": 3.0}, "velocity": 1e5})
    bake(arm, "changed.json")
    assert run(["bake", "changed.json", "-o", "joint_limits.yaml"]) == 0
    read = load_arm("rover_arm", limits="joint_limits.yaml")
    assert not [finding for finding in read.findings if finding.code.startswith("limits-")]
    for field in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        assert np.array_equal(getattr(read.limits, field), getattr(arm.limits, field)), field
    written = yaml.safe_load(Path("joint_limits.yaml").read_text())["joint_limits"]
    assert list(written) == list(arm.joint_names)
    assert written["elbow"]["max_jerk"] == 1e-5
    assert written["slide"]["has_jerk_limits"] is False
    Path("joint_limits.yaml").write_text("joint_limits: {}  # a team's own\n")
    assert run(["bake", "rover_arm", "-o", "joint_limits.yaml"]) == 2
    assert Path("joint_limits.yaml").read_text().startswith("joint_limits: {}")
    assert run(["bake", "rover_arm", "-o", "joint_limits.yaml", "--force"]) == 0
    assert load_arm("rover_arm", limits="joint_limits.yaml").limits.jerk.min() == np.inf


def test_an_open_side_is_a_number_that_every_reader_takes(here: Path) -> None:
    """ROS takes both sides of a position or none, and not every YAML reader takes .inf."""
    arm = load_arm("rover_arm", limits={"lower": {"elbow": -np.inf, "slide": -np.inf}, "upper": {"slide": np.inf}})
    bake(arm, "open.json")
    assert run(["bake", "open.json", "-o", "joint_limits.yaml"]) == 0
    text = Path("joint_limits.yaml").read_text()
    written = yaml.safe_load(text)["joint_limits"]
    assert "inf" not in text
    assert written["elbow"]["has_position_limits"] is True
    assert np.isfinite([written["elbow"]["min_position"], written["elbow"]["max_position"]]).all()
    assert written["slide"]["has_position_limits"] is False
    assert "min_position" not in written["slide"]
    read = load_arm("rover_arm", limits="joint_limits.yaml").limits
    assert (read.lower[2], read.upper[2]) == (-np.inf, arm.limits.upper[2])
