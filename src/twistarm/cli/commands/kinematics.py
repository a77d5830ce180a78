"""`fk`, `jacobian` and `ik`: poses, and joint values for one target, or for each target of a CSV file."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np

from ...arm.arm import Arm
from ...ik import POSTURES, AllSolutions, IKBatch, IKResult, StopReason, solve_ik, solve_ik_all, solve_ik_batch
from ...support.checks import Array
from ...support.errors import InputError
from ...support.messages import plural
from ...theory.rotations import to_xyzw
from .. import rows
from ..numbers import JointValues, joint_values, option, quantity, switch
from ..options import Answer, ArmArgument, Avoid, CsvAnswer, Theta, avoided
from ..output import Outputs, entries, progress_bar
from ..tables import Column, Table, joint_columns, matrix_table, number, pose_entries, pose_parts, theta_typed

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
        summary = (*pose_parts(title, g, out.radians), theta_typed(arm, x, out.radians))
        out.show(data | {"theta": x, **pose_entries(g)}, *summary, files={"csv": _poses_table(title, [1], g[None]).csv})
        return
    lines, many = rows.configurations_in(arm, configurations)
    poses = arm.pose(many, name)
    records = [{"line": k, "theta": x, **pose_entries(one)} for k, x, one in zip(lines, many, poses, strict=True)]
    table = _poses_table(title, lines, poses)
    parts: list[Table | str] = [] if out.files else [table]
    if len(lines) > rows.ROWS_SHOWN and not out.files:
        parts.append(f"{rows.ROWS_SHOWN} of {len(lines)} poses (-o FILE.csv has them all)")
    out.show(data | {"poses": records}, *parts, files={"csv": table.csv})


def _poses_table(title: str, lines: Sequence[int], g: Array) -> Table:
    """Poses (N, 4, 4): positions and quaternions, scalar last, as `ik --targets` reads them."""
    numbers = np.concatenate([g[:, :3, 3], to_xyzw(g[:, :3, :3])], axis=-1).T
    units = {"x": "m", "y": "m", "z": "m", "qx": "", "qy": "", "qz": "", "qw": ""}
    columns = [Column(name, row, unit, digits=6) for (name, unit), row in zip(units.items(), numbers, strict=True)]
    return Table(title, [Column("line", lines), *columns], rows=range(min(len(lines), rows.ROWS_SHOWN)))


def jacobian(
    source: ArmArgument,
    out: Answer,
    theta: Theta = None,
    kind: Annotated[Literal["spatial", "body", "hybrid"] | None, option(None, "Only one of them.")] = None,
) -> None:
    """The spatial and body Jacobians (rows v, ω) and the singular values of the body Jacobian."""
    arm = source.load()
    x = arm.ready if theta is None else theta.anywhere(arm)
    kinds = [kind] if kind else ["spatial", "body"]
    matrices = {f"{name}_jacobian": getattr(arm, f"{name}_jacobian")(x) for name in kinds}
    measure = arm.manipulability(x)
    values = " ".join(number(s) for s in measure.singular_values)
    tables: list[Table | str] = []
    for name, J in matrices.items():
        heads = ["v x", "v y", "v z", "ω x", "ω y", "ω z"], ["", *arm.joint_names]
        tables += [matrix_table(name.replace("_j", " J"), J, *heads), ""]
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "theta": x, **matrices}
        | entries(measure, "singular_values condition length"),
        *tables,
        theta_typed(arm, x, out.radians),
        f"singular values {values}, condition {float(measure.condition):.3g} (length {measure.length:.3f} m)",
    )


Targets = Annotated[str | None, option("CSV", f"A target in each row: {rows.TARGET_COLUMNS}; - is standard input.")]
Posture = Annotated[
    JointValues | None,
    joint_values(
        "Posture of a redundant arm at the target: near theta0 (the start), middle (of the limits), a name or values."
    ),
]
MaxTime = Annotated[float | None, quantity("s", "Time limit; with --all the answer is what was found by then.")]
All = Annotated[bool, switch("Every configuration that reaches the target, the one nearest to --start first.", "--all")]
FixedJoints = Annotated[
    JointValues | None,
    joint_values(
        "With --all: joint=value of joints that stay there; the others are solved for. Where there are more joints "
        "than the target determines, some are else held at values over their range.",
        "--fixed-joint",
    ),
]
Turns = Annotated[
    bool, switch("With --all: configurations that differ by whole turns count as different.", "--include-turns")
]


def ik(
    source: ArmArgument,
    out: CsvAnswer,
    goal: rows.TargetOptions,
    start: Theta = None,
    all_: All = False,
    fixed_joints: FixedJoints = None,
    include_turns: Turns = False,
    targets: Targets = None,
    posture: Posture = None,
    position_tol: rows.PositionTol = None,
    orientation_tol: rows.OrientationTol = None,
    max_time: MaxTime = None,
    avoid: Avoid = None,
) -> int:
    """Inverse kinematics: joint values for a position and orientation, all of them (--all), or for a CSV's rows."""
    arm = source.load()
    if len(goal.xyz or ()) != (1 if targets is None else 0):
        raise InputError("give one position by --xyz, or a file of targets by --targets")
    if not all_ and (fixed_joints or include_turns):
        raise InputError("--fixed-joint and --include-turns are about all configurations: they go with --all")
    if all_ and (posture or targets):
        raise InputError("--all gives every configuration for the one target of --xyz: leave out --posture, --targets")
    how: dict[str, Any] = {
        # From ready, so that the same line gives the same answer on every call.
        "theta0": arm.ready if start is None else start.of(arm),
        "scene": avoided(arm, avoid),
        "max_time": max_time,
    }
    tolerances = {"position_tol": position_tol, "orientation_tol": orientation_tol}
    how |= {name: value for name, value in tolerances.items() if value is not None}
    if all_:
        how["fixed_joints"] = None if fixed_joints is None else fixed_joints.joints(arm)
        with progress_bar("ik") as progress:
            solutions = solve_ik_all(arm, goal.all()[0], **how, include_turns=include_turns, progress=progress)
        _show_all(out, solutions)
        return 0 if len(solutions) else 1
    if posture is not None:
        how["posture"] = posture.text if posture.text in POSTURES else posture.of(arm)
    if targets is not None:
        lines, asked = rows.targets_in(targets, goal)
        with progress_bar("ik") as progress:
            batch = solve_ik_batch(arm, asked, **how, threads=os.cpu_count() or 1, progress=progress)
        _show_batch(out, targets, lines, batch)
        return 0 if batch.converged.all() else 1
    solution = solve_ik(arm, goal.all()[0], **how)
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


def _show_batch(out: Outputs, file: str, lines: list[int], batch: IKBatch) -> None:
    """The answers to a file's targets: those that people see can be typed."""
    arm, answers = batch.arm, list(batch)
    names = "stop converged theta position_error orientation_error"
    records = [
        {"line": line, **entries(answer, names), "reason": answer.stop.value}
        for line, answer in zip(lines, answers, strict=True)
    ]
    columns = [
        Column("line", lines),
        Column("answer", [answer.stop.name for answer in answers]),
        Column("off", [answer.position_error for answer in answers], "m"),
        Column("angle off", [answer.orientation_error for answer in answers], "rad"),
        Column("theta", [theta_typed(arm, answer.theta, out.radians) for answer in answers]),
    ]
    table = Table(arm.name, columns, rows=range(min(len(lines), rows.ROWS_SHOWN)))
    by_reason: dict[StopReason, list[int]] = {}
    for line, answer in zip(lines, answers, strict=True):
        by_reason.setdefault(answer.stop, []).append(line)
    # What is reached has no reason: the lines below list the misses.
    converged = len(by_reason.pop(StopReason.CONVERGED, ()))
    more = " (-o FILE.csv has them all)" if len(answers) > rows.ROWS_SHOWN else ""
    counted = [f"{converged} of {len(answers)} targets of {file} reached{more}"]
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, "converged": converged, "answers": records},
        table,
        *counted,
        *(f"{reason.value}: line {rows.few(numbers)}" for reason, numbers in by_reason.items()),
        files={"csv": lambda: _answers_csv(arm, lines, answers)},
    )


def _answers_csv(arm: Arm, lines: Sequence[int], answers: Sequence[IKResult]) -> str:
    """The answers as CSV: theta, whether and why not, and how far off."""
    columns = [
        Column("line", lines),
        *joint_columns(arm, np.array([answer.theta for answer in answers])),
        Column("answer", [answer.stop.name for answer in answers]),
        Column("position_error", [answer.position_error for answer in answers], "m"),
        Column("orientation_error", [answer.orientation_error for answer in answers], "rad"),
    ]
    return Table("", columns).csv()


def _show_all(out: Outputs, solutions: AllSolutions) -> None:
    """A row for each configuration, nearest first."""
    arm, count, hits = solutions.arm, len(solutions), solutions.colliding
    columns = [Column("", range(1, count + 1)), *joint_columns(arm, solutions.theta, digits=3)]
    if any(solutions.free):
        columns.append(Column("may go on moving", solutions.free))
    if hits.any():
        columns.append(Column("collides", ["yes" if hit else "" for hit in hits]))
    seen = min(count, rows.ROWS_SHOWN)
    more = f", the {seen} nearest of them (-o FILE.csv has all)" if count > seen else ", nearest first"
    counted = plural(count, "configuration") + (" of infinitely many" if any(solutions.free) else "")
    title = f"{arm.name}: {counted}{more if count > 1 else ''}"
    explanation = solutions.explain()
    names = "theta free colliding outside complete timed_out method family starts hits position_error orientation_error"
    parts: list[Table | str] = []
    if count:
        table = Table(title, columns, rows=range(seen))
        parts = [table, theta_typed(arm, solutions[0], out.radians)]
    out.show(
        {"arm": arm, "joint_names": arm.joint_names, **entries(solutions, names), "explanation": explanation},
        *parts,
        *out.lines(explanation),
        files={"csv": lambda: _all_csv(solutions)},
    )


def _all_csv(solutions: AllSolutions) -> str:
    """All configurations as CSV, also those outside the limits: theta, joints free to move, within or not."""
    arm, inside, outside = solutions.arm, len(solutions), len(solutions.outside)
    columns = [
        Column("number", range(1, inside + outside + 1)),
        *joint_columns(arm, np.append(solutions.theta, solutions.outside).reshape(-1, arm.n)),
        Column("free", [" ".join(names) for names in solutions.free] + [""] * outside),
        Column("within_limits", ["yes"] * inside + ["no"] * outside),
    ]
    return Table("", columns).csv()
