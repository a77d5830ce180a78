"""`fk` and `jacobian`."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from ...arm.arm import Arm
from ...support.checks import Array
from ...support.errors import InputError
from ..configurations import configurations_in, poses_csv, tell_poses
from ..csv_rows import Columns, read_sheet
from ..options import CONFIGURATION, ArmArgument, Json, Radians, Theta
from ..output import entries, warn
from ..outputs import Force, Output, Outputs, outputs_of
from ..tables import jacobian_table, number, pose_entries, pose_table, shown, theta_typed, units
from ..typed import parse_theta

Configurations = Annotated[
    str | None,
    typer.Option(
        metavar="CSV",
        help="A configuration in each row, a column for each joint [rad, m], `elbow [deg]` for degrees; - is standard "
        "input.",
    ),
]


def fk(
    source: ArmArgument,
    theta: Annotated[str | None, CONFIGURATION] = None,
    configurations: Configurations = None,
    columns: Columns = None,
    frame: Annotated[str | None, typer.Option(metavar="LINK", help="Another frame than the tip.")] = None,
    output: Output = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Forward kinematics: the pose of the tip, or of another frame, seen from the base."""
    arm = source.load()
    if columns is not None and configurations is None:
        raise InputError("--columns names the columns of a file: it goes with --configurations")
    out = outputs_of(output, {"csv": (".csv",)}, force=force, json=json, radians=rad)
    name = frame or arm.tip
    if configurations is not None:
        if theta is not None:
            raise InputError("give one --theta, or a file of configurations by --configurations")
        sheet = read_sheet(configurations, columns)
        tell_poses(arm, sheet, configurations_in(arm, sheet), name, out)
        return
    x = parse_theta(arm, "ready" if theta is None else theta, rad)
    warn_outside(arm, x, rad)
    g = arm.pose(x, name)
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "theta": x, "base": arm.base, "frame": name, **pose_entries(g)},
        pose_table(f"{name} seen from {arm.base}", g, rad),
        theta_typed(arm, x, rad),
        files={"csv": lambda: poses_csv([1], g[None])},
    )


def jacobian(
    source: ArmArgument,
    theta: Theta = "ready",
    kind: Annotated[Literal["spatial", "body", "hybrid"] | None, typer.Option(help="Only one of them.")] = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """The spatial and body Jacobians (rows v, ω) and the singular values of the body Jacobian."""
    arm = source.load()
    x = parse_theta(arm, theta, rad)
    warn_outside(arm, x, rad)
    names = [f"{one}_jacobian" for one in ([kind] if kind else ["spatial", "body"])]
    matrices = {name: getattr(arm, name)(x) for name in names}
    measure = arm.manipulability(x)
    values = " ".join(number(s) for s in measure.singular_values)
    tables = [part for name, J in matrices.items() for part in (jacobian_table(arm, name.replace("_j", " J"), J), "")]
    Outputs(json=json, radians=rad).show(
        {"arm": arm, "joint_names": arm.joint_names, "theta": x, **matrices}
        | entries(measure, "singular_values condition length"),
        *tables,
        theta_typed(arm, x, rad),
        f"singular values {values}, condition {float(measure.condition):.3g} (length {measure.length:.3f} m)",
    )


def warn_outside(arm: Arm, theta: Array, radians: bool) -> None:
    """Warn of a theta outside the limits, which fk and the Jacobians accept."""
    rows = (shown(arm, values, radians) for values in (theta, arm.limits.lower, arm.limits.upper))
    outside = (theta < arm.limits.lower) | (theta > arm.limits.upper)
    for name, unit, value, lower, upper, out in zip(arm.joint_names, units(arm, radians), *rows, outside, strict=True):
        if out:
            warn(f"{name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")
