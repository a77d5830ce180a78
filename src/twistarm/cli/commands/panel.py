"""`panel`: the tasks of a panel, where the rover parks for them, and the motions."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from ...design import PanelReport, best_parking, check_panel, load_panel
from ...theory.rotations import to_rpy
from ..numbers import PLACE, numbers, quantity
from ..options import ArmArgument, Avoid, answers, avoided
from ..output import Outputs, note, progress_bar
from ..tables import Column, Table, number, quantity_text, unit_text
from .motion import MOTION_KINDS, MaxTime, Step, Unwrap, motion_texts

PanelFile = Annotated[Path, typer.Argument(metavar="PANEL", help="A panel.toml with tasks, and where to park.")]
BasePose = Annotated[
    Any, numbers("m m rad", PLACE, "Check x, y [m] and yaw [°, or rad with --rad] instead of a search.")
]
Speed = Annotated[float | None, quantity("m/s", "The tool goes no faster in the motion of -o.")]
Files = Annotated[
    Outputs,
    answers(
        "output force rad json",
        MOTION_KINDS,
        output="One motion through all tasks that are done, as plan writes it; repeat it.",
    ),
]


def panel(
    source: ArmArgument,
    file: PanelFile,
    out: Files,
    base_pose: BasePose = None,
    avoid: Avoid = None,
    linear_speed: Speed = None,
    unwrap: Unwrap = False,
    max_time: MaxTime = 5.0,
    dt: Step = 0.01,
) -> int:
    """Tell which tasks of a panel the arm does, why it fails at others, and where the rover parks best."""
    arm = source.load()
    rad = out.radians
    asked = load_panel(file)
    scene = avoided(arm, avoid)
    with progress_bar("tasks") as progress:
        if base_pose is None:
            found = best_parking(arm, asked, scene, progress)
        else:
            x, y, yaw = base_pose.tolist()
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
