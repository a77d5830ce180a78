"""`fk` and `jacobian`."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from ...arm.arm import Arm
from ...support.checks import Array
from ...support.errors import InputError
from ..configurations import configurations_in, poses_csv, tell_poses
from ..csv_rows import Columns, read_sheet
from ..options import CONFIGURATION, Json, Radians, Theta, takes_arm
from ..output import (
    console,
    jacobian_table,
    number,
    pose_json,
    pose_table,
    print_json,
    say,
    shown,
    theta_typed,
    units,
    warn,
)
from ..outputs import Force, Output, outputs_of
from ..typed import parse_theta

Configurations = Annotated[
    str | None,
    typer.Option(
        metavar="CSV",
        help="A configuration in each row, a column for each joint [rad, m], `elbow [deg]` for degrees; - is standard "
        "input.",
    ),
]


@takes_arm
def fk(
    arm: Arm,
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
    if columns is not None and configurations is None:
        raise InputError("--columns names the columns of a file: it goes with --configurations")
    outputs = outputs_of(output, {"csv": (".csv",)}, force=force, json=json)
    name = frame or arm.tip
    if configurations is not None:
        if theta is not None:
            raise InputError("give one --theta, or a file of configurations by --configurations")
        sheet = read_sheet(configurations, columns)
        tell_poses(arm, sheet, configurations_in(arm, sheet), name, outputs, json=json)
        return
    x = parse_theta(arm, "ready" if theta is None else theta, rad)
    warn_outside(arm, x, rad)
    g = arm.pose(x, name)
    written = outputs.write({"csv": lambda: poses_csv([1], g[None])})
    if json:
        about = {"arm": arm.name, "joint_names": arm.joint_names, "theta": x, "base": arm.base, "frame": name}
        print_json({**about, **pose_json(g), "written": written})
        return
    console(outputs.words).print(pose_table(f"{name} seen from {arm.base}", g, rad))
    say(theta_typed(arm, x, rad), file=outputs.words)
    outputs.say(written)


@takes_arm
def jacobian(
    arm: Arm,
    theta: Theta = "ready",
    kind: Annotated[Literal["spatial", "body", "hybrid"] | None, typer.Option(help="Only one of them.")] = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """The spatial and body Jacobians (rows v, ω) and the singular values of the body Jacobian."""
    x = parse_theta(arm, theta, rad)
    warn_outside(arm, x, rad)
    matrices = {one: getattr(arm, f"{one}_jacobian")(x) for one in ([kind] if kind else ["spatial", "body"])}
    measure = arm.manipulability(x)
    if json:
        print_json(
            {"arm": arm.name, "joint_names": arm.joint_names, "theta": x}
            | {f"{name}_jacobian": J for name, J in matrices.items()}
            | {"singular_values": measure.singular_values, "condition": measure.condition, "length": measure.length}
        )
        return
    out = console()
    for name, J in matrices.items():
        out.print(jacobian_table(arm, f"{name} Jacobian", J), "")
    say(theta_typed(arm, x, rad))
    values = " ".join(number(s) for s in measure.singular_values)
    out.print(f"singular values {values}, condition {float(measure.condition):.3g} (length {measure.length:.3f} m)")


def warn_outside(arm: Arm, theta: Array, radians: bool) -> None:
    """Warn of a theta outside the limits, which fk and the Jacobians accept."""
    rows = (shown(arm, values, radians) for values in (theta, arm.limits.lower, arm.limits.upper))
    outside = (theta < arm.limits.lower) | (theta > arm.limits.upper)
    for name, unit, value, lower, upper, out in zip(arm.joint_names, units(arm, radians), *rows, outside, strict=True):
        if out:
            warn(f"{name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")
