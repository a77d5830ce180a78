"""Exercises on forward kinematics: the chain of frames and the product of exponentials."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import conjugated, inverted, tool
from .instances import TIMES, chain, chains, own_chain, pose
from .words import ADJOINT_TRANSPOSED, ANGULAR_FIRST, DEGREES, NO_CROSS_TERM, NO_HOME


def chain_of_frames(frames: Array) -> Array:
    """The pose (4, 4) of the last frame in the first.

    `frames` (k, 4, 4) has the pose of each frame in the one before it: g_01, g_12, …
    """
    g = np.eye(4)
    for step in frames:
        g = g @ step
    return g


def product_of_exponentials(twists: Array, home: Array, x: Array) -> Array:
    """The pose of the tool (4, 4), g_st = exp(ξ̂₁x₁) ⋯ exp(ξ̂ₘxₘ) g_st(0).

    `twists` (6, m) has the twist (v, ω) of each joint in a column. They are in base coordinates, at the home
    configuration. `home` (4, 4) is the tool's pose there, g_st(0). `x` (m,) are the joint values [rad, m]. Use your
    `twist_exp`, or `screws.exp` after `from twistarm import screws`.
    """
    from twistarm import screws

    g = np.eye(4)
    for i in range(len(x)):
        g = g @ screws.exp(twists[:, i], x[i])
    return g @ home


def body_screws(twists: Array, home: Array) -> Array:
    """The twists of the same joints (6, m), seen from the tool in the home configuration: ξᵢᵇ = Ad(g_st(0)⁻¹) ξᵢ.

    Use your `adjoint`, or `screws.adjoint` after `from twistarm import screws`.
    """
    from twistarm import screws

    B: Array = screws.adjoint(np.linalg.inv(home)) @ twists
    return B


def body_product(body_twists: Array, home: Array, x: Array) -> Array:
    """The pose of the tool (4, 4) from its body twists: g_st = g_st(0) exp(ξ̂₁ᵇx₁) ⋯ exp(ξ̂ₘᵇxₘ).

    The columns of `body_twists` (6, m) are the twists ξᵢᵇ seen from the tool in the home configuration. Use
    `screws.exp` after `from twistarm import screws`.
    """
    from twistarm import screws

    g = home
    for i in range(len(x)):
        g = g @ screws.exp(body_twists[:, i], x[i])
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
                "You multiply number by number ({times}): poses are multiplied with {matmul}.",
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
                "The joints are multiplied from tip to base: base first, exp(ξ̂₁x₁) stands on the left, "
                "for the first joint moves all the others.",
                {"g = g @ screws.exp(twists[:, i], x[i])": "g = screws.exp(twists[:, i], x[i]) @ g"},
            ),
            Slip("degrees", DEGREES, {"x[i])": "np.radians(x[i]))"}),
            Slip("angular first", ANGULAR_FIRST, {"exp(twists[:, i]": "exp(np.roll(twists[:, i], 3)"}),
            Slip(
                "one exponential",
                "You add the twists and take one exponential. exp(A) exp(B) is exp(A + B) only for joints that "
                "commute: multiply one exponential for each joint.",
                {
                    "    for i in range(len(x)):\n        g = g @ screws.exp(twists[:, i], x[i])\n": "    g = "
                    "screws.exp(twists @ x)\n"
                },
            ),
            Slip(
                "last joint forgotten",
                "The last joint is missing: the loop ends one too early.",
                {"range(len(x))": "range(len(x) - 1)"},
            ),
            Slip(
                "first joint forgotten",
                "The first joint is missing: the loop begins one too late.",
                {"range(len(x))": "range(1, len(x))"},
            ),
            Slip(
                "axes carried along",
                "You carry each twist to where the joints before it have brought the axis, and then multiply in the "
                "order base to tip. The product of exponentials takes the twists of the home configuration.",
                {"exp(twists[:, i]": "exp(screws.adjoint(g) @ twists[:, i]"},
            ),
            Slip(
                "axes of the moment",
                "You multiply the exponentials of the axes as they are now, moved by all joints before them. The "
                "product of exponentials takes the twists of the home configuration.",
                {
                    "    g = np.eye(4)\n": "    from twistarm import poe\n    twists = "
                    "poe.spatial_jacobian(twists, x)\n    g = np.eye(4)\n"
                },
            ),
            Slip(
                "home inverted",
                "You multiply by the inverse of the home pose: it is `home` itself, the tool seen from the base.",
                {"g @ home": "g @ np.linalg.inv(home)"},
            ),
            Slip("values negated", "Your joints turn the other way: exp(ξ̂ᵢxᵢ), without a minus.", {"x[i])": "-x[i])"}),
            Slip(
                "base seen from the tool",
                "You return the inverse: the pose of the base seen from the tool, g_ts.",
                {"return g @ home": "return np.linalg.inv(g @ home)"},
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
            Slip("no p̂R", NO_CROSS_TERM, {"screws.adjoint(np.linalg.inv(home))": "np.kron(np.eye(2), home[:3, :3].T)"}),
            Slip(
                "unchanged",
                "The twists come back as they were, seen from the base: carry them by Ad(g_st(0)⁻¹).",
                {"screws.adjoint(np.linalg.inv(home)) @ twists": "twists"},
            ),
            Slip(
                "ω not turned",
                "Your v is right, but ω is as it was, in the axes of the base: in those of the tool it is Rᵀω.",
                {"    return B\n": "    B[3:] = twists[3:]\n    return B\n"},
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
                "Your answer is the product with the home pose on the right, as for twists seen from the base. With "
                "body twists it comes first, and the twists are taken as they are given.",
                {"    g = home\n": "    g = np.eye(4)\n", "return g": "return g @ home"},
            ),
            Slip(
                "home forgotten",
                NO_HOME.replace("at the end", "first, from the left"),
                {"    g = home\n": "    g = np.eye(4)\n"},
            ),
            Slip(
                "order reversed",
                "The joints are multiplied in the reverse order. Here too it is base to tip, the first joint next to "
                "the home pose.",
                {"range(len(x))": "reversed(range(len(x)))"},
            ),
            Slip("degrees", DEGREES, {"x[i])": "np.radians(x[i]))"}),
            Slip("angular first", ANGULAR_FIRST, {"exp(body_twists[:, i]": "exp(np.roll(body_twists[:, i], 3)"}),
        ),
    ),
)
