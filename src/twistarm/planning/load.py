"""load_trajectory: a motion read from a file and checked."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm, require_arm
from ..support.errors import InputError, LimitError
from ..support.files import as_path
from ..support.messages import Quantity, Text, joined
from .files.csv_file import read_csv
from .files.joint_trajectory import read_json, read_yaml
from .files.mcap_file import read_mcap
from .piecewise import through
from .trajectory import Points, Trajectory
from .within import farthest_outside, require_positions

READERS: Mapping[str, Callable[[Arm, Path], Points]] = {
    ".csv": read_csv,
    ".json": read_json,
    ".yaml": read_yaml,
    ".yml": read_yaml,
    ".mcap": read_mcap,
}
"""By the ending of a file's name, in any letters."""

SHORTEST_STEP = 0.9e-9
"""Seconds between two points: a message counts nanoseconds, and a polynomial divides by the fifth power."""

LARGEST = 1e9
"""Times [s], positions [rad, m] and rates of every arm are far smaller. Larger values overflow in polynomials."""

DISAGREES, COMPARED, FEWEST, TINY = 5.0, 0.1, 3, 1e-300
"""Rates disagree with values by this median factor. Steps above that share of the greatest count, so many at least."""

SWING = 1e-4
"""A polynomial between two points may leave a position limit by so much [rad, m], as that of a coarse file does."""

BEYOND_LIMIT = 1e-6
"""Beyond a position limit by less [rad, m] is rounding of the file."""


def load_trajectory(arm: Arm, path: str | os.PathLike[str]) -> Trajectory:
    """Read a motion of `arm` from a file of `save_trajectory` or another program.

    Between two instants a polynomial meets the positions, rates and accelerations of both. It is quintic, cubic, or
    straight for positions alone, as in ROS's joint_trajectory_controller. The first instant is t = 0. The arm is at
    rest before the first and after the last. Every instant is a waypoint. Labels are read too; motors are those of the
    arm.

    - CSV: columns `time [s]`, and for each joint `<joint>.position [rad]` and `<joint>.velocity [rad/s]`, with or
      without `<joint>.acceleration [rad/s^2]` (m for slides), in any order. Counts of the motors' drives may replace
      them, as `save_trajectory(counts=True)` writes. Columns of limits are optional. Other columns are ignored.
    - JSON, YAML: a `trajectory_msgs/JointTrajectory` in rad and m, joints in any order, others ignored. YAML may last
      some minutes at most.
    - MCAP, with the extra `mcap`: the setpoints of a recorded stream, as sent. Of another recording of ROS 2 its only
      `JointTrajectory`. If it has several or none, the `sensor_msgs/JointState` of topics that end in `joint_states`.

    Args:
        arm: The arm.
        path: A file whose name ends with .csv, .json, .yaml, .yml or .mcap.

    Returns:
        The `Trajectory`.

    Raises:
        InputError: The file cannot be read, a joint is missing, a value is not finite, a time does not increase, or
            rates contradict positions and times. The message gives the line or the point.
        LimitError: A position lies outside the arm's limits, or the motion between two points leaves them.
    """
    require_arm(arm)
    file = as_path(path)
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise InputError(f"a motion is read from {', '.join(f'*{ending}' for ending in READERS)}; got {file}")
    points = reader(arm, file)
    if len(points.t) == 0:
        raise InputError(f"{file} holds no point of a motion")
    _require_usual(points)
    _require_agreement(points)
    (k, j), off, _ = farthest_outside(points.theta, arm.limits)
    if off > BEYOND_LIMIT:
        what = "{place}: joint {joint!r} at {value} is {beyond} beyond its limit; record a motion within the limits"
        value, beyond = Quantity(points.theta[k, j], arm.units[j]), Quantity(off, arm.units[j], 3)
        raise LimitError(Text(what, place=points.place(k), joint=arm.joint_names[j], value=value, beyond=beyond))
    t, theta = points.t - points.t[0], points.theta
    labels = tuple((time - float(points.t[0]), text) for time, text in points.labels)
    if len(t) == 1:
        breakpoints, coefficients = np.zeros(2), theta[None]
    else:
        breakpoints, coefficients = t, through(t, theta, points.theta_dot, points.theta_ddot)
    try:
        motion = Trajectory(
            arm.joint_names, arm.units, theta, t, breakpoints, coefficients, arm.actuators, labels, limits=points.limits
        )
        require_positions(motion, arm.limits, "check the times and rates of the file", SWING)
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
    apart: NDArray[np.bool_] = np.diff(points.t) >= SHORTEST_STEP
    if not apart.all():
        k = int(np.argmin(apart)) + 1
        raise InputError(f"{points.place(k)}: time must increase; got {points.t[k]:g} after {points.t[k - 1]:g}")
