"""`ik`: joint values for a target."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import typer

from ..arm import Arm
from ..errors import InputError
from ..ik import POSTURES, Approach, IKSolution, Pose, Position, solve_ik
from ..rotations import from_rpy
from .options import Json, Radians, Theta, takes_arm
from .output import console, pose_json, print_json, shown, table, theta_typed, units
from .typed import RPY, VALUES, XYZ, parse_numbers, parse_theta

Xyz = Annotated[str, typer.Option(metavar=XYZ, help="Position of the tool in the base frame, in metres.")]
Rpy = Annotated[
    str | None, typer.Option(metavar=RPY, help="Orientation: fixed-axis roll, pitch, yaw [°, or rad with --rad].")
]
Direction = Annotated[str | None, typer.Option(metavar=XYZ, help="Only where the tool's z axis points, in base axes.")]
Posture = Annotated[
    str | None,
    typer.Option(
        metavar=VALUES,
        help="What a redundant arm stays near while it meets the target: theta0 (the start), centre, a pose or values.",
    ),
]
MaxTime = Annotated[float | None, typer.Option("--max-time", metavar="S", help="Give up after so many seconds.")]


@takes_arm
def ik(
    arm: Arm,
    xyz: Xyz,
    rpy: Rpy = None,
    direction: Direction = None,
    start: Theta = "ready",
    posture: Posture = None,
    max_time: MaxTime = None,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Inverse kinematics: a pose (--xyz and --rpy), an approach (--xyz and --direction) or a position (--xyz)."""
    target = _target(xyz, rpy, direction, rad)
    preferred = posture if posture in (None, *POSTURES) else parse_theta(arm, str(posture), rad)
    solution = solve_ik(arm, target, parse_theta(arm, start, rad), posture=preferred, max_time=max_time)
    if json:
        print_json(_as_json(arm, solution))
    else:
        console().print(solution_table(arm, solution, rad))
        print(theta_typed(arm, solution.theta, rad))
        print(solution.explain())
    return 0 if solution.converged else 1


def _target(xyz: str, rpy: str | None, direction: str | None, radians: bool) -> Pose | Approach | Position:
    if rpy is not None and direction is not None:
        raise InputError("give --rpy for a whole pose or --direction for an approach, not both")
    p = parse_numbers(xyz, 3, "--xyz")
    if direction is not None:
        return Approach(p, parse_numbers(direction, 3, "--direction"))
    if rpy is None:
        return Position(p)
    angles = parse_numbers(rpy, 3, "--rpy")
    g = np.eye(4)
    g[:3, :3] = from_rpy(angles if radians else np.radians(angles))
    g[:3, 3] = p
    return Pose(g)


def solution_table(arm: Arm, solution: IKSolution, radians: bool) -> Any:
    """The solution's joint values with their limits."""
    lower, upper = (shown(arm, bound, radians) for bound in (arm.limits.lower, arm.limits.upper))
    values = shown(arm, solution.theta, radians)
    rows = list(zip(arm.joint_names, values, units(arm, radians), lower, upper, strict=True))
    return table(f"{arm.name}: {solution.stop.name}", ["joint", "value", "unit", "lower", "upper"], rows)


def _as_json(arm: Arm, solution: IKSolution) -> dict[str, Any]:
    fields = ("position_error", "orientation_error", "within_limits", "iterations", "restarts", "method", "notes")
    return {
        "arm": arm.name,
        "converged": solution.converged,
        "stop": solution.stop.name,
        "joint_names": arm.joint_names,
        "theta": solution.theta,
        **{field: getattr(solution, field) for field in fields},
        "explanation": solution.explain(),
        "reached": pose_json(arm.fk(solution.theta)),
    }
