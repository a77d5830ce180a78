"""The tables of the servo on the terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

Rows = list[dict[str, Any]]

COLUMNS = {
    "held": ("joints", "held", "shaking", "unlimited", "unsteady", "plain"),
    "joystick": ("drives", "position", "velocity", "acceleration"),
    "path": ("lines", "told median", "told worst", "median", "worst", "stop", "stop worst"),
    "leaving": (
        "singular", "singular never", "singular median", "singular worst",
        "limits", "limits never", "limits median", "limits worst",
    ),
    "steps": ("command", "median", "p99", "first", "fk", "ratio"),
}  # fmt: skip

TITLES = {
    "held": "Twists held for 8 s that end in shaking, with limits of acceleration and without (unlimited)",
    "joystick": "Drives by joystick, 4 s each: cycles in which a limit is exceeded",
    "path": "Straight lines in free space: off the line [mm], as told and as driven, and the time to a stop [s]",
    "leaving": "Ways out of singular configurations and off limits: how many, how many never, seconds to full speed",
    "steps": "One servo_step from Python, µs, beside one arm.fk",
}

FOOTNOTES = (
    "Shaking: in the last 4 s a joint turns round at least twice a second, or its acceleration at least five times. "
    "Unsteady: at rest, status, scale or lost twist vary by more than 1e-3. Plain: as many twists by a damped "
    "pseudo-inverse with clipping, how many shake.",
    "Driven: by position drives with 80 ms delay, 15 % of the setpoints lost, 3 % rate gain and 12-bit encoders.",
    "First: the first call of a round, when the caches hold the work of others.",
)


def report(console: Console, found: dict[str, Any]) -> None:
    console.print()
    for name, value in found["machine"].items():
        console.print(f"{name}: {value}", highlight=False)
    for part, columns in COLUMNS.items():
        console.print(_table(TITLES[part], found[part], columns))
    rows, growth = found["held"], found["growth"]
    total, shaking = sum(row["held"] for row in rows), sum(row["shaking"] + row["unlimited"] for row in rows)
    lines = (
        f"{shaking} of {total:,} held twists shake, {sum(row['unsteady'] for row in rows)} are unsteady at rest; "
        f"plain: {sum(row['plain'] for row in rows)} shake",
        *FOOTNOTES,
        f"After {growth['steps']:,} steps, beyond what a tenth as many left: {growth['python']:+,} bytes in Python "
        f"(tracemalloc), {growth['process']:+,} bytes of the process.",
        *(f"{name}: {why}" for name, why in found["absent"].items()),
    )
    for line in lines:
        console.print(f"  {line}", highlight=False, markup=False)


def _table(title: str, rows: Rows, columns: tuple[str, ...]) -> Table:
    table = Table(title=escape(title), title_justify="left", title_style="bold")
    table.add_column("arm", no_wrap=True)
    for column in columns:
        table.add_column(column, justify="left" if column == "command" else "right")
    for row in rows:
        table.add_row(row["arm"], *(_cell(row.get(column)) for column in columns))
    return table


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.2f}" if isinstance(value, float) else str(value)
