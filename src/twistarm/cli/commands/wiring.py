"""`wiring`: the motors of an arm.toml against a log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from ...arm.arm import Arm
from ...calibration import Residual, WiringReport, check_wiring
from ...calibration.calibration import amount
from ..numbers import quantity
from ..options import ArmArgument, Json
from ..output import plain
from ..tables import Column, Table, number

Log = Annotated[
    Path, typer.Argument(metavar="LOG", help="CSV: a column per motor, x, y, z [m], and qx, qy, qz, qw if measured.")
]
PositionNoise = Annotated[float, quantity("m", "Standard deviation of the measured positions.")]
OrientationNoise = Annotated[float, quantity("rad", "Standard deviation of the measured orientations [°].")]
BasePositionNoise = Annotated[
    float | None, quantity("m", "Standard deviation of the base's own position; 0 if exactly known.", zero=True)
]
BaseOrientationNoise = Annotated[
    float | None,
    quantity("rad", "Standard deviation of the base's own orientation [°]; 0 if exactly known.", zero=True),
]


def wiring(
    source: ArmArgument,
    log: Log,
    out: Json,
    position_noise: PositionNoise = 0.002,
    orientation_noise: OrientationNoise = 1.0,
    base_position_noise: BasePositionNoise = None,
    base_orientation_noise: BaseOrientationNoise = None,
) -> int:
    """Check signs, ratios and zeros of the motors against logged counts and measured tool positions."""
    arm = source.load()
    report = check_wiring(
        arm,
        log,
        position_noise=position_noise,
        orientation_noise=orientation_noise,
        base_position_noise=base_position_noise,
        base_orientation_noise=base_orientation_noise,
    )
    before, after = _residual(report.before), _residual(report.after)
    rows = "1 row" if report.rows == 1 else f"{report.rows} rows"
    faults = [each for each in report.motors if each.verdict != "sound" and each.what]
    lines = [
        f"{rows}; measured against computed: {before} as the arm.toml says, {after} as found here",
        *(f"{motor.name}: {'; '.join(filter(None, (motor.what, motor.remedy)))}" for motor in faults),
        f"{report.verdict}: {report.what}",
    ]
    out.show(plain(report) | {"ok": report.ok}, _table(arm, report), *lines)
    return 0 if report.ok else 1


def _table(arm: Arm, report: WiringReport) -> Table:
    assert arm.actuators is not None, "check_wiring has asked for them"
    motors, units = report.motors, dict(zip(arm.joint_names, arm.units, strict=True))
    counts = arm.actuators.to_counts(np.ones(len(motors)))
    plus = [
        f"{_with_deviation(motor.offset * count, motor.offset_std * count)} {unit}"
        for motor, count, unit in zip(motors, counts, arm.actuators.units, strict=True)
    ]
    # A question mark: the fault may be another motor's.
    verdicts = [
        ", ".join(motor.faults) + "?" * (motor.verdict == "possible fault") or motor.verdict for motor in motors
    ]
    added = [
        ", ".join(f"{joint} {amount(x, units[joint])}" for joint, x in motor.joint_offset.items()) for motor in motors
    ]
    columns = [
        Column("motor", [motor.name for motor in motors]),
        Column("verdict", verdicts),
        Column("readings times", [_with_deviation(motor.scale, motor.scale_std) for motor in motors]),
        Column("plus", plus),
        Column("added to the joints", added),
    ]
    return Table(f"{report.arm}: its motors, and what fits the log", columns)


def _with_deviation(value: float, deviation: float) -> str:
    return f"{number(value)} ± {deviation:.1g}" if np.isfinite(deviation) else f"{number(value)} ± ?"


def _residual(residual: Residual) -> str:
    position = f"{1000 * residual.position:.1f} mm"
    return position if residual.rotation is None else f"{position} and {np.degrees(residual.rotation):.2f}°"
