"""Denavit–Hartenberg tables: their check, their CSV files, and the URDF of one."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import partial, reduce
from typing import Any

import numpy as np

from ..support.checks import (
    Array,
    as_floats,
    as_number,
    as_pose,
    frozen,
    number_in,
    require_choice,
    require_names,
    require_one,
)
from ..support.csv_lines import Bounds, Row, csv_lines, csv_rows
from ..support.errors import InputError, listed, quote
from ..support.fields import fields, inside, one_of
from ..support.files import as_path
from ..support.units import TURN, angle_hint, column, factor
from ..theory.rotations import exp
from .bounds import LIMIT_NAMES
from .document import LARGEST, note_file
from .writing import add_joint

CONVENTIONS = ("standard", "modified")
TYPES = ("revolute", "prismatic")
FIXED = "fixed"  # The type of a row without a joint, before the first or behind the last.
BASE, TOOL = "base", "tool"

PARAMETERS = {"a": "m", "alpha": "rad", "d": "m", "theta": "rad"}  # The numbers of a row and their quantities.
# The limits of a row and their quantities, for a turn and for a slide.
LIMITS = {"lower": ("rad", "m"), "upper": ("rad", "m"), "velocity": ("rad/s", "m/s"), "effort": ("N m", "N")}

WORDS = ("joint", "type", "convention")
COLUMNS = (*WORDS, *PARAMETERS, *LIMITS)
KNOWN = {name: name for name in COLUMNS} | {"α": "alpha", "θ": "theta"}
# Largest angles [rad] without a unit. Larger ones are in degrees, mostly.
LONGEST = {"alpha": TURN, "theta": TURN, "lower": 4 * TURN, "upper": 4 * TURN}

UNDECIDED = (
    "say the convention, standard (Paul, Spong, Siciliano) or modified (Craig): in a column `convention` of the CSV "
    "file, or as an argument in Python"
)

BOUNDS = Bounds(bytes=1_000_000, lines=1_000)


@dataclass(frozen=True, eq=False)
class DhTable:
    """Denavit–Hartenberg parameters of an arm: `rows` (n, 4) are a [m], α [rad], d [m], θ [rad] of each joint.

    The joint's coordinate is added to θ, or to d where its type is prismatic. `base` (4, 4) is frame 0 seen from the
    base. `tool` (4, 4) is the tool seen from frame n. `limits` are {joint: {"lower": …, "upper": …, "velocity": …,
    "effort": …}}. `residual` [m, rad] is the largest difference from the arm that the table was computed from.

    The standard convention is T = R_z(θ) T_z(d) T_x(a) R_x(α) (Denavit and Hartenberg 1955; Paul 1981). The modified
    one is T = R_x(α) T_x(a) R_z(θ) T_z(d), with a and α of the link before (Craig 1986, §3.4).

    The default names are joint1, joint2 and so on, and the default type is revolute. Raises InputError for another
    convention, shape or type, for names that do not fit, and for numbers beyond 1e9.
    """

    rows: Array
    convention: str
    joints: tuple[str, ...] | None = None
    types: tuple[str, ...] | None = None
    base: Array = field(default_factory=lambda: np.eye(4))
    tool: Array = field(default_factory=lambda: np.eye(4))
    residual: float = 0.0
    limits: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows = as_floats(self.rows, "table", "rows of a [m], alpha [rad], d [m], theta [rad]")
        if rows.ndim != 2 or rows.shape[1] != 4 or not len(rows) or np.abs(rows).max() > LARGEST:
            raise InputError(
                f"table must be rows of a, alpha, d, theta (n, 4), none beyond {LARGEST:g}; got {rows.shape}"
            )
        n = len(rows)
        names = [f"joint{i + 1}" for i in range(n)] if self.joints is None else require_names(self.joints, "joints")
        types = (TYPES[0],) * n if self.types is None else require_names(self.types, "types")
        if len(names) != n or len(set(names)) != n or not all(name.strip() and name.isprintable() for name in names):
            raise InputError(f"joints must be {n} different names, one per row of the table; got {list(names)}")
        if len(types) != n or not set(types) <= set(TYPES):
            raise InputError(f"types must be {n} words, each {' or '.join(TYPES)}; got {list(types)}")
        require_choice(self.convention, CONVENTIONS, "convention")
        limits_of_one = partial(fields, needed={}, optional=dict.fromkeys(LIMITS, as_number))
        fields(self.limits, "limits", {}, dict.fromkeys(names, limits_of_one))
        poses = {name: frozen(require_one(as_pose(getattr(self, name), name), name, 2)) for name in (BASE, TOOL)}
        read = {"rows": frozen(rows), "joints": tuple(names), "types": tuple(types)}
        for name, value in {**read, **poses, "residual": as_number(self.residual, "residual")}.items():
            object.__setattr__(self, name, value)


def dh_urdf(table: DhTable, name: str) -> str:
    """The URDF of the table's arm, from the link `base` to the link `tool`."""
    fixed = [transform_of(row, table.convention) for row in table.rows]
    if table.convention == "standard":
        places, end = [table.base, *fixed[:-1]], fixed[-1] @ table.tool
    else:
        places, end = [table.base @ fixed[0], *fixed[1:]], table.tool
    robot, link = ET.Element("robot", name=name), BASE
    ET.SubElement(robot, "link", name=BASE)
    for joint, kind, place in zip(table.joints or (), table.types or (), places, strict=True):
        limit = dict.fromkeys(LIMIT_NAMES, np.inf) | {"lower": -np.inf} | dict(table.limits.get(joint, {}))
        turning = "continuous" if np.isinf([limit["lower"], limit["upper"]]).all() else "revolute"
        kind = turning if kind == TYPES[0] else kind
        add_joint(robot, joint, kind, (link, f"{joint}_link"), place, (0.0, 0.0, 1.0), limit)
        link = f"{joint}_link"
    add_joint(robot, f"{TOOL}_mount", "fixed", (link, TOOL), end)
    ET.indent(robot)
    return ET.tostring(robot, encoding="unicode") + "\n"


def transform_of(row: Array, convention: str) -> Array:
    """The transform (4, 4) of a row with its coordinate at 0."""
    a, alpha, d, theta = row
    about_x, about_z = np.eye(4), np.eye(4)
    about_x[:3, :3], about_x[0, 3] = exp(np.array([1.0, 0.0, 0.0]), alpha), a
    about_z[:3, :3], about_z[2, 3] = exp(np.array([0.0, 0.0, 1.0]), theta), d
    return about_z @ about_x if convention == "standard" else about_x @ about_z


def table_of_rows(rows: Iterable[Mapping[str, str]], convention: str | None = None) -> DhTable:
    """The table of rows by column. Names of columns may have units. A missing number is 0.

    Fixed rows at the ends belong to base and tool. Raises InputError with the row, and without a convention.
    """
    read = [_read(row, i) for i, row in enumerate(rows, start=1)]
    if not read:
        raise InputError("it has no rows of a, alpha, d, theta")
    conventions = {str(words) for words in (convention, *(row.get("convention") for row in read)) if words is not None}
    if len(conventions) != 1:
        raise InputError(
            f"it has the conventions {listed(sorted(conventions))}: keep one" if conventions else UNDECIDED
        )
    (convention,) = conventions
    require_choice(convention, CONVENTIONS, "convention")
    moving = [i for i, row in enumerate(read) if row.get("type") != FIXED]
    first, end = (moving[0], moving[-1] + 1) if moving else (0, 0)
    if len(moving) < end - first:
        raise InputError("a fixed row comes before the first joint or after the last; merge it into another row")
    numbers = np.array([[row.get(name, 0.0) for name in PARAMETERS] for row in read])
    transforms = [transform_of(row, convention) for row in numbers]
    joints = read[first:end]
    names = tuple(row.get("joint", f"joint{i}") for i, row in enumerate(joints, start=1))
    limits = [{key: row[key] for key in LIMITS if key in row} for row in joints]
    return DhTable(
        rows=numbers[first:end],
        convention=convention,
        joints=names,
        types=tuple(row.get("type", TYPES[0]) for row in joints),
        base=reduce(np.matmul, transforms[:first], np.eye(4)),
        tool=reduce(np.matmul, transforms[end:], np.eye(4)),
        limits=dict(zip(map(str, names), limits, strict=True)),
    )


def _read(row: Mapping[str, str], i: int) -> dict[str, Any]:
    """The entries of row i by column, in SI."""
    read: dict[str, Any] = {}
    with inside(f"row {i}"):
        kind = one_of((*TYPES, FIXED))(row.get("type") or TYPES[0], "type")
        for key, cell in row.items():
            if cell == "":
                continue
            name, unit = column(key, KNOWN)
            if name is None:
                raise InputError(f"unknown column {quote(key)}; allowed are {', '.join(COLUMNS)}")
            if name in read:
                raise InputError(f"two values of {name}")
            if name in WORDS:
                read[name] = cell
                continue
            quantity = PARAMETERS.get(name) or LIMITS[name][1 if kind == "prismatic" else 0]
            value = number_in(cell, key)
            if quantity == "rad" and not unit and abs(value) > LONGEST[name]:
                raise InputError(f"{angle_hint(np.array(value))}; name the column {name}_deg, or {name} [rad]")
            with inside(key):
                read[name] = value * factor(unit, quantity)
    return read


def rows_of_csv(path: str | os.PathLike[str]) -> list[dict[str, str]]:
    """The rows of a CSV file by the columns that its first line names."""
    note_file(as_path(path))
    header, *rows = [*csv_rows(csv_lines(path, BOUNDS), str(path))] or [Row(0, [])]
    names = [cell.strip() for cell in header.cells]
    for row in rows:
        row.numbers([], len(names), str(path))
    if len(set(names)) < len(names):
        raise InputError(f"{path}: its first line must name each column once, out of {', '.join(COLUMNS)}")
    return [dict(zip(names, map(str.strip, row.cells), strict=True)) for row in rows]
