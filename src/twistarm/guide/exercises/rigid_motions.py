"""Exercises on rigid motions: homogeneous matrices, their inverse, points carried from frame to frame."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from .exercise import Exercise, Slip
from .independent import tool
from .instances import TIMES, own_chain, pose, rotation


def homogeneous(R: Array, p: Array) -> Array:
    """The pose (4, 4) of a frame with rotation `R` (3, 3) and origin `p` (3,): [R, p; 0, 1]."""
    g = np.eye(4)
    g[:3, :3] = R
    g[:3, 3] = p
    return g


def inverse_pose(g: Array) -> Array:
    """The inverse (4, 4) of a pose `g` (4, 4). The formula with Rᵀ takes no elimination; np.linalg.inv is right too."""
    R, p = g[:3, :3], g[:3, 3]
    back = np.eye(4)
    back[:3, :3] = R.T
    back[:3, 3] = -R.T @ p
    return back


def transform_points(g_st: Array, points_t: Array) -> Array:
    """The coordinates (N, 3) in frame S of N points.

    `points_t` (N, 3) has their coordinates in frame T, a point in each row.
    """
    R, p = g_st[:3, :3], g_st[:3, 3]
    points_s: Array = points_t @ R.T + p
    return points_s


def tool_point(g_st: Array, g_tc: Array, q_c: Array) -> Array:
    """The coordinates (3,) of a point seen from the base S.

    The tool T is at `g_st`, and a camera C is mounted on it at `g_tc`. The camera sees the point at `q_c` (3,).
    """
    q_s: Array = (g_st @ g_tc @ np.append(q_c, 1.0))[:3]
    return q_s


def _parts(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((rotation(rng), rng.normal(size=3)) for _ in range(TIMES))


def _poses(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng),) for _ in range(TIMES))


def _points(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    yield from ((pose(rng), rng.normal(size=(int(rng.integers(1, 6)), 3))) for _ in range(TIMES))
    yield pose(rng), rng.normal(size=(3, 3))


def _on_the_tool(rng: np.random.Generator, arm: Arm) -> Iterator[tuple[Any, ...]]:
    for _ in range(3):
        yield tool(*own_chain(rng, arm)), pose(rng), rng.normal(size=3)
    yield from ((pose(rng), pose(rng), rng.normal(size=3)) for _ in range(TIMES))


EXERCISES = (
    Exercise(
        homogeneous,
        lambda R, p: np.block([[R, p[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]]),
        _parts,
        (
            Slip(
                "rotation transposed",
                "The rotation is transposed in your pose. Use it without the transpose.",
                {"= R\n": "= R.T\n"},
            ),
            Slip(
                "origin in the last row",
                "The origin stands in the last row, as in graphics libraries that multiply rows from the "
                "left. Here points are columns: p is the last column, the last row 0 0 0 1.",
                {"g[:3, 3] = p": "g[3, :3] = p"},
            ),
            Slip(
                "origin negated",
                "The origin of the frame is p itself; yours is −p. The minus belongs to the inverse.",
                {"g[:3, 3] = p": "g[:3, 3] = -p"},
            ),
            Slip(
                "origin turned",
                "The last column is R p in yours. The origin p is already seen from S: put it there unchanged.",
                {"g[:3, 3] = p": "g[:3, 3] = R @ p"},
            ),
            Slip(
                "no 1 in the corner",
                "The last row is 0 0 0 1: without the 1 in the corner no translation survives a product.",
                {"g = np.eye(4)": "g = np.zeros((4, 4))"},
            ),
        ),
    ),
    Exercise(
        inverse_pose,
        np.linalg.inv,
        _poses,
        (
            Slip(
                "only transposed",
                "The whole matrix is transposed: that puts the origin into the last row. Only the "
                "rotation is transposed, and the origin becomes −Rᵀp.",
                {"return back": "return g.T"},
            ),
            Slip(
                "origin not turned",
                "The origin is −p in yours; seen from the moved frame it is −Rᵀp.",
                {"-R.T @ p": "-p"},
            ),
            Slip(
                "rotation kept",
                "The rotation is not transposed: the inverse turns back.",
                {"back[:3, :3] = R.T": "back[:3, :3] = R"},
            ),
            Slip(
                "origin turned forth",
                "The origin is −R p in yours: it is turned back too, −Rᵀp.",
                {"-R.T @ p": "-R @ p"},
            ),
            Slip("no minus", "The minus of −Rᵀp is missing: the way back is the other way.", {"-R.T @ p": "R.T @ p"}),
            Slip(
                "origin kept",
                "The origin is still p: only the rotation is inverted. It becomes −Rᵀp.",
                {"-R.T @ p": "p"},
            ),
        ),
    ),
    Exercise(
        transform_points,
        lambda g, points: np.array([(g @ np.append(point, 1.0))[:3] for point in points]),
        _points,
        (
            Slip(
                "rows times R",
                "You multiply the rows by R from the right: each point is turned by Rᵀ. A row is turned by "
                "`points_t {matmul} R{transpose}`.",
                {"points_t @ R.T": "points_t @ R"},
            ),
            Slip(
                "rows as if they were columns",
                "R {matmul} points_t takes each column of points_t for a point, which for three points gives wrong "
                "numbers and for other numbers of them an error. The points are rows: "
                "`points_t {matmul} R{transpose}`.",
                {"points_t @ R.T + p": "R @ points_t + p"},
            ),
            Slip("origin forgotten", "The points are turned but not moved: add the origin p of frame T.", {" + p": ""}),
            Slip(
                "moved before turned",
                "The origin is added before the rotation: p is seen from S already, so turn first, then add.",
                {"points_t @ R.T + p": "(points_t + p) @ R.T"},
            ),
            Slip(
                "inverse",
                "You carry the points from S to T: that is the inverse. g_st takes coordinates of T to S.",
                {"points_t @ R.T + p": "(points_t - p) @ R"},
            ),
            Slip(
                "a column each",
                "Your points are columns, (3, N). The task asks for rows, (N, 3): transpose at the end.",
                {"return points_s": "return points_s.T"},
            ),
            Slip(
                "homogeneous left",
                "The 1 of the homogeneous coordinates is still there: leave out the last column.",
                {"return points_s": "return np.column_stack([points_s, np.ones(len(points_s))])"},
            ),
        ),
    ),
    Exercise(
        tool_point,
        lambda g_st, g_tc, q_c: g_st[:3, :3] @ (g_tc[:3, :3] @ q_c + g_tc[:3, 3]) + g_st[:3, 3],
        _on_the_tool,
        (
            Slip(
                "right for left",
                "You multiply g_tc g_st: what is mounted on the tool is multiplied from the right, g_st "
                "g_tc, so that the letters meet.",
                {"g_st @ g_tc": "g_tc @ g_st"},
            ),
            Slip(
                "direction for point",
                "The homogeneous coordinate is 0: that carries directions, which no translation moves. A point has 1.",
                {"np.append(q_c, 1.0)": "np.append(q_c, 0.0)"},
            ),
            Slip(
                "camera's origin not turned",
                "The two origins are added as they are. That of the camera is seen from the tool, so g_st turns it "
                "too: R_st (R_tc q_c + p_tc) + p_st.",
                {
                    "(g_st @ g_tc @ np.append(q_c, 1.0))[:3]": "g_st[:3, :3] @ g_tc[:3, :3] @ q_c + g_tc[:3, 3] + "
                    "g_st[:3, 3]"
                },
            ),
            Slip(
                "tool inverted",
                "You use the inverse of g_st, which takes coordinates of the base to the tool. The point is to be "
                "seen from the base: g_st itself.",
                {"g_st @ g_tc": "np.linalg.inv(g_st) @ g_tc"},
            ),
            Slip(
                "camera forgotten",
                "The point is taken as one of the tool's frame: the camera's own pose g_tc is missing.",
                {"g_st @ g_tc": "g_st"},
            ),
            Slip(
                "camera inverted",
                "You use the inverse of g_tc, which takes coordinates of the tool to the camera. The "
                "point comes from the camera: g_tc itself.",
                {"g_st @ g_tc": "g_st @ np.linalg.inv(g_tc)"},
            ),
            Slip(
                "all inverted",
                "You use the inverse of g_st g_tc, which takes coordinates of the base to the camera.",
                {"(g_st @ g_tc @": "(np.linalg.inv(g_st @ g_tc) @"},
            ),
            Slip(
                "tool forgotten",
                "The point is seen from the tool: g_st, which takes it to the base, is missing.",
                {"g_st @ g_tc": "g_tc"},
            ),
        ),
    ),
)
