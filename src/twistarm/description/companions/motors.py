"""Motors of an arm.toml: [actuators.NAME]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...limits.joint_limits import RATES
from .toml_entries import bounded, number_of, numbers_of, only, table_of, text_of, unusable

MOTOR_LIMITS = ("lower", "upper", "velocity", "acceleration", "effort")
"""Limits that a motor may have. Data sheets give no jerk."""

KEYS = ("ratio", "offset", "unit", "ticks_per_turn", "limits")


@dataclass(frozen=True)
class Motor:
    """A motor and the joints it drives: motor = Σ ratio[joint] · joint + offset, rad or m on either side.

    `unit` is the drive's unit, `ticks_per_turn` its resolution if known. `limits` hold on the motor's side of the gear,
    by the names of `MOTOR_LIMITS`.
    """

    name: str
    ratio: Mapping[str, float]
    offset: float = 0.0
    unit: str = "rad"
    ticks_per_turn: float | None = None
    limits: Mapping[str, float] = field(default_factory=dict)


def read_motors(content: Mapping[str, Any], path: Path) -> tuple[Motor, ...]:
    """The motors in the content of the arm.toml at `path`. Raises DescriptionError for unusable entries."""
    return tuple(_motor(name, table, path) for name, table in table_of(content, "actuators", path).items())


def _motor(name: str, table: Any, path: Path) -> Motor:
    text_of(name, "an actuator's name", path)
    place = f"actuators.{name}"
    if not isinstance(table, dict):
        raise unusable(path, f"{place} must be a table with ratio = {{ joint = number }}; got {table!r}")
    only(table, KEYS, path, f"in {place}")
    if not isinstance(table.get("ratio"), dict) or not table["ratio"]:
        what = f"{place}.ratio must be a table of joint = number; got {table.get('ratio')!r}"
        raise unusable(path, what, "write ratio = { elbow = 100.0 }: motor rad per joint rad (or per m)")
    wanted = "finite and not 0"
    ratio = {name: bounded(value, path, f"{place}.ratio.{name}", wanted) for name, value in table["ratio"].items()}
    for joint, value in ratio.items():
        if value == 0:
            raise unusable(path, f"{place}.ratio.{joint} must be {wanted}; got {value:g}")
    if not isinstance(table.get("unit", ""), str):
        raise unusable(path, f"{place}.unit must be a text; got {table['unit']!r}")
    ticks = table.get("ticks_per_turn")
    return Motor(
        name=name,
        ratio=ratio,
        offset=bounded(table.get("offset", 0.0), path, f"{place}.offset"),
        unit=table.get("unit", "rad"),
        ticks_per_turn=None if ticks is None else number_of(ticks, path, f"{place}.ticks_per_turn", "ticks"),
        limits=_motor_limits(table, path, f"{place}.limits"),
    )


def _motor_limits(motor: Mapping[str, Any], path: Path, place: str) -> dict[str, float]:
    table = motor.get("limits", {})
    if not isinstance(table, dict):
        what = f"{place} must be a table of limit = number; got {table!r}"
        raise unusable(path, what, "write limits = { velocity = 300.0 }: motor rad (or m), per s, per s²; N m or N")
    only(table, MOTOR_LIMITS, path, f"in {place}")
    limits = numbers_of(table, path, place)
    for name, value in limits.items():
        if name in RATES and value < 0:
            raise unusable(path, f"{place}.{name} must not be negative; got {value:g}")
    lower, upper = limits.get("lower", -np.inf), limits.get("upper", np.inf)
    if lower > upper:
        raise unusable(path, f"{place} are swapped: lower {lower:g} > upper {upper:g}")
    return limits
