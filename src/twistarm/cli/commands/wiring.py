"""`wiring`: the motors of an arm.toml against a log."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ...arm.arm import Arm
from ...calibration import Residual, WiringReport, check_wiring
from ..options import Json, takes_arm
from ..output import console, number, print_json, say, table
from ..quantities import quantity

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


@takes_arm
def wiring(
    arm: Arm,
    log: Log,
    position_noise: PositionNoise = 0.002,
    orientation_noise: OrientationNoise = 1.0,
    base_position_noise: BasePositionNoise = None,
    base_orientation_noise: BaseOrientationNoise = None,
    json: Json = False,
) -> int:
    """Check signs, ratios and zeros of the motors against logged counts and measured tool positions."""
    report = check_wiring(
        arm,
        log,
        position_noise=position_noise,
        orientation_noise=orientation_noise,
        base_position_noise=base_position_noise,
        base_orientation_noise=base_orientation_noise,
    )
    if json:
        print_json(asdict(report) | {"ok": report.ok})
    else:
        _print(arm, report)
    return 0 if report.ok else 1


def _print(arm: Arm, report: WiringReport) -> None:
    console().print(_table(arm, report))
    before, after = _residual(report.before), _residual(report.after)
    rows = "1 row" if report.rows == 1 else f"{report.rows} rows"
    say(f"{rows}; measured against computed: {before} as the arm.toml says, {after} as found here")
    for motor in report.motors:
        if motor.verdict != "sound" and motor.what:
            say(f"{motor.name}: {motor.what}" + (f"; {motor.remedy}" if motor.remedy else ""))
    say(f"{report.verdict}: {report.what}")


def _table(arm: Arm, report: WiringReport) -> Any:
    assert arm.actuators is not None, "check_wiring has asked for them"
    units = dict(zip(arm.joint_names, arm.units, strict=True))
    counts = arm.actuators.to_counts(np.ones(len(report.motors)))
    rows = [
        [
            motor.name,
            # A question mark: the fault may be another motor's.
            ", ".join(motor.faults) + "?" * (motor.verdict == "possible fault") or motor.verdict,
            _with_deviation(motor.scale, motor.scale_std),
            f"{_with_deviation(motor.offset * count, motor.offset_std * count)} {unit}",
            ", ".join(f"{joint} {_amount(value, units[joint])}" for joint, value in motor.joint_offset.items()),
        ]
        for motor, count, unit in zip(report.motors, counts, arm.actuators.units, strict=True)
    ]
    columns = ["motor", "verdict", "readings times", "plus", "added to the joints"]
    return table(f"{report.arm}: its motors, and what fits the log", columns, rows, text=["verdict", columns[-1]])


def _with_deviation(value: float, deviation: float) -> str:
    return f"{number(value)} ± {deviation:.1g}" if np.isfinite(deviation) else f"{number(value)} ± ?"


def _amount(value: float, unit: str) -> str:
    return f"{number(1000 * value, 1)} mm" if unit == "m" else f"{number(np.degrees(value), 2)}°"


def _residual(residual: Residual) -> str:
    position = f"{1000 * residual.position:.1f} mm"
    return position if residual.rotation is None else f"{position} and {np.degrees(residual.rotation):.2f}°"
