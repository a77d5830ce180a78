"""A recorded motion as a trajectory, to be played in the view."""

from __future__ import annotations

import os

import numpy as np

from ...model.arm import Arm
from ...planning.trajectory import Trajectory
from ...stream.recording import read_recording


def recorded_motion(arm: Arm, path: str | os.PathLike[str]) -> Trajectory:
    """The motion of `arm` in a CSV file, as `twistarm plan -o` writes it: a cubic between each two of its lines.

    The cubic of each interval, h [s] long, has the recorded positions a, b and rates u, v at its ends (Hermite):
    a + u s + (3 (b − a)/h − 2 u − v) s²/h + (2 (a − b)/h + u + v) s³/h².

    Raises InputError for what is not such a file, LimitError for a position outside the arm's limits.
    """
    recording = read_recording(arm, path)
    a, b = recording.theta[:-1], recording.theta[1:]
    u, v = recording.theta_dot[:-1], recording.theta_dot[1:]
    h = np.diff(recording.t)[:, None]
    mean = (b - a) / h
    coefficients = np.stack([(u + v - 2.0 * mean) / h**2, (3.0 * mean - 2.0 * u - v) / h, u, a])
    return Trajectory(
        arm.joint_names, arm.units, recording.theta, recording.t, recording.t, coefficients, arm.actuators
    )
