"""The answers of `ik` to the targets of a CSV file: shown, counted and written."""

from __future__ import annotations

from typing import Any

from ..arm.arm import Arm
from ..ik import IKBatch, IKSolution, StopReason
from ..ik.solution import missed_by_rounding
from ..support.csv_lines import csv_text
from .csv_rows import ROWS_SHOWN, Sheet, few
from .output import console, print_json, say, table, theta_typed
from .outputs import Outputs

ERRORS = ("position_error", "orientation_error")


def tell_answers(sheet: Sheet, batch: IKBatch, outputs: Outputs, *, radians: bool, json: bool) -> int:
    """Write and say the answers to a file's targets; the exit code."""
    arm, lines, answers = batch.arm, [row.line for row in sheet.rows], list(batch)
    written = outputs.write({"csv": lambda: answers_csv(arm, lines, answers)})
    if json:
        print_json(
            {
                "arm": arm.name,
                "joint_names": arm.joint_names,
                "met": int(batch.converged.sum()),
                "answers": [_row_json(*pair) for pair in zip(lines, answers, strict=True)],
                "written": written,
            }
        )
    else:
        if not written:
            console().print(_answers(arm, lines, answers, radians))
        say(*_counted(sheet, lines, answers), file=outputs.words)
        outputs.say(written)
    return 0 if batch.converged.all() else 1


def _row_json(line: int, answer: IKSolution) -> dict[str, Any]:
    fields = ("converged", "rounded", "theta", *ERRORS)
    return {"line": line, "stop": answer.stop.name} | {field: getattr(answer, field) for field in fields}


def _answers(arm: Arm, lines: list[int], answers: list[IKSolution], radians: bool) -> Any:
    """The first answers, each as it can be typed."""
    rows = [
        [line, answer.stop.name, theta_typed(arm, answer.theta, radians)]
        for line, answer in list(zip(lines, answers, strict=True))[:ROWS_SHOWN]
    ]
    return table(arm.name, ["line", "answer", "theta"], rows, text=["answer", "theta"])


def _counted(sheet: Sheet, lines: list[int], answers: list[IKSolution]) -> list[str]:
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


def answers_csv(arm: Arm, lines: list[int], answers: list[IKSolution]) -> str:
    """The answers as CSV: theta, whether and why not, and how far off."""
    joints = [f"{name} [{unit}]" for name, unit in zip(arm.joint_names, arm.units, strict=True)]
    rows = (
        [line, *answer.theta.tolist(), answer.stop.name, answer.position_error, answer.orientation_error]
        for line, answer in zip(lines, answers, strict=True)
    )
    return csv_text(["line", *joints, "answer", "position_error [m]", "orientation_error [rad]"], rows)
