import csv
import json
import os

import numpy as np
import pytest

from test_trajectory import motion, standstill
from twistarm.errors import InputError
from twistarm.planning import Trajectory


def named(trajectory, names, units):
    return Trajectory(
        names, units, trajectory.waypoints, trajectory.times, trajectory.breakpoints, trajectory.coefficients
    )


def test_csv_has_a_column_per_joint_and_rate_and_reads_back_exactly(tmp_path):
    trajectory = named(motion(), ("slide", "elbow, left"), ("m", "rad"))
    path = trajectory.to_csv(tmp_path / "a.csv", dt=0.3)
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
    message = json.loads(trajectory.to_json(tmp_path / "a.json", dt=0.3).read_text())
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


@pytest.mark.parametrize("export", [Trajectory.to_csv, Trajectory.to_json])
def test_a_motion_of_no_length_is_one_point(tmp_path, export):
    text = export(standstill(), tmp_path / "a").read_text()
    assert text.count("0.3") == 1


@pytest.mark.parametrize("export", [Trajectory.to_csv, Trajectory.to_json])
def test_a_failure_leaves_what_was_there(tmp_path, monkeypatch, export):
    path = tmp_path / "a"
    path.write_text("old")
    monkeypatch.setattr(os, "replace", lambda *_: (_ for _ in ()).throw(OSError(5, "Input/output error")))
    with pytest.raises(InputError, match=r"cannot write .*: Input/output error"):
        export(motion(), path)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["a"]


@pytest.mark.parametrize("export", [Trajectory.to_csv, Trajectory.to_json])
@pytest.mark.parametrize("dt", [0.0, -1.0, float("nan"), 1e-9])
def test_a_bad_dt_writes_nothing(tmp_path, export, dt):
    with pytest.raises(InputError, match="dt must be"):
        export(motion(), tmp_path / "a", dt)
    assert os.listdir(tmp_path) == []


def test_json_refuses_steps_below_a_nanosecond(tmp_path):
    line = Trajectory(("a",), ("m",), [[0.0], [1.0]], [0.0, 1e-8], [0.0, 1e-8], np.array([1e8, 0.0])[:, None, None])
    with pytest.raises(InputError, match=r"dt = 2e-10 s is too short for JointTrajectory.* nanoseconds"):
        line.to_json(tmp_path / "a.json", 2e-10)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("export", [Trajectory.to_csv, Trajectory.to_json])
def test_a_missing_folder_is_said(tmp_path, export):
    with pytest.raises(InputError, match="does not exist; create it first"):
        export(motion(), tmp_path / "missing" / "a")
