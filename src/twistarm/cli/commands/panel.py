"""`panel`: the tasks of a panel, where the rover parks for them, and the motions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...design import PanelReport, best_parking, check_panel, load_panel
from ...theory.rotations import to_rpy
from ..command import PLACE
from ..options import ArmArgument, Avoid, Json, Radians, avoided
from ..output import note, progress_bar
from ..outputs import Force, outputs_of, repeated
from ..quantities import quantity
from ..tables import Column, Table, number, quantity_text, unit_text
from ..typed import parse_numbers
from .motion import MOTION_KINDS, MaxTime, Step, Unwrap, motion_texts

PanelFile = Annotated[Path, typer.Argument(metavar="PANEL", help="A panel.toml with tasks, and where to park.")]
BasePose = Annotated[
    str | None,
    typer.Option(
        "--base-pose", metavar=PLACE, help="Check x, y [m] and yaw [°, or rad with --rad] instead of a search."
    ),
]
Speed = Annotated[float | None, quantity("m/s", "The tool goes no faster in the motion of -o.", "--linear-speed")]
Files = Annotated[list[str] | None, repeated("One motion through all tasks that are done, as plan writes it")]


def panel(
    source: ArmArgument,
    file: PanelFile,
    base_pose: BasePose = None,
    avoid: Avoid = None,
    linear_speed: Speed = None,
    unwrap: Unwrap = False,
    max_time: MaxTime = 5.0,
    output: Files = None,
    force: Force = False,
    dt: Step = 0.01,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Tell which tasks of a panel the arm does, why it fails at others, and where the rover parks best."""
    arm = source.load()
    out = outputs_of(output, MOTION_KINDS, force=force, json=json, radians=rad)
    asked = load_panel(file)
    place = None if base_pose is None else parse_numbers(base_pose, "m m rad", "--base-pose", rad)
    scene = avoided(arm, avoid)
    with progress_bar("tasks") as progress:
        if place is None:
            found = best_parking(arm, asked, scene, progress)
        else:
            x, y, yaw = place.tolist()
            found = check_panel(arm, asked, asked.base_at(x, y, yaw), scene, progress)
    x, y, z = found.base[:3, 3].tolist()
    yaw = float(to_rpy(found.base[:3, :3])[2])
    done, count = len(found.done), len(found.results)
    typed = " ".join([quantity_text(x, "m", rad), quantity_text(y, "m", rad), quantity_text(yaw, "rad", rad, 6)])
    missed = [f"{each.task.name}, {each.code}: {each.why}" for each in found.results if each.code != "done"]
    sentence = f'{done} of {count} tasks are done with the arm\'s base at --base-pose "{typed}"' + " --rad" * rad
    written: list[str] = []
    try:
        if out.files and not found.done:
            note("no task is done, so no motion is written")
        elif out.files:
            with progress_bar("planning") as progress:
                motion = found.motion(linear_speed=linear_speed, unwrap=unwrap, max_time=max_time, progress=progress)
            for each in motion.notes:
                note(each, radians=rad)
            written = out.write(motion_texts(arm, motion, out, dt))
    finally:  # the answer is good where the motion fails
        data = {"arm": arm, "done": done, "share": done / count, "base": {"x": x, "y": y, "z": z, "yaw": yaw}}
        out.show(data | {"places": found.places}, _table(found, rad), *missed, sentence, written=written)
    return int(done < count)


def _table(found: PanelReport, radians: bool) -> Table:
    results = found.results
    unit_of = dict(zip(found.arm.joint_names, found.arm.units, strict=True))
    nearest = []
    for each in results:
        unit = unit_of.get(each.joint, "")
        margin = f"{each.joint} {quantity_text(each.margin, unit, radians)} {unit_text(unit, radians)}"
        nearest.append(margin if each.code == "done" else "")
    millimetres = [number(1e3 * each.clearance, 1) if each.code == "done" else "" for each in results]
    columns = [
        Column("task", [each.task.name for each in results]),
        Column("kind", [each.task.kind for each in results]),
        Column("code", [each.code for each in results]),
        Column("why", [each.why for each in results], people=False),
        Column("nearest limit", [each.joint for each in results], text=nearest, key="joint"),
        Column("margin", [each.margin for each in results], people=False),
        Column("condition", [each.condition for each in results], digits=1),
        Column("clearance", [each.clearance for each in results], "mm", text=millimetres),
        Column("theta", [each.theta[:1] for each in results], people=False),
    ]
    return Table(f"{found.arm.name}: tasks of the panel", columns, "tasks")
