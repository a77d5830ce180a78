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
from ..output import console, number, print_json, progress_bar, table
from ..outputs import STDOUT, Force, Output, outputs_of
from ..typed import parse_numbers

KINDS = {"npz": (".npz",), "png": (".png",), "ply": (".ply",)}

Voxel = Annotated[float, typer.Option(metavar="M", help="Side of a cube, in metres.")]
Directions = Annotated[
    str, typer.Option(metavar="WHICH", help="down, position (any orientation), 26 all around, or 'X Y Z' in base axes.")
]
Method = Annotated[
    str, typer.Option(metavar="ik|fk", help="Exact by ik, or a first look by random configurations, fk.")
]
Resume = Annotated[
    Path | None, typer.Option(metavar="FOLDER", help="Keep what is done in files there, and go on from them.")
]
Workers = Annotated[int | None, typer.Option(min=1, help="Threads; else one per processor.")]


@takes_arm
def reach(
    arm: Arm,
    voxel: Voxel = 0.05,
    directions: Directions = "down",
    avoid: Avoid = None,
    method: Method = "ik",
    resume: Resume = None,
    workers: Workers = None,
    output: Output = None,
    force: Force = False,
    json: Json = False,
) -> int:
    """Map which places and directions of the tool the arm reaches; -o writes the map as .npz, .png or .ply."""
    outputs = outputs_of(output, KINDS, force=force, json=json)
    if any(name == STDOUT for _, name in outputs.files):
        raise InputError("-o takes a file that ends in .npz, .png or .ply; a map is no text for standard output")
    scene = avoided(arm, avoid)
    with progress_bar("reach") as progress:
        found = reach_map(arm, voxel, _directions(directions), scene=scene, method=method, workers=workers,
                          folder=resume, progress=progress)  # fmt: skip
    for kind, name in outputs.files:
        {"npz": found.save, "png": found.to_png, "ply": found.to_ply}[kind](name)
    figures = _figures(found)
    if json:
        content = {name: value for name, _, value in figures}
        print_json({"arm": arm.name, "frame": found.frame, "voxel": voxel, "directions": found.directions} | content)
    else:
        rows = [[label, " ".join(map(number, np.ravel(value)))] for _, label, value in figures]
        title = (
            f"{arm.name}: reach from {found.frame}, cubes of {voxel:g} m, {max(len(found.directions), 1)} directions"
        )
        console().print(table(title, ["", ""], rows))
        outputs.say([name for _, name in outputs.files])
    return 0 if found.counts.any() else 1


def _directions(typed: str) -> Any:
    if typed in ("down", "position", "26"):
        return 26 if typed == "26" else typed
    return parse_numbers(typed, 3, "--directions")


def _figures(found: ReachMap) -> list[tuple[str, str, Any]]:
    """The figures of a map: their names, labels and values."""
    grid, counts = found.grid, found.counts.reshape(-1)
    cells = np.flatnonzero(counts)
    centres = grid.centres(cells)
    best = cells[np.lexsort((found.manipulability.reshape(-1)[cells], counts[cells]))[-1:]]
    return [
        ("cubes", "cubes", grid.count),
        ("reached", "cubes reached", len(cells)),
        ("volume", "volume reached [m³]", found.volume),
        ("volume_all", "in all directions [m³]", np.count_nonzero(found.share == 1.0) * grid.voxel**3),
        ("lowest", "from x y z [m]", centres.min(axis=0, initial=np.inf)),
        ("highest", "to x y z [m]", centres.max(axis=0, initial=-np.inf)),
        ("best", "best cube at x y z [m]", grid.centres(best)),
        ("share", "its share of the directions", found.share.reshape(-1)[best]),
        ("manipulability", "its manipulability", found.manipulability.reshape(-1)[best]),
        ("margin", "its distance from limits [rad, m]", found.margin.reshape(-1)[best]),
    ]
