"""A trajectory as a file: CSV for people and plots, JSON in the shape of ROS's JointTrajectory."""

from __future__ import annotations

import csv
import io
import json
import os
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..files import write_whole
from .trajectory import Trajectory

RATES = ("position", "velocity", "acceleration")
CSV_UNITS = ("", "/s", "/s^2")
"""In ASCII: spreadsheets guess at anything else."""

NANOSECOND = 1e-9


def to_csv(trajectory: Trajectory, path: str | os.PathLike[str], dt: float = 0.01) -> Path:
    """Write a row every `dt` [s] and one at the end: time, then position, velocity, acceleration of each joint.

    The header names column and unit, `slide.position [m]`. Numbers are written so that reading gives the same
    floats. The file is written whole or not at all; raises InputError where it cannot be, and for a bad `dt`.
    """
    return write_whole(path, csv_text(trajectory, dt))


def to_json(trajectory: Trajectory, path: str | os.PathLike[str], dt: float = 0.01) -> Path:
    """Write a `trajectory_msgs/JointTrajectory`: joint_names, and a point every `dt` [s] and one at the end.

    Each point has positions, velocities, accelerations (rad or m, and per s, s²) and time_from_start as `sec` and
    `nanosec`, strictly increasing from 0; the last velocity is zero. The file is written whole or not at all;
    raises InputError where it cannot be, and for a bad `dt`.
    """
    return write_whole(path, json_text(trajectory, dt))


def csv_text(trajectory: Trajectory, dt: float) -> str:
    """What `to_csv` writes."""
    t, *values = trajectory.sample(dt)
    table = np.column_stack([t, np.stack(values, axis=-1).reshape(len(t), -1)])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time [s]", *_columns(trajectory)])
    writer.writerows(table.tolist())
    return text.getvalue()


def json_text(trajectory: Trajectory, dt: float) -> str:
    """What `to_json` writes."""
    samples = trajectory.sample(dt)
    nanoseconds = np.rint(samples.t / NANOSECOND).astype(np.int64)
    if not (np.diff(nanoseconds) > 0).all():
        raise InputError(f"dt = {dt:g} s is too short for JointTrajectory, which counts time in nanoseconds")
    points = [
        {
            "positions": theta.tolist(),
            "velocities": theta_dot.tolist(),
            "accelerations": theta_ddot.tolist(),
            "time_from_start": {"sec": int(ns // 10**9), "nanosec": int(ns % 10**9)},
        }
        for ns, theta, theta_dot, theta_ddot in zip(nanoseconds, *samples[1:], strict=True)
    ]
    message = {"joint_names": list(trajectory.joint_names), "points": points}
    return json.dumps(message, indent=1, allow_nan=False) + "\n"


def _columns(trajectory: Trajectory) -> list[str]:
    return [
        f"{name}.{rate} [{unit}{per}]"
        for name, unit in zip(trajectory.joint_names, trajectory.units, strict=True)
        for rate, per in zip(RATES, CSV_UNITS, strict=True)
    ]
