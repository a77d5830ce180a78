"""The benchmarks' own honesty: the judge, the problems, and a quick run of the whole."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from twistarm import load_arm, poe

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT))

from benchmarks.__main__ import main  # noqa: E402
from benchmarks.problems import Judge, make_robot  # noqa: E402


@pytest.fixture(scope="module")
def ur5(tmp_path_factory):
    return make_robot("ur5", tmp_path_factory.mktemp("arm"))


def poses(robot, theta):
    """By the product of exponentials of the whole description: neither Pinocchio nor the cut."""
    arm = load_arm(robot.whole_urdf, base=robot.base, tip=robot.tip)
    return poe.fk(arm.screws, arm.home, np.asarray(theta))


def test_the_judge_accepts_only_what_is_right(ur5):
    judge = Judge(ur5)
    theta = np.array([0.3, -1.1, 1.2, -0.4, 0.9, 0.2])
    goal = poses(ur5, theta)
    turn = np.deg2rad(360) * np.eye(6)[5]

    def verdict(answer, target=goal):
        return bool(judge.errors(np.array([answer]), np.array([target])).strict[0])

    assert verdict(theta)
    assert verdict(theta - turn)
    assert not verdict(theta + turn), "the same pose, but 0.2 + 2π lies outside the limits"
    assert not verdict(theta + 1e-4)
    assert not verdict(np.full(6, np.nan))
    shifted, within = goal.copy(), goal.copy()
    shifted[0, 3] += 1.1e-6
    within[0, 3] += 0.9e-6
    assert verdict(theta, within)
    assert not verdict(theta, shifted)
    for beyond, right in ((0.9e-7, True), (1.1e-7, False)):
        at_limit = np.array([ur5.upper[0] + beyond, *theta[1:]])
        assert verdict(at_limit, poses(ur5, at_limit)) is right
    for angle, right in ((0.9e-6, True), (1.1e-6, False)):
        c, s = np.cos(angle), np.sin(angle)
        turned = goal.copy()
        turned[:3, :3] = goal[:3, :3] @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        assert verdict(theta, turned) is right


@pytest.mark.slow
def test_a_quick_run(tmp_path):
    file = tmp_path / "figures.json"
    main(["--quick", "--arms", "panda", "so101", "--seed", "11", "--json", str(file)])
    found = json.loads(file.read_text())
    rows = {(row["arm"], row["peer"], row["kind"]): row for row in found["single"]}
    assert len(rows) == 2 * 2 * 4
    for (arm, peer, kind), row in rows.items():
        assert row["remark"] == "", (arm, peer, kind)
        assert row["wrong"] == 0
        assert 0 < row["median"] <= row["p99"]
        least = 1.0 if peer == "twistarm" else 0.5
        assert row["strict"] == 0 if kind == "unreachable" else row["strict"] >= least
    for arm in ("panda", "so101"):
        assert rows[arm, "twistarm", "warm"]["motion"] <= 0.2
        assert sum(rows[arm, "twistarm", "unreachable"]["reasons"].values()) == 3
        assert rows[arm, "twistarm", "cold"]["ratio"] == 1
    assert all(row["difference"] < 1e-12 for row in found["kinematics"])
