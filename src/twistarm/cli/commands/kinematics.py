"""`fk` and `jacobian`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

import numpy as np

from ...support.checks import Array
from ...support.errors import InputError
from ...theory.rotations import to_xyzw
from ..numbers import option
from ..options import Answer, ArmArgument, CsvAnswer, Theta
from ..output import entries
from ..rows import ROWS_SHOWN, configurations_in
from ..tables import Column, Table, jacobian_table, number, pose_entries, pose_parts, theta_typed

Configurations = Annotated[
    str | None,
    option(
        "CSV",
        "A configuration in each row, a column for each joint [rad, m], `elbow [deg]` for degrees; - is standard "
        "input.",
    ),
]


def fk(
    source: ArmArgument,
    out: CsvAnswer,
    theta: Theta = None,
    configurations: Configurations = None,
    frame: Annotated[str | None, option("LINK", "Another frame than the tip.")] = None,
) -> None:
    """Forward kinematics: the pose of the tip, or of another frame, seen from the base."""
    arm = source.load()
    if configurations is not None and theta is not None:
        raise InputError("give one --theta, or a file of configurations by --configurations")
    name = frame or arm.tip
    data = {"arm": arm, "joint_names": arm.joint_names, "base": arm.base, "frame": name}
    title = f"{name} seen from {arm.base}"
    if configurations is None:
        x = arm.ready if theta is None else theta.anywhere(arm)
        g = arm.pose(x, name)
        told = (*pose_parts(title, g, out.radians), theta_typed(arm, x, out.radians))
        out.show(data | {"theta": x, **pose_entries(g)}, *told, files={"csv": _poses_table(title, [1], g[None]).csv})
        return
    lines, many = configurations_in(arm, configurations)
    poses = arm.pose(many, name)
    records = [{"line": k, "theta": x, **pose_entries(one)} for k, x, one in zip(lines, many, poses, strict=True)]
    table = _poses_table(title, lines, poses)
    parts: list[Table | str] = [] if out.files else [table]
    if len(lines) > ROWS_SHOWN and not out.files:
        parts.append(f"{ROWS_SHOWN} of {len(lines)} poses (-o FILE.csv has them all)")
    out.show(data | {"poses": records}, *parts, files={"csv": table.csv})


def _poses_table(title: str, lines: Sequence[int], g: Array) -> Table:
    """Poses (N, 4, 4): positions and quaternions, scalar last, as `ik --targets` reads them."""
    numbers = np.concatenate([g[:, :3, 3], to_xyzw(g[:, :3, :3])], axis=-1).T
    names = ("x", "y", "z", "qx", "qy", "qz", "qw")
    columns = [Column(name, row, "m" * (len(name) == 1), digits=6) for name, row in zip(names, numbers, strict=True)]
    return Table(title, [Column("line", lines), *columns], rows=range(min(len(lines), ROWS_SHOWN)))


def jacobian(
    source: ArmArgument,
    out: Answer,
    theta: Theta = None,
    kind: Annotated[Literal["spatial", "body", "hybrid"] | None, option(None, "Only one of them.")] = None,
) -> None:
    """The spatial and body Jacobians (rows v, ω) and the singular values of the body Jacobian."""
    arm = source.load()
    x = arm.ready if theta is None else theta.anywhere(arm)
    names = [f"{one}_jacobian" for one in ([kind] if kind else ["spatial", "body"])]
    matrices = {name: getattr(arm, name)(x) for name in names}
    measure = arm.manipulability(x)
    values = " ".join(number(s) for s in measure.singular_values)
    tables = [part for name, J in matrices.items() for part in (jacobian_table(arm, name.replace("_j", " J"), J), "")]
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "theta": x, **matrices}
        | entries(measure, "singular_values condition length"),
        *tables,
        theta_typed(arm, x, out.radians),
        f"singular values {values}, condition {float(measure.condition):.3g} (length {measure.length:.3f} m)",
    )
