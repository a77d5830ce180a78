"""The answer of `ik --all`: every configuration that meets a target, shown, explained and written."""

from __future__ import annotations

from typing import Any

from ..ik import IKSolutions
from ..support.csv_lines import csv_text
from .csv_rows import ROWS_SHOWN
from .grid import Grid
from .output import console, print_json, say, shown, table, theta_typed, units
from .outputs import Outputs
from .wording import in_options


def tell_all(solutions: IKSolutions, outputs: Outputs, *, radians: bool, json: bool) -> int:
    """Write and say all configurations; the exit code."""
    written = outputs.write({"csv": lambda: all_csv(solutions)})
    if json:
        print_json(_as_json(solutions) | {"written": written})
    else:
        if len(solutions):
            console(outputs.words).print(_table(solutions, radians))
            say(theta_typed(solutions.arm, solutions[0], radians), file=outputs.words)
        say(*in_options(solutions.explain()).splitlines(), file=outputs.words)
        outputs.say(written)
    return 0 if len(solutions) else 1


def _table(solutions: IKSolutions, radians: bool) -> Grid:
    """A row for each configuration, nearest first."""
    arm, count = solutions.arm, len(solutions)
    moving = any(solutions.free)
    rows = [
        [i + 1, *shown(arm, theta, radians, digits=3), *([", ".join(free)] if moving else [])]
        for i, (theta, free) in enumerate(zip(solutions.theta[:ROWS_SHOWN], solutions.free, strict=False))
    ]
    heads = [f"{name} {unit}" for name, unit in zip(arm.joint_names, units(arm, radians), strict=True)]
    more = f", the {ROWS_SHOWN} nearest of them (-o FILE.csv has all)" if count > ROWS_SHOWN else ", nearest first"
    title = f"{arm.name}: {count} configuration{'s' * (count != 1)}{more if count > 1 else ''}"
    last = ["may go on moving"] if moving else []
    return table(title, ["", *heads, *last], rows, text=last)


def _as_json(solutions: IKSolutions) -> dict[str, Any]:
    fields = ("theta", "free", "outside", "complete", "timed_out", "method", "family", "starts", "hits")
    return {
        "arm": solutions.arm.name,
        "joint_names": solutions.arm.joint_names,
        **{field: getattr(solutions, field) for field in fields},
        "position_error": solutions.position_error,
        "orientation_error": solutions.orientation_error,
        "explanation": in_options(solutions.explain()),
    }


def all_csv(solutions: IKSolutions) -> str:
    """All configurations as CSV, also outside the limits: theta, free joints, inside or not.

    Members of one family share a number.
    """
    arm = solutions.arm
    joints = [f"{name} [{unit}]" for name, unit in zip(arm.joint_names, arm.units, strict=True)]
    free = (*solutions.free, *((),) * len(solutions.outside))
    families = (*solutions.members, *solutions.outside[:, None])
    rows = (
        [i + 1, *each.tolist(), " ".join(moving), "no" if i >= len(solutions) else "yes"]
        for i, (members, moving) in enumerate(zip(families, free, strict=True))
        for each in members
    )
    return csv_text(["number", *joints, "free", "within_limits"], rows)
