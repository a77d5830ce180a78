"""`check` and `freeze`: the regression for a team's own arm."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...checking.crosscheck import CrossCheck, crosscheck
from ...checking.difference import Difference, compare
from ...checking.golden_file import NOT_COVERED, golden_text
from ..avoiding import SELF, avoided
from ..options import Json, takes_arm, takes_source
from ..output import console, note, print_json, progress_bar, say, table
from ..outputs import STDOUT, Force, Output, outputs_of
from ..quantities import whole

Against = Annotated[
    str | None,
    typer.Option(metavar="FILE", help="A golden file, a baked arm or another ARM: say what differs from it."),
]
WORDS_SINCE = ("unchanged since", "CHANGED since", "changed")
WORDS_AGAINST = ("the same as", "DIFFERENT from", "different")

Samples = Annotated[int, whole(1, 1_000_000, "Random configurations to compare at.")]


@takes_source
def check(
    source: str, load: dict[str, Any], samples: Samples = 1000, against: Against = None, json: Json = False
) -> int:
    """Compare product of exponentials, Pinocchio, yourdfpy and MuJoCo; --against lists changes."""
    arm = load_arm(source, **load)
    difference = None if against is None else compare(arm, against)
    with progress_bar("cross-check") as progress:
        result = crosscheck(arm, samples, progress=progress)
    if json:
        print_json(_as_json(result, difference))
    else:
        _print(result, difference, against)
    for each in difference.notes if difference else ():
        note(each)
    return 0 if _good(result, difference) else 1


def _good(result: CrossCheck, difference: Difference | None) -> bool:
    return result.ok and (difference is None or difference.same)


def verdict(result: CrossCheck) -> str:
    """What the rows come to, in one line."""
    silent = [engine for engine in result.left_out if engine in ("pinocchio", "yourdfpy", "mujoco")]
    agree = f"the engines agree, but {' and '.join(silent)} compared nothing" if silent else "all engines agree"
    return f"{result.arm}: {agree if result.ok else 'THE ENGINES DISAGREE'}"


def _print(result: CrossCheck, difference: Difference | None, against: str | None) -> None:
    """The verdict first, then what has changed, then the rows."""
    if difference is None:
        say(verdict(result))
    else:
        # A .json is the arm as it was; anything else is another arm.
        same, other, change = WORDS_SINCE if str(against).endswith(".json") else WORDS_AGAINST
        say(f"{verdict(result)}; {same if difference.same else other} {against}")
        for words in difference.changes:
            say(f"{change}: {words}")
    console().print(check_table(result))


Collisions = Annotated[
    bool, typer.Option("--collisions", help="Keep how often each pair of links collides, to notice changed shapes.")
]


@takes_arm
def freeze(arm: Arm, collisions: Collisions = False, output: Output = None, force: Force = False) -> None:
    """Write a golden file: names, screws, home, limits, motors and masses; --collisions adds pairs of links."""
    scene = avoided(arm, SELF) if collisions else None
    outputs = outputs_of(output or f"{Path(arm.name).name}.golden.json", {"json": (".json",)}, force=force)
    for name in outputs.write({"json": lambda: golden_text(arm, scene)}):
        if name != STDOUT:
            later = f"later, with the same ARM and options: twistarm check … --against {name}"
            say(f"{name}: {arm.name} frozen; {later}", file=outputs.words)
            say(f"not covered: {', '.join(NOT_COVERED)}", file=outputs.words)


def check_table(result: CrossCheck) -> Any:
    """The comparisons as a table."""
    rows = [
        [
            row.quantity,
            " / ".join(row.engines),
            f"not compared: {row.not_compared}" if row.not_compared else f"{row.worst:.1e}",
            "" if row.not_compared else f"{row.tolerance:.0e}",
            "" if row.not_compared else str(row.samples),
            "" if row.not_compared else "ok" if row.ok else "WRONG",
        ]
        for row in result.comparisons
    ]
    columns = ["quantity", "engines", "worst difference", "allowed", "configurations", ""]
    return table("", columns, rows, text=columns)


def _as_json(result: CrossCheck, difference: Difference | None) -> dict[str, Any]:
    content: dict[str, Any] = {
        "arm": result.arm,
        "ok": _good(result, difference),
        "comparisons": [vars(row) | {"ok": row.ok} for row in result.comparisons],
    }
    if difference is not None:
        content |= {
            "unchanged": difference.same,
            "changes": difference.changes,
            "notes": difference.notes,
            "not_covered": NOT_COVERED,
            "pose_error": difference.pose_error,
            "jacobian_error": difference.jacobian_error,
        }
    return content
