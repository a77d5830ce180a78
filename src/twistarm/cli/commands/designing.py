"""`payload` and `designs`: what an arm holds, and arms side by side."""

from __future__ import annotations

import io
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...design import Needs, Payload, compare_designs, load_panel
from ...design import payload as payload_of
from ...support.checks import Array, as_not_negative
from ...support.csv_lines import csv_text
from ...support.errors import InputError, missing_extra
from ..asked_motion import motion_of_file, typed_targets
from ..options import CONFIGURATION, Json, Radians, takes_arm, takes_source
from ..output import console, note, number, print_json, say, shown, table, theta_typed
from ..outputs import Force, outputs_of
from ..typed import parse_theta
from .inspection import info_json
from .kinematics import warn_outside
from .motion import Directions, Positions, Rpys

Motion = Annotated[Path | None, typer.Option(metavar="FILE", help="Along a motion: *.csv, *.json, *.yaml or *.toml.")]
Panel = Annotated[Path | None, typer.Option(metavar="FILE", help="Which share of a panel.toml each arm does.")]
Mass = Annotated[float, typer.Option(metavar="KG", help="A wanted payload: what each joint and motor needs for it.")]
Files = Annotated[
    list[str] | None,
    typer.Option("--output", "-o", metavar="FILE", help="Every configuration to *.csv, a picture to *.png; repeat it."),
]


@takes_arm
def payload(
    arm: Arm,
    theta: Annotated[str | None, CONFIGURATION] = None,
    motion: Motion = None,
    mass: Mass = 0.0,
    output: Files = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Show the greatest mass at the tool anywhere inside the limits, at --theta, or along --motion."""
    outputs = outputs_of(output, {"csv": (".csv",), "png": (".png",)}, force=force, json=json)
    as_not_negative(mass, "--mass")
    if motion is not None and theta is not None:
        raise InputError("--motion has its own configurations: leave out --theta")
    x: Any = None if theta is None else parse_theta(arm, theta, rad)
    if x is not None:
        warn_outside(arm, x, rad)
    found = payload_of(arm, x if motion is None else motion_of_file(arm, motion, {})[1])
    needs, x = found.needs(mass), found.theta.reshape(-1, arm.n)
    by = [found.names[row] if row >= 0 else "nothing" for row in found.limiting.ravel()]
    written = outputs.write({"csv": lambda: _csv(found, x, by), "png": lambda: _picture(found, x)})
    for each in found.notes:
        note(each)
    if json:
        worst = {"payload": found.mass.ravel()[found.worst], "limited_by": by[found.worst], "theta": x[found.worst]}
        unknown = {"configurations": len(x), "unknown": int(np.isnan(found.mass).sum())}
        asked = {"arm": arm.name, "joint_names": arm.joint_names, "wanted": mass}
        told = {"needs": needs._asdict() | {"limit": found.limits}, "notes": found.notes, "written": written}
        print_json(asked | unknown | worst | {"median_payload": np.median(found.mass)} | told)
    else:
        console(outputs.words).print(_needs_table(found, needs, mass))
        say(_sentence(found, by[found.worst]), theta_typed(arm, x[found.worst], rad), file=outputs.words)
        outputs.say(written)
    return int(np.isnan(found.mass).any() or (needs.share > 1.0).any())


def _sentence(found: Payload, by: str) -> str:
    least = found.mass.ravel()[found.worst]
    if not least < np.inf:
        return "the payload is unknown" if np.isnan(found.mass).any() else "no joint or motor carries the payload"
    at = "here" if found.t is None else f"at {number(found.t[found.worst], 3)} s, here"
    if least == 0.0:
        return f"{by} cannot hold the arm itself {at}:"
    median = f", {number(float(np.median(found.mass)), 2)} kg in the median" if found.mass.size > 1 else ""
    return f"holds {number(least, 2)} kg at {found.arm.tip}{median}; {by} limits it {at}:"


def _needs_table(found: Payload, needs: Needs, mass: float) -> Any:
    units = (*found.arm.units, *(found.arm.actuators.motor_units if found.arm.actuators else ()))
    limiting = np.bincount(found.limiting.ravel() + 1, minlength=len(units) + 1)[1:] / found.mass.size
    columns = {
        "unit": ["N" if unit == "m" else "N m" for unit in units],
        "effort": [number(x, 3) for x in needs.effort],
        "limit": [number(x, 3) for x in found.limits],
        "used": [f"{100 * x:.0f} %" for x in needs.share],
        "limits in": [f"{100 * x:.0f} %" for x in limiting],
    }
    if needs.speed.any():
        columns |= {"speed /s": [number(x, 3) for x in needs.speed], "power [W]": [number(x, 1) for x in needs.power]}
    title = f"{found.arm.name}: needed with {mass:g} kg at {found.arm.tip}; configurations: {found.mass.size}"
    return table(title, ["", *columns], [[*row] for row in zip(found.names, *columns.values(), strict=False)], ["unit"])


def _csv(found: Payload, theta: Array, by: list[str]) -> str:
    """A row for each state: the time of a motion, theta, the payload and what limits it."""
    times = {} if found.t is None else {"time [s]": found.t}
    joints = [f"{name} [{unit}]" for name, unit in zip(found.arm.joint_names, found.arm.units, strict=True)]
    rows = np.column_stack([*times.values(), theta, found.mass.ravel()]).tolist()
    heads = [*times, *joints, "payload [kg]", "limited by"]
    return csv_text(heads, ([*row, name] for row, name in zip(rows, by, strict=True)))


def _picture(found: Payload, theta: Array) -> bytes:
    """A PNG: the payload against the time of a motion, else as the colour of the tool's places round the base."""
    try:
        from matplotlib.figure import Figure
    except ImportError as error:
        raise missing_extra("a picture", "matplotlib", "guide") from error
    figure, file, mass = Figure(layout="constrained"), io.BytesIO(), found.mass.ravel()
    axes: Any = figure.subplots()
    if found.t is not None:
        axes.plot(found.t, mass)
        axes.set(xlabel="time [s]", ylabel="payload [kg]", ylim=(0.0, None))
    else:
        x, y, z = found.arm.fk(theta)[:, :3, 3].T
        most = float(np.quantile(mass[np.isfinite(mass)], 0.9)) if np.isfinite(mass).any() else 1.0
        dots = axes.scatter(np.hypot(x, y), z, c=mass, s=6, vmin=0.0, vmax=most)
        axes.set(xlabel="distance from the base's z axis [m]", ylabel="height [m]", aspect="equal")
        figure.colorbar(dots, label="payload [kg]", extend="max")
    figure.savefig(file, format="png", dpi=120, bbox_inches="tight")
    return file.getvalue()


NUMBERS = (
    ("reach [m]", "reach"), ("volume [m³]", "volume"), ("condition, median", "condition"),
    ("near-singular, share", "singular"), ("least payload [kg]", "payload"), ("median payload [kg]", "median_payload"),
    ("moving mass [kg]", "mass"), ("motion [s]", "duration"), ("panel, share done", "panel"),
)  # fmt: skip
"""The rows of the table of designs."""


@takes_source
def designs(
    source: str,
    load: dict[str, Any],
    others: Annotated[list[str], typer.Argument(metavar="ARM...", help="The arms to compare with it.")],
    xyz: Positions = None,
    rpy: Rpys = None,
    direction: Directions = None,
    panel: Panel = None,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Compare arms: reach, dexterity, payload, mass, joint ranges, the time of a motion through --xyz, a --panel."""
    targets = typed_targets(xyz or (), rpy or (), direction or (), None, rad)
    if len(targets) == 1:
        raise InputError("a motion leads from one --xyz to another: give two or more, or none")
    asked = None if panel is None else load_panel(panel)
    found = compare_designs([load_arm(each, **load) for each in (source, *others)], targets, asked)
    against = [each.against(found[0]) for each in found[1:]]
    for name, why in ((each.name, why) for each in found for why in each.notes):
        note(f"{name}: {why}")
    if json:
        told = [vars(each) | {"arm": info_json(each.arm)["joints"]} for each in found]
        print_json({"designs": told, "against": against})
        return
    rows = [[title, *(number(getattr(each, field), 3) for each in found)] for title, field in NUMBERS]
    ends = [[shown(each.arm, x, rad, 1) for x in (each.arm.limits.lower, each.arm.limits.upper)] for each in found]
    ranges = zip_longest(*([f"{low} … {high}" for low, high in zip(*each, strict=True)] for each in ends), fillvalue="")
    rows += [[f"joint {i} [{'rad' if rad else '°'}, m]", *row] for i, row in enumerate(ranges, 1)]
    console().print(table("", ["", *(each.name for each in found)], rows))
    say(*against)
