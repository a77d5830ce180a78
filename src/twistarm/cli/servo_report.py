"""The reports of `twistarm servo` and `follow` for people and for programs."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ..arm.arm import Arm
from ..control.stream import FollowReport, StreamReport
from ..control.stream.report import names_counted
from .grid import Grid
from .output import table
from .wording import in_options


def report_json(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """The report of the loop, for programs."""
    values = {field.name: getattr(report, field.name) for field in fields(report)}
    counts = {name: {each.name: count for each, count in values[name].items()} for name in ("statuses", "reasons")}
    return {"arm": arm.name, **values, "ending": report.ending.name, **counts, "ok": report.ok}


def report_table(arm: Arm, report: StreamReport) -> Grid:
    """The same for people."""
    return table(f"{arm.name}: servo", ["", ""], _rows(report, "no command"), text=("",))


def follow_json(arm: Arm, report: FollowReport) -> dict[str, Any]:
    """The report of a motion and its loop, for programs."""
    lags, errors = (
        dict(zip(report.joint_names, off.tolist(), strict=True)) for off in (report.largest_lag, report.largest_error)
    )
    return {
        "arm": arm.name, "ok": report.ok, "completed": report.completed, "ending": report.stream.ending.name,
        "reason": in_options(report.stream.reason), "at": report.at, "duration": report.duration, "speed": report.speed,
        "largest_lag": lags, "largest_error": errors, "loop": report_json(arm, report.stream),
    }  # fmt: skip


def follow_table(arm: Arm, report: FollowReport) -> Grid:
    """The same for people."""
    followed = [list(line.split(": ", 1)) for line in report.followed()]
    return table(f"{arm.name}: follow", ["", ""], [*followed, *_rows(report.stream, "paused")], text=("",))


def _rows(report: StreamReport, uncommanded: str) -> list[list[str]]:
    late = [f"{1e3 * seconds:.2f} ms" for seconds in (report.late_p50, report.late_p99, report.late_max)]
    statuses = names_counted(report.statuses)
    blind = f"{report.blind:.1f} s later{because(report.blind, report.blind_reason)}"
    return [
        ["ended", ": ".join(filter(None, (report.ending.value, in_options(report.reason))))],
        ["cycles", f"{report.cycles} at {report.rate:g} Hz in {report.duration:.1f} s, {report.missed} missed"],
        ["begun late by", f"{late[0]} (median), {late[1]} (99 %), {late[2]} (most)"],
        *([["limits", report.assumed]] if report.assumed else []),
        ["status", statuses or ": ".join(filter(None, ("never moved", report.blind_reason)))],
        *([["reasons", names_counted(report.reasons)]] if statuses else []),
        [uncommanded, f"{report.uncommanded:.1f} s{because(report.uncommanded, report.uncommanded_reason)}"],
        *(
            [["held back", f"{report.barred:.1f} s{because(report.barred, report.barred_reason)}"]]
            if report.barred
            else []
        ),
        ["no joint state", f"{report.waited:.1f} s at the start, {blind}"],
        ["at the end", report.at_the_end],
        *(["trouble", trouble] for trouble in (*report.undelivered, *report.failures)),
    ]


def because(seconds: float, reason: str) -> str:
    """The reason for a time that is not 0."""
    return f"; at last: {reason}" if seconds > 0.0 and reason else ""
