"""The tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from math import isfinite

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from .figures import Batch, Kinematics, SingleCalls
from .measure import Plan, Results
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


def report(console: Console, results: Results, plan: Plan, about: dict[str, str]) -> None:
    console.print()
    for name, value in about.items():
        console.print(f"{name}: {value}", highlight=False)
    for kind, title in KINDS.items():
        rows = [row for row in results.single if row.kind == kind]
        if rows:
            console.print(_single(rows, title.format(seed=plan.seed)))
    console.print(_batch(results.batch, results.single, plan))
    console.print(_kinematics(results.kinematics, plan))
    for line in (*FOOTNOTES, *_about_peers(results)):
        console.print(f"  {line}", highlight=False, markup=False)


def _single(rows: list[SingleCalls], title: str) -> Table:
    kind = rows[0].kind
    last = {"warm": ["largest motion"], "unreachable": ["× own cold", "reasons"]}.get(kind, ["mean µs"])
    table = _table(title, "arm", "solver", "strict %", "median µs", "p99 µs", "×", "wrong", *last)
    for arm, group in groupby(rows, key=lambda row: row.arm):
        for row in group:
            cells = {
                "mean µs": _number(row.mean),
                "largest motion": _number(row.motion, "{:.3f}"),
                "× own cold": _number(row.to_cold),
                "reasons": ", ".join(f"{name} {count}" for name, count in row.reasons.items()),
            }
            strict = _number(100 * row.strict, "{:.1f}")
            times = _number(row.median), _number(row.p99), _number(row.ratio)
            wrong = "–" if row.remark else str(row.wrong)
            table.add_row(arm, row.peer, strict, *times, wrong, *(cells[name] for name in last))
        table.add_section()
    table.caption = _remarks(rows)
    return table


def _batch(rows: list[Batch], single: list[SingleCalls], plan: Plan) -> Table:
    title = f"Batch of {plan.batch} cold targets, µs per target (one by one: the mean of single calls)"
    table = _table(title, "arm", "solver", "1 thread", "2 threads", "one by one", "strict %", "wrong")
    batches = {(row.arm, row.peer, row.threads): row for row in rows}
    for arm, group in groupby((row for row in single if row.kind == "cold"), key=lambda row: row.arm):
        for row in group:
            each = [batches[arm, row.peer, threads] for threads in (1, 2) if (arm, row.peer, threads) in batches]
            times = [_number(batch.each) for batch in each] or ["–", "–"]
            strict = _number(100 * min((batch.strict for batch in each), default=row.strict), "{:.2f}")
            failed = any(measured.remark for measured in each or [row])
            wrong = "–" if failed else str(max((batch.wrong for batch in each), default=row.wrong))
            table.add_row(arm, row.peer, *times, _number(row.mean), strict, wrong)
        table.add_section()
    table.caption = _remarks(rows)
    return table


def _kinematics(rows: list[Kinematics], plan: Plan) -> Table:
    title = f"Forward kinematics (FK) and body Jacobian (J), µs per configuration; batches of {plan.batch}"
    names = {
        "one fk": "FK\none call", "one fk_jacobian": "FK + J\none call",
        "unchecked fk": "FK\nunchecked", "unchecked fk_jacobian": "FK + J\nunchecked",
        "batch fk": "FK\nbatch", "batch fk_jacobian": "FK + J\nbatch",
    }  # fmt: skip
    table = _table(title, "arm", "solver", *names.values(), "off by")
    for arm, group in groupby(rows, key=lambda row: row.arm):
        for row in group:
            times = (_number(row.times.get(name, float("nan")), "{:.3g}") for name in names)
            table.add_row(arm, row.peer, *times, _number(row.difference, "{:.0e}"))
        table.add_section()
    table.caption = _remarks(rows)
    return table


def _remarks(rows: Sequence[SingleCalls | Batch | Kinematics]) -> str | None:
    """Why there are no figures in a row."""
    lines = [f"{row.arm}, {row.peer}: {row.remark}" for row in rows if row.remark]
    return escape("\n".join(dict.fromkeys(lines))) or None


def _about_peers(results: Results) -> list[str]:
    settings = [f"{peer}: {text}" for peer, text in results.settings.items()]
    versions = ", ".join(f"{name} {number}" for name, number in results.versions.items())
    absent = [f"{peer} is not in the tables: {why}" for peer, why in results.absent.items()]
    return [*settings, f"Versions: {versions}", *absent]


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", title_style="bold", caption_justify="left")
    for column in columns:
        words = column in ("arm", "solver", "reasons")
        table.add_column(column, justify="left" if words else "right", no_wrap=column == "solver")
    return table


def _number(value: float, style: str = "") -> str:
    """Three digits that count, unless a style is given; – for none."""
    if not isfinite(value):
        return "–"
    return (style or ("{:.0f}" if value >= 100 else "{:.1f}" if value >= 10 else "{:.2f}")).format(value)
