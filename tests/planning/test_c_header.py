"""The header of a motion, compiled as C99 and C++17 and run, beside the trajectory that it was made of."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from test_export import with_motors
from test_trajectory import motion, standstill
from twistarm import plan_joint, save_trajectory
from twistarm.cli.application import run
from twistarm.support.errors import InputError

WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror", "-O1"]
C99, CPP17 = ("cc", "-std=c99", "-x", "c"), ("c++", "-std=c++17", "-x", "c++")

PROGRAM = """
#include <stdio.h>
#include "motion.h"
#include "other_1.h"
int main(void) {
    double t;
    while (scanf("%lf", &t) == 1) {
        TWISTARM_REAL out[3][motion_joints];
        int order, joint;
        motion_theta((TWISTARM_REAL)t, out[0]);
        motion_velocity((TWISTARM_REAL)t, out[1]);
        motion_acceleration((TWISTARM_REAL)t, out[2]);
        for (order = 0; order < 3; ++order)
            for (joint = 0; joint < motion_joints; ++joint) printf("%.17g ", (double)out[order][joint]);
    }
    printf("\\n%s\\n%s\\n%.9g\\n", motion_joint_names[0], motion_units[1], (double)other_1_duration);
#ifdef LABELS
    for (int i = 0; i < motion_label_count; ++i)
        printf("%.9g %s\\n", (double)motion_labels[i].time, motion_labels[i].text);
#endif
    return 0;
}
"""


@pytest.fixture(scope="module", autouse=True)
def compilers():
    lacking = [name for name in ("cc", "c++") if not shutil.which(name)]
    if lacking and os.environ.get("TWISTARM_REQUIRE_ALL"):
        pytest.fail(f"there is no {' and no '.join(lacking)}")
    if lacking:
        pytest.skip(f"there is no {' and no '.join(lacking)}")


def compiled(folder, language, *defines):
    (folder / "program.txt").write_text(PROGRAM)
    save_trajectory(standstill(), folder / "other-1.h")
    (folder / "other-1.h").rename(folder / "other_1.h")
    command = [*language, *WARNINGS, *defines, f"-I{folder}", str(folder / "program.txt"), "-o", str(folder / "run")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr

    def at(t, n):
        text = " ".join(map(repr, t.tolist()))
        said = subprocess.run(
            [folder / "run"], input=text, capture_output=True, text=True, check=True, timeout=60
        ).stdout
        numbers, *words = said.splitlines()
        return np.array(numbers.split(), float).reshape(len(t), 3, n).transpose(1, 0, 2), words

    return at


def instants(trajectory):
    """Inside, on the breakpoints, at the ends and beyond."""
    inside = np.random.default_rng(0).uniform(0.0, trajectory.duration, 300)
    return np.concatenate([inside, trajectory.breakpoints, [-1.0, 1e9]])


@pytest.mark.parametrize("language", [C99, CPP17], ids=["C99", "C++17"])
def test_in_double_it_is_the_trajectory(rover, tmp_path, language):
    way = [rover.ready, rover.ready + [0.1, 0.3, -0.4, 0.2, 1.0], rover.ready]
    planned = plan_joint(rover, way, limits={"acceleration": 2.0})
    planned = replace(planned, labels=((0.5, 'close "it" ü */ ??/'), (1.0, "\\n%s")))
    save_trajectory(planned, tmp_path / "motion.h")
    t = instants(planned)
    values, words = compiled(tmp_path, language, "-DLABELS")(t, rover.n)
    for order, value in enumerate(values):
        assert_allclose(value, planned(t, order), atol=1e-12 * max(1.0, planned.peak(order).max()), rtol=0)
    assert words == ["slide", "rad", "0", '0.5 close "it" ü */ ??/', "1 \\n%s"]


def test_in_single_precision_and_in_what_drives_count(tmp_path):
    arm, planned = with_motors()
    save_trajectory(planned, tmp_path / "motion.h", counts=True)
    t = instants(planned)
    values, words = compiled(tmp_path, C99, "-DTWISTARM_REAL=float")(t, 3)
    motors = planned.to_motors()
    for order, value in enumerate(values[:2]):
        exact = arm.actuators.to_counts(motors(t, order))
        assert_allclose(value, exact, atol=3e-6 * np.abs(exact).max(), rtol=0)
    assert words[:2] == ["shoulder", "tick"]


def test_nan_is_the_start_and_a_motion_of_one_piece_compiles(tmp_path):
    save_trajectory(motion(), tmp_path / "motion.h")
    values, _ = compiled(tmp_path, C99)(np.array([np.nan, 1.0]), 2)
    assert values[:, 0].tolist() == [[0.0, 0.0]] * 3
    assert_allclose(values[0, 1], motion()(1.0), atol=1e-12)


def test_what_cannot_be_a_header(tmp_path):
    with pytest.raises(InputError, match=r"a motion is written to \*.csv, .*; got .*motion.c"):
        save_trajectory(motion(), tmp_path / "motion.c")
    with pytest.raises(InputError, match="this trajectory knows no motors"):
        save_trajectory(motion(), tmp_path / "motion.h", counts=True)
    assert list(tmp_path.iterdir()) == []


def test_the_command_names_it_after_the_file(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    arguments = ["plan", "rover_arm", "--to", "zero", "--velocity", "1", "--acceleration", "1"]
    assert run([*arguments, "-o", "wave 2.hpp"]) == 0
    assert 'include "wave 2.hpp"' in (text := (tmp_path / "wave 2.hpp").read_text())
    assert "static inline void wave_2_theta(" in text
    capsys.readouterr()
    assert run([*arguments, "-o", "-", "--format", "header"]) == 0
    assert "static inline void motion_theta(" in capsys.readouterr().out
