"""`payload` and `designs`: what an arm holds, and arms side by side."""

from __future__ import annotations

from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...design import Cubes, Needs, Payload, compare_designs, load_panel
from ...design import payload as payload_of
from ...support.checks import Array
from ...support.csv_lines import csv_text
from ...support.errors import InputError
from ..asked_motion import motion_of_file
from ..numbers import quantity
from ..options import Answer, ArmArgument, CsvAnswer, Source, Theta
from ..output import note, plain, progress_bar, warn
from ..tables import Column, Table, joint_heads, number, outside, shown, theta_typed, units
from ..targets import Directions, Positions, Rpys, typed_targets
from .arms import joints_table

Motion = Annotated[Path | None, typer.Option(metavar="FILE", help="Along a motion: *.csv, *.json, *.yaml or *.toml.")]
Panel = Annotated[Path | None, typer.Option(metavar="FILE", help="Which share of a panel.toml each arm does.")]
Mass = Annotated[float, quantity("kg", "A wanted payload: what each joint and motor needs for it.", zero=True)]
Voxel = Annotated[float | None, quantity("m", "-o writes the payload over space, in cubes of this side.")]
SAMPLES = 200_000
"""Random configurations of a map of the payload: four seconds."""


def payload(
    source: ArmArgument,
    out: CsvAnswer,
    theta: Theta = None,
    motion: Motion = None,
    mass: Mass = 0.0,
    voxel: Voxel = None,
) -> int:
    """Show the greatest mass at the tool anywhere inside the limits, at --theta, or along --motion."""
    arm = source.load()
    if motion is not None and theta is not None:
        raise InputError("--motion has its own configurations: leave out --theta")
    if voxel is not None and (motion is not None or theta is not None):
        raise InputError("--voxel maps random configurations: leave out --theta and --motion")
    x: Any = None if theta is None else theta.of(arm)
    for words in [] if x is None else outside(arm, x, out.radians):
        warn(words)
    x = arm.random_theta(0, SAMPLES) if voxel else x
    found = payload_of(arm, x if motion is None else motion_of_file(arm, motion)[1])
    needs, x = found.needs(mass), found.theta.reshape(-1, arm.n)
    by = [found.names[row] if row >= 0 else "nothing" for row in found.limiting.ravel()]
    worst = found.worst
    cubes = None if voxel is None else found.in_cubes(voxel)
    for each in found.notes:
        note(each)
    data = {
        "arm": arm, "joint_names": arm.joint_names, "wanted": mass, "configurations": len(x),
        "unknown": np.isnan(found.mass).sum(), "payload": found.mass.ravel()[worst], "limited_by": by[worst],
        "theta": x[worst], "median_payload": np.median(found.mass), "notes": found.notes,
    }  # fmt: skip
    out.show(
        data,
        _needs_table(found, needs, mass),
        *_sentences(found, by[worst], out.radians),
        files={"csv": lambda: _csv(found, x, by) if cubes is None else _cubes_csv(cubes)},
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
    median = f", {number(float(np.median(found.mass)), 2)} kg in the median" if found.mass.size > 1 else ""
    return f"holds {number(least, 2)} kg at {found.arm.tip}{median}; {by} limits it {at}:", typed


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
        Column("share", needs.share, text=used),
        Column("limits in", limiting, text=[f"{x:.0%}" for x in limiting]),
    ]
    if needs.speed.any():
        columns += [Column("speed /s", needs.speed, digits=3, key="speed"), Column("power", needs.power, "W", digits=1)]
    title = f"{found.arm.name}: needed with {mass:g} kg at {found.arm.tip}; configurations: {found.mass.size}"
    return Table(title, columns, "needs")


def _csv(found: Payload, theta: Array, by: list[str]) -> str:
    """A row for each state: the time of a motion, theta, the payload and what limits it."""
    times = {} if found.t is None else {"time [s]": found.t}
    rows = np.column_stack([*times.values(), theta, found.mass.ravel()]).tolist()
    heads = [*times, *joint_heads(found.arm), "payload [kg]", "limited by"]
    return csv_text(heads, ([*row, name] for row, name in zip(rows, by, strict=True)))


def _cubes_csv(cubes: Cubes) -> str:
    heads = ["x [m]", "y [m]", "z [m]", "configurations", "least payload [kg]", "greatest payload [kg]"]
    return csv_text(heads, ([*p.round(9), *rest] for p, *rest in zip(*cubes, strict=True)))


NUMBERS = {
    "reach [m]": "reach", "farthest [m]": "farthest", "volume [m³]": "volume", "condition, median": "condition",
    "near-singular, share": "singular", "least payload [kg]": "payload", "median payload [kg]": "median_payload",
    "moving mass [kg]": "mass", "motion [s]": "duration", "panel, share done": "panel",
}  # fmt: skip
"""The rows of the table of designs."""


def designs(
    source: ArmArgument,
    others: Annotated[list[Source], typer.Argument(metavar="ARM...", parser=Source, help="The arms to compare with.")],
    out: Answer,
    xyz: Positions = None,
    rpy: Rpys = None,
    direction: Directions = None,
    panel: Panel = None,
) -> None:
    """Compare arms: reach, dexterity, payload, mass, joint ranges, the time of a motion through --xyz, a --panel."""
    targets = typed_targets(xyz or (), rpy or (), direction or ())
    if len(targets) == 1:
        raise InputError("a motion leads from one --xyz to another: give two or more, or none")
    asked = None if panel is None else load_panel(panel)
    arms = [each.load() for each in (source, *others)]
    with progress_bar("comparing") as progress:
        found = compare_designs(arms, targets, asked, progress)
    for each in found:
        for why in each.notes:
            note(f"{each.name}: {why}")
    ranges = list(zip_longest(*(_ranges(arm, out.radians) for arm in arms), fillvalue=""))
    columns = [Column("", [*NUMBERS, *(f"joint {i}" for i in range(1, len(ranges) + 1))])]
    for each, its in zip(found, zip(*ranges, strict=True), strict=True):
        columns.append(Column(each.name, [*(number(getattr(each, name), 3) for name in NUMBERS.values()), *its]))
    records = [plain(each) | joints_table(each.arm).entries() for each in found]
    out.show({"designs": records}, Table("", columns))


def _ranges(arm: Arm, radians: bool) -> list[str]:
    """The range of each joint with its unit, or that it has no limits."""
    ends = (shown(arm, x, radians) for x in (arm.limits.lower, arm.limits.upper))
    rows = zip(*ends, units(arm, radians), strict=True)
    return ["no limits" if low == high == "−" else f"{low} … {high} {unit}" for low, high, unit in rows]
