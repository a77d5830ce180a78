"""Configurations in a CSV file for `fk`, and the poses that they give."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.csv_lines import csv_text
from ..support.errors import InputError, listed
from ..theory.rotations import to_xyzw
from .csv_rows import ROWS_SHOWN, Sheet, few, no_column
from .output import note, warn
from .outputs import Outputs
from .tables import Column, Table, pose_entries


def configurations_in(arm: Arm, sheet: Sheet) -> Array:
    """theta (N, n) of a CSV's rows [rad, m]: a column per joint, by names or base to tip.

    Joints without a column take their value in ready, with a note.
    """
    if sheet.header is None:
        width = len(sheet.rows[0].cells)
        if width != arm.n:
            raise InputError(
                f"{sheet.file} has {width} columns without names, and {arm.name} {arm.n} joints "
                f"({', '.join(arm.joint_names)}): add --columns with their names"
            )
        sheet = replace(sheet, header=arm.joint_names)
    known = {said: name for name in arm.joint_names for said in (name, f"{name}.position")}
    columns = sheet.columns(known, dict(zip(arm.joint_names, arm.units, strict=True)))
    if not columns:
        raise no_column(sheet, f"no column is a joint of {arm.name}: {listed(arm.joint_names)}")
    others = [name for name in arm.joint_names if name not in columns]
    if others:
        note(f"{', '.join(others)} as in the pose ready")
    theta = np.tile(arm.ready, (len(sheet.rows), 1))
    theta[:, [arm.joint_names.index(name) for name in columns]] = [
        sheet.numbers(row, list(columns.values())) for row in sheet.rows
    ]
    outside = [row.line for row, inside in zip(sheet.rows, arm.limits.contains(theta), strict=True) if not inside]
    if outside:
        advice = f"angles are rad unless the header says so, as in '{arm.joint_names[-1]} [deg]'"
        warn(f"{sheet.file}: outside the limits: line {few(outside)}; {advice}")
    return theta


def tell_poses(arm: Arm, sheet: Sheet, theta: Array, frame: str, out: Outputs) -> None:
    """Write and say the poses of a frame at every theta (N, n)."""
    g, lines = arm.pose(theta, frame), [row.line for row in sheet.rows]
    poses = [{"line": line, "theta": x, **pose_entries(one)} for line, x, one in zip(lines, theta, g, strict=True)]
    heads = (Column(name, values, digits=6) for name, values in zip(COLUMNS, _numbers(g).T, strict=True))
    few = range(min(len(lines), ROWS_SHOWN))
    table = Table(f"{frame} seen from {arm.base}", [Column("line", lines), *heads], rows=few)
    parts: list[Table | str] = [] if out.files else [table]
    if len(lines) > ROWS_SHOWN and not out.files:
        parts.append(f"{ROWS_SHOWN} of {len(lines)} poses (-o FILE.csv has them all)")
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "base": arm.base, "frame": frame, "poses": poses},
        *parts,
        files={"csv": lambda: poses_csv(lines, g)},
    )


COLUMNS = ("x [m]", "y [m]", "z [m]", "qx", "qy", "qz", "qw")


def _numbers(g: Array) -> Array:
    """Position and quaternion (N, 7) of poses (N, 4, 4)."""
    return np.concatenate([g[:, :3, 3], to_xyzw(g[:, :3, :3])], axis=-1)


def poses_csv(lines: list[int], g: Array) -> str:
    """Poses (N, 4, 4) as CSV: positions and quaternions, scalar last, as `ik --targets` reads them."""
    rows = ([line, *row] for line, row in zip(lines, _numbers(g).tolist(), strict=True))
    return csv_text(["line", *COLUMNS], rows)
