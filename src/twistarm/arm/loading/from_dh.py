"""Arms from tables of Denavit–Hartenberg parameters, and the table of an arm."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...description.bounds import LIMIT_NAMES
from ...description.companions.arm_file import ArmSpecification
from ...description.dh import (
    BASE,
    COLUMNS,
    CONVENTIONS,
    FIXED,
    PARAMETERS,
    TOOL,
    UNDECIDED,
    DhTable,
    dh_urdf,
    rows_of_csv,
    table_of_rows,
)
from ...limits.joint_limits import JointLimits
from ...support.checks import Array, as_number, pose_of, require_choice
from ...support.csv_lines import csv_text
from ...support.errors import InputError, quote
from ...support.messages import Argument, Text
from ...theory.joints import plane_axes
from ...theory.lines import nearest_on_line
from ...theory.rotations import to_euler
from ...theory.screws import inverse, to_screw
from ..arm import Arm, require_arm
from .arm_builder import UNIT, ArmBuilder, arm_of_urdf

# Axes at a smaller angle [rad] count as parallel. The foot of their common normal is beyond double precision.
PARALLEL = 1e-7
MOST_PARALLEL = 0.1  # rad. A table whose axes may be farther apart is another arm's.
EXACT = 1e-14  # A smaller number of a row is rounding.

OF_COUPLED = Text(
    "Use arm.screws and arm.coupling, which `twistarm bake` writes. For a table of the other joints, lock those that "
    "lead others by {locked}",
    locked=Argument("locked_joints", None),
)
"""What to do instead of a table."""

SAMPLES = 20  # Random configurations at which a table is compared with its arm.


def arm_from_dh(
    table: ArrayLike | DhTable | str | os.PathLike[str],
    convention: str | None = None,
    *,
    joints: Sequence[str] | None = None,
    types: Sequence[str] | None = None,
    base: ArrayLike | None = None,
    tool: ArrayLike | None = None,
    limits: JointLimits | Mapping[str, Any] | None = None,
    name: str = "arm",
) -> Arm:
    """An arm from rows of a [m], α [rad], d [m] and θ [rad], by the convention of `DhTable`.

    The joint's coordinate is added to θ, which is its fixed offset, or to d for a prismatic joint.

    Args:
        table: Rows (n, 4), a `DhTable`, or the path of a CSV file. Its first line names columns out of joint, type,
            convention, a, alpha, d, theta, lower, upper, velocity, effort, with units as in `a [mm]`; else they are
            SI. Rows of type fixed belong to base and tool.
        convention: "standard" or "modified". A `DhTable` has its own, and a file may have.
        joints: The n joint names; by default joint1, joint2 and so on.
        types: "revolute" or "prismatic" for each joint; by default revolute.
        base: Frame 0 seen from the base (4, 4); by default the identity.
        tool: The tool seen from frame n (4, 4); by default the identity.
        limits: Limits as in `load_arm`; by default those of the file, else unbounded.
        name: The arm's name.

    Returns:
        The `Arm`, with a description and a Pinocchio model, from the link `base` to the link `tool`.

    Raises:
        InputError: A wrong shape, name, type, convention or pose, or a file that is no table.
        DescriptionError: Limits of the table leave a joint no room.
    """
    made: Any = table
    if isinstance(table, (str, os.PathLike)):
        made = table_of_rows(rows_of_csv(table), convention)
    elif not isinstance(table, DhTable):
        if convention is None:
            raise InputError(UNDECIDED)
        made = DhTable(made, convention)
    elif convention not in (None, table.convention):
        raise InputError(f"the table is {table.convention}; got convention={quote(convention)}")
    given = {"joints": joints, "types": types, "base": base, "tool": tool}
    made = replace(made, **{key: value for key, value in given.items() if value is not None})
    ArmBuilder(name)  # which checks the name
    specification = ArmSpecification(Path(name), "DH table", base=BASE, tip=TOOL)
    return arm_of_urdf(dh_urdf(made, name), specification, limits)


def to_dh(arm: Arm, convention: str = "standard", parallel: float = PARALLEL) -> DhTable:
    """The Denavit–Hartenberg table of an arm, with poses of base and tool before and behind it.

    Each frame lies on the common normal of two successive axes, the last of them the tool's z axis. Of parallel axes
    the normal goes through the frame before. a is never negative. Axes within `parallel` count as parallel, and
    `residual` [m, rad] is the difference of the table from the arm. Source: Craig, §3.4; Paul, §2.8.

    The common normal of two axes at a small angle is far away. Axes 10 µrad and 0.3 m apart give a d of 30 km. Where a
    description has rounded its angles, a greater `parallel` gives a table of usual size.

    Args:
        arm: An arm of turns and slides, one for each coordinate.
        convention: "standard" or "modified".
        parallel: The angle [rad] below which axes count as parallel.

    Raises:
        InputError: The arm has coupled or helical joints, or twists that are not of unit length.
    """
    require_choice(convention, CONVENTIONS, "convention")
    if not 0.0 < as_number(parallel, "parallel") <= MOST_PARALLEL:
        raise InputError(f"parallel must be above 0 and at most {MOST_PARALLEL} rad; got {parallel:g} rad")
    moving = require_arm(arm).coupling.A.any(axis=1)
    A, screws = arm.coupling.A[moving], to_screw(arm.screws[:, moving].T)
    slides = np.isinf(screws.pitch)
    if not np.array_equal(A, np.eye(arm.n)):
        what = "{arm} has coupled joints; a DH table has one independent joint in each row. {how}"
        raise InputError(Text(what, arm=arm.name, how=OF_COUPLED))
    if (np.abs(screws.magnitude - 1.0) > UNIT).any() or (np.abs(screws.pitch[~slides]) > UNIT * arm.reach).any():
        raise InputError(f"{arm.name} has joints with a pitch or a rate; a DH table has only turns and slides")
    axes = np.vstack([screws.axis, arm.home[:3, 2]])
    points = np.vstack([screws.point, arm.home[:3, 3]])
    origin = np.zeros(3) if slides[0] else points[0] - axes[0] * (axes[0] @ points[0])  # nearest to the base
    frame = pose_of(plane_axes(axes[0]), origin)
    base, frames = frame, [frame]
    for i in range(arm.n):
        here = frame[:3, 3]  # a slide's axis may pass through any point
        one, other = (here if j < arm.n and slides[j] else points[j] for j in (i, i + 1))
        x, feet = _normal((axes[i], one), (axes[i + 1], other), frame, parallel)
        k = i + 1 if convention == "standard" else i
        frame = pose_of(plane_axes(axes[k], x), feet[k - i])
        frames.append(frame)
    steps = [inverse(frame) @ other for frame, other in pairwise(frames)]
    rows = np.array([_row(T, convention) for T in steps])
    types = tuple("prismatic" if slide else "revolute" for slide in slides)
    bounds = {name: getattr(arm.limits, name) for name in LIMIT_NAMES}
    limits = {
        joint: {name: float(values[j]) for name, values in bounds.items() if np.isfinite(values[j])}
        for j, joint in enumerate(arm.joint_names)
    }
    table = DhTable(rows, convention, arm.joint_names, types, base, inverse(frame) @ arm.home, limits=limits)
    theta = arm.random_theta(0, SAMPLES)
    return replace(table, residual=float(np.abs(arm_from_dh(table).fk(theta) - arm.fk(theta)).max()))


def dh_rows(table: DhTable) -> list[dict[str, Any]]:
    """The rows of a table by column, in SI, as its CSV file has them: base and tool are fixed rows."""
    base, tool = (_fixed_rows(T, table.convention) for T in (table.base, table.tool))
    joints = (*(BASE for _ in base), *(table.joints or ()), *(TOOL for _ in tool))
    types = (*(FIXED for _ in base), *(table.types or ()), *(FIXED for _ in tool))
    return [
        {"joint": joint, "type": kind, "convention": table.convention}
        | dict(zip(PARAMETERS, np.where(np.abs(row) < EXACT, 0.0, row).tolist(), strict=True))
        | dict(table.limits.get(joint, {}) if kind != FIXED else {})
        for joint, kind, row in zip(joints, types, [*base, *table.rows, *tool], strict=True)
    ]


def dh_csv(table: DhTable) -> str:
    """The CSV file of a table, which `load_arm` and `arm_from_dh` read."""
    heads = {"a": "a [m]", "alpha": "alpha [rad]", "d": "d [m]", "theta": "theta [rad]"}
    rows = [[row.get(name, "") for name in COLUMNS] for row in dh_rows(table)]
    return csv_text([heads.get(name, name) for name in COLUMNS], rows)


def _fixed_rows(T: Array, convention: str) -> list[Array]:
    """Up to three rows (4,) with a transform (4, 4) as their product: a way, then the turns Z, X and Z."""
    if convention == "modified":  # a modified row is the inverse of a standard one with other signs
        return [-row for row in reversed(_fixed_rows(inverse(T), "standard"))]
    (x, y, z), (first, tilt, last) = T[:3, 3], to_euler("ZXZ", T[:3, :3])
    turn = np.arctan2(y, x)
    rows = np.array([[np.hypot(x, y), 0.0, z, turn], [0.0, tilt, 0.0, first - turn], [0.0, 0.0, 0.0, last]])
    return [row for row in rows if np.abs(row).max() > EXACT]


def _normal(
    line: tuple[Array, Array], other: tuple[Array, Array], frame: Array, parallel: float
) -> tuple[Array, tuple[Array, Array]]:
    """The direction (3,) of the common normal of two lines (axis, point), and its feet on both."""
    (z, p), (w, q) = line, other
    across = np.cross(z, w)
    sine = float(np.linalg.norm(across))
    if sine < parallel:
        foot = nearest_on_line(z, p, frame[:3, 3])
        far = nearest_on_line(w, q, foot)
        return (far - foot if np.linalg.norm(far - foot) > UNIT else frame[:3, 0]), (foot, far)
    foot, far = (p + z * (np.cross(q - p, w) @ across / sine**2), q + w * (np.cross(q - p, z) @ across / sine**2))
    return across * (-1.0 if (far - foot) @ across < 0 else 1.0) / sine, (foot, far)


def _row(T: Array, convention: str) -> Array:
    """a, α, d and θ of a transform (4, 4) of that form."""
    if convention == "modified":
        return -_row(inverse(T), "standard")
    R, p = T[:3, :3], T[:3, 3]
    theta, alpha = np.arctan2(R[1, 0], R[0, 0]), np.arctan2(R[2, 1], R[2, 2])
    return np.array([p[0] * np.cos(theta) + p[1] * np.sin(theta), alpha, p[2], theta])
