"""Baked arms without Pinocchio and the description: the same answers, and what is lacking is said."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from baked_arms import TOL, bake
from catalogue import load
from twistarm import Arm, load_arm, plan_joint, solve_ik
from twistarm.support.errors import TwistarmError

ALONE = """
import sys

class Refusal:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("pinocchio", "xacro", "yaml", "typer", "rich", "scipy", "cmeel", "meshcat"):
            raise ModuleNotFoundError(f"{name} is not for a baked arm", name=name)

sys.meta_path.insert(0, Refusal())
import json
import numpy as np
import twistarm

arm = twistarm.load_arm(sys.argv[1])
theta = arm.random_theta(np.random.default_rng(1), 5)
targets = [arm.fk(row) for row in theta]
found = [twistarm.solve_ik(arm, target) for target in targets]
try:
    arm.pinocchio
    lack = ""
except twistarm.TwistarmError as error:
    lack = str(error)
print(json.dumps({
    "fk": arm.fk(theta).tolist(),
    "spatial": arm.spatial_jacobian(theta).tolist(),
    "body": arm.body_jacobian(theta).tolist(),
    "singular_values": arm.manipulability(theta).singular_values.tolist(),
    "answers": [solution.theta.tolist() for solution in found],
    "converged": [solution.converged for solution in found],
    "lack": lack,
    "needless": sorted({"twistarm.checking.doctor", "twistarm.viewer", "urllib.request"} & set(sys.modules)),
}))
"""


@pytest.mark.parametrize(("name", "core"), [("rover_arm", False), ("panda", True)], ids=["without the core", "with it"])
def test_without_pinocchio(name: str, core: bool, tmp_path: Path) -> None:
    """In a process that cannot import it, nor what reads descriptions; the full arm's Pinocchio judges."""
    arm = load(name)
    hidden = "" if core else "import sys; sys.modules['twistarm._core'] = None\n"
    command = [sys.executable, "-c", hidden + ALONE, str(bake(arm, tmp_path))]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    theta = arm.random_theta(np.random.default_rng(1), 5)
    model = arm.pinocchio
    g, J = (
        np.array(parts)
        for parts in zip(*(model.pose_and_body_jacobian(row, arm.base, arm.tip_link) for row in theta), strict=True)
    )
    spatial = [model.spatial_jacobian(row, arm.base, arm.tip_link) for row in theta]
    assert np.abs(np.array(said["fk"]) - g).max() < TOL
    assert np.abs(np.array(said["body"]) - J).max() < TOL
    assert np.abs(np.array(said["spatial"]) - spatial).max() < TOL
    rows = np.array([1 / arm.reach] * 3 + [1.0] * 3)  # linear rows by the reach, columns of slides times the reach
    columns = np.array([arm.reach if unit == "m" else 1.0 for unit in arm.units])
    values = np.linalg.svd(J * rows[:, None] * columns, compute_uv=False)
    assert np.abs(np.array(said["singular_values"]) - values).max() < TOL
    assert all(said["converged"])
    assert said["needless"] == []
    for answer, target in zip(np.array(said["answers"]), g, strict=True):
        reached, _ = model.pose_and_body_jacobian(answer, arm.base, arm.tip_link)
        assert np.abs(reached - target).max() < 2e-6
        assert arm.limits.contains(answer)
    assert f"{name} was baked without its description (load {name!r} for that)" in said["lack"]


def test_planning_and_inverse_kinematics(rover: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(rover, tmp_path))
    goal = rover.fk(rover.named_states["reach"])
    found, whole = solve_ik(baked, goal), solve_ik(rover, goal)
    assert found.converged
    assert np.abs(found.theta - whole.theta).max() < 1e-6
    path = [baked.ready, baked.named_states["reach"]]
    assert plan_joint(baked, path).duration == pytest.approx(plan_joint(rover, path).duration)


def test_what_needs_the_description_says_so(rover: Arm, tmp_path: Path) -> None:
    baked = load_arm(bake(rover, tmp_path))
    asked: tuple[Callable[[], object], ...] = (
        lambda: baked.pinocchio,
        lambda: baked.gravity_torques(baked.ready),
        lambda: baked.pose(baked.ready, "forearm"),
    )
    for ask in asked:
        with pytest.raises(TwistarmError, match=r"baked without its description \(load 'rover_arm' for that\)"):
            ask()
