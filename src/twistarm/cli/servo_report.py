"""The report of `twistarm servo`: the loop's cycles and how it ended, for people and for programs."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ..model.arm import Arm
from ..stream import StreamReport
from .grid import Grid
from .output import table


def report_json(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """What the loop did, for programs."""
    values = {field.name: getattr(report, field.name) for field in fields(report)}
    statuses = {status.name: count for status, count in report.statuses.items()}
    return {"arm": arm.name, **values, "ending": report.ending.name, "statuses": statuses, "ok": report.ok}


def report_table(arm: Arm, report: StreamReport) -> Grid:
    """The same for people."""
    late = [f"{1e3 * seconds:.2f} ms" for seconds in (report.late_p50, report.late_p99, report.late_max)]
    statuses = ", ".join(f"{status.name} {count}" for status, count in report.statuses.items())
    blind = f"{report.blind:.1f} s later{because(report.blind, report.blind_reason)}"
    rows = [
        ["ended", ": ".join(filter(None, (report.ending.value, report.reason)))],
        ["cycles", f"{report.cycles} at {report.rate:g} Hz in {report.duration:.1f} s, {report.missed} missed"],
        ["begun late by", f"{late[0]} (median), {late[1]} (99 %), {late[2]} (most)"],
        *([["limits", report.assumed]] if report.assumed else []),
        ["status", statuses or f"never moved: {report.blind_reason}"],
        ["no command", f"{report.uncommanded:.1f} s{because(report.uncommanded, report.uncommanded_reason)}"],
        *(
            [["held back", f"{report.barred:.1f} s{because(report.barred, report.barred_reason)}"]]
            if report.barred
            else []
        ),
        ["no joint state", f"{report.waited:.1f} s at the start, {blind}"],
        ["at the end", report.at_the_end],
        *(["trouble", trouble] for trouble in (*report.undelivered, *report.failures)),
    ]
    return table(f"{arm.name}: servo", ["", ""], rows, text=("",))


def because(seconds: float, reason: str) -> str:
    """The reason behind a time that is not 0."""
    return f"; at last: {reason}" if seconds > 0.0 and reason else ""
