"""Exercises on all solutions of inverse kinematics: the Paden–Kahan subproblems, and a wrist's flip."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import scipy_rotation, wrapped
from .instances import TIMES, angle, unit


def subproblem_1(omega: Array, r: Array, p: Array, q: Array) -> float:
    """The angle [rad], in (−π, π], of the turn that takes the point `p` (3,) to `q` (3,).

    The axis is the line along the unit vector `omega` (3,) through `r` (3,). Neither point lies on it.
    """
    u, v = p - r, q - r
    u, v = u - omega * (omega @ u), v - omega * (omega @ v)
    return float(np.arctan2(omega @ np.cross(u, v), u @ v))


def crossings(omega_1: Array, omega_2: Array, r: Array, p: Array, q: Array) -> Array:
    """Both points in which the two circles of subproblem 2 cross, a row each: (2, 3).

    The point `p` (3,) goes round the line along the unit vector `omega_2` (3,). The point `q` (3,) goes round the line
    along `omega_1` (3,). The lines cross in `r` (3,). First comes the point on the side of ω₁ × ω₂. There are two.
    """
    u, v, c = p - r, q - r, omega_1 @ omega_2
    normal = np.cross(omega_1, omega_2)
    alpha = (c * (omega_2 @ u) - omega_1 @ v) / (c**2 - 1)
    beta = (c * (omega_1 @ v) - omega_2 @ u) / (c**2 - 1)
    gamma = np.sqrt((u @ u - alpha**2 - beta**2 - 2 * alpha * beta * c) / (normal @ normal))
    middle = r + alpha * omega_1 + beta * omega_2
    return np.array([middle + gamma * normal, middle - gamma * normal])


def subproblem_3(omega: Array, r: Array, p: Array, q: Array, delta: float) -> Array:
    """Both angles (2,) [rad], in (−π, π], that turn the point `p` (3,) to the distance `delta` [m] from `q` (3,).

    The axis is the line along the unit vector `omega` (3,) through `r` (3,). The smaller angle comes first. There are
    two.
    """
    u, v = p - r, q - r
    along = omega @ (u - v)
    u, v = u - omega * (omega @ u), v - omega * (omega @ v)
    middle = np.arctan2(omega @ np.cross(u, v), u @ v)
    cosine = (u @ u + v @ v - (delta**2 - along**2)) / (2 * np.linalg.norm(u) * np.linalg.norm(v))
    half = np.arccos(np.clip(cosine, -1.0, 1.0))
    both = np.array([middle - half, middle + half])
    return np.sort(np.pi - (np.pi - both) % (2 * np.pi))


def flip_wrist(theta: Array) -> Array:
    """The other angles (3,) [rad] of a ZYZ wrist with the same rotation as `theta` (3,).

    The wrist turns about z, y and z. Each angle is in (−π, π].
    """
    other = np.array([theta[0] + np.pi, -theta[1], theta[2] + np.pi])
    return np.pi - (np.pi - other) % (2 * np.pi)


def _turned(omega: Array, r: Array, p: Array, theta: float) -> Array:
    made: Array = scipy_rotation().from_rotvec(omega * theta).apply(p - r) + r
    return made


def _turns(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES + 2):
        omega, r, p = unit(rng), rng.normal(size=3), rng.normal(size=3)
        yield omega, r, p, _turned(omega, r, p, angle(rng))


def _circles(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Axes at an angle. The circles cross well away from the plane of both axes."""
    for _ in range(TIMES):
        while True:
            omega_1, omega_2, r, p = unit(rng), unit(rng), rng.normal(size=3), rng.normal(size=3)
            crossing = _turned(omega_2, r, p, angle(rng))
            normal = np.cross(omega_1, omega_2)
            if np.linalg.norm(normal) > 0.4 and abs(normal @ (crossing - r)) > 0.3:
                break
        yield omega_1, omega_2, r, p, _turned(omega_1, r, crossing, angle(rng))


def _distances(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES + 2):
        omega, r, p, q = unit(rng), rng.normal(size=3), rng.normal(size=3), rng.normal(size=3)
        # Between the nearest and the farthest that p comes to q, away from both.
        circle = np.array([np.linalg.norm(_turned(omega, r, p, t) - q) for t in np.linspace(0.0, 2 * np.pi, 200)])
        yield omega, r, p, q, float(circle.min() + rng.uniform(0.25, 0.75) * np.ptp(circle))


def _wrists(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((np.array([angle(rng), angle(rng), angle(rng)]),) for _ in range(TIMES))


def _by_complex_numbers(omega: Array, r: Array, p: Array, q: Array) -> float:
    """In the plane across the axis, with its real axis anywhere in it."""
    e = np.cross(omega, np.eye(3)[np.argmin(np.abs(omega))])
    f = np.cross(omega, e)
    z = [complex(e @ (point - r), f @ (point - r)) for point in (p, q)]
    return float(np.angle(z[1] / z[0]))


def _around(omega: Array, r: Array, p: Array, value: Callable[[Array], Any]) -> tuple[Any, Any, Any]:
    """m, c, s of value(p(θ)) = m + c cos θ + s sin θ, from three angles."""
    at0, at1, at2 = (value(_turned(omega, r, p, t)) for t in (0.0, np.pi / 2, np.pi))
    m = (at0 + at2) / 2
    return m, at0 - m, at1 - m


def _roots(m: float, c: float, s: float) -> Array:
    """Both θ with m + c cos θ + s sin θ = 0: a quadratic in exp(iθ)."""
    return np.array(np.angle(np.roots([(c - 1j * s) / 2, m, (c + 1j * s) / 2])))


def _by_height(omega_1: Array, omega_2: Array, r: Array, p: Array, q: Array) -> Array:
    """The point of p's circle as far along the first axis as q. r is on both axes, so the distance agrees."""
    angles = _roots(*_around(omega_2, r, p, lambda x: omega_1 @ (x - q)))
    points = [_turned(omega_2, r, p, theta) for theta in angles]
    return np.array(sorted(points, key=lambda x: -np.cross(omega_1, omega_2) @ (x - r)))


def _by_roots(omega: Array, r: Array, p: Array, q: Array, delta: float) -> Array:
    """Where ‖p(θ) − q‖² is δ²."""
    return np.sort(wrapped(_roots(*_around(omega, r, p, lambda x: np.sum((x - q) ** 2) - delta**2))))


def _flipped(theta: Array) -> Array:
    """SciPy's angles have a positive middle one; mirrored by z it is negative."""
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
                "This is the angle from q to p: the cross product is u' × v', in this order.",
                {"np.cross(u, v)": "np.cross(v, u)"},
            ),
            Slip(
                "sign lost",
                "The arccosine has no sign: it cannot tell a turn to the left from one to the right. Use np.arctan2 of "
                "ω · (u' × v') and u' · v'.",
                {"np.arctan2(omega @ np.cross(u, v), u @ v)": "np.arccos(u @ v / np.sqrt((u @ u) * (v @ v)))"},
            ),
            Slip(
                "not projected",
                "You use p − r and q − r as they are: the parts along the axis enter the scalar product. Project both "
                "onto the plane across the axis first.",
                {"    u, v = u - omega * (omega @ u), v - omega * (omega @ v)\n": ""},
            ),
            Slip(
                "axis through the origin",
                "You measure from the origin; the axis goes through r: take p − r and q − r.",
                {"p - r, q - r": "p, q"},
            ),
            Slip(
                "degrees",
                "The angle comes out in degrees: leave np.degrees out.",
                {"return float(": "return float(180 / np.pi * "},
            ),
            Slip(
                "atan2 reversed",
                "np.arctan2 takes the sine's part first: ω · (u' × v'), then u' · v'.",
                {"np.arctan2(omega @ np.cross(u, v), u @ v)": "np.arctan2(u @ v, omega @ np.cross(u, v))"},
            ),
            Slip(
                "arcsine",
                "The arcsine never gives more than a quarter turn: it cannot tell 80° from 100°. Use np.arctan2 of "
                "ω · (u' × v') and u' · v'.",
                {
                    "np.arctan2(omega @ np.cross(u, v), u @ v)": "np.arcsin(omega @ np.cross(u, v) / np.sqrt((u @ u) * "
                    "(v @ v)))"
                },
            ),
            Slip(
                "from 0 to 2π",
                "Your angles go from 0 to 2π; asked for is (−π, π], so that −0.1 stays −0.1.",
                {"u @ v))": "u @ v) % (2 * np.pi))"},
            ),
        ),
    ),
    Exercise(
        crossings,
        _by_height,
        _circles,
        (
            Slip(
                "from the origin",
                "You measure from the origin; the axes cross in r: take u = p − r and v = q − r.",
                {"p - r, q - r": "p, q"},
            ),
            Slip(
                "r forgotten",
                "Your points are seen from r, where the axes cross: add r at the end.",
                {"r + alpha": "alpha"},
            ),
            Slip(
                "the other side first",
                "Both points are right, in the other order: first comes the one on the side of ω₁ × ω₂.",
                {"np.sqrt(": "-np.sqrt("},
            ),
            Slip(
                "α and β exchanged",
                "α and β have changed places: α is the share of ω₁, β that of ω₂.",
                {"alpha * omega_1 + beta * omega_2": "beta * omega_1 + alpha * omega_2"},
            ),
            Slip(
                "axes exchanged",
                "Your p goes round the first axis and your q round the second. The second joint moves p; the first one "
                "acts after it.",
                {"omega_2 @ u": "omega_1 @ u", "omega_1 @ v": "omega_2 @ v"},
            ),
            Slip("root forgotten", "This is γ²: take the root.", {"np.sqrt(": "("}),
            Slip(
                "ω₁ × ω₂ taken for a unit vector",
                "ω₁ × ω₂ is a unit vector only where the axes are at right angles: γ² is divided by ‖ω₁ × ω₂‖².",
                {" / (normal @ normal)": ""},
            ),
            Slip(
                "axes at right angles",
                "Your γ² lacks 2 α β ω₁ · ω₂: that is right only where the axes are at right angles.",
                {" - 2 * alpha * beta * c": ""},
            ),
            Slip(
                "columns for rows",
                "The points are rows, (2, 3). Yours are columns: transpose.",
                {"middle - gamma * normal])": "middle - gamma * normal]).T"},
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
                "You use the distance as it is in the plane across the axis. Subtract the part along the axis: δ'² = "
                "δ² − (ω · (p − q))².",
                {"(delta**2 - along**2)": "delta**2"},
            ),
            Slip(
                "part along the axis added",
                "What lies along the axis is taken away from the distance, not added: δ'² = δ² − (ω · (p − q))².",
                {"delta**2 - along**2": "delta**2 + along**2"},
            ),
            Slip(
                "not projected",
                "You use p − r, q − r and the distance without projecting them. The law of cosines holds in the "
                "plane across the axis: project both, and take δ'² = δ² − (ω · (p − q))².",
                {"    u, v = u - omega * (omega @ u), v - omega * (omega @ v)\n": "", "along**2": "0"},
            ),
            Slip(
                "points not projected",
                "You use p − r and q − r as they are: project both onto the plane across the axis before you take "
                "their lengths and the angle between them.",
                {"    u, v = u - omega * (omega @ u), v - omega * (omega @ v)\n": ""},
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
                "larger first", "Both are right, but the smaller comes first.", {"(2 * np.pi))": "(2 * np.pi))[::-1]"}
            ),
            Slip(
                "from 0 to 2π",
                "Your angles go from 0 to 2π; asked for is (−π, π], so that −0.1 stays −0.1.",
                {"np.pi - (np.pi - both) % (2 * np.pi)": "both % (2 * np.pi)"},
            ),
            Slip(
                "direction to v forgotten",
                "The two solutions lie on both sides of the direction to v: add the angle of subproblem 1 to ±φ.",
                {"[middle - half, middle + half]": "[-half, half]"},
            ),
            Slip(
                "direction reversed",
                "The angle in the middle is that from u' to v', with u' × v' in this order.",
                {"np.cross(u, v)": "np.cross(v, u)"},
            ),
            Slip(
                "axis through the origin",
                "You measure from the origin; the axis goes through r: take p − r and q − r.",
                {"p - r, q - r": "p, q"},
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
                "middle alone",
                "You change the middle angle alone. The wrist bends to the other side, and both outer joints turn by π "
                "to make up for it.",
                {"theta[0] + np.pi": "theta[0]", "theta[2] + np.pi": "theta[2]"},
            ),
            Slip(
                "middle taken from π",
                "The middle angle is −θ₅, not π − θ₅: the last axis would point another way.",
                {"-theta[1]": "np.pi - theta[1]"},
            ),
            Slip(
                "half a turn off, not wrapped",
                "Some angles lie outside (−π, π]: whether π is added or taken away, wrap the result.",
                {
                    "+ np.pi,": "- np.pi,",
                    "+ np.pi]": "- np.pi]",
                    "return np.pi - (np.pi - other) % (2 * np.pi)": "return other",
                },
            ),
            Slip(
                "unchanged",
                "These are the given angles. The task asks for the other triple with the same rotation.",
                {"return np.pi - (np.pi - other) % (2 * np.pi)": "return theta.copy()"},
            ),
            Slip(
                "degrees",
                "You add 180, as for degrees; half a turn is π.",
                {"theta[0] + np.pi": "theta[0] + 180", "theta[2] + np.pi": "theta[2] + 180"},
            ),
        ),
    ),
)
