"""`ik`: joint values for a target, all of them, or for each target of a CSV file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from ...arm.arm import Arm
from ...ik import POSTURES, AllSolutions, IKBatch, IKResult, StopReason, solve_ik, solve_ik_all, solve_ik_batch
from ...ik.solution import missed_by_rounding
from ...support.csv_lines import csv_text
from ...support.errors import InputError
from ...support.messages import plural
from ..command import VALUES, XYZ
from ..csv_rows import ROWS_SHOWN, Columns, Sheet, few, read_sheet
from ..options import ArmArgument, Avoid, Json, Radians, Theta, avoided
from ..output import entries, progress_bar
from ..outputs import Force, Output, Outputs, outputs_of
from ..quantities import quantity
from ..tables import Column, Table, joint_heads, pose_entries, theta_typed
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
from ..typed import parse_joints, parse_numbers, parse_theta

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
Turns = Annotated[
    bool, typer.Option("--include-turns", help="With --all: what differs by whole turns of joints counts as different.")
]

ERRORS = ("position_error", "orientation_error")


def ik(
    source: ArmArgument,
    xyz: Xyz = None,
    rpy: Rpy = None,
    quaternion: Quaternion = None,
    quaternion_xyzw: QuaternionXyzw = None,
    direction: Direction = None,
    axis: Axis = None,
    start: Theta = "ready",
    all_: All = False,
    fixed_joints: FixedJoints = None,
    include_turns: Turns = False,
    targets: Targets = None,
    columns: Columns = None,
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
    arm = source.load()
    if (xyz is None) == (targets is None):
        raise InputError("give one position by --xyz, or a file of targets by --targets")
    if columns is not None and targets is None:
        raise InputError("--columns names the columns of a file: it goes with --targets")
    for option, value in {"--fixed-joint": fixed_joints, "--include-turns": include_turns}.items():
        if value and not all_:
            raise InputError(f"{option} is about all configurations: it goes with --all")
    for option, value in {"--posture": posture, "--targets": targets}.items():
        if value is not None and all_:
            raise InputError(f"--all takes no {option}: it gives every configuration for the one target of --xyz")
    out = outputs_of(output, {"csv": (".csv",)}, force=force, json=json, radians=rad)
    orientation = typed_orientation(rpy, quaternion, quaternion_xyzw, direction, axis, rad)
    how: dict[str, Any] = {
        "theta0": parse_theta(arm, start, rad),
        "scene": avoided(arm, avoid),
        "max_time": max_time,
        **typed_tolerances(position_tol, orientation_tol, rad),
    }
    if all_:
        how["fixed_joints"] = None if fixed_joints is None else parse_joints(arm, fixed_joints, "--fixed-joint", rad)
        target = orientation.at(parse_numbers(str(xyz), "m m m", "--xyz"))
        with progress_bar("ik") as progress:
            solutions = solve_ik_all(arm, target, **how, include_turns=include_turns, progress=progress)
        _show_all(out, solutions)
        return 0 if len(solutions) else 1
    how["posture"] = posture if posture in (None, *POSTURES) else parse_theta(arm, str(posture), rad)
    if targets is not None:
        sheet = read_sheet(targets, columns)
        asked = targets_in(sheet, orientation)
        with progress_bar("ik") as progress:
            batch = solve_ik_batch(arm, asked, **how, threads=os.cpu_count() or 1, progress=progress)
        _show_batch(out, sheet, batch)
        return 0 if batch.converged.all() else 1
    solution = solve_ik(arm, orientation.at(parse_numbers(str(xyz), "m m m", "--xyz")), **how)
    show_solution(out, arm, solution)
    return 0 if solution.converged else 1


def show_solution(out: Outputs, arm: Arm, solution: IKResult) -> None:
    """The answer to one target, its joint values beside their limits."""
    explanation = solution.explain()
    columns = [
        Column("joint", arm.joint_names, key="joint_names"),
        Column("value", solution.theta, arm.units, key="theta"),
        Column("lower", arm.limits.lower, arm.units, key=None),
        Column("upper", arm.limits.upper, arm.units, key=None),
    ]
    out.show(
        {
            "arm": arm,
            **entries(solution, "converged stop position_error orientation_error within_limits"),
            **entries(solution, "iterations restarts method notes"),
            "explanation": explanation,
            "reached": pose_entries(arm.fk(solution.theta)),
        },
        Table(f"{arm.name}: {solution.stop.name}", columns, ""),
        theta_typed(arm, solution.theta, out.radians),
        *out.lines(explanation),
        files={"csv": lambda: _answers_csv(arm, [1], [solution])},
    )


def _show_batch(out: Outputs, sheet: Sheet, batch: IKBatch) -> None:
    """The answers to a file's targets: those that people see can be typed."""
    arm, lines, answers = batch.arm, [row.line for row in sheet.rows], list(batch)
    names = "stop converged rounded theta position_error orientation_error"
    records = [{"line": line, **entries(answer, names)} for line, answer in zip(lines, answers, strict=True)]
    columns = [
        Column("line", lines),
        Column("answer", [answer.stop.name for answer in answers]),
        Column("theta", [theta_typed(arm, answer.theta, out.radians) for answer in answers]),
    ]
    table = Table(arm.name, columns, rows=range(min(len(lines), ROWS_SHOWN)))
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "met": batch.converged.sum(), "answers": records},
        *([] if out.files else [table]),
        *_counted(sheet, lines, answers),
        files={"csv": lambda: _answers_csv(arm, lines, answers)},
    )


def _counted(sheet: Sheet, lines: list[int], answers: list[IKResult]) -> list[str]:
    """How many targets are met, and which are not, by reasons."""
    by_reason: dict[StopReason, list[int]] = {}
    for line, answer in zip(lines, answers, strict=True):
        by_reason.setdefault(answer.stop, []).append(line)
    met = len(by_reason.pop(StopReason.CONVERGED, ()))
    count = f"{met} of {len(answers)} targets of {sheet.file} met"
    if len(answers) > ROWS_SHOWN:
        count += " (-o FILE.csv has them all)"
    notes = []
    rounded = [line for line, answer in zip(lines, answers, strict=True) if answer.rounded]
    if rounded:
        worst = [max(getattr(answer, error) for answer in answers if answer.rounded) for error in ERRORS]
        notes = [f"note: line {few(rounded)}: {missed_by_rounding(*worst)}"]
    return [count, *notes, *(f"{reason.value}: line {few(numbers)}" for reason, numbers in by_reason.items())]


def _answers_csv(arm: Arm, lines: Sequence[int], answers: Sequence[IKResult]) -> str:
    """The answers as CSV: theta, whether and why not, and how far off."""
    rows = (
        [line, *answer.theta.tolist(), answer.stop.name, answer.position_error, answer.orientation_error]
        for line, answer in zip(lines, answers, strict=True)
    )
    return csv_text(["line", *joint_heads(arm), "answer", "position_error [m]", "orientation_error [rad]"], rows)


def _show_all(out: Outputs, solutions: AllSolutions) -> None:
    """A row for each configuration, nearest first."""
    arm, count, hits = solutions.arm, len(solutions), solutions.colliding
    columns = [Column("", range(1, count + 1))]
    for i, (name, unit) in enumerate(zip(arm.joint_names, arm.units, strict=True)):
        columns.append(Column(name, solutions.theta[:, i], unit, digits=3))
    if any(solutions.free):
        columns.append(Column("may go on moving", solutions.free))
    if hits.any():
        columns.append(Column("collides", ["yes" if hit else "" for hit in hits]))
    more = f", the {ROWS_SHOWN} nearest of them (-o FILE.csv has all)" if count > ROWS_SHOWN else ", nearest first"
    title = f"{arm.name}: {plural(count, 'configuration')}{more if count > 1 else ''}"
    explanation = solutions.explain()
    names = "theta free colliding outside complete timed_out method family starts hits position_error orientation_error"
    parts: list[Table | str] = []
    if count:
        table = Table(title, columns, rows=range(min(count, ROWS_SHOWN)))
        parts = [table, theta_typed(arm, solutions[0], out.radians)]
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, **entries(solutions, names), "explanation": explanation},
        *parts,
        *out.lines(explanation),
        files={"csv": lambda: _all_csv(solutions)},
    )


def _all_csv(solutions: AllSolutions) -> str:
    """All configurations as CSV, also those outside the limits: theta, joints free to move, within or not.

    Members of one family have one number.
    """
    arm = solutions.arm
    free = (*solutions.free, *((),) * len(solutions.outside))
    families = (*solutions.members, *solutions.outside[:, None])
    rows = (
        [i + 1, *each.tolist(), " ".join(moving), "no" if i >= len(solutions) else "yes"]
        for i, (members, moving) in enumerate(zip(families, free, strict=True))
        for each in members
    )
    return csv_text(["number", *joint_heads(arm), "free", "within_limits"], rows)
