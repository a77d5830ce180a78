"""Questions before an arm is built: `payload`, `reach`, `panel`, and `designs` side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...design import (
    Needs,
    PanelReport,
    Payload,
    ReachMap,
    best_parking,
    check_panel,
    compare_designs,
    load_panel,
    reach_map,
)
from ...design import payload as payload_of
from ...support.checks import Array
from ...support.errors import InputError
from ...theory.rotations import to_rpy
from ..numbers import PLACE, argument, numbers, option, parse_numbers, quantity, whole
from ..options import Answer, ArmArgument, Avoid, CsvAnswer, Offset, Source, Theta, answers, avoided
from ..output import STDOUT, Outputs, note, plain, progress_bar
from ..rows import TargetOptions
from ..tables import Column, Table, joint_columns, number, quantity_text, theta_typed, unit_text
from .arms import joints_table
from .motion import MOTION_KINDS, MaxTime, Step, Unwrap, motion_of_file, motion_texts

Motion = Annotated[Path | None, option("FILE", "Along a motion: *.csv, *.json, *.yaml, *.mcap or *.toml.")]
PanelOption = Annotated[Path | None, option("FILE", "Which share of a panel.toml each arm does.")]
Mass = Annotated[float, quantity("kg", "Show what each joint and motor needs for this payload.", zero=True)]

KINDS = {"npz": (".npz",), "png": (".png",)}

WORDS: dict[str, Any] = {"down": "down", "position": "position", "26": 26}

MapFiles = Annotated[
    Outputs, answers("output force json", KINDS, output="The map to *.npz, slices to *.png; repeat it.")
]
Voxel = Annotated[float, quantity("m", "Side of a cube.")]
Towards = Annotated[str, option("WHICH", "down, position (in any orientation), 26 (all around) or 'X Y Z'.")]
Method = Annotated[str, option("ik|fk", "ik is exact; fk, by random configurations, a first look.")]
Resume = Annotated[Path | None, option("FOLDER", "Save finished parts in this folder, and resume from them.")]
Workers = Annotated[int | None, whole(1, 1024, "Threads; else one per processor.")]

PanelFile = Annotated[Path, argument("PANEL", "A panel.toml with tasks, and where to park.")]
BasePose = Annotated[
    Any, numbers("m m rad", PLACE, "Check x, y [m] and yaw [°, or rad with --rad] instead of a search.")
]
Speed = Annotated[float | None, quantity("m/s", "The tool goes no faster in the motion of -o.")]
MotionFiles = Annotated[
    Outputs,
    answers(
        "output force rad json",
        MOTION_KINDS,
        output="One motion through all tasks that are done, as plan writes it; repeat it.",
    ),
]


def payload(
    source: ArmArgument, out: CsvAnswer, theta: Theta = None, motion: Motion = None, mass: Mass = 0.0,
    offset: Offset = None,
) -> int:  # fmt: skip
    """Show the greatest mass at the tool anywhere inside the limits, at --theta, or along --motion."""
    arm = source.load()
    if motion is not None and theta is not None:
        raise InputError("--motion has its own configurations: leave out --theta")
    x: Any = None if theta is None else theta.anywhere(arm)
    centre = (0.0, 0.0, 0.0) if offset is None else offset
    found = payload_of(arm, x if motion is None else motion_of_file(arm, motion)[1], offset=centre)
    needs, x = found.needs(mass), found.theta.reshape(-1, arm.n)
    by = [found.names[row] if row >= 0 else "nothing" for row in found.limiting.ravel()]
    worst = found.worst
    for remark in found.notes:
        note(remark)
    data = {
        "arm": arm, "joint_names": arm.joint_names, "wanted": mass, "configurations": len(x),
        "unknown": np.isnan(found.mass).sum(), "payload": found.mass.ravel()[worst], "limited_by": by[worst],
        "theta": x[worst], "median_payload": np.median(found.mass), "notes": found.notes,
    }  # fmt: skip
    out.show(
        data,
        _needs_table(found, needs, mass),
        "effort: greatest of all configurations; weakest in: share of them where this row limits the payload",
        *_sentences(found, by[worst], out.radians),
        files={"csv": lambda: _csv(found, x, by)},
    )
    return int(np.isnan(found.mass).any() or (needs.share > 1.0).any())


def _sentences(found: Payload, by: str, radians: bool) -> tuple[str, ...]:
    """What the arm holds, and the weakest configuration as it can be typed if there is one."""
    least = found.mass.ravel()[found.worst]
    if not least < np.inf:
        return ("the payload is unknown" if np.isnan(found.mass).any() else "no joint or motor carries the payload",)
    typed = theta_typed(found.arm, found.theta.reshape(-1, found.arm.n)[found.worst], radians)
    at = "here" if found.t is None else f"at {number(found.t[found.worst], 3)} s, here"
    if least == 0.0:
        return f"{by} cannot hold the arm itself {at}:", typed
    median = f" (median {number(float(np.median(found.mass)), 2)} kg)" if found.mass.size > 1 else ""
    return f"payload {number(least, 2)} kg at {found.arm.tip}{median}; {by} is the first to limit it, {at}:", typed


def _needs_table(found: Payload, needs: Needs, mass: float) -> Table:
    """What each joint and motor needs for the mass, beside its limit."""
    drives = (*found.arm.units, *(found.arm.actuators.motor_units if found.arm.actuators else ()))
    limiting = np.bincount(found.limiting.ravel() + 1, minlength=len(drives) + 1)[1:] / found.mass.size
    used = ["−" if np.isinf(most) else f"{x:.0%}" for x, most in zip(needs.share, found.limits, strict=True)]
    columns = [
        Column("", found.names, key="name"),
        Column("unit", ["N" if unit == "m" else "N m" for unit in drives]),
        Column("effort", needs.effort, digits=3),
        Column("limit", found.limits, digits=3),
        Column("of limit", needs.share, text=used, key="share"),
        Column("weakest in", limiting, text=[f"{x:.0%}" for x in limiting]),
    ]
    if needs.speed.any():
        columns += [Column("speed /s", needs.speed, digits=3, key="speed"), Column("power", needs.power, "W", digits=1)]
    title = f"{found.arm.name}: efforts for {mass:g} kg at {found.arm.tip}; configurations: {found.mass.size}"
    return Table(title, columns, "needs")


def _csv(found: Payload, theta: Array, by: list[str]) -> str:
    """A row for each state: the time of a motion, theta, the payload and what limits it."""
    times = [] if found.t is None else [Column("time", found.t, "s")]
    mass, limited = Column("payload", found.mass.ravel(), "kg"), Column("limited by", by)
    return Table("", [*times, *joint_columns(found.arm, theta), mass, limited]).csv()


NUMBERS = {
    "reach [m]": "reach", "farthest [m]": "farthest", "volume [m³]": "volume", "condition, median": "condition",
    "near-singular, share": "singular", "least payload [kg]": "payload", "median payload [kg]": "median_payload",
    "moving mass [kg]": "mass", "motion [s]": "duration", "panel, share done": "panel",
}  # fmt: skip
"""The rows of the table of designs."""


def designs(
    source: ArmArgument,
    others: Annotated[list[Source], argument("ARM...", "The arms to compare with.", parser=Source)],
    out: Answer,
    through: TargetOptions,
    panel: PanelOption = None,
) -> None:
    """Compare arms: reach, dexterity, payload, mass, the time of a motion through --xyz, the share of a --panel."""
    targets = through.all()
    if len(targets) == 1:
        raise InputError("a motion leads from one --xyz to another: give two or more, or none")
    asked = None if panel is None else load_panel(panel)
    arms = [file.load() for file in (source, *others)]
    with progress_bar("comparing") as progress:
        found = compare_designs(arms, targets, asked, progress)
    for design in found:
        for why in design.notes:
            note(f"{design.name}: {why}")
    columns = [Column(design.name, [number(getattr(design, name), 3) for name in NUMBERS.values()]) for design in found]
    records = [plain(design) | joints_table(design.arm).entries() for design in found]
    missing = {"motion [s]": not targets and "--xyz", "panel, share done": panel is None and "--panel"}
    heads = [f"{name} (needs {missing[name]})" if missing.get(name) else name for name in NUMBERS]
    out.show({"designs": records}, Table("", [Column("", heads), *columns]))


def reach(
    source: ArmArgument,
    out: MapFiles,
    voxel: Voxel = 0.05,
    directions: Towards = "down",
    avoid: Avoid = None,
    method: Method = "ik",
    resume: Resume = None,
    workers: Workers = None,
) -> int:
    """Map where the arm brings its tool, and in which directions; -o writes the map as .npz or .png."""
    arm = source.load()
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
        Table(
            f"{arm.name}: reach in the frame {found.frame}, cubes of {voxel:g} m; --directions {directions}", columns
        ),
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


def panel(
    source: ArmArgument,
    file: PanelFile,
    out: MotionFiles,
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
    missed = [f"{result.task.name}, {result.code}: {result.why}" for result in found.results if result.code != "done"]
    flag = " --rad" if rad else ""
    sentence = f'{done} of {count} tasks are done with the arm\'s base at --base-pose "{typed}"{flag}'
    written: list[str] = []
    try:
        if out.files and not found.done:
            note("no task is done, so no motion is written")
        elif out.files:
            with progress_bar("planning") as progress:
                motion = found.motion(linear_speed=linear_speed, unwrap=unwrap, max_time=max_time, progress=progress)
            for remark in motion.notes:
                note(remark, radians=rad)
            written = out.write(motion_texts(arm, motion, out, dt))
    finally:  # the answer is good where the motion fails
        data = {"arm": arm, "done": done, "share": done / count, "base": {"x": x, "y": y, "z": z, "yaw": yaw}}
        out.show(data | {"places": found.places}, _tasks_table(found, rad), *missed, sentence, written=written)
    return int(done < count)


def _tasks_table(found: PanelReport, radians: bool) -> Table:
    results = found.results
    unit_of = dict(zip(found.arm.joint_names, found.arm.units, strict=True))
    nearest = []
    for result in results:
        unit = unit_of.get(result.joint, "")
        margin = f"{result.joint} {quantity_text(result.margin, unit, radians)} {unit_text(unit, radians)}"
        nearest.append(margin if result.code == "done" else "")
    millimetres = [number(1e3 * result.clearance, 1) if result.code == "done" else "" for result in results]
    columns = [
        Column("task", [result.task.name for result in results]),
        Column("kind", [result.task.kind for result in results]),
        Column("code", [result.code for result in results]),
        Column("why", [result.why for result in results], people=False),
        Column("nearest limit", [result.joint for result in results], text=nearest, key="joint"),
        Column("margin", [result.margin for result in results], people=False),
        Column("condition", [result.condition for result in results], digits=1),
        Column("clearance", [result.clearance for result in results], "mm", text=millimetres),
        Column("theta", [result.theta[:1] for result in results], people=False),
    ]
    return Table(f"{found.arm.name}: tasks of the panel", columns, "tasks")
