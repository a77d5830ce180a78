"""`panel`: the tasks of a panel, where the rover parks for them, and the motions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...design import PanelReport, best_parking, check_panel, load_panel
from ...support.pictures import empty_figure, png_of
from ...theory.rotations import to_rpy
from ..avoiding import Avoid, avoided
from ..options import Json, Radians, takes_arm
from ..output import console, note, number, print_json, progress_bar, say, table
from ..outputs import Force, Outputs, outputs_of, repeated
from ..quantities import quantity
from ..typed import PLACE, parse_numbers
from .motion import MOTION_KINDS, MaxTime, Step, Unwrap, motion_texts

PanelFile = Annotated[Path, typer.Argument(metavar="PANEL", help="A panel.toml with tasks, and where to park.")]
BasePose = Annotated[
    str | None,
    typer.Option(
        "--base-pose", metavar=PLACE, help="Check x, y [m] and yaw [°, or rad with --rad] instead of a search."
    ),
]
Speed = Annotated[float | None, quantity("m/s", "The tool goes no faster in the motion of -o.", "--linear-speed")]
Files = Annotated[list[str] | None, repeated("A picture to *.png, the motion as plan does")]

DONE, MISSED = "#0072b2", "#d55e00"
"""Colours that most people tell apart (Okabe & Ito)."""


@takes_arm
def panel(
    arm: Arm,
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
    outputs = outputs_of(output, {"png": (".png",), **MOTION_KINDS}, force=force, json=json)
    how = {"linear_speed": linear_speed, "unwrap": unwrap, "max_time": max_time}
    asked = load_panel(file)
    place = None if base_pose is None else parse_numbers(base_pose, "m m rad", "--base-pose", rad)
    scene = avoided(arm, avoid)
    with progress_bar("tasks") as progress:
        if place is None:
            found = best_parking(arm, asked, scene, progress)
        else:
            x, y, yaw = place.tolist()
            base = asked.base_at(x, y, yaw)
            found = check_panel(arm, asked, base, scene, progress)
    if not json:
        console(outputs.words).print(_table(found, rad))
        missed = [f"{each.task.name}, {each.code}: {each.why}" for each in found.results if each.code != "done"]
        say(*missed, _sentence(found, rad), file=outputs.words)
    written: list[str] = []
    try:
        for names in _write(found, outputs, dt, how, rad):
            written += names
    finally:
        if json:
            print_json(_as_json(found) | {"written": written})
        else:
            outputs.say(written)
    return int(len(found.done) < len(found.results))


def _write(found: PanelReport, outputs: Outputs, dt: float, how: dict[str, Any], radians: bool) -> Iterator[list[str]]:
    """Write the pictures, then the motion, which may fail. Yields the names of what is written."""
    pictures = replace(outputs, files=tuple(each for each in outputs.files if each[0] == "png"))
    motions = replace(outputs, files=tuple(each for each in outputs.files if each[0] != "png"))
    yield pictures.write({"png": lambda: _picture(found)})
    if motions.files and not found.done:
        note("no task is done, so no motion is written")
    elif motions.files:
        with progress_bar("planning") as progress:
            motion = found.motion(**how, progress=progress)
        for each in motion.notes:
            note(each, radians=radians)
        yield motions.write(motion_texts(found.arm, motion, motions, dt))


def _table(found: PanelReport, radians: bool) -> Any:
    rows = []
    for each in found.results:
        nearest = ""
        if each.code == "done":
            unit = found.arm.units[found.arm.joint_names.index(each.joint)]
            turns = unit == "rad" and not radians
            margin = number(np.degrees(each.margin) if turns else each.margin, 2)
            nearest = f"{each.joint} {margin}{'°' if turns else f' {unit}'}"
        measured = [number(value, 1) if nearest else "" for value in (each.condition, 1e3 * each.clearance)]
        rows.append([each.task.name, each.task.kind, each.code, nearest, *measured])
    heads = ["task", "kind", "verdict", "nearest limit", "condition", "clearance [mm]"]
    return table(f"{found.arm.name}: tasks of the panel", heads, rows, heads[1:4])


def _base(found: PanelReport) -> dict[str, float]:
    x, y, z = found.base[:3, 3]
    return {"x": x, "y": y, "z": z, "yaw": to_rpy(found.base[:3, :3])[2]}


def _sentence(found: PanelReport, radians: bool) -> str:
    x, y, _, yaw = _base(found).values()
    typed = " ".join(number(value, 4) for value in (x, y, yaw if radians else np.degrees(yaw)))
    done = f"{len(found.done)} of {len(found.results)} tasks are done"
    return f'{done} with the arm\'s base at --base-pose "{typed}"' + " --rad" * radians


def _as_json(found: PanelReport) -> dict[str, Any]:
    tasks = [
        vars(one) | {"task": one.task.name, "kind": one.task.kind, "theta": one.theta[:1]} for one in found.results
    ]
    share = {"done": len(found.done), "share": len(found.done) / len(tasks)}
    return {"arm": found.arm.name, **share, "base": _base(found), "tasks": tasks}


def _picture(report: PanelReport) -> bytes:
    """A PNG: the parking poses from above with their numbers of tasks, and the panel from the front.

    Raises MissingExtraError without matplotlib.
    """
    figure, panel = empty_figure("a picture of a panel", figsize=(11, 5)), report.panel
    top, front = figure.subplots(1, 2, width_ratios=(2, 3))
    if len(report.places):
        x, y, _, count = report.places[report.places[:, 3].argsort(kind="stable")].T
        dots = top.scatter(x, y, c=count, s=12, marker="s", vmin=0, vmax=len(panel.tasks), cmap="Greys")
        figure.colorbar(dots, ax=top, label="tasks within reach, at the best yaw")
    (x, y), (ahead, aside) = report.base[:2, 3], 0.25 * report.base[:2, 0]
    top.quiver(x, y, ahead, aside, angles="xy", scale_units="xy", scale=1.0, color=DONE, zorder=3)
    top.plot(x, y, "o", color=DONE, label="the arm's base")
    width, height = (1.0, 1.0) if panel.size is None else panel.size[:2]
    wall = panel.pose[:2, 3] + 0.5 * width * np.outer([-1.0, 1.0], panel.pose[:2, 0])
    top.plot(*wall.T, color="black", lw=3, label="the panel")
    top.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="from above")
    if panel.size is not None:
        across, up = 0.5 * width * np.array([-1, 1, 1, -1, -1]), 0.5 * height * np.array([-1, -1, 1, 1, -1])
        front.plot(across, up, color="black", lw=1)
    for result in report.results:
        place, colour = result.task.place[:2], DONE if result.code == "done" else MISSED
        front.plot(*place, "o" if colour == DONE else "X", color=colour)
        same = [one.task.name for one in report.results if np.allclose(one.task.place[:2], place)]
        if result.task.name == same[0]:
            how = {"textcoords": "offset points", "rotation": 35, "fontsize": 8, "parse_math": False}
            front.annotate(", ".join(same), place, xytext=(3, 3), color=colour, **how)
    front.set(xlabel="x of the panel [m]", ylabel="y of the panel [m]", aspect="equal", title="from the front")
    figure.suptitle(f"{report.arm.name}: {len(report.done)} of {len(panel.tasks)} tasks", parse_math=False)
    top.margins(0.1)
    front.margins(0.1)
    top.legend(loc="upper left", fontsize=8)
    return png_of(figure, dpi=120)
