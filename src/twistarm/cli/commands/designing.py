"""`payload` and `designs`: what an arm holds, and arms side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...arm.loading.load import load_arm
from ...design import Cubes, Design, Needs, Payload, compare_designs, load_panel
from ...design import payload as payload_of
from ...support.checks import Array
from ...support.csv_lines import csv_text
from ...support.errors import InputError
from ...support.pictures import empty_figure, png_of
from ...sweeps import reach_map
from ..asked_motion import motion_of_file, typed_targets
from ..options import CONFIGURATION, Json, Radians, takes_arm, takes_source
from ..output import console, joint_heads, note, number, print_json, progress_bar, say, shown, table, theta_typed, units
from ..outputs import Force, outputs_of, repeated
from ..quantities import quantity
from ..typed import parse_theta
from .inspection import info_json
from .kinematics import warn_outside
from .motion import Directions, Positions, Rpys

Motion = Annotated[Path | None, typer.Option(metavar="FILE", help="Along a motion: *.csv, *.json, *.yaml or *.toml.")]
Panel = Annotated[Path | None, typer.Option(metavar="FILE", help="Which share of a panel.toml each arm does.")]
Mass = Annotated[float, quantity("kg", "A wanted payload: what each joint and motor needs for it.", zero=True)]
Voxel = Annotated[float | None, quantity("m", "-o writes the payload over space, in cubes of this side.")]
SAMPLES = 200_000
"""Random configurations of a map of the payload: four seconds."""
Files = Annotated[list[str] | None, repeated("Every configuration to *.csv, a picture to *.png")]
Tables = Annotated[list[str] | None, repeated("The figures to *.csv, bars and outlines to *.png")]
LAYERS = 24
"""Cubes of a map from the base to the farthest place."""

KINDS = {"csv": (".csv",), "png": (".png",)}


@takes_arm
def payload(
    arm: Arm,
    theta: Annotated[str | None, CONFIGURATION] = None,
    motion: Motion = None,
    mass: Mass = 0.0,
    voxel: Voxel = None,
    output: Files = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> int:
    """Show the greatest mass at the tool anywhere inside the limits, at --theta, or along --motion."""
    outputs = outputs_of(output, KINDS, force=force, json=json)
    if motion is not None and theta is not None:
        raise InputError("--motion has its own configurations: leave out --theta")
    if voxel is not None and (motion is not None or theta is not None):
        raise InputError("--voxel maps random configurations: leave out --theta and --motion")
    x: Any = None if theta is None else parse_theta(arm, theta, rad)
    if x is not None:
        warn_outside(arm, x, rad)
    x = arm.random_theta(0, SAMPLES) if voxel else x
    found = payload_of(arm, x if motion is None else motion_of_file(arm, motion, {})[1])
    needs, x = found.needs(mass), found.theta.reshape(-1, arm.n)
    by = [found.names[row] if row >= 0 else "nothing" for row in found.limiting.ravel()]
    written = outputs.write(_contents(found, x, by, voxel))
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
        say(*_sentences(found, by[found.worst], rad), file=outputs.words)
        outputs.say(written)
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


def _needs_table(found: Payload, needs: Needs, mass: float) -> Any:
    units = (*found.arm.units, *(found.arm.actuators.motor_units if found.arm.actuators else ()))
    limiting = np.bincount(found.limiting.ravel() + 1, minlength=len(units) + 1)[1:] / found.mass.size
    columns = {
        "unit": ["N" if unit == "m" else "N m" for unit in units],
        "effort": [number(x, 3) for x in needs.effort],
        "limit": [number(x, 3) for x in found.limits],
        "used": [
            "−" if np.isinf(most) else f"{100 * x:.0f} %" for x, most in zip(needs.share, found.limits, strict=True)
        ],
        "limits in": [f"{100 * x:.0f} %" for x in limiting],
    }
    if needs.speed.any():
        columns |= {"speed /s": [number(x, 3) for x in needs.speed], "power [W]": [number(x, 1) for x in needs.power]}
    title = f"{found.arm.name}: needed with {mass:g} kg at {found.arm.tip}; configurations: {found.mass.size}"
    return table(title, ["", *columns], [[*row] for row in zip(found.names, *columns.values(), strict=False)], ["unit"])


def _contents(found: Payload, x: Array, by: list[str], voxel: float | None) -> dict[str, Callable[[], str | bytes]]:
    if voxel is None:
        return {"csv": lambda: _csv(found, x, by), "png": lambda: _picture(found, x)}
    cubes, side = found.in_cubes(voxel), voxel
    return {"csv": lambda: _cubes_csv(cubes), "png": lambda: _cubes_picture(found.arm.name, cubes, side)}


def _csv(found: Payload, theta: Array, by: list[str]) -> str:
    """A row for each state: the time of a motion, theta, the payload and what limits it."""
    times = {} if found.t is None else {"time [s]": found.t}
    rows = np.column_stack([*times.values(), theta, found.mass.ravel()]).tolist()
    heads = [*times, *joint_heads(found.arm), "payload [kg]", "limited by"]
    return csv_text(heads, ([*row, name] for row, name in zip(rows, by, strict=True)))


def _picture(found: Payload, theta: Array) -> bytes:
    """A PNG: the payload against the time of a motion, else as the colour of the tool's places round the base."""
    figure, mass = empty_figure("a picture"), found.mass.ravel()
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
    return png_of(figure, dpi=120, bbox_inches="tight")


def _cubes_csv(cubes: Cubes) -> str:
    heads = ["x [m]", "y [m]", "z [m]", "configurations", "least payload [kg]", "greatest payload [kg]"]
    return csv_text(heads, ([*p.round(9), *rest] for p, *rest in zip(*cubes, strict=True)))


def _cubes_picture(name: str, cubes: Cubes, voxel: float) -> bytes:
    """A PNG: the layer of cubes nearest to y = 0, by their least and by their greatest payload."""
    figure, index = empty_figure("a picture", figsize=(11, 4.5)), np.round(cubes.centres / voxel).astype(int)
    x, y, z = index.T
    level = y[np.abs(y).argmin()]
    here = y == level
    held = np.concatenate([cubes.least, cubes.greatest])
    most = float(np.quantile(held[np.isfinite(held)], 0.9)) if np.isfinite(held).any() else 1.0
    ends = [voxel * (end + half) for i in (x, z) for end, half in ((i.min(), -0.5), (i.max(), 0.5))]
    for axes, which in zip(figure.subplots(1, 2), ("least", "greatest"), strict=True):
        layer = np.full((np.ptp(z) + 1, np.ptp(x) + 1), np.nan)
        layer[(z - z.min())[here], (x - x.min())[here]] = getattr(cubes, which)[here]
        drawn = axes.imshow(layer, origin="lower", extent=ends, vmin=0.0, vmax=most)
        axes.set(title=f"{which} payload, y = {voxel * level:.3g} m", xlabel="x [m]", ylabel="z [m]")
    figure.colorbar(drawn, ax=figure.axes, label="payload [kg]", extend="max")
    figure.suptitle(name, parse_math=False)
    return png_of(figure)


def _ranges(arm: Arm, radians: bool) -> list[str]:
    """The range of each joint with its unit, or that it has no limits."""
    ends = (shown(arm, x, radians, 1 + radians) for x in (arm.limits.lower, arm.limits.upper))
    rows = zip(*ends, units(arm, radians), strict=True)
    return ["no limits" if low == high == "−" else f"{low} … {high} {unit}" for low, high, unit in rows]


NUMBERS = (
    ("reach [m]", "reach"), ("farthest [m]", "farthest"), ("volume [m³]", "volume"), ("condition, median", "condition"),
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
    output: Tables = None,
    force: Force = False,
    rad: Radians = False,
    json: Json = False,
) -> None:
    """Compare arms: reach, dexterity, payload, mass, joint ranges, the time of a motion through --xyz, a --panel."""
    outputs = outputs_of(output, KINDS, force=force, json=json)
    targets = typed_targets(xyz or (), rpy or (), direction or (), None, rad)
    if len(targets) == 1:
        raise InputError("a motion leads from one --xyz to another: give two or more, or none")
    asked = None if panel is None else load_panel(panel)
    arms = [load_arm(each, **load) for each in (source, *others)]
    with progress_bar("comparing") as progress:
        found = compare_designs(arms, targets, asked, progress)
    against = [each.against(found[0]) for each in found[1:]]
    for name, why in ((each.name, why) for each in found for why in each.notes):
        note(f"{name}: {why}")
    heads = ["design", *(title for title, _ in NUMBERS)]
    lines = [[each.name, *(getattr(each, field) for _, field in NUMBERS)] for each in found]
    written = outputs.write({"csv": lambda: csv_text(heads, lines), "png": lambda: _designs_picture(found)})
    if json:
        told = [vars(each) | {"arm": info_json(each.arm)["joints"]} for each in found]
        print_json({"designs": told, "against": against, "written": written})
        return
    rows = [[title, *(number(getattr(each, field), 3) for each in found)] for title, field in NUMBERS]
    rows += [
        [f"joint {i}", *row]
        for i, row in enumerate(zip_longest(*(_ranges(each.arm, rad) for each in found), fillvalue=""), 1)
    ]
    console(outputs.words).print(table("", ["", *(each.name for each in found)], rows))
    say(*against, file=outputs.words)
    outputs.say(written)


def _designs_picture(designs: Sequence[Design]) -> bytes:
    """A PNG of the figures as bars, and of slices through y = 0 and through the height at which most is reached.

    A cube counts as in `reach_map`, in any orientation; without the compiled core, by random configurations.
    """
    figure = empty_figure("a picture", figsize=(15, 5))
    bars, side, top = figure.subplots(1, 3)
    titles, fields = zip(*NUMBERS, strict=True)
    values = np.array([[getattr(each, field) for field in fields] for each in designs])
    known = np.isfinite(values) & (values[0] > 0.0) & (values[0] < np.inf)
    share = np.divide(100.0 * values, values[0], out=np.zeros(values.shape), where=known)
    voxel, at = max(each.farthest for each in designs) / LAYERS, np.arange(len(NUMBERS))
    for i, each in enumerate(designs):
        height = 0.8 / len(designs)
        bars.barh(at + i * height, share[i], height, color=f"C{i}", label=each.name)
        m = reach_map(each.arm, voxel, "position", method="fk" if each.arm._why_not_compiled else "ik")
        x, y, z = (m.grid.along(k) for k in range(3))
        level = z[m.counts.sum(axis=(0, 1), dtype=np.int64).argmax()]
        _outline(side, x, z, m.slice("y", float(np.clip(0.0, *y[[0, -1]]))), f"C{i}")
        _outline(top, x, y, m.slice("z", float(level)), f"C{i}")
    bars.set(yticks=at + 0.4 - 0.4 / len(designs), yticklabels=titles, xlabel=f"% of {designs[0].name}")
    bars.invert_yaxis()
    bars.legend()
    side.set(title="reach at y = 0", xlabel="x [m]", ylabel="z [m]", aspect="equal")
    top.set(title="reach at the height of most", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    return png_of(figure)


def _outline(axes: Any, across: Array, up: Array, layer: Array, colour: str) -> None:
    """Draw the border of what is reached, also where that ends with the map."""
    step = across[1:2] - across[:1]
    u, v = (np.concatenate([along[:1] - step, along, along[-1:] + step]) for along in (across, up))
    axes.contour(u, v, np.pad(layer, 1).T, [0.5], colors=colour)
