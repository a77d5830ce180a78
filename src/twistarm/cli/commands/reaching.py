"""`reach`: a map of what the arm reaches, as a table and as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...support.errors import InputError
from ...sweeps import ReachMap, reach_map
from ..avoiding import Avoid, avoided
from ..options import Json, takes_arm
from ..output import console, number, print_json, progress_bar, say, table
from ..outputs import STDOUT, Force, outputs_of, repeated
from ..quantities import quantity, whole
from ..typed import parse_numbers

KINDS = {"npz": (".npz",), "png": (".png",), "ply": (".ply",)}

WORDS: dict[str, Any] = {"down": "down", "position": "position", "26": 26}

UNITS = {"volume": "m³", "lowest": "m", "highest": "m", "best at": "m", "best margin": "rad or m"}
"""Units of the figures, by how their names begin."""

Files = Annotated[list[str] | None, repeated("The map to *.npz, slices to *.png, a cloud to *.ply")]
Voxel = Annotated[float, quantity("m", "Side of a cube.")]
Directions = Annotated[
    str, typer.Option(metavar="WHICH", help="down, position (in any orientation), 26 (all around) or 'X Y Z'.")
]
Method = Annotated[str, typer.Option(metavar="ik|fk", help="ik is exact; fk, by random configurations, a first look.")]
Resume = Annotated[Path | None, typer.Option(metavar="FOLDER", help="Keep what is done there, and go on from it.")]
Workers = Annotated[int | None, whole(1, 1024, "Threads; else one per processor.")]


@takes_arm
def reach(
    arm: Arm,
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
    """Map where the arm brings its tool, and in which directions; -o writes the map as .npz, .png or .ply."""
    outputs = outputs_of(output, KINDS, force=force, json=json)
    if any(name == STDOUT for _, name in outputs.files):
        raise InputError("a map is no text for standard output: -o takes a file that ends in .npz, .png or .ply")
    towards = WORDS[directions] if directions in WORDS else _direction(directions)
    how: dict[str, Any] = {"method": method, "scene": avoided(arm, avoid), "workers": workers, "folder": resume}
    with progress_bar("reach") as progress:
        found = reach_map(arm, voxel, towards, **how, progress=progress)
    for kind, name in outputs.files:
        {"npz": found.save, "png": found.to_png, "ply": found.to_ply}[kind](name)
    figures = _figures(found)
    if json:
        print_json({"arm": arm.name, "frame": found.frame, "voxel": voxel, "directions": found.directions} | figures)
        return 0 if found.counts.any() else 1
    rows = [[name.replace("_", " "), " ".join(map(number, np.ravel(value)))] for name, value in figures.items()]
    rows = [[*row, next((unit for begin, unit in UNITS.items() if row[0].startswith(begin)), "")] for row in rows]
    title = f"{arm.name}: reach in the frame {found.frame}, cubes of {voxel:g} m"
    console().print(table(title, ["", "", "unit"], rows, ["unit"]))
    if not found.counts.any():
        say("nothing is reached in these directions; --directions position leaves them free")
    outputs.say([name for _, name in outputs.files])
    return 0 if found.counts.any() else 1


def _direction(typed: str) -> Any:
    try:
        return parse_numbers(typed, "1 1 1", "--directions")
    except InputError as error:
        raise InputError(
            f"--directions takes {', '.join(WORDS)} or three numbers, as in '0 0 -1'; got {typed!r}"
        ) from error


def _figures(found: ReachMap) -> dict[str, Any]:
    """The figures of a map."""
    grid, counts = found.grid, found.counts.reshape(-1)
    cells = np.flatnonzero(counts)
    figures = {"cubes": grid.count, "reached": len(cells), "volume": found.volume}
    if not len(cells):
        return figures
    centres = np.round(grid.centres(cells), 9)
    i = np.lexsort((found.manipulability.reshape(-1)[cells], counts[cells]))[-1]
    if len(found.directions) > 1:
        figures["volume_in_all_directions"] = np.count_nonzero(found.share == 1.0) * grid.voxel**3
    return figures | {
        "lowest_x_y_z": centres.min(axis=0),
        "highest_x_y_z": centres.max(axis=0),
        "best_at_x_y_z": centres[i],
        "best_share": found.share.reshape(-1)[cells[i]],
        "best_manipulability": found.manipulability.reshape(-1)[cells[i]],
        "best_margin": found.margin.reshape(-1)[cells[i]],
    }
