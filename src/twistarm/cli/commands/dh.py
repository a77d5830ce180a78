"""`dh`: the arm's Denavit–Hartenberg table."""

from __future__ import annotations

from typing import Annotated

import typer

from ...arm.loading.from_dh import PARALLEL, dh_csv, dh_rows, to_dh
from ...description.dh import PARAMETERS
from ..numbers import quantity
from ..options import ArmArgument, CsvAnswer
from ..output import entries
from ..tables import Column, Table

ROWS = {"standard": "R_z(θ) T_z(d) T_x(a) R_x(α)", "modified": "R_x(α) T_x(a) R_z(θ) T_z(d)"}

Convention = Annotated[
    str, typer.Option(metavar="standard|modified", help="That of Paul, Spong and Siciliano, or of Craig.")
]
Parallel = Annotated[
    float | None,
    quantity("rad", "Axes within this count as parallel; others meet far away [°, or rad with --rad]; 1e-7 rad."),
]


def dh(source: ArmArgument, out: CsvAnswer, convention: Convention = "standard", parallel: Parallel = None) -> None:
    """Show the arm's Denavit–Hartenberg table, or write it as a *.csv that is an ARM too."""
    arm = source.load()
    found = to_dh(arm, convention, PARALLEL if parallel is None else parallel)
    rows = dh_rows(found)
    columns = [
        Column("joint", [row["joint"] for row in rows]),
        Column("type", [row["type"] for row in rows]),
        *(Column(name, [row[name] for row in rows], unit, digits=6, key=name) for name, unit in PARAMETERS.items()),
    ]
    caption = f"a row is {ROWS[found.convention]}; a joint adds its coordinate to theta, or to d if it is prismatic"
    out.show(
        {"arm": arm, **entries(found, "convention base tool residual")},
        Table(f"{arm.name}: {found.convention} convention", columns, "rows"),
        caption,
        f"the table differs from the arm by {found.residual:.1g} m or rad at most",
        files={"csv": lambda: dh_csv(found)},
    )
