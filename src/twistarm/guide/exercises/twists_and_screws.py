"""Exercises on twists and screws."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from . import independent
from .exercise import Exercise, Slip
from .independent import expm, twist_matrix
from .instances import TIMES, angle, column, own_chain, unit
from .words import ANGULAR_FIRST, DEGREES


def twist_of_screw(axis: Array, point: Array, pitch: float) -> Array:
    """The twist (v, ω), (6,), of a screw motion at 1 rad/s.

    It turns about the line along `axis` (3,) through `point` (3,), and slides by `pitch` metres for each radian. The
    axis may have any length but 0; ω has the length 1.
    """
    w = axis / np.linalg.norm(axis)
    return np.concatenate([-np.cross(w, point) + pitch * w, w])


def screw_of_twist(xi: Array) -> tuple[Array, Array, float]:
    """The screw of a twist (v, ω) with ω ≠ 0, as (axis, point, pitch).

    The axis is the unit vector (3,) in the direction of ω. The point (3,) may be any of the axis, such as the one
    nearest to the origin. The pitch is in m/rad.
    """
    v, w = xi[:3], xi[3:]
    square = float(w @ w)
    return w / np.sqrt(square), np.cross(w, v) / square, float(w @ v / square)


def twist_exp(xi: Array, theta: float) -> Array:
    """The motion exp(ξ̂ θ) (4, 4) of the twist `xi` = (v, ω).

    ω has the length 1, or is 0: then it is the translation by v θ. Write it with Rodrigues' formula, or with
    scipy.linalg.expm.
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


def pose_log(g: Array) -> Array:
    """The logarithm of a pose `g` (4, 4): the twist ξθ = (v, ω), (6,), with exp(ξ̂θ) = g. The length of ω is the angle.
    Here it is less than a half turn and may be 0.

    For ω you may use `rotations.log(R)`, after `from twistarm import rotations`.
    """
    from twistarm import rotations

    R, p = g[:3, :3], g[:3, 3]
    w = rotations.log(R)
    theta = np.linalg.norm(w)
    if theta < 1e-9:
        return np.concatenate([p, w])
    u = w / theta
    U = np.array([[0.0, -u[2], u[1]], [u[2], 0.0, -u[0]], [-u[1], u[0], 0.0]])
    G = (np.eye(3) - R) @ U + np.outer(u, u) * theta
    return np.concatenate([np.linalg.solve(G, p) * theta, w])


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


def _displacements(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for kind in ["thread", "turn", "slide"] * 3:
        yield (expm(twist_matrix(column(rng, kind)) * angle(rng)),)
    S, _, _ = own_chain(rng, arm)
    yield from ((expm(twist_matrix(xi) * angle(rng)),) for xi in S.T)


def _velocity_at_points(axis: Array, point: Array, pitch: float) -> Array:
    """The twist by its effect: v is the velocity of the body point at the origin."""
    w = axis / np.sqrt(np.sum(axis**2))
    return np.concatenate([np.cross(w, np.zeros(3) - point) + pitch * w, w])


def _screw_by_solving(xi: Array) -> tuple[Array, Array, float]:
    """Axis point q and pitch h by least squares of v = −ω × q + hω, with the least ‖q‖."""
    W = twist_matrix(np.concatenate([np.zeros(3), xi[3:]]))[:3, :3]
    solution = np.linalg.lstsq(np.column_stack([-W, xi[3:]]), xi[:3], rcond=None)[0]
    return xi[3:] / np.sqrt(np.sum(xi[3:] ** 2)), np.array(solution[:3], float), float(solution[3])


def _at_any_point(answer: Any, xi: Array) -> Any:
    """A screw with the point of its axis nearest to the origin."""
    axis, point, pitch = answer
    u = xi[3:] / np.sqrt(np.sum(xi[3:] ** 2))
    return [axis, point - (u @ point) * u, pitch]


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
                "axis not normalised in v",
                "ω has the length 1, but the cross product of v has the axis as it was given: −ω × q takes the unit "
                "vector too.",
                {"-np.cross(w, point)": "-np.cross(axis, point)"},
            ),
            Slip(
                "point for velocity",
                "You put the point of the axis where v belongs. v is a velocity, −ω × q + hω.",
                {"-np.cross(w, point) + pitch * w": "point"},
            ),
            Slip(
                "point for moment",
                "You have q + hω: what belongs there is the velocity of the point at the origin, −ω × q + hω.",
                {"-np.cross(w, point)": "point"},
            ),
            Slip(
                "pitch without direction",
                "You add the number h to each part of v. The slide is along the axis: h times ω.",
                {" + pitch * w": " + pitch"},
            ),
            Slip(
                "lead for pitch",
                "You divide the pitch by 2π, as if it were metres for a whole turn. It is metres for each radian "
                "already.",
                {"pitch * w": "pitch * w / (2 * np.pi)"},
            ),
            Slip(
                "sign of the pitch",
                "Your slide runs against the axis: v = −ω × q + hω, with a plus.",
                {" + pitch * w": " - pitch * w"},
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
                "Your point has v × ω, and lies on the other side of the origin: it is ω × v / ‖ω‖².",
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
                "axis not normalised", "Your axis is ω itself: divide it by its length.", {"w / np.sqrt(square)": "w"}
            ),
            Slip(
                "axis reversed",
                "Your axis points against ω. By the right-hand rule a turn is about the direction of ω.",
                {"w / np.sqrt(square)": "-w / np.sqrt(square)"},
            ),
            Slip(
                "velocity for point",
                "Your point is v, which is a velocity. A point of the axis is ω × v / ‖ω‖².",
                {"np.cross(w, v) / square": "v"},
            ),
            Slip(
                "sign of the pitch",
                "Your pitch has the wrong sign: it is positive where v and ω point to the same side, ωᵀv / ‖ω‖².",
                {"float(w @ v / square)": "float(-(w @ v) / square)"},
            ),
            Slip(
                "all of v for the pitch",
                "You take the whole length of v for the slide. Only its part along ω is one: ωᵀv / ‖ω‖².",
                {"float(w @ v / square)": "float(np.linalg.norm(v) / np.sqrt(square))"},
            ),
            Slip(
                "lead for pitch",
                "You give the slide for a whole turn, the lead. The pitch is for each radian: leave out the 2π.",
                {"float(w @ v / square)": "float(2 * np.pi * (w @ v) / square)"},
            ),
        ),
        seen=_at_any_point,
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
                "You have v × ω for ω × v, or R − I for I − R: the formula is (I − R)(ω × v).",
                {"np.cross(w, v)": "np.cross(v, w)"},
            ),
            Slip(
                "degrees",
                DEGREES,
                {"    v, w = xi[:3], xi[3:]\n": "    v, w = xi[:3], xi[3:]\n    theta = np.radians(theta)\n"},
            ),
            Slip(
                "θ missing in the slide",
                "The slide along the axis does not grow with θ: the last term is ω ωᵀ v θ.",
                {"w * (w @ v) * theta": "w * (w @ v)"},
            ),
            Slip(
                "θ missing in the translation",
                "For ω = 0 your shift does not grow with θ: it is v θ.",
                {"g[:3, 3] = v * theta": "g[:3, 3] = v"},
            ),
            Slip(
                "θ missing in both shifts",
                "Neither v nor ω ωᵀ v is multiplied by θ: the translation is v θ, and the slide of a turn is ω ωᵀ v θ.",
                {"w * (w @ v) * theta": "w * (w @ v)", "g[:3, 3] = v * theta": "g[:3, 3] = v"},
            ),
            Slip(
                "slide as a number",
                "ωᵀ v θ is a number, and is added to each part of the shift. The slide is along the axis: ω (ωᵀ v) θ.",
                {"w * (w @ v) * theta": "(w @ v) * theta"},
            ),
            Slip(
                "θ outside",
                "You multiply the exponential by θ. θ belongs in the exponent: exp(ξ̂θ), not exp(ξ̂) θ.",
                {"    g = np.eye(4)\n": "    g = np.eye(4)\n    return expm(twist_matrix(xi)) * theta\n"},
            ),
            Slip(
                "θ forgotten",
                "Your matrix does not depend on θ: it is exp(ξ̂), the motion for θ = 1. Multiply ξ̂ by θ before you take "
                "the exponential.",
                {"    g = np.eye(4)\n": "    g = np.eye(4)\n    return expm(twist_matrix(xi))\n"},
            ),
            Slip(
                "first order",
                "I + ξ̂θ is the beginning of the series, and good for small θ only.",
                {"    g = np.eye(4)\n": "    g = np.eye(4)\n    return g + twist_matrix(xi) * theta\n"},
            ),
            Slip(
                "backwards",
                "Your motion is the inverse: it goes the other way. Where has a sign been lost, in ω̂ or before θ?",
                {"    v, w = xi[:3], xi[3:]\n": "    v, w = xi[:3], xi[3:]\n    theta = -theta\n"},
            ),
            Slip(
                "number by number",
                "You take the exponential of each number by itself. That of a matrix is another function, "
                "{expm}, or Rodrigues' formula.",
                {
                    "    g = np.eye(4)\n": "    g = np.zeros((4, 4))\n    g[:3, :3] = np.cross(w, np.eye(3)).T\n"
                    "    g[:3, 3] = v\n    return np.exp(g * theta)\n"
                },
            ),
        ),
    ),
    Exercise(
        pose_log,
        independent.pose_log,
        _displacements,
        (
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"np.linalg.solve(G, p) * theta, w]": "w, np.linalg.solve(G, p) * theta]"},
            ),
            Slip(
                "p for v",
                "Your v is p. It is so where the body does not turn. Else p is G v, with G from the upper right "
                "corner of exp(ξ̂θ): solve for v.",
                {"np.linalg.solve(G, p) * theta": "p"},
            ),
            Slip(
                "multiplied by G",
                "You multiply p by G. It is G v that is p: solve for v, np.linalg.solve(G, p).",
                {"np.linalg.solve(G, p) * theta": "G @ p * theta"},
            ),
            Slip(
                "v not multiplied by the angle",
                "ω has the length of the angle, but v is that of a unit ω. The answer is ξθ, so multiply v by θ too.",
                {"np.linalg.solve(G, p) * theta": "np.linalg.solve(G, p)"},
            ),
            Slip(
                "without the angle",
                "You return ξ with ‖ω‖ = 1. The answer is ξθ, whose exponential is g: multiply both halves by θ.",
                {"np.linalg.solve(G, p) * theta, w]": "np.linalg.solve(G, p), u]"},
            ),
            Slip(
                "θ missing in G",
                "In G the term ω ωᵀ is multiplied by θ: the slide grows with the angle.",
                {"np.outer(u, u) * theta": "np.outer(u, u)"},
            ),
            Slip(
                "ω not of length one in G",
                "G has the unit vector along the axis. You have put ω in, whose length is the angle.",
                {"u = w / theta": "u = w"},
            ),
            Slip(
                "pure translation forgotten",
                "Where R = I there is no axis to divide by: the twist is (p, 0).",
                {"if theta < 1e-9:": "if False:"},
            ),
            Slip(
                "backwards",
                "This is the logarithm of the inverse: both halves have the wrong sign.",
                {"    R, p = g[:3, :3], g[:3, 3]\n": "    g = np.linalg.inv(g)\n    R, p = g[:3, :3], g[:3, 3]\n"},
            ),
            Slip(
                "number by number",
                "np.log takes the logarithm of each number by itself. The logarithm of the matrix is "
                "scipy.linalg.logm, or the formula of the lesson.",
                {
                    "    R, p = g[:3, :3], g[:3, 3]\n": "    X = np.log(g)\n    return np.array([*X[:3, 3], "
                    "X[2, 1], X[0, 2], X[1, 0]])\n    R, p = g[:3, :3], g[:3, 3]\n"
                },
            ),
        ),
    ),
)
