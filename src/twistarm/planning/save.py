"""save_trajectory: a motion written to a file, by the ending of its name."""

from __future__ import annotations

import os
from pathlib import Path

from ..arm.arm import Arm
from ..limits.actuators import Actuators
from ..support.checks import as_flag, require
from ..support.errors import InputError
from ..support.files import writable, write_whole
from ..support.messages import Argument, Text
from .files.c_header import SUFFIXES, header_text
from .files.csv_file import csv_text
from .files.joint_trajectory import json_text
from .files.mcap_file import mcap_bytes
from .trajectory import Trajectory

ENDINGS = (".csv", ".json", ".mcap", *SUFFIXES)


def save_trajectory(
    trajectory: Trajectory,
    path: str | os.PathLike[str],
    *,
    dt: float = 0.01,
    arm: Arm | None = None,
    actuators: Actuators | None = None,
    counts: bool = False,
) -> Path:
    """Write a motion to a file, whole or not at all. `load_trajectory` reads all but headers.

    - CSV: a row every `dt` [s] and one at the end. A row has the time, then position, velocity and acceleration of
      each joint. The header names column and unit, `slide.position [m]`. A planned motion adds its constant limits,
      `slide.velocity_limit [m/s]` and `slide.acceleration_limit [m/s^2]`. Each motor adds `left.motor_position [rad]`,
      `left.motor_velocity [rad/s]`, `left.counts [tick]` and `left.counts_rate [tick/s]`, not rounded. A last column
      `label` has each label in a row at its time. Numbers read back as the same floats.
    - JSON: a `trajectory_msgs/JointTrajectory`, a point every `dt` [s] and one at the end. Each point has positions,
      velocities, accelerations [rad, m, s] and time_from_start (`sec`, `nanosec`). The last velocity is zero. Two
      fields may follow. `motors` has names, units, count_units and points of positions, velocities, counts and
      counts_rates. `labels` have `time` [s] and `text`.
    - MCAP: ROS 2 messages, as rosbag2 records them, for Foxglove and Rerun. The motion is one
      `trajectory_msgs/JointTrajectory` on `/joint_trajectory`. At each of its points `/joint_states` has positions and
      velocities [rad, m, s], and `/tf` the pose of every link. `/robot_description` is the arm's description, if it
      has one. `/labels` are `std_msgs/String`. Stamps begin at 0. Motors are left out. It needs the extra `mcap`.
    - C99 and C++17 header (.h, .hpp, .hh, .hxx): the polynomials, and functions that evaluate them. In motion.h,
      `motion_theta(t, theta)`, `motion_velocity` and `motion_acceleration` evaluate this trajectory, in float or
      double. Names begin with the file's. Labels are a table too. `dt` does not matter.

    Args:
        trajectory: The motion.
        path: A file whose name ends with .csv, .json, .mcap, .h, .hpp, .hh or .hxx.
        dt: Time between rows or points [s].
        arm: The arm of the motion, for MCAP.
        actuators: The motors; by default those of the arm that the motion was planned for.
        counts: Whether CSV and headers hold counts of the motors' drives in place of joint values, for firmware that
            knows no joints.

    Returns:
        The path written.

    Raises:
        InputError: The file cannot be written, its ending is unknown, dt is not positive, or arm or actuators do not
            fit.
        MissingExtraError: rosbags is not installed, and the file is MCAP.
    """
    require(trajectory, Trajectory, "trajectory", "from plan, plan_joint or load_trajectory")
    target = writable(path)
    ending = target.suffix.lower()
    if ending not in ENDINGS:
        raise InputError(f"a motion is written to {', '.join(f'*{known}' for known in ENDINGS)}; got {target}")
    if as_flag(counts, "counts") and ending in (".json", ".mcap"):
        raise InputError(f"counts go into *.csv and headers; a file {target.name} is in rad and m")
    if ending == ".csv":
        return write_whole(target, csv_text(trajectory, dt, actuators, counts=counts))
    if ending == ".json":
        return write_whole(target, json_text(trajectory, dt, actuators))
    if ending == ".mcap":
        if arm is None:
            raise InputError(Text("an MCAP file holds the poses of all links: give {arm}", arm=Argument("arm")))
        return write_whole(target, mcap_bytes(trajectory, arm, dt))
    return write_whole(target, header_text(trajectory, target.name, actuators, counts=counts))
