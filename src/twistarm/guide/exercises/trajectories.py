"""Exercises on trajectories."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import expm, pose_log, twist_matrix
from .instances import TIMES, own_chain, pose


def cubic(t: float, T: float, theta0: float, theta1: float) -> float:
    """The joint's value at the time `t` [s] on a cubic.

    The cubic starts at `theta0` at 0 and ends at `theta1` at `T` [s]. It is at rest at both ends.
    """
    u = t / T
    return theta0 + (3 * u**2 - 2 * u**3) * (theta1 - theta0)


def quintic_velocity(t: float, T: float, theta0: float, theta1: float) -> float:
    """The joint's velocity at the time `t` on the quintic from `theta0` at 0 to `theta1` at `T` [s].

    It is at rest and without acceleration at both ends: θ = θ₀ + (10 u³ − 15 u⁴ + 6 u⁵)(θ₁ − θ₀) with u = t/T.
    """
    u = t / T
    return (30 * u**2 - 60 * u**3 + 30 * u**4) * (theta1 - theta0) / T


def shortest_time(distance: float, velocity: float, acceleration: float) -> float:
    """The least duration [s] of a cubic from rest to rest over `distance`, within both limits.

    The distance may have either sign.

    Over u = t/T, the cubic 3 u² − 2 u³ has the greatest slope 3/2 and curvature 6.
    """
    d = abs(distance)
    return float(max(1.5 * d / velocity, np.sqrt(6 * d / acceleration)))


def screw_between(g0: Array, g1: Array, s: float) -> Array:
    """The pose (4, 4) at the share `s`, from 0 to 1, of the screw motion from `g0` to `g1` (4, 4).

    `screws.exp(xi, s)` and `screws.log(g)` are the exponential and the logarithm of poses, after `from twistarm import
    screws`.
    """
    from twistarm import screws

    g: Array = g0 @ screws.exp(screws.log(screws.inverse(g0) @ g1), s)
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
    yield 0.4, 2.0, 0.3
    yield -0.4, 2.0, 0.3


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
    """The same motion seen from space: exp(s log(g1 g0⁻¹)) g0."""
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
                "You put the time itself into the polynomial; it goes from 0 to 1: u = t / T.",
                {"u = t / T": "u = t"},
            ),
            Slip(
                "straight line",
                "This is a straight line: it starts and stops with a jerk. The cubic is 3 u² − 2 u³.",
                {"(3 * u**2 - 2 * u**3)": "u"},
            ),
            Slip(
                "quintic",
                "This is the quintic; the cubic from rest to rest is 3 u² − 2 u³.",
                {"(3 * u**2 - 2 * u**3)": "(10 * u**3 - 15 * u**4 + 6 * u**5)"},
            ),
            Slip("start forgotten", "The way is right, but it begins at theta0: add it.", {"theta0 + (3": "(3"}),
            Slip("end for way", "You multiply by theta1; the way is theta1 − theta0.", {"(theta1 - theta0)": "theta1"}),
            Slip(
                "coefficients swapped",
                "The coefficients are swapped: 3 u² − 2 u³ is 1 at u = 1 and flat at both ends.",
                {"3 * u**2 - 2 * u**3": "3 * u**3 - 2 * u**2"},
            ),
            Slip(
                "way forgotten",
                "Your joint always goes by 1: multiply the polynomial by the way, theta1 − theta0.",
                {" * (theta1 - theta0)": ""},
            ),
            Slip(
                "plus for minus",
                "The second term is taken away: 3 u² − 2 u³ is 1 at u = 1, and flat there.",
                {"- 2 * u**3": "+ 2 * u**3"},
            ),
            Slip(
                "backwards",
                "Your joint goes from theta1 to theta0.",
                {"theta0 + (": "theta1 + (", "(theta1 - theta0)": "(theta0 - theta1)"},
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
                {"* (theta1 - theta0) / T": "* (theta1 - theta0)"},
            ),
            Slip(
                "time not scaled",
                "You put the time itself into the polynomial; it goes from 0 to 1: u = t / T.",
                {"u = t / T": "u = t"},
            ),
            Slip(
                "position",
                "This is the position: differentiate it.",
                {
                    "return (30 * u**2 - 60 * u**3 + 30 * u**4) * "
                    "(theta1 - theta0) / T": "return theta0 + (10 * u**3 - 15 * u**4 + 6 * u**5) * (theta1 - theta0)"
                },
            ),
            Slip(
                "acceleration",
                "This is the acceleration: differentiate once only.",
                {"30 * u**2 - 60 * u**3 + 30 * u**4": "60 * u - 180 * u**2 + 120 * u**3", "/ T\n": "/ T**2\n"},
            ),
            Slip(
                "divided twice",
                "You divide by T²: that is for the acceleration. The velocity has 1/T.",
                {"(theta1 - theta0) / T": "(theta1 - theta0) / T**2"},
            ),
            Slip(
                "start added",
                "theta0 does not move: it is no part of the velocity.",
                {"return (30": "return theta0 + (30"},
            ),
            Slip(
                "backwards",
                "The sign is wrong: the way is theta1 − theta0, from the start to the end.",
                {"(theta1 - theta0)": "(theta0 - theta1)"},
            ),
            Slip("end for way", "You multiply by theta1; the way is theta1 − theta0.", {"(theta1 - theta0)": "theta1"}),
            Slip(
                "cubic",
                "This is the velocity of the cubic; the quintic is 10 u³ − 15 u⁴ + 6 u⁵.",
                {"30 * u**2 - 60 * u**3 + 30 * u**4": "6 * u - 6 * u**2"},
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
                "sum of both",
                "You add the two durations. Both limits hold at the same time: the greater one is enough.",
                {"max(1.5 * d / velocity, np": "(1.5 * d / velocity + np"},
            ),
            Slip(
                "quintic",
                "15/8 and 10/√3 are the peaks of the quintic; the cubic has 3/2 and 6.",
                {"1.5 * d": "1.875 * d", "6 * d": "10 / np.sqrt(3) * d"},
            ),
            Slip(
                "six forgotten",
                "The greatest acceleration of the cubic is 6 |d| / T²: the 6 stands below the root.",
                {"6 * d": "d"},
            ),
            Slip(
                "constant acceleration",
                "|d| / v and √(2 |d| / a) belong to constant velocity and to constant acceleration. The cubic has the "
                "peaks 3/2 and 6: 1.5 |d| / v and √(6 |d| / a).",
                {"1.5 * d": "d", "6 * d": "2 * d"},
            ),
            Slip(
                "even motion",
                "|d| / v is an even motion from the first instant to the last. The cubic starts and stops at rest: its "
                "peaks give 1.5 |d| / v and √(6 |d| / a).",
                {"max(1.5 * d / velocity, np.sqrt(6 * d / acceleration))": "d / velocity"},
            ),
            Slip(
                "trapezoid",
                "|d| / v + v / a is the duration of another law, with full acceleration, an even middle and full "
                "braking. The cubic has the peaks 3/2 and 6: 1.5 |d| / v and √(6 |d| / a).",
                {"max(1.5 * d / velocity, np.sqrt(6 * d / acceleration))": "d / velocity + velocity / acceleration"},
            ),
            Slip(
                "half and half",
                "2 √(|d| / a) is for full acceleration on the first half and full braking on the second. The cubic has "
                "the peaks 3/2 and 6: 1.5 |d| / v and √(6 |d| / a).",
                {"1.5 * d": "d", "6 * d": "4 * d"},
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
                "multiplied from the right, g0 exp(s …).",
                {"g0 @ screws.exp(": "screws.exp(", "@ g1), s)": "@ g1), s) @ g0"},
            ),
            Slip(
                "mixed sides",
                "The logarithm of g1 g0⁻¹ is seen from the base, and g0 stands on its left. Seen from the base it is "
                "exp(s …) g0; with g0 on the left it is g0 exp(s log(g0⁻¹ g1)).",
                {"screws.inverse(g0) @ g1": "g1 @ screws.inverse(g0)"},
            ),
            Slip(
                "start forgotten, seen from the base",
                "This is the motion, seen from the base, and not yet the pose: multiply it by g0 on the right.",
                {"g0 @ screws.exp(": "screws.exp(", "screws.inverse(g0) @ g1": "g1 @ screws.inverse(g0)"},
            ),
            Slip(
                "from the other end",
                "At s = 0 yours is at g1, at s = 1 at g0: the share counts from g0.",
                {"@ g1), s)": "@ g1), 1 - s)"},
            ),
            Slip(
                "logarithms blended",
                "You blend the logarithms of the two poses: that is no screw motion. The screw is the logarithm of the "
                "way between them, g0⁻¹ g1.",
                {
                    "g0 @ screws.exp(": "screws.exp(",
                    "screws.log(screws.inverse(g0) @ g1), s)": "(1 - s) * screws.log(g0) + s * screws.log(g1))",
                },
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
                {"g0 @ screws.exp(screws.log(screws.inverse(g0) @ g1), s)": "g0 + s * (g1 - g0)"},
            ),
            Slip(
                "start forgotten",
                "The motion is right, but it begins at g0: multiply by it.",
                {"g0 @ screws.exp": "screws.exp"},
            ),
            Slip(
                "backwards",
                "The motion goes away from g1: the logarithm is that of g0⁻¹ g1.",
                {"screws.inverse(g0) @ g1": "screws.inverse(g1) @ g0"},
            ),
        ),
        tolerance=1e-5,
    ),
)
