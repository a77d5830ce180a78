"""`calibrate`: the arm's axes and zeros from measurements of its tool."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...calibration import Calibration, Estimate, corrected_urdf
from ...calibration import calibrate as fit
from ...support.errors import InputError
from ...viewer import Viewer
from ..options import Json, takes_arm
from ..output import console, number, print_json, say, table
from ..outputs import Force, Output, outputs_of
from .viewing import show_address

Log = Annotated[
    Path,
    typer.Argument(metavar="LOG", help="CSV: a column per joint, then x, y, z, or point, plane, wire and length."),
]
Noise = Annotated[float, typer.Option(help="Standard deviation of the measured positions, in metres.")]
OrientationNoise = Annotated[float, typer.Option(help="Standard deviation of the measured orientations, in degrees.")]
HeldBase = Annotated[bool, typer.Option("--base-held", help="Positions are in the base frame; do not fit it.")]
HeldTool = Annotated[bool, typer.Option("--tool-held", help="The measured point is the tip; do not fit it.")]
Distance = Annotated[
    list[str] | None, typer.Option(metavar="A=B=METRES", help="A known distance of two points; may be repeated.")
]
Scales = Annotated[bool, typer.Option("--scales", help="Fit a scale of each joint too.")]
Eccentricity = Annotated[bool, typer.Option("--eccentricity", help="Fit eccentric gears too.")]

View = Annotated[bool, typer.Option("--view", help="Show the residuals in the browser, magnified, until Ctrl-C.")]


@takes_arm
def calibrate(
    arm: Arm,
    log: Log,
    position_noise: Noise = 1e-4,
    orientation_noise: OrientationNoise = 0.06,
    base_held: HeldBase = False,
    tool_held: HeldTool = False,
    distance: Distance = None,
    scales: Scales = False,
    eccentricity: Eccentricity = False,
    output: Output = None,
    force: Force = False,
    json: Json = False,
    view: View = False,
) -> int:
    """Fit the arm's axes and zeros to measured positions of its tool, and write the corrected URDF."""
    outputs = outputs_of(output, {"urdf": (".urdf",)}, force=force, json=json)
    found = fit(
        arm,
        log,
        base="held" if base_held else "fit",
        tool="held" if tool_held else "fit",
        position_noise=position_noise,
        orientation_noise=float(np.radians(orientation_noise)),
        distances=dict(_distance(said) for said in distance or ()),
        scales=scales,
        eccentricity=eccentricity,
    )
    if json:
        print_json(_as_json(found))
    else:
        _print(found, outputs.words)
    outputs.say(outputs.write({"urdf": lambda: corrected_urdf(found)}))
    if view:
        with Viewer(arm, open_browser=False) as viewer:
            viewer.show_residuals(found)
            show_address(viewer, browser=True, out=sys.stderr if json else outputs.words)
            viewer.wait()
    return 0 if found.confirmed else 1


def _distance(said: str) -> tuple[tuple[str, str], float]:
    try:
        a, b, metres = said.split("=")
        return (a, b), float(metres)
    except ValueError:
        raise InputError(f"--distance takes A=B=METRES, as in left=right=0.05; got {said!r}") from None


def _joints(found: Calibration) -> list[Estimate]:
    places = ("base", "tool", "point ", "plane ", "wire ")
    return [estimate for estimate in found.estimates if not estimate.parameter.owner.startswith(places)]


def _print(found: Calibration, words: Any) -> None:
    rows = [
        [estimate.parameter.owner, estimate.parameter.what, *_amounts(estimate)]
        for estimate in _joints(found)
        if estimate.seen
    ]
    console(words).print(table(f"{found.arm.name}: its corrections", ["joint", "what", "value", "±", "unit"], rows,
                               text=["what", "unit"]))  # fmt: skip
    unseen = [str(one.parameter) for one in _joints(found) if not one.seen]
    say(
        f"mean error of base and tool alone: {_mm(found.before)}; corrected: {_mm(found.after)}",
        f"on rows left out: {_mm(found.held_out_before)} and {_mm(found.held_out)}",
        f"not shown beside the others, held at 0: {', '.join(unseen) or 'none'}",
        file=words,
    )
    if found.outliers:
        say(f"rows that do not fit: {', '.join(map(str, found.outliers))}", file=words)
    for warning in found.warnings:
        say(f"warning: {warning}", file=words)
    say("confirmed" if found.confirmed else "not confirmed", file=words)


def _amounts(estimate: Estimate) -> tuple[str, str, str]:
    factor, unit = {"m": (1e3, "mm"), "rad": (float(np.degrees(1.0)), "°"), "1": (1.0, "")}[estimate.parameter.unit]
    return number(factor * estimate.value), number(factor * estimate.std), unit


def _mm(metres: float) -> str:
    return f"{1000 * metres:.3g} mm"


def _as_json(found: Calibration) -> dict[str, Any]:
    names = ("base", "tool", "before", "after", "held_out", "held_out_before", "confirmed", "outliers", "warnings")
    estimates = [
        {"owner": one.parameter.owner, "what": one.parameter.what, "unit": one.parameter.unit, "value": one.value,
         "std": one.std, "seen": one.seen}
        for one in found.estimates
    ]  # fmt: skip
    return {"arm": found.arm.name, "estimates": estimates} | {name: getattr(found, name) for name in names}
