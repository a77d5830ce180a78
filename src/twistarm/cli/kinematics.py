"""`fk` and `jacobian`."""

from __future__ import annotations

from enum import Enum
from typing import Annotated

import typer

from ..arm import Arm
from ..checks import Array
from .options import Json, Radians, Theta, takes_arm
from .output import (
    console,
    jacobian_table,
    number,
    pose_json,
    pose_table,
    print_json,
    shown,
    theta_typed,
    units,
    warn,
)
from .typed import parse_theta


class Kind(str, Enum):
    """Which Jacobian."""

    spatial = "spatial"
    body = "body"
    hybrid = "hybrid"


@takes_arm
def fk(
    arm: Arm,
    theta: Theta = "ready",
    frame: Annotated[str | None, typer.Option(metavar="LINK", help="Another frame than the tip.")] = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Forward kinematics: the pose of the tip, or of another frame, seen from the base."""
    x = parse_theta(arm, theta, rad)
    warn_outside(arm, x, rad)
    name = frame or arm.tip
    g = arm.pose(x, name)
    if json:
        print_json(
            {
                "arm": arm.name,
                "joint_names": arm.joint_names,
                "theta": x,
                "base": arm.base,
                "frame": name,
                **pose_json(g),
            }
        )
        return
    console().print(pose_table(f"{name} seen from {arm.base} at {theta_typed(arm, x, rad)}", g))


@takes_arm
def jacobian(
    arm: Arm,
    theta: Theta = "ready",
    kind: Annotated[Kind | None, typer.Option(help="Only one of them.")] = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """The spatial and body Jacobians (rows v, ω) and the singular values of the body Jacobian."""
    x = parse_theta(arm, theta, rad)
    warn_outside(arm, x, rad)
    kinds = [kind] if kind else [Kind.spatial, Kind.body]
    matrices = {one.value: getattr(arm, f"{one.value}_jacobian")(x) for one in kinds}
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
        out.print(jacobian_table(arm, f"{name} Jacobian at {theta_typed(arm, x, rad)}", J))
    values = " ".join(number(s) for s in measure.singular_values)
    out.print(f"singular values {values}, condition {float(measure.condition):.3g} (length {measure.length:.3f} m)")


def warn_outside(arm: Arm, theta: Array, radians: bool) -> None:
    """fk and the Jacobians accept any theta; a person should know when it lies outside the limits."""
    rows = (shown(arm, values, radians) for values in (theta, arm.limits.lower, arm.limits.upper))
    outside = (theta < arm.limits.lower) | (theta > arm.limits.upper)
    for name, unit, value, lower, upper, out in zip(arm.joint_names, units(arm, radians), *rows, outside, strict=True):
        if out:
            warn(f"{name} = {value} {unit} lies outside its limits {lower} … {upper} {unit}")
