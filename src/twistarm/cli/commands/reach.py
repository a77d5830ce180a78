"""`reach`: a map of what the arm reaches, as a table and as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...support.errors import InputError
from ...sweeps import ReachMap, reach_map
from ..options import ArmArgument, Avoid, Json, avoided
from ..output import progress_bar
from ..outputs import STDOUT, Force, outputs_of, repeated
from ..quantities import quantity, whole
from ..tables import Column, Table, number
from ..typed import parse_numbers

KINDS = {"npz": (".npz",), "png": (".png",)}

WORDS: dict[str, Any] = {"down": "down", "position": "position", "26": 26}

Files = Annotated[list[str] | None, repeated("The map to *.npz, slices to *.png")]
Voxel = Annotated[float, quantity("m", "Side of a cube.")]
Directions = Annotated[
    str, typer.Option(metavar="WHICH", help="down, position (in any orientation), 26 (all around) or 'X Y Z'.")
]
Method = Annotated[str, typer.Option(metavar="ik|fk", help="ik is exact; fk, by random configurations, a first look.")]
Resume = Annotated[Path | None, typer.Option(metavar="FOLDER", help="Keep what is done there, and go on from it.")]
Workers = Annotated[int | None, whole(1, 1024, "Threads; else one per processor.")]


def reach(
    source: ArmArgument,
    voxel: Voxel = 0.05,
    directions: Directions = "down",
    avoid: Avoid = None,
    method: Method = "ik",
    resume: Resume = None,
    workers: Workers = None,
    output: Files = None,
    force: Force = False,
    json: Json = False,
) -> int:
    """Map where the arm brings its tool, and in which directions; -o writes the map as .npz or .png."""
    arm = source.load()
    out = outputs_of(output, KINDS, force=force, json=json)
    if any(name == STDOUT for _, name in out.files):
        raise InputError("a map is no text for standard output: -o takes a file that ends in .npz or .png")
    try:
        towards = WORDS[directions] if directions in WORDS else parse_numbers(directions, "1 1 1", "--directions")
    except InputError as error:
        allowed = f"{', '.join(WORDS)} or three numbers, as in '0 0 -1'"
        raise InputError(f"--directions takes {allowed}; got {directions!r}") from error
    how: dict[str, Any] = {"method": method, "scene": avoided(arm, avoid), "workers": workers, "folder": resume}
    with progress_bar("reach") as progress:
        found = reach_map(arm, voxel, towards, **how, progress=progress)
    for kind, name in out.files:
        {"npz": found.save, "png": found.to_png}[kind](name)
    figures = _figures(found)
    columns = [
        Column("", [name.replace("_", " ") for name in figures]),
        Column("", [" ".join(map(number, np.ravel(value))) for value, _ in figures.values()]),
        Column("unit", [unit for _, unit in figures.values()]),
    ]
    nothing = "nothing is reached in these directions; --directions position leaves them free"
    out.show(
        {"arm": arm, "frame": found.frame, "voxel": voxel, "directions": found.directions}
        | {name: value for name, (value, _) in figures.items()},
        Table(f"{arm.name}: reach in the frame {found.frame}, cubes of {voxel:g} m", columns),
        *([] if found.counts.any() else [nothing]),
        written=[name for _, name in out.files],
    )
    return 0 if found.counts.any() else 1


def _figures(found: ReachMap) -> dict[str, tuple[Any, str]]:
    """The figures of a map with their units."""
    grid, cells = found.grid, np.flatnonzero(found.counts)
    figures: dict[str, tuple[Any, str]] = {
        "cubes": (grid.count, ""), "reached": (len(cells), ""), "volume": (found.volume, "m³"),
    }  # fmt: skip
    if not len(cells):
        return figures
    if len(found.directions) > 1:
        figures["volume_in_all_directions"] = np.count_nonzero(found.share == 1.0) * grid.voxel**3, "m³"
    centres = np.round(grid.centres(cells), 9)
    share, measure, margin = (x.reshape(-1)[cells] for x in (found.share, found.manipulability, found.margin))
    i = np.lexsort((measure, share))[-1]
    return figures | {
        "lowest_x_y_z": (centres.min(axis=0), "m"), "highest_x_y_z": (centres.max(axis=0), "m"),
        "best_at_x_y_z": (centres[i], "m"), "best_share": (share[i], ""),
        "best_manipulability": (measure[i], ""), "best_margin": (margin[i], "rad or m"),
    }  # fmt: skip
