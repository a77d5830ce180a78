"""The machine, and the tables on the terminal."""

from __future__ import annotations

import os
import platform
from collections.abc import Callable
from importlib.metadata import version
from itertools import groupby
from math import isfinite
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .measure import Plan, Results, Row
from .problems import FARTHEST, SEED, WARM_DISTANCE

KINDS = {
    "cold": f"Cold: goal and start uniform in the limits, seed {SEED}",
    "fresh": "Fresh: the same from the seed of this run, {seed}",
    "warm": f"Warm: the goal {WARM_DISTANCE} rad from the start",
    "unreachable": f"Unreachable: 1.05 to {FARTHEST} times the reach away",
}

FOOTNOTES = (
    "Strict: position ≤ 1e-6 m, rotation ≤ 1e-6 rad, limits kept to 1e-7 rad, judged by Pinocchio for every answer; "
    "every solver is asked for 1e-6.",
    "Times are of one call from Python, in µs; × is the ratio of the medians to twistarm's. Compare ratios: "
    "all solvers share the machine in turn, a few targets each.",
    "Wrong: answers that the solver called converged and Pinocchio does not confirm. Unreachable targets are met by "
    "none; × own cold is the time to find that out, in medians of the solver's own cold targets.",
    "FK and J: one call checks its argument as twistarm does; unchecked is the bare call; who has no batch call loops. "
    "Off by: the largest difference from Pinocchio's numbers.",
)


def machine() -> dict[str, str]:
    """What the figures were measured on."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return {
        "processor": models[0] if models else platform.processor() or platform.machine(),
        "cores": str(os.cpu_count()),
        "system": platform.platform(),
        "python": platform.python_version(),
        "numpy": version("numpy"),
        "pinocchio (the judge)": version("pin"),
        "load": " ".join(f"{load:.2f}" for load in os.getloadavg()) if hasattr(os, "getloadavg") else "unknown",
    }


def report(console: Console, results: Results, plan: Plan, about: dict[str, str]) -> None:
    console.print()
    for name, value in about.items():
        console.print(f"{name}: {value}", highlight=False)
    for kind, title in KINDS.items():
        rows = [row for row in results.single if row["kind"] == kind]
        if rows:
            console.print(_single(kind, rows, title.format(seed=plan.seed)))
    console.print(_batch(results, plan))
    console.print(_kinematics(results.kinematics, plan))
    for line in (*FOOTNOTES, *_about_peers(results)):
        console.print(f"  {line}", highlight=False, markup=False)


def _single(kind: str, rows: list[Row], title: str) -> Table:
    last = {"warm": ["largest motion"], "unreachable": ["× own cold", "reasons"]}.get(kind, ["mean µs"])

    def cells(row: Row) -> list[str]:
        named = {
            "mean µs": _number(row["mean"]),
            "largest motion": _number(row["motion"], "{:.3f}"),
            "× own cold": _number(row["to_cold"]),
            "reasons": ", ".join(f"{name} {count}" for name, count in row["reasons"].items()),
        }
        times = (_number(row[name]) for name in ("median", "p99", "ratio"))
        wrong = "–" if row["remark"] else str(row["wrong"])
        return [_number(100 * row["strict"], "{:.1f}"), *times, wrong, *(named[name] for name in last)]

    return _table(title, ["strict %", "median µs", "p99 µs", "×", "wrong", *last], rows, cells)


def _batch(results: Results, plan: Plan) -> Table:
    title = f"Batch of {plan.batch} cold targets, µs per target (one by one: the mean of single calls)"

    def cells(row: Row) -> list[str]:
        of_row = [each for each in results.batch if (each["arm"], each["peer"]) == (row["arm"], row["peer"])]
        times = [_number(each["each"]) for each in of_row] or ["–", "–"]
        found = of_row or [row]
        strict = _number(100 * min(each["strict"] for each in found), "{:.2f}")
        wrong = "–" if any(each["remark"] for each in found) else str(max(each["wrong"] for each in found))
        return [*times, _number(row["mean"]), strict, wrong]

    cold = [row for row in results.single if row["kind"] == "cold"]
    return _table(title, ["1 thread", "2 threads", "one by one", "strict %", "wrong"], cold, cells, results.batch)


def _kinematics(rows: list[Row], plan: Plan) -> Table:
    title = f"Forward kinematics (FK) and body Jacobian (J), µs per configuration; batches of {plan.batch}"
    names = {
        "one fk": "FK\none call", "one fk_jacobian": "FK + J\none call",
        "unchecked fk": "FK\nunchecked", "unchecked fk_jacobian": "FK + J\nunchecked",
        "batch fk": "FK\nbatch", "batch fk_jacobian": "FK + J\nbatch",
    }  # fmt: skip

    def cells(row: Row) -> list[str]:
        times = [_number(row["times"].get(name, float("nan")), "{:.3g}") for name in names]
        return [*times, _number(row["difference"], "{:.0e}")]

    return _table(title, [*names.values(), "off by"], rows, cells)


def _about_peers(results: Results) -> list[str]:
    settings = [f"{peer}: {text}" for peer, text in results.settings.items()]
    versions = ", ".join(f"{name} {number}" for name, number in results.versions.items())
    absent = [f"{peer} is not in the tables: {why}" for peer, why in results.absent.items()]
    return [*settings, f"Versions: {versions}", *absent]


def _table(
    title: str, columns: list[str], rows: list[Row], cells: Callable[[Row], list[str]], noted: list[Row] | None = None
) -> Table:
    """A row for each arm and solver. Below it stands why there are no figures in a row."""
    table = Table(title=title, title_justify="left", title_style="bold", caption_justify="left")
    for column in ("arm", "solver", *columns):
        words = column in ("arm", "solver", "reasons")
        table.add_column(column, justify="left" if words else "right", no_wrap=column == "solver")
    for arm, group in groupby(rows, key=lambda row: row["arm"]):
        for row in group:
            table.add_row(arm, row["peer"], *cells(row))
        table.add_section()
    why = [f"{row['arm']}, {row['peer']}: {row['remark']}" for row in noted or rows if row["remark"]]
    table.caption = escape("\n".join(dict.fromkeys(why))) or None
    return table


def _number(value: float, style: str = "") -> str:
    """Three digits that count, unless a style is given; – for none."""
    if not isfinite(value):
        return "–"
    return (style or ("{:.0f}" if value >= 100 else "{:.1f}" if value >= 10 else "{:.2f}")).format(value)
