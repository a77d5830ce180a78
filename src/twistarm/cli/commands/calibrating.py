"""`calibrate`: the arm's axes and zeros from measurements of its tool."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...calibration import Calibration, corrected_urdf
from ...calibration import calibrate as fit
from ...calibration.calibration import amount
from ...support.errors import InputError
from ..numbers import LENGTH, quantity, typed_number, whole
from ..options import ArmArgument, Avoid, answers, avoided
from ..output import Outputs, entries
from ..tables import Column, Table
from .viewing import Page
from .wiring import OrientationNoise

Logs = Annotated[
    list[Path],
    typer.Argument(metavar="LOG…", help="CSV: a column per joint, then x, y, z, or point, plane, wire and length."),
]
Noise = Annotated[float, quantity("m", "Standard deviation of the measured positions.")]
HeldBase = Annotated[bool, typer.Option("--base-held", help="Positions are in the base frame; do not fit it.")]
HeldTool = Annotated[bool, typer.Option("--tool-held", help="The measured point is the tip; do not fit it.")]
Distance = Annotated[
    list[str] | None, typer.Option(metavar="A=B=LENGTH", help="A known distance of two points; may be repeated.")
]
DistanceNoise = Annotated[float, quantity("m", "Standard deviation of the known distances.")]
Scales = Annotated[bool, typer.Option("--scales", help="Fit a scale of each joint too.")]
Eccentricity = Annotated[bool, typer.Option("--eccentricity", help="Fit eccentric gears too.")]
Next = Annotated[int, whole(0, 1000, "Name N configurations to measure next.", "--next")]
Written = Annotated[
    Outputs,
    answers(
        "output force json",
        {"urdf": (".urdf",), "toml": (".toml",)},
        output="The corrected description (*.urdf), or the motors' offsets for arm.toml (*.toml). "
        "With a toml the zeros are not in the urdf; repeat it.",
        force="Replace files that are there; write what is confirmed only where the log was taken.",
    ),
]
View = Annotated[bool, typer.Option("--view", help="Show the residuals in the browser, magnified, until Ctrl-C.")]


def calibrate(
    source: ArmArgument,
    logs: Logs,
    outputs: Written,
    position_noise: Noise = 1e-4,
    orientation_noise: OrientationNoise = 0.06,
    base_held: HeldBase = False,
    tool_held: HeldTool = False,
    distance: Distance = None,
    distance_noise: DistanceNoise = 1e-4,
    scales: Scales = False,
    eccentricity: Eccentricity = False,
    next_postures: Next = 0,
    avoid: Avoid = None,
    view: View = False,
) -> int:
    """Fit the arm's axes and zeros to measured positions of its tool, and write the corrected URDF."""
    arm = source.load()
    apart = any(kind == "toml" for kind, _ in outputs.files)
    found = fit(
        arm,
        logs,
        base="held" if base_held else "fit",
        tool="held" if tool_held else "fit",
        position_noise=position_noise,
        orientation_noise=orientation_noise,
        distances=dict(_distance(said) for said in distance or ()),
        distance_noise=distance_noise,
        scales=scales,
        eccentricity=eccentricity,
    )
    more = found.next_postures(next_postures, scene=avoided(arm, avoid)) if next_postures else np.empty((0, arm.n))
    answer = replace(outputs, files=())
    answer.show(_as_json(found) | {"next": more}, *_parts(found, arm, more))
    contents: dict[str, Callable[[], str | bytes]] = {
        "urdf": lambda: corrected_urdf(found, zeros=not apart, here=outputs.force),
        "toml": lambda: _toml(found.require(here=outputs.force)),
    }
    try:
        outputs.say(outputs.write(contents))
    finally:  # a correction that is refused is the one to look at
        if view:
            with Page().viewer(arm, None) as viewer:
                viewer.show_residuals(found)
                Page().show_address(viewer, outputs.words)
                viewer.wait()
    return 0 if found.confirmed else 1


def _distance(said: str) -> tuple[tuple[str, str], float]:
    a, b, length, *more = [*said.split("="), "", ""]
    value = typed_number(length, LENGTH)
    if len(more) != 2 or not np.isfinite(value):
        raise InputError(f"--distance takes A=B=LENGTH, as in left=right=0.05 or left=right=50mm; got {said!r}")
    return (a, b), value


def _parts(found: Calibration, arm: Arm, more: Any) -> Iterator[Table | str]:
    """What people read."""
    unseen: dict[str, list[str]] = {}
    for one in found.estimates:
        if one.of_joint and not one.seen:
            unseen.setdefault(one.parameter.owner, []).append(one.parameter.what)
    held = "; ".join(f"{owner} {', '.join(what)}" for owner, what in unseen.items()) or "none"
    yield f"held at 0, because others explain them in this log: {held}"
    yield from _tables(found, arm, more)
    if found.outliers:
        yield f"rows that do not fit: {', '.join(found.problem.log.label[row - 1] for row in found.outliers)}"
    for warning in found.warnings:
        if warning not in found.faults:
            yield f"warning: {warning}"
    if found.confirmed_here and found.expected > 2.0 * found.held_out:
        said = f"elsewhere in reach expect {1000 * found.expected:.2g} mm"
        yield f"warning: {said}: measure at other configurations, as --next names them"
    here = "confirmed only where the log was taken (--force writes it)" if found.confirmed_here else "not confirmed"
    yield "confirmed" if found.confirmed else f"{here}: {found.why_not}"


def _tables(found: Calibration, arm: Arm, more: Any) -> Iterator[Table]:
    every, sound = found.estimates, not found.faults
    columns = [
        Column("joint", [one.parameter.owner for one in every], key="owner"),
        Column("what", [one.parameter.what for one in every]),
        Column("value", [one.value for one in every], text=[amount(one.value, one.parameter.unit) for one in every]),
        Column("±", [one.std for one in every], text=[amount(one.std, one.parameter.unit) for one in every], key="std"),
        Column("unit", [one.parameter.unit for one in every], people=False),
        Column("seen", [one.seen for one in every], people=False),
    ]
    rows = [i for i, one in enumerate(every) if one.of_joint and one.seen and sound]
    yield Table(f"{arm.name}: its corrections", columns, key="estimates", rows=rows)
    if not sound:
        return
    names, thirds = found.by_joint().keys(), np.array(list(found.by_joint().values())).reshape(-1, 3)
    parts = [Column(name, 1e3 * thirds[:, i], digits=3) for i, name in enumerate(("lower", "middle", "upper"))]
    yield Table("median error [mm] by thirds of each joint's range", [Column("joint", list(names)), *parts])
    if len(more):
        joints = (Column(*each) for each in zip(arm.joint_names, more.T, arm.units, strict=True))
        yield Table("to measure next", [Column("", range(1, len(more) + 1)), *joints])
    errors = (
        ("all rows", found.before.mean(), found.after.mean()),
        ("rows left out", found.held_out_before, found.held_out),
        ("a fifth left out at one end", found.block_before, found.block),
    )
    columns = [Column("", [name for name, _, _ in errors])]
    for i, name in enumerate(("base and tool alone", "corrected"), 1):
        columns.append(Column(name, [1e3 * float(each[i]) for each in errors], digits=3))
    yield Table("mean error [mm]", columns)


def _toml(found: Calibration) -> str:
    offsets = found.motor_offsets().items()
    return "\n".join(f"[actuators.{name}]\noffset = {offset!r}\n" for name, offset in offsets)


def _as_json(found: Calibration) -> dict[str, Any]:
    names = "base tool expected held_out held_out_before block block_before confirmed confirmed_here outliers"
    said = {"arm": found.arm.name, "warnings": found.warnings, "by_joint": found.by_joint()}
    means = {"before": float(found.before.mean()), "after": float(found.after.mean())}
    return said | means | entries(found, names)
