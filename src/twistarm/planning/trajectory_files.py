"""Motions in files: saved, loaded and checked by one table of formats and the endings of their names."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm, require_arm
from ..limits.actuators import Actuators
from ..support.checks import as_flag, require
from ..support.errors import InputError, LimitError
from ..support.files import as_path, writable, write_whole
from ..support.messages import Quantity, Text, joined
from .files.c_header import header_text
from .files.csv_file import csv_text, read_csv
from .files.joint_trajectory import json_text, read_message
from .files.mcap_file import mcap_bytes, read_mcap
from .piecewise import through
from .trajectory import Points, Trajectory, Writing
from .within import farthest_outside, require_positions, returning


class Format(NamedTuple):
    """A kind of file: its endings, its writer and its reader, and whether counts go into it."""

    endings: tuple[str, ...]
    write: Callable[[Trajectory, Writing], str | bytes] | None = None
    read: Callable[[Arm, Path], Points] | None = None
    counts: bool = False


FORMATS: Mapping[str, Format] = {
    "csv": Format((".csv",), csv_text, read_csv, counts=True),
    "json": Format((".json",), json_text, read_message),
    "yaml": Format((".yaml", ".yml"), None, read_message),
    "mcap": Format((".mcap",), mcap_bytes, read_mcap),
    "header": Format((".h", ".hpp", ".hh", ".hxx"), header_text, counts=True),
}
"""All kinds of files of motions. A name's ending counts in any letters."""

# Seconds between two points: a message counts nanoseconds, and a polynomial divides by the fifth power.
SHORTEST_STEP = 0.9e-9
# Times [s], positions [rad, m] and rates of every arm are far smaller. Larger values overflow in polynomials.
LARGEST = 1e9
# Rates disagree with values by this median factor. Steps above that share of the greatest count, so many at least.
DISAGREES, COMPARED, FEWEST, TINY = 5.0, 0.1, 3, 1e-300
# A polynomial between two points may leave a position limit by so much [rad, m], as that of a coarse file does.
SWING = 1e-4


def load_trajectory(arm: Arm, path: str | os.PathLike[str]) -> Trajectory:
    """Read a motion of `arm` from a file of `save_trajectory` or another program.

    Between two instants a polynomial meets the positions, rates and accelerations of both. It is quintic, cubic, or
    straight for positions alone, as in ROS's joint_trajectory_controller. The first instant is t = 0. The arm is at
    rest before the first and after the last. Every instant is a waypoint. Labels are read too; motors are those of the
    arm.

    - CSV: columns `time [s]`, and for each joint `<joint>.position [rad]` and `<joint>.velocity [rad/s]`, with or
      without `<joint>.acceleration [rad/s^2]` (m for slides), in any order. Counts of the motors' drives may replace
      them, as `save_trajectory(counts=True)` writes. Other columns are ignored.
    - JSON, YAML: a `trajectory_msgs/JointTrajectory`, or MoveIt's `RobotTrajectory` with one, in rad and m, joints in
      any order, others ignored. YAML may last some minutes at most.
    - MCAP, with the extra `mcap`: the setpoints of a recorded stream, as sent. Of another recording of ROS 2 its only
      `JointTrajectory`. If it has several or none, the `sensor_msgs/JointState` of topics that end in `joint_states`.

    Args:
        arm: The arm.
        path: A file with the ending .csv, .json, .yaml, .yml or .mcap.

    Returns:
        The `Trajectory`.

    Raises:
        InputError: The file cannot be read, or a joint is missing. Or a value is not finite, a time does not increase,
            or rates contradict positions and times. The message gives the line or the point.
        LimitError: A position lies outside the arm's limits, or the motion between two points leaves them.
    """
    require_arm(arm)
    file = as_path(path)
    kinds = {ending: kind for kind in FORMATS.values() if kind.read for ending in kind.endings}
    kind = kinds.get(file.suffix.lower())
    if kind is None or kind.read is None:
        raise InputError(f"a motion is read from {_listed(kinds)}; got {file}")
    points = kind.read(arm, file)
    if len(points.t) == 0:
        raise InputError(f"{file} holds no point of a motion")
    _require_usual(points)
    _require_agreement(points)
    allowed = returning(arm.limits, points.theta[0], arm.units)
    (k, j), off, _ = farthest_outside(points.theta, allowed)
    if off > 0.0:
        what = "{place}: joint {joint!r} at {value} is {beyond} beyond its limit; record a motion within the limits"
        value, beyond = Quantity(points.theta[k, j], arm.units[j]), Quantity(off, arm.units[j], 3)
        raise LimitError(Text(what, place=points.place(k), joint=arm.joint_names[j], value=value, beyond=beyond))
    t, theta = points.t - points.t[0], points.theta
    labels = tuple((time - float(points.t[0]), text) for time, text in points.labels)
    if len(t) == 1:
        breakpoints, coefficients = np.zeros(2), theta[None]
    else:
        breakpoints, coefficients = t, through(t, theta, points.theta_dot, points.theta_ddot)
    straight = points.theta_dot is None and len(t) > 1
    notes = ("the file has positions alone, so velocities jump at its points",) if straight else ()
    try:
        motion = Trajectory(
            arm.joint_names, arm.units, theta, t, breakpoints, coefficients, arm.actuators, labels, notes
        )
        require_positions(motion, allowed, "check the times and rates of the file", SWING)
    except (InputError, LimitError) as error:
        raise type(error)(joined(": ", [str(file), error.message])) from error
    return motion


def _require_agreement(points: Points) -> None:
    """Raise InputError where rates carry the joints much farther, or much less far, than the values say."""
    names, rows = ("positions", "velocities", "accelerations"), (points.theta, points.theta_dot, points.theta_ddot)
    for i, (values, rates) in enumerate(pairwise(rows)):
        if values is None or rates is None:
            continue
        change, carried = np.diff(values, axis=0), 0.5 * (rates[1:] + rates[:-1]) * np.diff(points.t)[:, None]
        size = np.maximum(np.abs(change), np.abs(carried))
        # Where both rates are zero, or hardly anything moves, nothing can be compared.
        compared = (carried != 0.0) & (size > COMPARED * size.max(initial=0.0))
        if compared.sum() < FEWEST:
            continue
        ratio = float(np.median(np.abs(carried[compared]) / np.maximum(np.abs(change[compared]), TINY)))
        if not 1.0 / DISAGREES < ratio < DISAGREES:
            raise InputError(
                f"{points.place(0)}: over the times that follow, the {names[i + 1]} mean {ratio:.3g} times the change "
                f"of the {names[i]}: check the unit of the times [s] and of the {names[i + 1]}"
            )


def _require_usual(points: Points) -> None:
    for values in (points.t[:, None], points.theta, points.theta_dot, points.theta_ddot):
        if values is not None and not (np.abs(values) <= LARGEST).all():
            k, j = (int(index) for index in np.unravel_index(np.argmax(np.abs(values)), values.shape))
            raise InputError(f"{points.place(k)}: no arm moves so far or so fast; got {values[k, j]:g}")
    increasing: NDArray[np.bool_] = np.diff(points.t) >= SHORTEST_STEP
    if not increasing.all():
        k = int(np.argmin(increasing)) + 1
        raise InputError(f"{points.place(k)}: time must increase; got {points.t[k]:g} after {points.t[k - 1]:g}")


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
      each joint. The header names column and unit, `slide.position [m]`. Each motor adds `left.motor_position [rad]`,
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
      double. Names begin with the file's. Labels are a table too. `dt` does not matter. Quintic pieces within 1e-6 rad
      or m replace tables of more than 60 kB. A comment tells how far they are off, and how their rates compare.

    Args:
        trajectory: The motion.
        path: A file with the ending .csv, .json, .mcap, .h, .hpp, .hh or .hxx.
        dt: Time between rows or points [s].
        arm: The arm of the motion, for MCAP.
        actuators: The motors; by default those of the arm that the motion was planned for.
        counts: Whether CSV and headers hold counts of the motors' drives in place of joint values. It is for firmware
            that knows no joints.

    Returns:
        The path written.

    Raises:
        InputError: The file cannot be written, or its ending is unknown. Or dt is not positive, or arm or actuators do
            not fit.
        MissingExtraError: rosbags is not installed, and the file is MCAP.
    """
    require(trajectory, Trajectory, "trajectory", "from plan, plan_joint or load_trajectory")
    target = writable(path)
    kinds = {ending: name for name, kind in FORMATS.items() if kind.write for ending in kind.endings}
    name = kinds.get(target.suffix.lower())
    if name is None:
        raise InputError(f"a motion is written to {_listed(kinds)}; got {target}")
    how = Writing(dt, arm, actuators, as_flag(counts, "counts"), target.name)
    return write_whole(target, written(trajectory, name, how))


def written(trajectory: Trajectory, kind: str, how: Writing) -> str | bytes:
    """Return the content of a file of that kind, one of `FORMATS`. Raises InputError as `save_trajectory`."""
    form = FORMATS[kind]
    assert form.write is not None
    if how.counts and not form.counts:
        raise InputError(f"counts go into *.csv and headers; a file {how.name} is in rad and m")
    return form.write(trajectory, how)


def _listed(endings: Iterable[str]) -> str:
    return ", ".join(f"*{ending}" for ending in endings)
