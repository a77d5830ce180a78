"""A trajectory as the text of a file: CSV for people and plots, JSON in the shape of ROS's JointTrajectory."""

from __future__ import annotations

import csv
import io
import json

import numpy as np

from ..errors import InputError
from .trajectory import Trajectory

RATES = ("position", "velocity", "acceleration")
CSV_UNITS = ("", "/s", "/s^2")
"""In ASCII: spreadsheets guess at anything else."""

NANOSECOND = 1e-9


def csv_text(trajectory: Trajectory, dt: float) -> str:
    """What `Trajectory.to_csv` writes."""
    t, *values = trajectory.sample(dt)
    table = np.column_stack([t, np.stack(values, axis=-1).reshape(len(t), -1)])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time [s]", *_columns(trajectory)])
    writer.writerows(table.tolist())
    return text.getvalue()


def json_text(trajectory: Trajectory, dt: float) -> str:
    """What `Trajectory.to_json` writes."""
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
