"""Every configuration by the C++ header of an arm: those that Python finds, without heap."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from catalogue import load
from test_cpp_header import HEAP, build, compiler  # noqa: F401  (a fixture)
from twistarm import Approach, Pose
from twistarm.export.cpp_header import cpp_header
from twistarm.ik import solve_ik_all
from twistarm.ik.targets import target_for

PROGRAM = """
// Reads the numbers of a target; writes how many configurations are inside the limits, and each of them; again.
#include <cstdio>
#include "arm.hpp"
using namespace ARM;
using T = REAL;
int main() {
    const auto limits = ranges<T>();
    T given[COUNT];
    for (;;) {
        for (T& number : given) {
            double read;
            if (std::scanf("%lf", &read) != 1) return 0;
            number = static_cast<T>(read);
        }
        const auto found = solve_ik_all(limits, TARGET, poses<T>[0], T(TOLERANCE), T(TOLERANCE));
        std::printf("%d\\n", found.inside);
        for (int i = 0; i < found.inside; ++i)
            for (T value : found.found[i].theta) std::printf("%.17g\\n", static_cast<double>(value));
    }
}
"""

POSE = "twistarm::pose_target(twistarm::frame_from_rows<T>(given))"
APPROACH = "twistarm::approach_target(given, given + 3, given + 6)"

BUILDS = [
    pytest.param("rover_arm", "double", "approach", id="rover_arm"),
    pytest.param("ur5", "float", "pose", id="ur5-float"),
    pytest.param("panda", "double", "pose", id="panda", marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("name", "real", "kind"), BUILDS)
def test_as_in_python(name: str, real: str, kind: str, compiler: str, tmp_path: Path) -> None:  # noqa: F811
    """Of an arm with more joints than a pose determines the last stands where theta0 has it."""
    arm = load(name)
    tolerance, close = {"double": (1e-9, 1e-6), "float": (1e-4, 2e-2)}[real]
    target, count = (POSE, 16) if kind == "pose" else (APPROACH, 9)
    defines = {"REAL": real, "TARGET": target, "COUNT": count, "TOLERANCE": tolerance}
    program = build(compiler, arm, tmp_path, "all", PROGRAM, "-O1" if name == "panda" else "-O0", **defines)
    assert not any(taboo in program.read_bytes() for taboo in HEAP)
    theta = np.array(arm.random_theta(3, 10))
    given = {arm.joint_names[6]: float(arm.ready[6])} if arm.n > 6 else None
    theta[:, 6:] = arm.ready[6:]
    poses = arm.fk(theta)
    along = [Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis) for g in poses]
    targets = [Pose(g) for g in poses] if kind == "pose" else [target_for(arm, each) for each in along]
    asked = "\n".join(" ".join(map(repr, target.numbers.ravel().tolist())) for target in targets)
    done = subprocess.run([program], input=asked, capture_output=True, text=True, timeout=60, check=True)
    numbers = iter(map(float, done.stdout.split()))
    for each in targets:
        found = np.array([[next(numbers) for _ in range(arm.n)] for _ in range(int(next(numbers)))])
        wanted = solve_ik_all(arm, each, fixed_joints=given)
        assert len(found) == len(wanted)
        apart = np.abs(found[:, None] - wanted.theta[None]).max(axis=2)
        assert (apart.min(axis=0) < close).all()
        assert (apart.min(axis=1) < close).all()


def test_an_arm_without_a_family_says_so() -> None:
    text = cpp_header(load("rover_arm_6dof"))
    assert "pose_family" not in text
    assert "position_family" in text
