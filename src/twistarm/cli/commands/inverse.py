"""`ik`: joint values for a target, all of them, or for each target of a CSV file."""

from __future__ import annotations

import os
from typing import Annotated, Any

import typer

from ...arm.arm import Arm
from ...ik import POSTURES, IKResult, solve_ik, solve_ik_all, solve_ik_batch
from ...support.errors import InputError
from ..answers import answers_csv, tell_all, tell_answers
from ..avoiding import Avoid, avoided
from ..csv_rows import Columns, read_sheet
from ..options import Json, Radians, Theta, takes_arm
from ..output import console, pose_json, print_json, progress_bar, say, shown, table, theta_typed, units
from ..outputs import Force, Output, outputs_of
from ..quantities import quantity
from ..targets import (
    COLUMNS,
    Axis,
    Direction,
    OrientationTol,
    PositionTol,
    Quaternion,
    QuaternionXyzw,
    Rpy,
    targets_in,
    typed_orientation,
    typed_tolerances,
)
from ..typed import VALUES, XYZ, parse_joints, parse_numbers, parse_theta
from ..wording import words

Xyz = Annotated[str | None, typer.Option(metavar=XYZ, help="Position of the tool in the base frame, in metres.")]
Targets = Annotated[
    str | None, typer.Option(metavar="CSV", help=f"A target in each row: {COLUMNS}; - is standard input.")
]
Posture = Annotated[
    str | None,
    typer.Option(
        metavar=VALUES,
        help="Where a redundant arm stands while it meets the target: near theta0 (the start), middle (of the limits), "
        "a pose or values.",
    ),
]
MaxTime = Annotated[
    float | None, quantity("s", "Give up after so many seconds; with --all what is found by then.", "--max-time")
]
All = Annotated[
    bool, typer.Option("--all", help="Every configuration that meets the target, the one nearest to --start first.")
]
FixedJoints = Annotated[
    str | None,
    typer.Option(
        "--fixed-joint",
        metavar=VALUES,
        help="With --all: joint=value of joints that stay there; the others are solved for. Where there are "
        "more joints than the target determines, some are else held at values over their range.",
    ),
]
Copies = Annotated[
    bool, typer.Option("--include-turns", help="With --all: what differs by whole turns of joints counts as different.")
]


@takes_arm
def ik(
    arm: Arm,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quaternion: Quaternion = None,
    quaternion_xyzw: QuaternionXyzw = None,
    direction: Direction = None,
    axis: Axis = None,
    targets: Targets = None,
    columns: Columns = None,
    start: Theta = "ready",
    all_: All = False,
    given: FixedJoints = None,
    copies: Copies = False,
    posture: Posture = None,
    position_tol: PositionTol = None,
    orientation_tol: OrientationTol = None,
    max_time: MaxTime = None,
    avoid: Avoid = None,
    output: Output = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Inverse kinematics: joint values for a position and orientation, all of them (--all), or for a CSV's rows."""
    if (xyz is None) == (targets is None):
        raise InputError("give one position by --xyz, or a file of targets by --targets")
    if columns is not None and targets is None:
        raise InputError("--columns names the columns of a file: it goes with --targets")
    _require_fitting(
        all_, {"--fixed-joint": given, "--include-turns": copies}, {"--posture": posture, "--targets": targets}
    )
    outputs = outputs_of(output, {"csv": (".csv",)}, force=force, json=json)
    orientation = typed_orientation(rpy, quaternion, quaternion_xyzw, direction, axis, rad)
    how = {"theta0": parse_theta(arm, start, rad), **typed_tolerances(position_tol, orientation_tol, rad)}
    how["scene"] = avoided(arm, avoid)
    if all_:
        stands = None if given is None else parse_joints(arm, given, "--fixed-joint", rad)
        target = orientation.at(parse_numbers(str(xyz), "m m m", "--xyz"))
        with progress_bar("ik") as progress:
            solutions = solve_ik_all(
                arm, target, **how, fixed_joints=stands, include_turns=copies, max_time=max_time, progress=progress
            )
        return tell_all(solutions, outputs, radians=rad, json=json)
    how["posture"] = posture if posture in (None, *POSTURES) else parse_theta(arm, str(posture), rad)
    how["max_time"] = max_time
    if targets is not None:
        sheet = read_sheet(targets, columns)
        asked = targets_in(sheet, orientation)
        with progress_bar("ik") as progress:
            batch = solve_ik_batch(arm, asked, **how, threads=os.cpu_count() or 1, progress=progress)
        return tell_answers(sheet, batch, outputs, radians=rad, json=json)
    solution = solve_ik(arm, orientation.at(parse_numbers(str(xyz), "m m m", "--xyz")), **how)
    written = outputs.write({"csv": lambda: answers_csv(arm, [1], [solution])})
    if json:
        print_json(_as_json(arm, solution) | {"written": written})
    else:
        console(outputs.words).print(solution_table(arm, solution, rad))
        say(
            theta_typed(arm, solution.theta, rad),
            *words(solution.explain(), radians=rad).splitlines(),
            file=outputs.words,
        )
        outputs.say(written)
    return 0 if solution.converged else 1


def _require_fitting(all_: bool, alone: dict[str, Any], never: dict[str, Any]) -> None:
    """InputError for options that go with --all alone, or never with it."""
    for option, value in alone.items():
        if value and not all_:
            raise InputError(f"{option} is about all configurations: it goes with --all")
    for option, value in never.items():
        if value is not None and all_:
            raise InputError(f"--all takes no {option}: it gives every configuration for the one target of --xyz")


def solution_table(arm: Arm, solution: IKResult, radians: bool) -> Any:
    """The solution's joint values with their limits."""
    lower, upper = (shown(arm, bound, radians) for bound in (arm.limits.lower, arm.limits.upper))
    values = shown(arm, solution.theta, radians)
    rows = list(zip(arm.joint_names, values, units(arm, radians), lower, upper, strict=True))
    return table(f"{arm.name}: {solution.stop.name}", ["joint", "value", "unit", "lower", "upper"], rows)


def _as_json(arm: Arm, solution: IKResult) -> dict[str, Any]:
    fields = ("position_error", "orientation_error", "within_limits", "iterations", "restarts", "method", "notes")
    return {
        "arm": arm.name,
        "converged": solution.converged,
        "stop": solution.stop.name,
        "joint_names": arm.joint_names,
        "theta": solution.theta,
        **{field: getattr(solution, field) for field in fields},
        "explanation": words(solution.explain(), radians=True),
        "reached": pose_json(arm.fk(solution.theta)),
    }
