"""Exercises on all solutions of inverse kinematics: the subproblems of Paden and Kahan, and the flip of a wrist."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import scipy_rotation, wrapped
from .instances import TIMES, angle, unit


def subproblem_1(w: Array, q: Array, u: Array, v: Array) -> float:
    """The angle [rad], in (−π, π], by which the point `u` (3,) turns to `v` (3,) about the line along the unit vector
    `w` (3,) through `q` (3,).
    """
    a, b = u - q, v - q
    a, b = a - w * (w @ a), b - w * (w @ b)
    return float(np.arctan2(w @ np.cross(a, b), a @ b))


def subproblem_3(w: Array, q: Array, u: Array, v: Array, distance: float) -> Array:
    """Both angles [rad], in (−π, π], the smaller first, (2,), by which the point `u` (3,) may turn about the line along
    the unit vector `w` (3,) through `q` (3,) so that it comes to `distance` [m] from `v` (3,). There are two.
    """
    a, b = u - q, v - q
    along = w @ (a - b)
    a, b = a - w * (w @ a), b - w * (w @ b)
    middle = np.arctan2(w @ np.cross(a, b), a @ b)
    cosine = (a @ a + b @ b - (distance**2 - along**2)) / (2 * np.linalg.norm(a) * np.linalg.norm(b))
    half = np.arccos(np.clip(cosine, -1.0, 1.0))
    both = np.array([middle - half, middle + half])
    return np.sort(np.pi - (np.pi - both) % (2 * np.pi))


def flip_wrist(theta: Array) -> Array:
    """The other angles (3,) [rad], each in (−π, π], of a wrist that turns about z, y and z (ZYZ) by `theta` (3,), which
    give the same rotation.
    """
    other = np.array([theta[0] + np.pi, -theta[1], theta[2] + np.pi])
    return np.pi - (np.pi - other) % (2 * np.pi)


def _turned(w: Array, q: Array, u: Array, theta: float) -> Array:
    made: Array = scipy_rotation().from_rotvec(w * theta).apply(u - q) + q
    return made


def _turns(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES + 2):
        w, q, u = unit(rng), rng.normal(size=3), rng.normal(size=3)
        yield w, q, u, _turned(w, q, u, angle(rng))


def _distances(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES + 2):
        w, q, u, v = unit(rng), rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
        # Between the nearest and the farthest that u comes to v, away from both.
        circle = np.array([np.linalg.norm(_turned(w, q, u, t) - v) for t in np.linspace(0.0, 2 * np.pi, 200)])
        yield w, q, u, v, float(circle.min() + rng.uniform(0.25, 0.75) * np.ptp(circle))


def _wrists(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((np.array([angle(rng), angle(rng), angle(rng)]),) for _ in range(TIMES))


def _by_complex_numbers(w: Array, q: Array, u: Array, v: Array) -> float:
    """In the plane across the axis, with its real axis anywhere in it."""
    e = np.cross(w, np.eye(3)[np.argmin(np.abs(w))])
    f = np.cross(w, e)
    z = [complex(e @ (p - q), f @ (p - q)) for p in (u, v)]
    return float(np.angle(z[1] / z[0]))


def _by_roots(w: Array, q: Array, u: Array, v: Array, distance: float) -> Array:
    """‖u(θ) − v‖² = m + c cos θ + s sin θ, its numbers read off at three angles; roots of a quadratic in e^{iθ}."""
    at0, at1, at2 = (np.sum((_turned(w, q, u, t) - v) ** 2) for t in (0.0, np.pi / 2, np.pi))
    m, c = (at0 + at2) / 2, (at0 - at2) / 2
    s = at1 - m
    roots = np.roots([(c - 1j * s) / 2, m - distance**2, (c + 1j * s) / 2])
    return np.sort(wrapped(np.angle(roots)))


def _flipped(theta: Array) -> Array:
    """SciPy's angles have the middle one positive; mirrored by z they are those with it negative."""
    R = scipy_rotation().from_euler("ZYZ", theta).as_matrix()
    sign = -1.0 if theta[1] > 0 else 1.0
    mirror = np.diag([1.0, 1.0, sign])
    a, b, c = scipy_rotation().from_matrix(mirror @ R @ mirror).as_euler("ZYZ")
    return np.array([a, sign * b, c])


EXERCISES = (
    Exercise(
        subproblem_1,
        _by_complex_numbers,
        _turns,
        (
            Slip(
                "the other way",
                "This is the angle from v to u: the cross product is u' × v', in this order.",
                {"np.cross(a, b)": "np.cross(b, a)"},
            ),
            Slip(
                "sign lost",
                "The arccosine has no sign: it cannot tell a turn to the left from one to the right. Use np.arctan2 of "
                "ω · (u' × v') and u' · v'.",
                {"np.arctan2(w @ np.cross(a, b), a @ b)": "np.arccos(a @ b / np.sqrt((a @ a) * (b @ b)))"},
            ),
            Slip(
                "not projected",
                "You use u − q and v − q as they are: their parts along the axis take part in the scalar "
                "product. Project both onto the plane across the axis first.",
                {"    a, b = a - w * (w @ a), b - w * (w @ b)\n": ""},
            ),
            Slip(
                "axis through the origin",
                "You measure from the origin; the axis goes through q: take u − q and v − q.",
                {"u - q, v - q": "u, v"},
            ),
            Slip(
                "degrees",
                "The angle comes out in degrees: leave np.degrees out.",
                {"return float(": "return float(180 / np.pi * "},
            ),
            Slip(
                "atan2 reversed",
                "np.arctan2 takes the sine's part first: ω · (u' × v'), then u' · v'.",
                {"np.arctan2(w @ np.cross(a, b), a @ b)": "np.arctan2(a @ b, w @ np.cross(a, b))"},
            ),
        ),
    ),
    Exercise(
        subproblem_3,
        _by_roots,
        _distances,
        (
            Slip(
                "distance not projected",
                "You use the distance as it is in the plane across the axis. What lies along the axis takes its share: "
                "δ'² = δ² − (ω · (u − v))².",
                {"(distance**2 - along**2)": "distance**2"},
            ),
            Slip(
                "not wrapped",
                "Some of your angles lie outside (−π, π]: wrap both, then sort them.",
                {"np.sort(np.pi - (np.pi - both) % (2 * np.pi))": "np.sort(both)"},
            ),
            Slip(
                "not sorted",
                "Both are right, but the smaller comes first: sort them after wrapping.",
                {"np.sort(np.pi - (np.pi - both) % (2 * np.pi))": "np.pi - (np.pi - both) % (2 * np.pi)"},
            ),
            Slip(
                "direction to v forgotten",
                "The two solutions lie on both sides of the direction to v: add the angle of subproblem 1 to ±φ.",
                {"[middle - half, middle + half]": "[-half, half]"},
            ),
            Slip(
                "direction reversed",
                "The angle in the middle is that from u' to v', with u' × v' in this order.",
                {"np.cross(a, b)": "np.cross(b, a)"},
            ),
            Slip(
                "axis through the origin",
                "You measure from the origin; the axis goes through q: take u − q and v − q.",
                {"u - q, v - q": "u, v"},
            ),
        ),
    ),
    Exercise(
        flip_wrist,
        _flipped,
        _wrists,
        (
            Slip(
                "middle not negated",
                "The middle angle changes its sign: turned by half a turn about z, the wrist bends to the other side.",
                {"-theta[1]": "theta[1]"},
            ),
            Slip(
                "not wrapped",
                "Some angles lie outside (−π, π]: wrap them.",
                {"return np.pi - (np.pi - other) % (2 * np.pi)": "return other"},
            ),
            Slip(
                "all negated",
                "You negate all three: the outer ones are turned by π instead, θ₄ + π, −θ₅, θ₆ + π.",
                {"[theta[0] + np.pi, -theta[1], theta[2] + np.pi]": "[-theta[0], -theta[1], -theta[2]]"},
            ),
            Slip(
                "one side only",
                "Only one of the outer joints is turned by π: both are.",
                {"theta[2] + np.pi": "theta[2]"},
            ),
            Slip(
                "only the last",
                "Only the last joint is turned by π: the first one is, too.",
                {"theta[0] + np.pi": "theta[0]"},
            ),
            Slip(
                "degrees",
                "You add 180, as for degrees; half a turn is π.",
                {"theta[0] + np.pi": "theta[0] + 180", "theta[2] + np.pi": "theta[2] + 180"},
            ),
        ),
    ),
)
