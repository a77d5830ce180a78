"""`reach`: a map of what the arm reaches, as a table and as files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...support.errors import InputError
from ...sweeps import ReachMap, reach_map
from ..numbers import parse_numbers, quantity, whole
from ..options import ArmArgument, Avoid, answers, avoided
from ..output import STDOUT, Outputs, progress_bar
from ..tables import Column, Table, number

KINDS = {"npz": (".npz",), "png": (".png",), "ply": (".ply",)}

WORDS: dict[str, Any] = {"down": "down", "position": "position", "26": 26}

Files = Annotated[
    Outputs,
    answers("output force json", KINDS, output="The map to *.npz, slices to *.png, a cloud to *.ply; repeat it."),
]
Voxel = Annotated[float, quantity("m", "Side of a cube.")]
Directions = Annotated[
    str, typer.Option(metavar="WHICH", help="down, position (in any orientation), 26 (all around) or 'X Y Z'.")
]
Method = Annotated[str, typer.Option(metavar="ik|fk", help="ik is exact; fk, by random configurations, a first look.")]
Resume = Annotated[Path | None, typer.Option(metavar="FOLDER", help="Keep what is done there, and go on from it.")]
Workers = Annotated[int | None, whole(1, 1024, "Threads; else one per processor.")]


def reach(
    source: ArmArgument,
    out: Files,
    voxel: Voxel = 0.05,
    directions: Directions = "down",
    avoid: Avoid = None,
    method: Method = "ik",
    resume: Resume = None,
    workers: Workers = None,
) -> int:
    """Map where the arm brings its tool, and in which directions; -o writes the map as .npz, .png or .ply."""
    arm = source.load()
    if any(name == STDOUT for _, name in out.files):
        raise InputError("a map is no text for standard output: -o takes a file that ends in .npz, .png or .ply")
    towards = WORDS[directions] if directions in WORDS else _direction(directions)
    how: dict[str, Any] = {"method": method, "scene": avoided(arm, avoid), "workers": workers, "folder": resume}
    with progress_bar("reach") as progress:
        found = reach_map(arm, voxel, towards, **how, progress=progress)
    for kind, name in out.files:
        {"npz": found.save, "png": found.to_png, "ply": found.to_ply}[kind](name)
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


def _direction(typed: str) -> Any:
    try:
        return parse_numbers(typed, "1 1 1", "--directions")
    except InputError as error:
        raise InputError(
            f"--directions takes {', '.join(WORDS)} or three numbers, as in '0 0 -1'; got {typed!r}"
        ) from error


def _figures(found: ReachMap) -> dict[str, tuple[Any, str]]:
    """The figures of a map with their units."""
    grid, counts = found.grid, found.counts.reshape(-1)
    cells = np.flatnonzero(counts)
    figures: dict[str, tuple[Any, str]] = {
        "cubes": (grid.count, ""), "reached": (len(cells), ""), "volume": (found.volume, "m³"),
    }  # fmt: skip
    if not len(cells):
        return figures
    centres = np.round(grid.centres(cells), 9)
    i = np.lexsort((found.manipulability.reshape(-1)[cells], counts[cells]))[-1]
    if len(found.directions) > 1:
        figures["volume_in_all_directions"] = np.count_nonzero(found.share == 1.0) * grid.voxel**3, "m³"
    return figures | {
        "lowest_x_y_z": (centres.min(axis=0), "m"),
        "highest_x_y_z": (centres.max(axis=0), "m"),
        "best_at_x_y_z": (centres[i], "m"),
        "best_share": (found.share.reshape(-1)[cells[i]], ""),
        "best_manipulability": (found.manipulability.reshape(-1)[cells[i]], ""),
        "best_margin": (found.margin.reshape(-1)[cells[i]], "rad or m"),
    }
