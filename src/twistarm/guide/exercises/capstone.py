"""Exercises of the capstone: from a target to setpoints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import tool
from .instances import TIMES, chain, own_chain, pose


def pregrasp(g_object: Array, distance: float) -> Array:
    """The pose (4, 4) from which the tool approaches the grasp pose `g_object` (4, 4).

    It is the grasp pose, moved back by `distance` [m] along its z axis. This axis points into the object.
    """
    back = np.eye(4)
    back[2, 3] = -distance
    g: Array = g_object @ back
    return g


def solve_pose(twists: Array, home: Array, x0: Array, target: Array) -> Array:
    """Joint values (m,) [rad, m] that bring the tool to `target` (4, 4), searched from `x0` (m,), which is near.

    `twists` (6, m) and `home` (4, 4) are the arm's. Repeat: the error g⁻¹ g_target as a twist, a damped step of the
    body Jacobian. Use your own functions, or, after `from twistarm import poe, screws`, `poe.fk`, `poe.body_jacobian`,
    `screws.inverse` and `screws.log`.
    """
    from twistarm import poe, screws

    x = x0.copy()
    for _ in range(100):
        error = screws.log(screws.inverse(poe.fk(twists, home, x)) @ target)
        if np.abs(error).max() < 1e-10:
            break
        J = poe.body_jacobian(twists, home, x)
        x = x + J.T @ np.linalg.solve(J @ J.T + 1e-8 * np.eye(6), error)
    return x


def setpoints(x0: Array, x1: Array, duration: float, period: float) -> Array:
    """The setpoints (N, m) of the joints, every `period` [s] from 0 to `duration` [s], with both ends.

    They are on the cubic from rest at `x0` (m,) to rest at `x1` (m,). The duration is a whole number of periods.
    """
    N = round(duration / period) + 1
    s = np.linspace(0.0, 1.0, N)[:, None]
    return x0 + (3 * s**2 - 2 * s**3) * (x1 - x0)


def _grasps(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng), float(rng.uniform(0.05, 0.3))) for _ in range(TIMES))
    yield tool(*own_chain(rng, arm)), 0.1


def _tasks(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Targets that are met, for the joints' values come first."""
    for k in range(5):
        twists, home, x = chain(rng) if k < 3 else own_chain(rng, arm)
        yield twists, home, x + rng.uniform(-0.15, 0.15, len(x)), tool(twists, home, x)


def _courses(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for duration, period in ((0.7, 0.1), (0.9, 0.3)):  # which rounding divides to a hair below, and above
        yield rng.normal(size=2), rng.normal(size=2), duration, period
    for n in (1, 3, 5, 6, arm.n):
        period = float(rng.choice([0.1, 0.25, 0.05]))
        yield rng.normal(size=n), rng.normal(size=n), period * int(rng.integers(7, 20)), period


def _solved(twists: Array, home: Array, x0: Array, target: Array) -> Array:
    """By SciPy's least squares on the numbers of the matrices."""
    from scipy.optimize import least_squares

    def off(x: Array) -> Array:
        return np.asarray((tool(twists, home, x) - target)[:3].ravel())

    return np.asarray(least_squares(off, x0, xtol=1e-12, ftol=1e-12, gtol=1e-12).x)


def _reached(x: Array, twists: Array, home: Array, x0: Array, target: Array) -> Array:
    """Where the tool is at those joint values: several may be right."""
    return tool(twists, home, x)


def _course(x0: Array, x1: Array, duration: float, period: float) -> Array:
    """Each joint by itself, on the polynomial of its four conditions."""
    A = np.array(
        [[1, 0, 0, 0], [0, 1, 0, 0], [1, duration, duration**2, duration**3], [0, 1, 2 * duration, 3 * duration**2]],
        float,
    )
    times = [k * period for k in range(int(duration / period + 1.5))]
    courses = [np.linalg.solve(A, [a, 0.0, b, 0.0]) for a, b in zip(x0, x1, strict=True)]
    return np.array([[c @ [1, t, t**2, t**3] for c in courses] for t in times])


EXERCISES = (
    Exercise(
        pregrasp,
        lambda g, d: np.column_stack([g[:, :3], g[:, 3] - d * g[:, 2]]),
        _grasps,
        (
            Slip(
                "left for right",
                "You multiply from the left: that moves along the base's z axis. Along the grasp's own "
                "it is multiplied from the right.",
                {"g_object @ back": "back @ g_object"},
            ),
            Slip(
                "forwards",
                "You go forwards, into the object: its z axis points inwards, so the way back is −distance.",
                {"= -distance": "= distance"},
            ),
            Slip("along x", "You go along the grasp's x axis; z is the third.", {"back[2, 3]": "back[0, 3]"}),
            Slip(
                "row for column",
                "The translation is in the last row. It belongs in the last column, back[2, 3].",
                {"back[2, 3]": "back[3, 2]"},
            ),
            Slip(
                "row of the rotation",
                "You move along the third row of the rotation. The axes are its columns, and z is g[:3, 2].",
                {"g_object @ back": "g_object.copy()\n    g[:3, 3] -= distance * g_object[2, :3]"},
            ),
            Slip(
                "grasp forgotten",
                "You return the way back alone: multiply the grasp's pose by it.",
                {"g_object @ back": "back"},
            ),
        ),
    ),
    Exercise(
        solve_pose,
        _solved,
        _tasks,
        (
            Slip(
                "one step",
                "You make one step. That is near, and no more: compute error and Jacobian again from there, until the "
                "error is small.",
                {"range(100)": "range(1)"},
            ),
            Slip(
                "error reversed",
                "The error is reversed, so that every step leads away: it is g⁻¹ g_target, from where the tool is to "
                "where it should be.",
                {"inverse(poe.fk(twists, home, x)) @ target": "inverse(target) @ poe.fk(twists, home, x)"},
            ),
            Slip(
                "error seen from the base",
                "Your error is g_target g⁻¹, seen from the base, and your Jacobian is the body's, seen from the tool. "
                "Take g⁻¹ g_target with Jᵇ.",
                {"screws.inverse(poe.fk(twists, home, x)) @ target": "target @ np.linalg.inv(poe.fk(twists, home, x))"},
            ),
            Slip(
                "degrees",
                "Your joint values are in degrees: leave {degrees} out.",
                {"return x": "return np.degrees(x)"},
            ),
            Slip(
                "start returned",
                "You return the start as it was: did the loop never run, or did you return x0?",
                {"return x": "return x0"},
            ),
            Slip("change returned", "You return the change alone: add it to x0.", {"return x": "return x - x0"}),
            Slip(
                "pose returned",
                "You return the pose that was reached; asked for are the joint values.",
                {"return x": "return poe.fk(twists, home, x)"},
            ),
        ),
        tolerance=1e-5,
        seen=_reached,
    ),
    Exercise(
        setpoints,
        _course,
        _courses,
        (
            Slip(
                "straight line",
                "The joints move evenly and start with a jerk: ease them with 3 s² − 2 s³.",
                {"(3 * s**2 - 2 * s**3)": "s"},
            ),
            Slip(
                "end missing",
                "The last setpoint is missing (or the steps are too short): both ends are sent, N = "
                "duration / period + 1.",
                {"+ 1\n": "\n", "np.linspace(0.0, 1.0, N)": "np.arange(N) / N"},
            ),
            Slip(
                "not divided by the duration",
                "You put the time itself into the polynomial: s = t / duration goes from 0 to 1.",
                {"np.linspace(0.0, 1.0, N)": "np.linspace(0.0, duration, N)"},
            ),
            Slip(
                "a column each",
                "Your setpoints are columns. The task asks for a row for each moment, (N, m).",
                {"return x0 + (3 * s**2 - 2 * s**3) * (x1 - x0)": "return (x0 + (3 * s**2 - 2 * s**3) * (x1 - x0)).T"},
            ),
            Slip(
                "np.arange to the end",
                "np.arange(0, duration, period) leaves its end out, or not, by rounding. Count the moments, "
                "N = round(duration / period) + 1.",
                {
                    "    N = round(duration / period) + 1\n": "",
                    "np.linspace(0.0, 1.0, N)": "(np.arange(0.0, duration, period) / duration)",
                },
            ),
            Slip(
                "cut for rounded",
                "int cuts what comes after the point, and 0.7 / 0.1 is a hair below 7: the last setpoint is missing "
                "then. Use round.",
                {"round(duration / period)": "int(duration / period)"},
            ),
            Slip(
                "one too few, spread",
                "One setpoint is missing: from 0 to the duration there are duration / period + 1 moments.",
                {"+ 1\n": "\n"},
            ),
        ),
    ),
)
