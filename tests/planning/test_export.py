"""Motions as files: CSV, JSON with motors, and the header, compiled as C99 and C++17 and run."""

import csv
import json
import os
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from catalogue import load
from needed import absent
from test_trajectory import motion, standstill
from twistarm import Actuators, LineMove, ScrewMove, load_trajectory, plan, plan_joint, save_trajectory
from twistarm.cli.application import run
from twistarm.planning import Trajectory
from twistarm.support.errors import InputError


def test_csv_has_a_column_per_joint_and_rate_and_reads_back_exactly(tmp_path):
    trajectory = replace(motion(), joint_names=("slide", "elbow, left"), units=("m", "rad"))
    path = save_trajectory(trajectory, tmp_path / "a.csv", dt=0.3)
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header == [
        "time [s]",
        "slide.position [m]", "slide.velocity [m/s]", "slide.acceleration [m/s^2]",
        "elbow, left.position [rad]", "elbow, left.velocity [rad/s]", "elbow, left.acceleration [rad/s^2]",
    ]  # fmt: skip
    table = np.array(rows, dtype=float)
    t, theta, theta_dot, theta_ddot = trajectory.sample(0.3)
    assert np.array_equal(table[:, 0], t)
    assert np.array_equal(table[:, [1, 4]], theta)
    assert np.array_equal(table[:, [2, 5]], theta_dot)
    assert np.array_equal(table[:, [3, 6]], theta_ddot)


def test_json_is_a_joint_trajectory(tmp_path):
    trajectory = motion()
    message = json.loads(save_trajectory(trajectory, tmp_path / "a.json", dt=0.3).read_text())
    assert list(message) == ["joint_names", "points"]
    assert message["joint_names"] == ["joint1", "joint2"]
    t, *values = trajectory.sample(0.3)
    stamps = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in message["points"]]
    assert stamps[0] == 0
    assert (np.diff(stamps) > 0).all()
    assert np.allclose(stamps, 1e9 * t, atol=1)
    assert all(0 <= p["time_from_start"]["nanosec"] < 10**9 for p in message["points"])
    for key, expected in zip(("positions", "velocities", "accelerations"), values, strict=True):
        assert np.array_equal([p[key] for p in message["points"]], expected)
    assert message["points"][-1]["velocities"] == [0.0, 0.0]
    assert stamps[-1] == 5 * 10**9


def test_json_refuses_steps_below_a_nanosecond(tmp_path):
    line = Trajectory(("a",), ("m",), [[0.0], [1.0]], [0.0, 1e-8], [0.0, 1e-8], np.array([1e8, 0.0])[:, None, None])
    with pytest.raises(InputError, match=r"dt = 2e-10 s is too short for JointTrajectory.* nanoseconds"):
        save_trajectory(line, tmp_path / "a.json", dt=2e-10)
    assert os.listdir(tmp_path) == []


LABELS = ((0.0, "=1+1"), (0.9, "close gripper"), (0.9, "blow"), (1.0, "lift, slowly"), (5.0, "zu"))


def test_labels_stand_in_rows_at_their_times(tmp_path):
    trajectory = replace(motion(), labels=LABELS)
    with open(save_trajectory(trajectory, tmp_path / "a.csv", dt=0.3), newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header[-2:] == ["label", "label"]
    assert {float(row[0]): row[-2:] for row in rows if row[-2] or row[-1]} == {
        0.0: ["=1+1", ""], 0.9: ["close gripper", "blow"], 1.0: ["lift, slowly", ""], 5.0: ["zu", ""],
    }  # fmt: skip
    t = np.array([float(row[0]) for row in rows])
    assert sorted({*np.round(trajectory.sample(0.3).t, 9), 1.0}) == np.round(t, 9).tolist()
    assert np.array_equal(np.array([row[1:-2] for row in rows], float)[:, 0], trajectory(t)[:, 0])
    message = json.loads(save_trajectory(trajectory, tmp_path / "a.json", dt=0.3).read_text())
    assert [(label["time"], label["text"]) for label in message["labels"]] == list(LABELS)


def with_motors():
    """The rover arm, driven at the shoulder and by a differential wrist, and a motion of its."""
    arm = load("rover_arm")
    G = np.array([[0, 100.0, 0, 0, 0], [0, 0, 0, 60.0, 60.0], [0, 0, 0, 60.0, -60.0]])
    ticks = np.array([np.nan, 4096, 1024])
    motors = Actuators(
        ("shoulder", "left", "right"), arm.joint_names, G, np.array([0.4, 0, 0]), ("deg", "tick", "tick"), ticks
    )
    arm = replace(arm, actuators=motors)
    return arm, plan_joint(arm, [arm.ready, arm.random_theta(2)], limits={"acceleration": 2.0})


def by_hand(theta, theta_dot):
    """Of each motor where it is and how fast it turns, in rad, then as its drive counts it."""
    shoulder, pitch, roll = theta[:, 1], theta[:, 3], theta[:, 4]
    motor = np.stack([100 * shoulder + 0.4, 60 * pitch + 60 * roll, 60 * pitch - 60 * roll], axis=1)
    shoulder, pitch, roll = theta_dot[:, 1], theta_dot[:, 3], theta_dot[:, 4]
    motor_dot = np.stack([100 * shoulder, 60 * pitch + 60 * roll, 60 * pitch - 60 * roll], axis=1)
    counts = np.array([180 / np.pi, 4096 / (2 * np.pi), 1024 / (2 * np.pi)])
    return motor, motor_dot, motor * counts, motor_dot * counts


def test_the_motors_columns_follow_the_joints(tmp_path):
    arm, trajectory = with_motors()
    path = save_trajectory(trajectory, tmp_path / "a.csv", dt=0.1)
    with open(path, newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    assert header[:16] == next(
        csv.reader(save_trajectory(plain(trajectory), tmp_path / "b.csv").open(encoding="utf-8"))
    )
    assert header[16:] == [
        "shoulder.motor_position [rad]", "shoulder.motor_velocity [rad/s]", "shoulder.counts [deg]",
        "shoulder.counts_rate [deg/s]",
        "left.motor_position [rad]", "left.motor_velocity [rad/s]", "left.counts [tick]", "left.counts_rate [tick/s]",
        "right.motor_position [rad]", "right.motor_velocity [rad/s]", "right.counts [tick]",
        "right.counts_rate [tick/s]",
    ]  # fmt: skip
    table = np.array(rows, dtype=float)
    _, theta, theta_dot, _ = trajectory.sample(0.1)
    expected = np.stack(by_hand(theta, theta_dot), axis=-1).reshape(len(theta), -1)
    assert np.allclose(table[:, 16:], expected, rtol=1e-12, atol=1e-12)
    again = load_trajectory(arm, path)
    assert np.array_equal(again(again.times), theta)
    assert np.array_equal(again(again.times, 1), theta_dot)


def test_the_motors_stand_beside_the_points_of_a_joint_trajectory(tmp_path):
    arm, trajectory = with_motors()
    message = json.loads(save_trajectory(trajectory, tmp_path / "a.json", dt=0.1).read_text())
    without = json.loads(save_trajectory(plain(trajectory), tmp_path / "b.json", dt=0.1).read_text())
    motors = message.pop("motors")
    assert message == without
    assert motors["names"] == ["shoulder", "left", "right"]
    assert motors["units"] == ["rad", "rad", "rad"]
    assert motors["count_units"] == ["deg", "tick", "tick"]
    _, theta, theta_dot, _ = trajectory.sample(0.1)
    keys = ("positions", "velocities", "counts", "counts_rates")
    for key, expected in zip(keys, by_hand(theta, theta_dot), strict=True):
        assert np.allclose([point[key] for point in motors["points"]], expected, rtol=1e-12, atol=1e-12)
    given = save_trajectory(plain(trajectory), tmp_path / "c.json", dt=0.1, actuators=arm.actuators)
    assert given.read_text() == (tmp_path / "a.json").read_text()


def plain(trajectory):
    """The same without motors."""
    return replace(trajectory, actuators=None)


def test_actuators_of_other_joints_are_refused(tmp_path):
    arm, _ = with_motors()
    with pytest.raises(
        InputError, match="actuators must drive the trajectory's joints, 'joint1', 'joint2', in this order"
    ):
        save_trajectory(motion(), tmp_path / "a.csv", actuators=arm.actuators)
    assert os.listdir(tmp_path) == []


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


@pytest.fixture(scope="module")
def compilers():
    lacking = [name for name in ("cc", "c++") if not shutil.which(name)]
    if lacking:
        absent(f"there is no {' and no '.join(lacking)}")


def compiled(folder, language, *defines):
    (folder / "program.txt").write_text(PROGRAM)
    save_trajectory(standstill(), folder / "other-1.h")
    (folder / "other-1.h").rename(folder / "other_1.h")
    command = [*language, *WARNINGS, *defines, f"-I{folder}", str(folder / "program.txt"), "-o", str(folder / "run")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr

    def at(t, n):
        text = " ".join(map(repr, t.tolist()))
        printed = subprocess.run(
            [folder / "run"], input=text, capture_output=True, text=True, check=True, timeout=60
        ).stdout
        numbers, *words = printed.splitlines()
        return np.array(numbers.split(), float).reshape(len(t), 3, n).transpose(1, 0, 2), words

    return at


def instants(trajectory):
    """Inside, on the breakpoints, at the ends and beyond."""
    inside = np.random.default_rng(0).uniform(0.0, trajectory.duration, 300)
    return np.concatenate([inside, trajectory.breakpoints, [-1.0, 1e9]])


@pytest.mark.usefixtures("compilers")
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


@pytest.mark.usefixtures("compilers")
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


@pytest.mark.usefixtures("compilers")
def test_a_motion_of_many_pieces_is_refitted_within_what_the_header_says(tmp_path):
    """And what is no number is the start."""
    arm = load("rover_arm_6dof")
    lift, turn = LineMove.by([0, 0, 0.08], blend=0.01), ScrewMove.about([0, 0, 1], arm.fk(arm.ready)[:3, 3], 0.3)
    planned = plan(arm, [lift, turn], limits={"acceleration": 3.0, "jerk": 30.0})
    assert planned.coefficients.size > 20_000
    text = save_trajectory(planned, tmp_path / "motion.h").read_text()
    off, velocity, acceleration, jerk = map(
        float, re.search(r"at most ([\de.-]+) rad.*?most (\S+), (\S+) and (\S+) of", text, re.DOTALL).groups()
    )
    t = instants(planned)
    values, _ = compiled(tmp_path, C99)(np.append(t, np.nan), arm.n)
    assert np.abs(values[0, :-1] - planned(t)).max() <= off * 1.01 <= 1.01e-6
    assert (values[0, -1] == arm.ready).all()
    assert max(velocity, acceleration, jerk) <= 1.002
    for order, most in ((1, velocity), (2, acceleration)):
        assert (np.abs(values[order]).max(axis=0) <= most * planned.peak(order) * (1 + 1e-4)).all()
    assert len(text) < 60_000


def test_what_cannot_be_a_header(tmp_path):
    with pytest.raises(InputError, match=r"a motion is written to \*.csv, .*; got .*motion.c"):
        save_trajectory(motion(), tmp_path / "motion.c")
    with pytest.raises(InputError, match="this trajectory knows no motors"):
        save_trajectory(motion(), tmp_path / "motion.h", counts=True)
    assert list(tmp_path.iterdir()) == []


def test_the_command_names_it_after_the_file(here, capsys):
    arguments = ["plan", "rover_arm", "--to", "zero", "--velocity", "1", "--acceleration", "1"]
    assert run([*arguments, "-o", "wave 2.hpp"]) == 0
    assert 'include "wave 2.hpp"' in (text := (here / "wave 2.hpp").read_text())
    assert "static inline void wave_2_theta(" in text
    capsys.readouterr()
    assert run([*arguments, "-o", "-", "--format", "header"]) == 0
    assert "static inline void motion_theta(" in capsys.readouterr().out
