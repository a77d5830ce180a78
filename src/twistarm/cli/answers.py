"""The answers of `ik` to targets in a CSV file, and of `ik --all`: shown, counted and written."""

from __future__ import annotations

from typing import Any

from ..arm.arm import Arm
from ..ik import AllSolutions, IKBatch, IKResult, StopReason
from ..ik.solution import missed_by_rounding
from ..support.csv_lines import csv_text
from ..support.messages import plural
from .csv_rows import ROWS_SHOWN, Sheet, few
from .grid import Grid
from .output import console, joint_heads, print_json, say, shown, table, theta_typed, units
from .outputs import Outputs
from .wording import words

ERRORS = ("position_error", "orientation_error")


def tell_answers(sheet: Sheet, batch: IKBatch, outputs: Outputs, *, radians: bool, json: bool) -> int:
    """Write and say the answers to a file's targets; the exit code."""
    arm, lines, answers = batch.arm, [row.line for row in sheet.rows], list(batch)
    written = outputs.write({"csv": lambda: answers_csv(arm, lines, answers)})
    if json:
        about = {"arm": arm.name, "joint_names": arm.joint_names, "met": int(batch.converged.sum())}
        rows = [_row_json(*pair) for pair in zip(lines, answers, strict=True)]
        print_json({**about, "answers": rows, "written": written})
    else:
        if not written:
            console().print(_answers(arm, lines, answers, radians))
        say(*_counted(sheet, lines, answers), file=outputs.words)
        outputs.say(written)
    return 0 if batch.converged.all() else 1


def _row_json(line: int, answer: IKResult) -> dict[str, Any]:
    fields = ("converged", "rounded", "theta", *ERRORS)
    return {"line": line, "stop": answer.stop.name} | {field: getattr(answer, field) for field in fields}


def _answers(arm: Arm, lines: list[int], answers: list[IKResult], radians: bool) -> Grid:
    """The first answers, each as it can be typed."""
    rows = [
        [line, answer.stop.name, theta_typed(arm, answer.theta, radians)]
        for line, answer in list(zip(lines, answers, strict=True))[:ROWS_SHOWN]
    ]
    return table(arm.name, ["line", "answer", "theta"], rows, text=["answer", "theta"])


def _counted(sheet: Sheet, lines: list[int], answers: list[IKResult]) -> list[str]:
    """How many targets are met, and which are not, by reasons."""
    by_reason: dict[StopReason, list[int]] = {}
    for line, answer in zip(lines, answers, strict=True):
        by_reason.setdefault(answer.stop, []).append(line)
    met = len(by_reason.pop(StopReason.CONVERGED, ()))
    count = f"{met} of {len(answers)} targets of {sheet.file} met"
    if len(answers) > ROWS_SHOWN:
        count += " (-o FILE.csv has them all)"
    rounded = [line for line, answer in zip(lines, answers, strict=True) if answer.rounded]
    if rounded:
        worst = [max(getattr(answer, error) for answer in answers if answer.rounded) for error in ERRORS]
        count += f"\nnote: line {few(rounded)}: {missed_by_rounding(*worst)}"
    return [count, *(f"{reason.value}: line {few(numbers)}" for reason, numbers in by_reason.items())]


def answers_csv(arm: Arm, lines: list[int], answers: list[IKResult]) -> str:
    """The answers as CSV: theta, whether and why not, and how far off."""
    rows = (
        [line, *answer.theta.tolist(), answer.stop.name, answer.position_error, answer.orientation_error]
        for line, answer in zip(lines, answers, strict=True)
    )
    return csv_text(["line", *joint_heads(arm), "answer", "position_error [m]", "orientation_error [rad]"], rows)


def tell_all(solutions: AllSolutions, outputs: Outputs, *, radians: bool, json: bool) -> int:
    """Write and say all configurations; the exit code."""
    written = outputs.write({"csv": lambda: all_csv(solutions)})
    if json:
        print_json(_all_json(solutions) | {"written": written})
    else:
        if len(solutions):
            console(outputs.words).print(_all_table(solutions, radians))
            say(theta_typed(solutions.arm, solutions[0], radians), file=outputs.words)
        say(*words(solutions.explain(), radians=radians).splitlines(), file=outputs.words)
        outputs.say(written)
    return 0 if len(solutions) else 1


def _all_table(solutions: AllSolutions, radians: bool) -> Grid:
    """A row for each configuration, nearest first."""
    arm, count = solutions.arm, len(solutions)
    moving = any(solutions.free)
    hits = solutions.colliding
    rows = [
        [
            i + 1,
            *shown(arm, theta, radians, digits=3),
            *([", ".join(solutions.free[i])] if moving else []),
            *(["yes" if hits[i] else ""] if hits.any() else []),
        ]
        for i, theta in enumerate(solutions.theta[:ROWS_SHOWN])
    ]
    heads = [f"{name} {unit}" for name, unit in zip(arm.joint_names, units(arm, radians), strict=True)]
    more = f", the {ROWS_SHOWN} nearest of them (-o FILE.csv has all)" if count > ROWS_SHOWN else ", nearest first"
    title = f"{arm.name}: {plural(count, 'configuration')}{more if count > 1 else ''}"
    last = ["may go on moving"] * moving + ["collides"] * bool(hits.any())
    return table(title, ["", *heads, *last], rows, text=last)


def _all_json(solutions: AllSolutions) -> dict[str, Any]:
    fields = ("theta", "free", "colliding", "outside", "complete", "timed_out", "method", "family", "starts", "hits")
    return {
        "arm": solutions.arm.name,
        "joint_names": solutions.arm.joint_names,
        **{field: getattr(solutions, field) for field in fields},
        "position_error": solutions.position_error,
        "orientation_error": solutions.orientation_error,
        "explanation": words(solutions.explain(), radians=True),
    }


def all_csv(solutions: AllSolutions) -> str:
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
