"""Exercises on forward kinematics: the chain of frames and the product of exponentials."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...model.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import conjugated, inverted, tool
from .instances import TIMES, chain, chains, own_chain, pose
from .words import ADJOINT_TRANSPOSED, ANGULAR_FIRST, DEGREES, NO_CROSS_TERM, NO_HOME


def chain_of_frames(frames: Array) -> Array:
    """The pose (4, 4) of the last frame seen from the first. `frames` (k, 4, 4) has the pose of each frame seen from
    the one before it: g_01, g_12, …
    """
    g = np.eye(4)
    for step in frames:
        g = g @ step
    return g


def product_of_exponentials(screws: Array, home: Array, x: Array) -> Array:
    """The pose of the tool (4, 4), g_st = e^{ξ̂₁x₁} ⋯ e^{ξ̂ₘxₘ} g_st(0).

    `screws` (6, m) has a joint's twist (v, ω) in each column, seen from the base where all joints are at 0; `home` (4,
    4) is the tool there; `x` (m,) are the joints' values [rad, m]. Use your `twist_exp`, or `screws.exp` of twistarm.
    """
    from twistarm.theory.screws import exp

    g = np.eye(4)
    for i in range(len(x)):
        g = g @ exp(screws[:, i], x[i])
    return g @ home


def body_screws(screws: Array, home: Array) -> Array:
    """The same joints' twists seen from the tool at rest: (6, m), B_i = Ad(g_st(0)⁻¹) ξ_i.

    Use your `adjoint`, or that of twistarm.screws.
    """
    from twistarm.theory.screws import adjoint

    B: Array = adjoint(np.linalg.inv(home)) @ screws
    return B


def body_product(body_screws: Array, home: Array, x: Array) -> Array:
    """The pose of the tool (4, 4) from twists seen from the tool at rest, `body_screws` (6, m):
    g_st = g_st(0) e^{B̂₁x₁} ⋯ e^{B̂ₘxₘ}.
    """
    from twistarm.theory.screws import exp

    g = home
    for i in range(len(x)):
        g = g @ exp(body_screws[:, i], x[i])
    return g


def _frames(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((np.array([pose(rng) for _ in range(int(rng.integers(2, 6)))]),) for _ in range(TIMES))


def _at_rest(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from (chain(rng)[:2] for _ in range(TIMES))
    yield own_chain(rng, arm)[:2]


def _in_body(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for screws, home, x in chains(rng, arm):
        yield _body_screws(screws, home), home, x


def _body_screws(screws: Array, home: Array) -> Array:
    back = inverted(home)
    return np.column_stack([conjugated(back, xi) for xi in screws.T])


def _from_body(body: Array, home: Array, x: Array) -> Array:
    """Through the space form: what two forms must agree on."""
    return tool(np.column_stack([conjugated(home, xi) for xi in body.T]), home, x)


EXERCISES = (
    Exercise(
        chain_of_frames,
        lambda frames: np.linalg.multi_dot(list(frames)),
        _frames,
        (
            Slip(
                "order reversed",
                "Your frames are multiplied in the reverse order: g_01 g_12 …, each new frame from the right.",
                {"g @ step": "step @ g"},
            ),
            Slip(
                "inverse",
                "You return the pose of the first frame seen from the last: the inverse of what is asked for.",
                {"return g": "return np.linalg.inv(g)"},
            ),
            Slip(
                "last forgotten",
                "The last frame is missing: the loop ends one too early.",
                {"in frames:": "in frames[:-1]:"},
            ),
            Slip(
                "first forgotten",
                "The first frame is missing: begin the loop at 0 (Python counts from 0).",
                {"in frames:": "in frames[1:]:"},
            ),
            Slip(
                "number by number",
                "You multiply number by number (`*`): poses are multiplied with @.",
                {"    g = np.eye(4)\n": "    g = np.ones((4, 4))\n", "g @ step": "g * step"},
            ),
            Slip(
                "parts added",
                "You multiply the rotations but only add the origins: each step lies along the axes of "
                "the frame before, R p. Multiply the whole poses.",
                {
                    "        g = g @ step\n": "        turned = g[:3, :3] @ step[:3, :3]\n        moved = g[:3, "
                    "3] + step[:3, 3]\n        g = np.eye(4)\n        g[:3, :3], g[:3, "
                    "3] = turned, moved\n"
                },
            ),
        ),
    ),
    Exercise(
        product_of_exponentials,
        tool,
        chains,
        (
            Slip("home forgotten", NO_HOME, {"g @ home": "g"}),
            Slip(
                "home on the left",
                "You multiply by the home pose first: that is right for body twists. With twists seen "
                "from the base the home pose stands at the end, on the right.",
                {"return g @ home": "return home @ g"},
            ),
            Slip(
                "order reversed",
                "The joints are multiplied from tip to base: base first, e^{ξ̂₁x₁} stands on the left, "
                "for the first joint moves all the others.",
                {"g = g @ exp(screws[:, i], x[i])": "g = exp(screws[:, i], x[i]) @ g"},
            ),
            Slip(
                "degrees",
                DEGREES,
                {"x[i])": "np.radians(x[i]))"},
            ),
            Slip(
                "angular first",
                ANGULAR_FIRST,
                {"exp(screws[:, i]": "exp(np.roll(screws[:, i], 3)"},
            ),
            Slip(
                "one exponential",
                "You add the twists and take one exponential. e^A e^B is e^{A+B} only for joints that "
                "commute: multiply one exponential for each joint.",
                {"    for i in range(len(x)):\n        g = g @ exp(screws[:, i], x[i])\n": "    g = exp(screws @ x)\n"},
            ),
            Slip(
                "last joint forgotten",
                "The last joint is missing: range(len(x)) goes over all of them.",
                {"range(len(x))": "range(len(x) - 1)"},
            ),
        ),
    ),
    Exercise(
        body_screws,
        _body_screws,
        _at_rest,
        (
            Slip(
                "not inverted",
                "You use Ad(g_st(0)), which takes twists from the tool to the base. To see them from the "
                "tool it is the Adjoint of the inverse.",
                {"np.linalg.inv(home)": "home"},
            ),
            Slip("transposed", ADJOINT_TRANSPOSED, {"adjoint(np.linalg.inv(home))": "adjoint(np.linalg.inv(home)).T"}),
            Slip(
                "transposed for inverse",
                "The transpose of an Adjoint is not its inverse (as it is for a rotation): Ad(g)⁻¹ = Ad(g⁻¹).",
                {"adjoint(np.linalg.inv(home))": "adjoint(home).T"},
            ),
            Slip(
                "no p̂R",
                NO_CROSS_TERM,
                {"adjoint(np.linalg.inv(home))": "np.kron(np.eye(2), home[:3, :3].T)"},
            ),
            Slip(
                "unchanged",
                "The twists come back as they were, seen from the base: carry them by Ad(g_st(0)⁻¹).",
                {"adjoint(np.linalg.inv(home)) @ screws": "screws"},
            ),
        ),
    ),
    Exercise(
        body_product,
        _from_body,
        _in_body,
        (
            Slip(
                "home on the right",
                "The home pose stands on the right in yours: that is right for twists seen from the "
                "base. With body twists it comes first.",
                {"    g = home\n": "    g = np.eye(4)\n", "return g": "return g @ home"},
            ),
            Slip(
                "home forgotten",
                NO_HOME.replace("at the end", "first, from the left"),
                {"    g = home\n": "    g = np.eye(4)\n"},
            ),
            Slip(
                "order reversed",
                "The joints are multiplied in the reverse order. Here too it is base to tip, B₁ next to the home pose.",
                {"range(len(x))": "reversed(range(len(x)))"},
            ),
            Slip("degrees", DEGREES, {"x[i])": "np.radians(x[i]))"}),
            Slip("angular first", ANGULAR_FIRST, {"exp(body_screws[:, i]": "exp(np.roll(body_screws[:, i], 3)"}),
        ),
    ),
)
