"""Exercises on the six joint types."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import crossing
from .instances import TIMES, own_chain, unit
from .words import ANGULAR_FIRST


def joint_twist(kind: str, axis: Array, point: Array, pitch: float) -> Array:
    """The twist (v, ω), (6,), of a joint with the unit vector `axis` (3,).

    `kind` is "revolute" (a turn about the line through `point` (3,)), "prismatic" (a slide along the axis) or
    "helical". A helical joint turns and slides by `pitch` metres for each radian.
    """
    if kind == "prismatic":
        return np.concatenate([axis, np.zeros(3)])
    v = -np.cross(axis, point)
    if kind == "helical":
        v = v + pitch * axis
    return np.concatenate([v, axis])


def ball_joint(point: Array) -> Array:
    """The twists (6, 3) of a ball joint centred at `point` (3,).

    The columns are turns about the z, y and x axes of the space frame, in this order.
    """
    return np.column_stack([np.concatenate([-np.cross(w, point), w]) for w in np.eye(3)[::-1]])


def degrees_of_freedom(twists: Array) -> int:
    """The number of independent motions that joints allow.

    It is the number of linearly independent columns of `twists` (6, m). Numbers below 1e-9 are rounding.
    """
    return int(np.linalg.matrix_rank(twists, tol=1e-9))


def _kinds(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for kind in ("revolute", "prismatic", "helical") * 3:
        yield kind, unit(rng), rng.normal(size=3), float(rng.uniform(0.05, 0.4))


def _centres(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rng.normal(size=3),) for _ in range(TIMES))


def _stacks(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    """Joints with a redundant turn, slide or copy, and the joints of the arm."""
    w, q = unit(rng), rng.normal(size=3)
    turns = [np.concatenate([-np.cross(axis, q), axis]) for axis in (*np.eye(3), unit(rng))]
    slides = [np.concatenate([np.cross(w, axis), np.zeros(3)]) for axis in (unit(rng), unit(rng), unit(rng))]
    about_w = np.concatenate([-np.cross(w, q), w])
    yield (np.column_stack(turns),)
    yield (np.column_stack([*slides, about_w]),)
    yield (np.column_stack([about_w, 2.0 * about_w]),)
    yield (np.column_stack([about_w, np.concatenate([w, np.zeros(3)])]),)
    yield (rng.normal(size=(6, 7)),)
    yield (rng.normal(size=(6, 5)),)
    screws = own_chain(rng, arm)[0]
    values = np.linalg.svd(screws, compute_uv=False)
    if not np.any((values > 1e-12) & (values < 1e-4)):  # where rounding of a description decides, no answer is right
        yield (screws,)


def _by_velocities(kind: str, axis: Array, point: Array, pitch: float) -> Array:
    """v is what the point of the body at the origin does."""
    if kind == "prismatic":
        return np.array([*axis, 0.0, 0.0, 0.0])
    slide = pitch if kind == "helical" else 0.0
    return np.array([*(crossing(point) @ axis + slide * axis), *axis])


def _ball(point: Array) -> Array:
    x, y, z = point
    return np.array([[y, -z, 0.0], [-x, 0.0, z], [0.0, x, -y], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def _rank(screws: Array) -> int:
    return int((np.linalg.eigvalsh(screws @ screws.T) > 1e-12).sum())


EXERCISES = (
    Exercise(
        joint_twist,
        _by_velocities,
        _kinds,
        (
            Slip(
                "slide that turns",
                "Your prismatic joint has ω = axis: a slide does not turn. Its twist is (axis, 0).",
                {"[axis, np.zeros(3)]": "[axis, axis]"},
            ),
            Slip(
                "slide about a point",
                "Your prismatic joint is (0, axis): that is a turn, about an axis through the origin. A slide is "
                "(axis, 0).",
                {"[axis, np.zeros(3)]": "[np.zeros(3), axis]"},
            ),
            Slip(
                "slide with a moment",
                "Your prismatic joint has −ω × q in its v. A slide moves every point alike: (axis, 0), for every "
                "position of the joint.",
                {"[axis, np.zeros(3)]": "[axis - np.cross(axis, point), np.zeros(3)]"},
            ),
            Slip(
                "slide as a turn",
                "Your prismatic joint turns about the axis, as the revolute one does. A slide is (axis, 0).",
                {'if kind == "prismatic":': "if False:"},
            ),
            Slip(
                "sign of the moment",
                "Your v has +ω × q: a turn moves the point of the body at the origin with −ω × q.",
                {"v = -np.cross(axis, point)": "v = np.cross(axis, point)"},
            ),
            Slip(
                "pitch forgotten",
                "Your helical joint does not slide: add pitch · axis to v.",
                {"v = v + pitch * axis": "v = v + 0.0 * axis"},
            ),
            Slip(
                "pitch for all",
                "The pitch is added to revolute joints too: they have none, for any `pitch`.",
                {'if kind == "helical":': "if True:"},
            ),
            Slip(
                "pitch inverted",
                "You divide by the pitch; it is metres for each radian, so v gets pitch · axis.",
                {"pitch * axis": "axis / pitch"},
            ),
            Slip(
                "lead for pitch",
                "You divide the pitch by 2π, as if it were metres for a whole turn. It is metres for each radian "
                "already.",
                {"pitch * axis": "pitch * axis / (2 * np.pi)"},
            ),
            Slip(
                "pitch without direction",
                "You add the number `pitch` to each part of v. The slide is along the axis: pitch · axis.",
                {"pitch * axis": "pitch"},
            ),
            Slip(
                "pitch in ω",
                "Your helical joint has pitch · axis for ω. It turns as a revolute one does, ω = axis; the pitch "
                "belongs to v.",
                {"[v, axis]": '[v, pitch * axis if kind == "helical" else axis]'},
            ),
            Slip(
                "angular first", ANGULAR_FIRST, {"[axis, np.zeros(3)]": "[np.zeros(3), axis]", "[v, axis]": "[axis, v]"}
            ),
            Slip(
                "through the origin",
                "Your turns go through the origin: the point of the axis is not used. v = −ω × q.",
                {"v = -np.cross(axis, point)": "v = np.zeros(3)"},
            ),
        ),
    ),
    Exercise(
        ball_joint,
        _ball,
        _centres,
        (
            Slip(
                "order of the columns",
                "Your columns are the turns about x, y and z. The order is z, y and x, as in URDF's yaw, pitch, roll.",
                {"np.eye(3)[::-1]": "np.eye(3)"},
            ),
            Slip(
                "rows for columns",
                "Your twists are rows. The task asks for columns, (6, 3): transpose.",
                {"np.column_stack": "np.array"},
            ),
            Slip(
                "through the origin",
                "Your turns go through the origin: v = −ω × q for each.",
                {"-np.cross(w, point)": "np.zeros(3)"},
            ),
            Slip(
                "sign of the moment",
                "Your v has +ω × q: it is −ω × q for each of the turns.",
                {"-np.cross(w, point)": "np.cross(w, point)"},
            ),
            Slip("angular first", ANGULAR_FIRST, {"[-np.cross(w, point), w]": "[w, -np.cross(w, point)]"}),
            Slip(
                "point for velocity",
                "You put the centre where v belongs. v is a velocity, −ω × q for each of the turns.",
                {"-np.cross(w, point)": "point"},
            ),
        ),
    ),
    Exercise(
        degrees_of_freedom,
        _rank,
        _stacks,
        (
            Slip(
                "joints counted",
                "You count the joints. Four turns about one point move a body in three ways: count the "
                "columns that are independent, the rank.",
                {"int(np.linalg.matrix_rank(twists, tol=1e-9))": "twists.shape[1]"},
            ),
            Slip(
                "six at most",
                "You take the smaller of six and the number of joints: joints that repeat others then count too. Take "
                "the rank.",
                {"int(np.linalg.matrix_rank(twists, tol=1e-9))": "min(twists.shape)"},
            ),
            Slip(
                "turns alone",
                "You look at ω alone: slides move a body too. Take the rank of all six rows.",
                {"matrix_rank(twists,": "matrix_rank(twists[3:],"},
            ),
            Slip(
                "velocities alone",
                "You look at v alone: take the rank of all six rows.",
                {"matrix_rank(twists,": "matrix_rank(twists[:3],"},
            ),
            Slip(
                "halves added",
                "You add the ranks of v and of ω: a turn about a distant axis counts twice then. Take the rank of all "
                "six rows at once.",
                {
                    "int(np.linalg.matrix_rank(twists, tol=1e-9))": "int(np.linalg.matrix_rank(twists[:3], tol=1e-9) + "
                    "np.linalg.matrix_rank(twists[3:], tol=1e-9))"
                },
            ),
            Slip(
                "what is missing",
                "You count the directions that are missing, 6 less the rank. The answer is the rank itself.",
                {"int(np.linalg.matrix_rank(twists, tol=1e-9))": "6 - int(np.linalg.matrix_rank(twists, tol=1e-9))"},
            ),
        ),
    ),
)
