"""`dh`: the arm's Denavit–Hartenberg table."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.loading.from_dh import PARALLEL, dh_csv, dh_rows, to_dh
from ...description.dh import DhTable
from ..options import Json, Radians, takes_arm
from ..output import console, note, number, print_json, say, table
from ..outputs import Force, Output, outputs_of
from ..typed import parse_numbers

FAR = 10.0
"""A row so many times longer than the arm's reach comes from axes that are nearly parallel."""

ROWS = {"standard": "R_z(θ) T_z(d) T_x(a) R_x(α)", "modified": "R_x(α) T_x(a) R_z(θ) T_z(d)"}

Convention = Annotated[
    str, typer.Option(metavar="standard|modified", help="That of Paul, Spong and Siciliano, or of Craig.")
]
Parallel = Annotated[
    str | None,
    typer.Option(metavar="ANGLE", help="Axes within this count as parallel [°, or rad with --rad]; 1e-7 rad."),
]


@takes_arm
def dh(
    arm: Arm,
    convention: Convention = "standard",
    parallel: Parallel = None,
    output: Output = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Show the arm's Denavit–Hartenberg table, or write it as a *.csv that is an ARM too."""
    outputs = outputs_of(output, {"csv": (".csv",)}, force=force, json=json)
    (angle,) = [PARALLEL] if parallel is None else parse_numbers(parallel, "rad", "--parallel", rad)
    found = to_dh(arm, convention, float(angle))
    if parallel is None and np.abs(found.rows[:, [0, 2]]).max() > FAR * arm.reach:
        note("axes that are nearly parallel meet far away; with --parallel 0.01deg they count as parallel")
    written = outputs.write({"csv": lambda: dh_csv(found)})
    if json:
        told = {name: getattr(found, name) for name in ("convention", "base", "tool", "residual")}
        print_json({"arm": arm.name, **told, "rows": dh_rows(found), "written": written})
        return
    console(outputs.words).print(_table(arm, found, rad))
    say(f"the table differs from the arm by {found.residual:.1g} m or rad at most", file=outputs.words)
    outputs.say(written)


def _table(arm: Arm, found: DhTable, radians: bool) -> Any:
    """The table, with base and tool as fixed rows."""
    angle, of_rad = ("rad", 1.0) if radians else ("°", float(np.degrees(1.0)))
    columns = {"a": 1.0, "alpha": of_rad, "d": 1.0, "theta": of_rad}
    rows = [
        [row["joint"], row["type"], *(number(row[name] * factor, 6) for name, factor in columns.items())]
        for row in dh_rows(found)
    ]
    heads = ["joint", "type", "a [m]", f"alpha [{angle}]", "d [m]", f"theta [{angle}]"]
    caption = f"a row is {ROWS[found.convention]}; a joint adds its coordinate to theta, or to d if it is prismatic"
    return table(f"{arm.name}: {found.convention} convention", heads, rows, ["type"], caption)
