"""A trajectory as a C99 and C++17 header: a table and functions that evaluate it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ...limits.actuators import Actuators
from ...support.checks import Array, as_flag
from ...support.code_text import c_number, c_string, c_strings, filled, identifier_of
from .motor_values import counted, motors_of, require_motors

if TYPE_CHECKING:
    from ..trajectory import Trajectory

FOLDER = Path(__file__).parent

SUFFIXES = (".h", ".hpp", ".hh", ".hxx")


def header_text(
    trajectory: Trajectory, file: str = "motion.h", actuators: Actuators | None = None, *, counts: bool = False
) -> str:
    """Return the text that `Trajectory.to_header` writes. Every name in it begins with that of the file."""
    name = identifier_of(Path(file).stem, "motion")
    if as_flag(counts, "counts"):
        trajectory = counted(trajectory, require_motors(motors_of(trajectory, actuators)))
    columns = zip(trajectory.joint_names, trajectory.units, strict=True)
    return filled(
        FOLDER / "motion.h.in",
        name=name,
        file=c_string(Path(file).name),
        guard=f"TWISTARM_MOTION_{name.upper()}_H",
        order=", ".join(f"{c_string(joint)} [{unit}]" for joint, unit in columns),
        n=trajectory.n,
        pieces=len(trajectory.breakpoints) - 1,
        degree=len(trajectory.coefficients) - 1,
        seconds=f"{trajectory.duration:.6g}",
        duration=c_number(trajectory.duration),
        joint_names=c_strings(trajectory.joint_names),
        units=c_strings(trajectory.units),
        breakpoints=_numbers(trajectory.breakpoints[:-1]),
        coefficients=",\n    ".join(map(_piece, trajectory.coefficients.transpose(1, 2, 0))),
        labels=_labels(trajectory, name),
    )


def _piece(coefficients: Array) -> str:
    return "{" + ",\n     ".join(f"{{{_numbers(row)}}}" for row in coefficients) + "}"


def _numbers(values: Array) -> str:
    return ", ".join(map(c_number, values))


def _labels(trajectory: Trajectory, name: str) -> str:
    if not trajectory.labels:
        return ""
    rows = ",\n    ".join(f"{{{c_number(time)}, {c_string(text)}}}" for time, text in trajectory.labels)
    return filled(FOLDER / "labels.h.in", name=name, count=len(trajectory.labels), rows=rows)
