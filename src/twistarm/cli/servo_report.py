"""The reports of `twistarm servo` and `follow` for programs."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from ..arm.arm import Arm
from ..control.stream import FollowReport, StreamReport
from .wording import in_options


def report_json(arm: Arm, report: StreamReport) -> dict[str, Any]:
    """The report of the loop, for programs."""
    values = {field.name: getattr(report, field.name) for field in fields(report)}
    counts = {name: {each.name: count for each, count in values[name].items()} for name in ("statuses", "reasons")}
    return {"arm": arm.name, **values, "ending": report.ending.name, **counts, "ok": report.ok}


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
