"""Exercises on the two-link arm."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import wrapped
from .instances import TIMES, angle
from .words import ACOS, DEGREES


def wrap(angle: float) -> float:
    """The same direction as an angle in (−π, π] [rad]. At a half turn, where rounding decides, −π counts as π."""
    return float(np.pi - (np.pi - angle) % (2 * np.pi))


def tip(l1: float, l2: float, theta1: float, theta2: float) -> Array:
    """The tip (x, y) of the two-link arm. `theta2` [rad] is measured from the first link, not from the x axis."""
    x = l1 * np.cos(theta1) + l2 * np.cos(theta1 + theta2)
    y = l1 * np.sin(theta1) + l2 * np.sin(theta1 + theta2)
    return np.array([x, y])


def elbow(l1: float, l2: float, r: float) -> float:
    """The angle [rad] between the two links at the elbow, from 0 (folded) to π (stretched).

    The tip is at the distance `r` [m] from the base. `r` comes from a computer: at the edges it may be off by rounding.
    """
    return float(np.arccos(np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * l2), -1.0, 1.0)))


def both_elbows(l1: float, l2: float, x: float, y: float) -> Array:
    """Both configurations (theta1, theta2) [rad] with the tip at (x, y), a row each: (2, 2). The first has theta2 ≥ 0,
    the second is its flip. All angles are in (−π, π]. (x, y) is reachable up to rounding at the edges, and is not the
    base.
    """
    r2 = x * x + y * y
    theta2 = np.arccos(np.clip((r2 - l1**2 - l2**2) / (2 * l1 * l2), -1.0, 1.0))
    beta = np.arccos(np.clip((r2 + l1**2 - l2**2) / (2 * l1 * np.sqrt(r2)), -1.0, 1.0))
    phi = np.arctan2(y, x)
    rows = np.array([[phi - beta, theta2], [phi + beta, -theta2]])
    return np.pi - (np.pi - rows) % (2 * np.pi)


def _angles(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((float(value),) for value in rng.uniform(-12.0, 12.0, TIMES))
    yield from ((value,) for value in (0.0, 1.0, -1.0, 4.0, -4.0, np.pi, -np.pi, 3 * np.pi, 200.5, -301.5))


def _configurations(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((*_two_links(rng), angle(rng), angle(rng)) for _ in range(TIMES))


def _two_links(rng: np.random.Generator) -> tuple[float, float]:
    l1, l2 = rng.uniform(0.2, 0.6, 2)
    return float(l1), float(l2)


def _distances(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        l1, l2 = _two_links(rng)
        yield l1, l2, float(abs(l1 - l2) + rng.uniform(0.1, 0.9) * 2 * min(l1, l2))
    yield 0.5, 0.3, 0.8 + 4e-16
    yield 0.5, 0.3, 0.2 - 4e-16


def _targets(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for quadrant in (0.7, 2.2, -2.2, -0.7, 3.0, -3.0):
        for _ in range(2):
            l1, l2 = _two_links(rng)
            r = abs(l1 - l2) + rng.uniform(0.15, 0.85) * 2 * min(l1, l2)
            turn = quadrant + rng.uniform(-0.1, 0.1)
            yield l1, l2, float(r * np.cos(turn)), float(r * np.sin(turn))
    yield 0.5, 0.3, -0.8 - 4e-16, 0.0


def _wrapped(value: float) -> float:
    return float(wrapped(value))


def _tip(l1: float, l2: float, theta1: float, theta2: float) -> Array:
    """By complex numbers: each link is turned by exp(iθ)."""
    z = np.exp(1j * theta1) * (l1 + np.exp(1j * theta2) * l2)
    return np.array([z.real, z.imag])


def _elbow(l1: float, l2: float, r: float) -> float:
    """By Heron's half-angle formula: tan(α/2) = √((s−l1)(s−l2) / (s (s−r)))."""
    s = (l1 + l2 + r) / 2
    return float(2 * np.arctan2(np.sqrt(max((s - l1) * (s - l2), 0.0)), np.sqrt(max(s * (s - r), 0.0))))


def _both(l1: float, l2: float, x: float, y: float) -> Array:
    """By intersecting two circles: elbow points, and the directions of the links from there."""
    target = complex(x, y)
    r = abs(target)
    along = (r * r + l1 * l1 - l2 * l2) / (2 * r)
    across = np.sqrt(max(l1 * l1 - along * along, 0.0))
    rows = []
    for side in (-1.0, 1.0):
        joint = target / r * (along + 1j * side * across)
        rows.append([np.angle(joint), np.angle((target - joint) / joint)])
    return np.array(wrapped(np.array(rows)))


def _directions(angles: Any, *_: Any) -> Array:
    """Unchanged angles. Within 1e-5 of a half turn −π and π are one, because rounding decides."""
    return np.where(np.abs(np.add(angles, np.pi)) < 1e-5, np.pi, angles)


EXERCISES = (
    Exercise(
        wrap,
        _wrapped,
        _angles,
        (
            Slip(
                "from 0 to 2π",
                "Your angles go from 0 to 2π; asked for is (−π, π], so that −0.1 stays −0.1.",
                {"np.pi - (np.pi - angle) % (2 * np.pi)": "angle % (2 * np.pi)"},
            ),
            Slip(
                "unchanged",
                "You return the angle as it came, or with whole turns still in it: the answer lies in (−π, π].",
                {"return float(np.pi - (np.pi - angle) % (2 * np.pi))": "return angle"},
            ),
            Slip(
                "once only",
                "You take away one full turn at most; angles may be several turns off. Use % or a loop.",
                {
                    "return float(np.pi - (np.pi - angle) % (2 * np.pi))": "return float(angle - 2 * np.pi if angle > "
                    "np.pi else angle + 2 * np.pi if angle <= "
                    "-np.pi else angle)"
                },
            ),
            Slip(
                "degrees",
                "You wrap at 180, as for degrees; angles are in radians, and a full turn is 2π.",
                {"np.pi - (np.pi - angle) % (2 * np.pi)": "180.0 - (180.0 - angle) % 360.0"},
            ),
            Slip(
                "modulo π",
                "You wrap by π, half a turn: that turns some directions round. A full turn is 2π.",
                {"% (2 * np.pi)": "% np.pi"},
            ),
        ),
        seen=_directions,
    ),
    Exercise(
        tip,
        _tip,
        _configurations,
        (
            Slip(
                "second angle from the x axis",
                "The second link is drawn at theta2; it is measured from the first link, so it points at "
                "theta1 + theta2.",
                {"theta1 + theta2": "theta2"},
            ),
            Slip(
                "inner angle",
                "You take theta2 for the angle between the links at the elbow. It is measured from the direction of "
                "the first link: at theta2 = 0 the arm is stretched.",
                {"theta1 + theta2": "theta1 + np.pi - theta2"},
            ),
            Slip(
                "folded at zero",
                "Your arm is folded at theta2 = 0: the second link points back, by half a turn too much. At theta2 = 0 "
                "it goes on in the direction of the first.",
                {"theta1 + theta2": "theta1 + theta2 + np.pi"},
            ),
            Slip(
                "sine for cosine",
                "Sine and cosine have changed places: with both angles 0 the arm lies along x.",
                {"np.array([x, y])": "np.array([y, x])"},
            ),
            Slip(
                "difference",
                "The second link points at theta1 − theta2 in yours: both angles turn the same way, theta1 + theta2.",
                {"theta1 + theta2": "theta1 - theta2"},
            ),
            Slip(
                "degrees",
                DEGREES,
                {"(theta1)": "(np.radians(theta1))", "(theta1 + theta2)": "(np.radians(theta1 + theta2))"},
            ),
            Slip(
                "links swapped",
                "The lengths have changed places: the first link, l1, is the one at the base.",
                {"l1 * np": "L * np", "l2 * np": "l1 * np", "    return": "    L = l2\n    return"},
            ),
        ),
    ),
    Exercise(
        elbow,
        _elbow,
        _distances,
        (
            Slip(
                "acos not clamped",
                ACOS,
                {
                    "np.clip((l1**2 + l2**2 - r**2) / (2 * l1 * "
                    "l2), -1.0, 1.0)": "(l1**2 + l2**2 - r**2) / (2 * l1 * l2)"
                },
            ),
            Slip(
                "the outer angle",
                "This is theta2, how far the second link is turned from the first one's direction: 0 where the arm is "
                "stretched. The angle between the links is π minus that: l1² + l2² − r² in the numerator.",
                {"l1**2 + l2**2 - r**2": "r**2 - l1**2 - l2**2"},
            ),
            Slip(
                "distance not squared",
                "The law of cosines has the squares of all three sides: r², not r.",
                {"r**2": "r"},
            ),
            Slip(
                "the angle at the base",
                "This is the angle at the base, between the first link and the line to the tip. The elbow lies "
                "opposite r: l1² + l2² − r², over 2 l1 l2.",
                {"(l1**2 + l2**2 - r**2) / (2 * l1 * l2)": "(r**2 + l1**2 - l2**2) / (2 * l1 * r)"},
            ),
            Slip("two forgotten", "The law of cosines has 2 l1 l2 below the line.", {"(2 * l1 * l2)": "(l1 * l2)"}),
            Slip(
                "degrees",
                "The angle comes out in degrees: leave np.degrees out.",
                {"np.arccos(": "np.rad2deg(1.0) * np.arccos("},
            ),
            Slip(
                "asin",
                "You use the arcsine; the law of cosines gives the cosine of the angle.",
                {"np.arccos": "np.arcsin"},
            ),
        ),
        tolerance=1e-6,
    ),
    Exercise(
        both_elbows,
        _both,
        _targets,
        (
            Slip(
                "mixed signs",
                "Your signs are mixed: with theta2 positive the first link lies below the line to the target, "
                "theta1 = φ − β; with theta2 negative above it, φ + β. Mixed, the tip misses by up to 2 l2.",
                {"[phi - beta, theta2], [phi + beta, -theta2]": "[phi + beta, theta2], [phi - beta, -theta2]"},
            ),
            Slip(
                "not wrapped",
                "Some of your angles lie outside (−π, π]: φ ± β may pass a half turn. Wrap them at the end.",
                {"return np.pi - (np.pi - rows) % (2 * np.pi)": "return rows"},
            ),
            Slip(
                "π + α not wrapped",
                "Both configurations are right, but some angles lie outside (−π, π]: π + α is more than half a turn, "
                "and φ ± β may be. Wrap all of them at the end.",
                {"return np.pi - (np.pi - rows) % (2 * np.pi)": "return rows", "-theta2]": "2 * np.pi - theta2]"},
            ),
            Slip(
                "mixed signs, not wrapped",
                "Two things: your signs are mixed, for θ₂ = π + α goes with θ₁ = φ + β and π − α with φ − β; and some "
                "angles lie outside (−π, π]: wrap them at the end.",
                {
                    "return np.pi - (np.pi - rows) % (2 * np.pi)": "return rows",
                    "[phi - beta, theta2], [phi + beta, -theta2]": "[phi + beta, theta2], "
                    "[phi - beta, 2 * np.pi - theta2]",
                },
            ),
            Slip(
                "from 0 to 2π",
                "Your angles go from 0 to 2π; asked for is (−π, π], so that −0.1 stays −0.1.",
                {"np.pi - (np.pi - rows) % (2 * np.pi)": "rows % (2 * np.pi)"},
            ),
            Slip(
                "columns for rows",
                "A configuration is a row: [[theta1, theta2], [theta1, theta2]]. Yours are columns: transpose.",
                {"return np.pi - (np.pi - rows) % (2 * np.pi)": "return (np.pi - (np.pi - rows) % (2 * np.pi)).T"},
            ),
            Slip(
                "acos not clamped",
                ACOS,
                {
                    "np.clip((r2 - l1**2 - l2**2) / (2 * l1 * l2), -1.0, 1.0)": "(r2 - l1**2 - l2**2) / (2 * l1 * l2)",
                    "np.clip((r2 + l1**2 - l2**2) / (2 * l1 * "
                    "np.sqrt(r2)), -1.0, 1.0)": "(r2 + l1**2 - l2**2) / (2 * l1 * np.sqrt(r2))",
                },
            ),
            Slip(
                "atan for atan2",
                "np.arctan(y / x) does not distinguish a target in front of the base from one behind it: the arm "
                "points the other way. Use np.arctan2(y, x).",
                {"np.arctan2(y, x)": "np.arctan(y / x)"},
            ),
            Slip(
                "atan2(x, y)", "np.arctan2 takes y first: np.arctan2(y, x).", {"np.arctan2(y, x)": "np.arctan2(x, y)"}
            ),
            Slip(
                "elbow angle for theta2",
                "You return the angle between the links. theta2 is measured from the first link's "
                "direction: π minus that.",
                {"(r2 - l1**2 - l2**2)": "(l1**2 + l2**2 - r2)"},
            ),
            Slip(
                "flip first",
                "Both are right, in the other order: the first row has theta2 ≥ 0.",
                {"[[phi - beta, theta2], [phi + beta, -theta2]]": "[[phi + beta, -theta2], [phi - beta, theta2]]"},
            ),
            Slip(
                "degrees",
                "Your angles are in degrees: leave np.degrees out.",
                {
                    "return np.pi - (np.pi - rows) % (2 * np.pi)": "return np.degrees(np.pi - (np.pi - rows) % (2 "
                    "* np.pi))"
                },
            ),
            Slip(
                "l1 and l2 swapped in β",
                "The angle at the base belongs to the first link: r² + l1² − l2², over 2 l1 r.",
                {"(r2 + l1**2 - l2**2) / (2 * l1 * np.sqrt(r2))": "(r2 + l2**2 - l1**2) / (2 * l2 * np.sqrt(r2))"},
            ),
        ),
        seen=_directions,
    ),
)
