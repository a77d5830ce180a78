"""Exercises on twists and screws."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import expm, twist_matrix
from .instances import TIMES, angle, column, own_chain, pose, unit
from .words import ANGULAR_FIRST, DEGREES


def twist_of_screw(axis: Array, point: Array, pitch: float) -> Array:
    """The twist (v, ω), (6,), of a screw: a turn of 1 rad/s about the line along `axis` (3,) through `point` (3,) with
    `pitch` metres of slide for each radian. The axis may have any length but 0; ω has the length 1.
    """
    w = axis / np.linalg.norm(axis)
    return np.concatenate([-np.cross(w, point) + pitch * w, w])


def screw_of_twist(xi: Array) -> tuple[Array, Array, float]:
    """The screw of a twist (v, ω) with ω ≠ 0: the unit vector along its axis (3,), the point of the axis nearest to the
    origin (3,), and its pitch [m/rad].
    """
    v, w = xi[:3], xi[3:]
    square = float(w @ w)
    return w / np.sqrt(square), np.cross(w, v) / square, float(w @ v / square)


def twist_exp(xi: Array, theta: float) -> Array:
    """The motion e^{ξ̂ θ} (4, 4) of the twist `xi` = (v, ω), whose ω has the length 1, or is 0: then it is the
    translation by v θ. Write it with Rodrigues' formula, or with scipy.linalg.expm.
    """
    v, w = xi[:3], xi[3:]
    g = np.eye(4)
    if w @ w < 1e-12:
        g[:3, 3] = v * theta
        return g
    W = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    R = np.eye(3) + W * np.sin(theta) + W @ W * (1.0 - np.cos(theta))
    g[:3, :3] = R
    g[:3, 3] = (np.eye(3) - R) @ np.cross(w, v) + w * (w @ v) * theta
    return g


def pose_after(g0: Array, xi: Array, theta: float) -> Array:
    """Where a body is, (4, 4), that was at `g0` (4, 4) and has moved along the twist `xi` = (v, ω) by `theta`.

    The twist is seen from the space frame, as `g0` is. `screws.exp(xi, theta)` is the motion.
    """
    from twistarm import screws

    g: Array = screws.exp(xi, theta) @ g0
    return g


def _screws(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for k in range(TIMES):
        yield unit(rng) * (1.0 if k < 3 else rng.uniform(0.4, 3.0)), rng.normal(size=3), float(rng.uniform(0.1, 0.9))


def _turning(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(TIMES):
        yield (column(rng, "thread") * rng.uniform(0.4, 3.0),)


def _motions(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for kind in ["turn", "slide", "thread"] * 3:
        yield column(rng, kind), angle(rng)
    yield np.concatenate([np.zeros(3), unit(rng)]), angle(rng)
    S, _, _ = own_chain(rng, arm)
    yield from ((xi, angle(rng)) for xi in S.T)


def _moved(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for kind in ["turn", "thread"] * 4:
        yield pose(rng), column(rng, kind), angle(rng)
    S, home, _ = own_chain(rng, arm)
    yield from ((home, xi, angle(rng)) for xi in S.T)


def _velocity_at_points(axis: Array, point: Array, pitch: float) -> Array:
    """The twist by what it does: v is the velocity of the point of the body at the origin."""
    w = axis / np.sqrt(np.sum(axis**2))
    return np.concatenate([np.cross(w, np.zeros(3) - point) + pitch * w, w])


def _screw_by_solving(xi: Array) -> tuple[Array, Array, float]:
    """Axis point q and pitch h by least squares of v = −ω × q + hω, of least ‖q‖."""
    W = twist_matrix(np.concatenate([np.zeros(3), xi[3:]]))[:3, :3]
    solution = np.linalg.lstsq(np.column_stack([-W, xi[3:]]), xi[:3], rcond=None)[0]
    return xi[3:] / np.sqrt(np.sum(xi[3:] ** 2)), np.array(solution[:3], float), float(solution[3])


EXERCISES = (
    Exercise(
        twist_of_screw,
        _velocity_at_points,
        _screws,
        (
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"[-np.cross(w, point) + pitch * w, w]": "[w, -np.cross(w, point) + pitch * w]"},
            ),
            Slip(
                "sign of the moment",
                "Your v has +ω × q, or −q × ω: the point of the body at the origin lies at −q from the "
                "axis and moves with −ω × q = q × ω.",
                {"-np.cross(w, point)": "np.cross(w, point)"},
            ),
            Slip(
                "pitch forgotten",
                "The slide along the axis is missing: v = −ω × q + hω. Without hω it is a pure turn.",
                {" + pitch * w": ""},
            ),
            Slip(
                "pitch inverted",
                "You divide by the pitch. It is metres for each radian: the slide is h times ω.",
                {"pitch * w": "w / pitch"},
            ),
            Slip(
                "axis not normalised",
                "The axis has another length than 1 here, and your twist turns faster than 1 rad/s: divide it by its "
                "length.",
                {"axis / np.linalg.norm(axis)": "axis"},
            ),
            Slip(
                "point for velocity",
                "You put the point of the axis where v belongs. v is a velocity, −ω × q + hω.",
                {"-np.cross(w, point) + pitch * w": "point"},
            ),
        ),
    ),
    Exercise(
        screw_of_twist,
        _screw_by_solving,
        _turning,
        (
            Slip("angular first", ANGULAR_FIRST, {"v, w = xi[:3], xi[3:]": "w, v = xi[:3], xi[3:]"}),
            Slip(
                "pitch inverted",
                "Your pitch is upside down: it is metres for each radian, ωᵀv / ‖ω‖².",
                {"w @ v / square": "square / (w @ v)"},
            ),
            Slip(
                "sign of the point",
                "Your point has v × ω; it is ω × v / ‖ω‖², on the other side of the origin.",
                {"np.cross(w, v)": "np.cross(v, w)"},
            ),
            Slip(
                "not divided",
                "Point and pitch are to be divided by ‖ω‖²: a twist that turns twice as fast has the "
                "same axis and pitch.",
                {"np.cross(w, v) / square, float(w @ v / square)": "np.cross(w, v), float(w @ v)"},
            ),
            Slip(
                "divided by the length",
                "You divide by ‖ω‖, but ω stands twice in ω × v / ‖ω‖² (once in v): it takes the square.",
                {"square = float(w @ w)": "square = np.linalg.norm(w)", "w / np.sqrt(square)": "w / square"},
            ),
            Slip(
                "axis not normalised",
                "Your axis is ω itself: divide it by its length.",
                {"w / np.sqrt(square)": "w"},
            ),
        ),
    ),
    Exercise(
        twist_exp,
        lambda xi, theta: expm(twist_matrix(xi) * theta),
        _motions,
        (
            Slip("angular first", ANGULAR_FIRST, {"v, w = xi[:3], xi[3:]": "w, v = xi[:3], xi[3:]"}),
            Slip(
                "straight on",
                "Your translation is v θ, a straight line; but v turns with the body. p = (I − R)(ω × v) + ω ωᵀ v θ.",
                {"(np.eye(3) - R) @ np.cross(w, v) + w * (w @ v) * theta": "v * theta"},
            ),
            Slip(
                "slide forgotten",
                "The term ω ωᵀ v θ is missing: what the screw slides along its axis. Pure turns come out "
                "right without it.",
                {" + w * (w @ v) * theta": ""},
            ),
            Slip(
                "pure translation forgotten",
                "For ω = 0 the formula for turns gives no motion at all: that case is the translation v θ.",
                {"if w @ w < 1e-12:": "if False:"},
            ),
            Slip(
                "zero divided by zero",
                "For ω = 0 you divide by its length, 0: that case is the translation v θ, without a turn.",
                {"if w @ w < 1e-12:": "w = w / np.linalg.norm(w)\n    if False:"},
            ),
            Slip(
                "cross product reversed",
                "You have v × ω where the formula has ω × v: (I − R)(ω × v).",
                {"np.cross(w, v)": "np.cross(v, w)"},
            ),
            Slip(
                "degrees",
                DEGREES,
                {"    v, w = xi[:3], xi[3:]\n": "    v, w = xi[:3], xi[3:]\n    theta = np.radians(theta)\n"},
            ),
            Slip(
                "number by number",
                "np.exp takes the exponential of each number by itself. The matrix exponential is "
                "scipy.linalg.expm, or Rodrigues' formula.",
                {
                    "    g = np.eye(4)\n": "    g = np.zeros((4, 4))\n    g[:3, :3] = np.cross(w, np.eye(3)).T\n"
                    "    g[:3, 3] = v\n    return np.exp(g * theta)\n"
                },
            ),
        ),
    ),
    Exercise(
        pose_after,
        lambda g0, xi, theta: expm(twist_matrix(xi) * theta) @ g0,
        _moved,
        (
            Slip(
                "right for left",
                "You multiply from the right: that moves along the twist as seen from the body. A twist "
                "seen from space is multiplied from the left, e^{ξ̂θ} g(0).",
                {"screws.exp(xi, theta) @ g0": "g0 @ screws.exp(xi, theta)"},
            ),
            Slip(
                "start forgotten",
                "You return the motion alone; the body began at g(0): e^{ξ̂θ} g(0).",
                {" @ g0": ""},
            ),
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"screws.exp(xi, theta)": "screws.exp(np.roll(xi, 3), theta)"},
            ),
            Slip("degrees", DEGREES, {"(xi, theta)": "(xi, np.radians(theta))"}),
            Slip(
                "backwards",
                "The body has moved the other way: e^{ξ̂θ}, without a minus or an inverse.",
                {"(xi, theta)": "(xi, -theta)"},
            ),
        ),
    ),
)
