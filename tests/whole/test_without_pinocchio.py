"""An installation without Pinocchio and xacro, as on Windows or in a notebook of the browser."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from numpy.testing import assert_allclose

from twistarm import load_arm
from urdf_text import two_joints

MISSING = (
    "pinocchio", "coal", "hppfcl", "eigenpy", "xacro",  # no wheels
    "fcntl", "resource", "termios", "tty", "pwd", "grp",  # other systems have none
)  # fmt: skip

BLOCKER = f"""
import os, signal, sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {MISSING} or (name == "twistarm._core" and "NO_CORE" in os.environ):
            raise ModuleNotFoundError(name, name=name.split(".")[0])
sys.meta_path.insert(0, Blocker())
for module, name in ((os, "O_NONBLOCK"), (os, "O_NOCTTY"), (os, "O_CLOEXEC"), (signal, "SIGHUP")):
    delattr(module, name)
"""

PROGRAM = """
import json, sys
import twistarm as t
arm = t.load_arm("ur5")
theta = json.loads(sys.argv[1])
t.bake(arm, sys.argv[2])
baked = t.load_arm(sys.argv[2])
rows = t.crosscheck(arm, samples=10).comparisons
print(json.dumps({
    "fk": arm.fk(theta).tolist(),
    "J": arm.spatial_jacobian(theta).tolist(),
    "poses": {name: g.tolist() for name, g in arm.poses(theta).items()},
    "writeable": all(g.flags.writeable for g in arm.poses(theta).values()),
    "forearm": arm.pose(theta, "forearm_link").tolist(),
    "ik": t.solve_ik(baked, t.Pose(baked.fk(theta)), theta0=arm.ready).theta.tolist(),
    "proof": arm.proof,
    "findings": {one.code: str(one) for one in arm.findings},
    "skipped": [row.not_compared for row in rows if "pinocchio" in row.engines],
    "compared": ["/".join(row.engines) for row in rows if not row.not_compared],
}))
"""


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("blocked")
    (folder / "sitecustomize.py").write_text(BLOCKER)
    return {**os.environ, "PYTHONPATH": str(folder)}


def run(environment: dict[str, str], *command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *command], env=environment, capture_output=True, text=True, timeout=120, check=False
    )


@pytest.mark.parametrize("core", [True, False], ids=["core", "numpy"])
def test_kinematics_are_those_of_pinocchio(environment: dict[str, str], tmp_path: Path, core: bool) -> None:
    arm, theta = load_arm("ur5"), [0.4, -1.2, 1.1, 0.3, -0.7, 2.0]
    more = {} if core else {"NO_CORE": "1"}
    done = run(environment | more, "-c", PROGRAM, json.dumps(theta), str(tmp_path / "ur5.arm.json"))
    assert done.returncode == 0, done.stderr
    said: dict[str, Any] = json.loads(done.stdout)
    g, spatial, _ = arm.by_pinocchio(theta)
    assert_allclose(said["fk"], g, atol=1e-12)
    assert_allclose(said["J"], spatial, atol=1e-12)
    poses = arm.poses(theta)
    assert said["poses"].keys() == poses.keys()
    for name, pose in poses.items():
        assert_allclose(said["poses"][name], pose, atol=1e-12)
    assert said["writeable"]  # as with Pinocchio
    assert_allclose(said["forearm"], poses["forearm_link"], atol=1e-12)
    assert_allclose(arm.by_pinocchio(said["ik"])[0], g, atol=1e-5)
    assert said["proof"] is None
    assert "pip install 'pin>=" in said["findings"]["not-compared"]
    assert len(said["skipped"]) == 1
    assert "pip install 'pin>=" in said["skipped"][0]
    assert "poe/differences" in said["compared"]


def test_doctor_examines_and_repairs(environment: dict[str, str], tmp_path: Path) -> None:
    """What needs Pinocchio is left out, and says so."""
    file, copy = tmp_path / "arm.urdf", tmp_path / "copy.urdf"
    file.write_text(two_joints().replace("0 0 1", "0 0 2"))
    program = ("-c", "from twistarm.cli import main; main()", "doctor", str(file))
    done = run(environment, *program, "--json")
    assert done.returncode == 0, done.stderr
    codes = {finding["code"]: finding["remedy"] for finding in json.loads(done.stdout)["findings"]}
    assert "pip install 'pin>=" in codes["not-compared"]
    assert len(codes) > 1
    done = run(environment, *program, "--fix", "-o", str(copy))
    assert "parser does not read it: pinocchio is not installed" in " ".join(done.stdout.split())
    assert load_arm(copy).proof is not None


def test_a_xacro_file_names_what_is_missing(environment: dict[str, str]) -> None:
    done = run(environment, "-c", "from twistarm.cli import main; main()", "fk", "rover_arm")
    assert done.returncode == 2
    assert "".join(done.stderr.split()) == "error:xacroisnotinstalled;pipinstall'xacro>=2.1'"
