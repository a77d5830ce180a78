"""Exercises on trajectories."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import expm, pose_log, twist_matrix
from .instances import TIMES, own_chain, pose


def cubic(t: float, T: float, q0: float, q1: float) -> float:
    """The joint's value at the time `t`, on the cubic that starts at `q0` at 0, ends at `q1` at `T` [s], and is at
    rest at both ends.
    """
    s = t / T
    return q0 + (3 * s**2 - 2 * s**3) * (q1 - q0)


def quintic_velocity(t: float, T: float, q0: float, q1: float) -> float:
    """The joint's velocity at the time `t`, on the quintic from `q0` at 0 to `q1` at `T` [s], at rest and without
    acceleration at both ends: q = q0 + (10 s³ − 15 s⁴ + 6 s⁵)(q1 − q0) with s = t/T.
    """
    s = t / T
    return (30 * s**2 - 60 * s**3 + 30 * s**4) * (q1 - q0) / T


def shortest_time(distance: float, velocity: float, acceleration: float) -> float:
    """The least duration [s] of a cubic from rest to rest over `distance` (of either sign) that keeps to both limits.

    The cubic 3 s² − 2 s³ has the greatest slope 3/2 and the greatest curvature 6.
    """
    d = abs(distance)
    return float(max(1.5 * d / velocity, np.sqrt(6 * d / acceleration)))


def screw_between(g0: Array, g1: Array, s: float) -> Array:
    """The pose (4, 4) at the share `s`, from 0 to 1, of the screw motion from `g0` to `g1` (4, 4).

    `exp` and `log` of twistarm.theory.screws are the exponential and the logarithm of poses.
    """
    from twistarm.theory.screws import exp, inverse, log

    g: Array = g0 @ exp(log(inverse(g0) @ g1), s)
    return g


def _moments(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        T = float(rng.uniform(1.5, 5.0))
        yield float(rng.uniform(0.1, 0.9) * T), T, float(rng.uniform(0.3, 2.0)), float(rng.uniform(-2.0, -0.3))
    yield 0.0, 2.0, 0.5, 1.5
    yield 2.0, 2.0, 0.5, 1.5


def _limits(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for acceleration in (0.3, 50.0) * (TIMES // 2):
        yield float(rng.uniform(0.3, 3.0) * rng.choice([-1, 1])), float(rng.uniform(0.5, 2.0)), acceleration


def _motions(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng), pose(rng), float(rng.uniform(0.2, 0.8))) for _ in range(TIMES))
    yield own_chain(rng, arm)[1], pose(rng), 0.5


def _by_conditions(t: float, T: float, q0: float, q1: float) -> float:
    """Four conditions for four coefficients, solved as equations."""
    A = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, T, T**2, T**3], [0, 1, 2 * T, 3 * T**2]], float)
    return float(np.linalg.solve(A, [q0, 0.0, q1, 0.0]) @ [1, t, t**2, t**3])


def _velocity_by_conditions(t: float, T: float, q0: float, q1: float) -> float:
    powers = np.arange(6)

    def row(at: float, order: int) -> Array:
        factors = np.array([np.prod(np.arange(k, k - order, -1)) for k in powers], float)
        return np.array(factors * np.where(powers >= order, float(at) ** np.maximum(powers - order, 0), 0.0))

    A = np.array([row(at, order) for at in (0.0, T) for order in range(3)])
    return float(np.linalg.solve(A, [q0, 0.0, 0.0, q1, 0.0, 0.0]) @ row(t, 1))


def _by_trying(distance: float, velocity: float, acceleration: float) -> float:
    """The least duration in which finely sampled differences keep to the limits, by bisection."""
    s = np.linspace(0.0, 1.0, 20_001)
    q = np.polynomial.Polynomial([0.0, 0.0, 3.0, -2.0])
    fastest, hardest = np.abs(q.deriv(1)(s)).max() * abs(distance), np.abs(q.deriv(2)(s)).max() * abs(distance)
    low, high = 0.0, 1e3
    for _ in range(80):
        T = (low + high) / 2
        kept = fastest / T <= velocity and hardest / T**2 <= acceleration
        low, high = (low, T) if kept else (T, high)
    return high


def _screw(g0: Array, g1: Array, s: float) -> Array:
    """The same motion seen from space: e^{s log(g1 g0⁻¹)} g0."""
    made: Array = expm(s * twist_matrix(pose_log(g1 @ np.linalg.inv(g0)))) @ g0
    return made


EXERCISES = (
    Exercise(
        cubic,
        _by_conditions,
        _moments,
        (
            Slip(
                "not divided by T",
                "You put the time itself into the polynomial; it goes from 0 to 1: s = t / T.",
                {"s = t / T": "s = t"},
            ),
            Slip(
                "straight line",
                "This is a straight line: it starts and stops with a jerk. The cubic is 3 s² − 2 s³.",
                {"(3 * s**2 - 2 * s**3)": "s"},
            ),
            Slip(
                "quintic",
                "This is the quintic; the cubic from rest to rest is 3 s² − 2 s³.",
                {"(3 * s**2 - 2 * s**3)": "(10 * s**3 - 15 * s**4 + 6 * s**5)"},
            ),
            Slip("start forgotten", "The way is right, but it begins at q0: add it.", {"q0 + (3": "(3"}),
            Slip(
                "end for way",
                "You multiply by q1; the way is q1 − q0.",
                {"(q1 - q0)": "q1"},
            ),
            Slip(
                "coefficients swapped",
                "The coefficients are swapped: 3 s² − 2 s³ is 1 at s = 1 and flat at both ends.",
                {"3 * s**2 - 2 * s**3": "3 * s**3 - 2 * s**2"},
            ),
        ),
    ),
    Exercise(
        quintic_velocity,
        _velocity_by_conditions,
        _moments,
        (
            Slip(
                "not divided by T",
                "The derivative is by s; by the time it is 1/T of that (the chain rule): divide by T.",
                {"* (q1 - q0) / T": "* (q1 - q0)"},
            ),
            Slip(
                "time not scaled",
                "You put the time itself into the polynomial; it goes from 0 to 1: s = t / T.",
                {"s = t / T": "s = t"},
            ),
            Slip(
                "position",
                "This is the position: differentiate it.",
                {
                    "return (30 * s**2 - 60 * s**3 + 30 * s**4) * "
                    "(q1 - q0) / T": "return q0 + (10 * s**3 - 15 * s**4 + 6 * s**5) * (q1 - q0)"
                },
            ),
            Slip(
                "acceleration",
                "This is the acceleration: differentiate once only.",
                {
                    "(30 * s**2 - 60 * s**3 + 30 * s**4) * (q1 - q0) / T": "(60 * s - 180 * s**2 + 120 * s**3) * (q1 - "
                    "q0) / T**2"
                },
            ),
            Slip(
                "divided twice",
                "You divide by T²: that is for the acceleration. The velocity has 1/T.",
                {"(q1 - q0) / T": "(q1 - q0) / T**2"},
            ),
            Slip(
                "start added",
                "q0 does not move: it is no part of the velocity.",
                {"return (30": "return q0 + (30"},
            ),
        ),
    ),
    Exercise(
        shortest_time,
        _by_trying,
        _limits,
        (
            Slip(
                "least for greatest",
                "You take the smaller of the two durations: it breaks the other limit. Take the greater one.",
                {"max(": "min("},
            ),
            Slip(
                "average velocity",
                "You divide by the velocity as if the joint moved evenly. Its peak is 3/2 of the average: 1.5 |d| / v.",
                {"1.5 * d": "d"},
            ),
            Slip(
                "root forgotten",
                "The acceleration goes with 1/T²: take the root of 6 |d| / a.",
                {"np.sqrt(6 * d / acceleration)": "6 * d / acceleration"},
            ),
            Slip(
                "sign of the way",
                "For a way backwards the duration comes out negative, or NaN: take the absolute value of the distance.",
                {"abs(distance)": "distance"},
            ),
            Slip(
                "acceleration forgotten",
                "You heed the velocity alone: on short ways the acceleration decides, √(6 |d| / a).",
                {"max(1.5 * d / velocity, np.sqrt(6 * d / acceleration))": "1.5 * d / velocity"},
            ),
            Slip(
                "velocity forgotten",
                "You heed the acceleration alone: on long ways the velocity decides, 1.5 |d| / v.",
                {"max(1.5 * d / velocity, np.sqrt(6 * d / acceleration))": "np.sqrt(6 * d / acceleration)"},
            ),
        ),
    ),
    Exercise(
        screw_between,
        _screw,
        _motions,
        (
            Slip(
                "right for left",
                "You multiply by the start on the wrong side: the logarithm of g0⁻¹ g1 is seen from the body, and is "
                "multiplied from the right, g0 e^{s …}.",
                {"g0 @ exp(log(inverse(g0) @ g1), s)": "exp(log(inverse(g0) @ g1), s) @ g0"},
            ),
            Slip(
                "line for screw",
                "The origin goes straight while the rotation turns: that is the straight line, another "
                "motion. On the screw the origin goes along a helix.",
                {
                    "    g: Array = g0 @": "    g: Array = g0 + s * (g1 - g0)\n    along = g[:3, 3].copy()\n    "
                    "g = g0 @",
                    "    return g": "    g[:3, 3] = along\n    return g",
                },
            ),
            Slip(
                "numbers interpolated",
                "You interpolate the numbers of the matrices: between two rotations lies no rotation then.",
                {"g0 @ exp(log(inverse(g0) @ g1), s)": "g0 + s * (g1 - g0)"},
            ),
            Slip(
                "start forgotten",
                "The motion is right, but it begins at g0: multiply by it.",
                {"g0 @ exp": "exp"},
            ),
            Slip(
                "backwards",
                "The motion goes away from g1: the logarithm is that of g0⁻¹ g1.",
                {"inverse(g0) @ g1": "inverse(g1) @ g0"},
            ),
        ),
        tolerance=1e-5,
    ),
)
