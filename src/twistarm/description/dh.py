"""Denavit–Hartenberg tables: their check, their CSV files, and the URDF of one."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

import numpy as np

from ..support.checks import Array, Rechecked, as_floats, as_pose, frozen, require_choice, require_names, require_one
from ..support.csv_lines import FACTORS, Bounds, Row, csv_lines, csv_rows, quantity_and_unit
from ..support.errors import InputError
from ..theory.rotations import exp
from .bounds import LIMIT_NAMES
from .document import LARGEST
from .writing import add_joint

CONVENTIONS = ("standard", "modified")
TYPES = ("revolute", "prismatic")
BASE, TOOL = "base", "tool"

UNITS = {"a": "m", "alpha": "rad", "d": "m", "theta": "rad"}
"""The columns of a table in their order, with their units."""

BOUNDS = Bounds(bytes=1_000_000, lines=1_000)

Limits = dict[str, dict[str, float]]


@dataclass(frozen=True, eq=False)
class DhTable(Rechecked):
    """Denavit–Hartenberg parameters of an arm: `rows` (n, 4) are a [m], α [rad], d [m], θ [rad] of each joint.

    The joint's coordinate is added to θ, or to d where its type is prismatic. `base` (4, 4) is frame 0 seen from the
    base. `tool` (4, 4) is the tool seen from frame n. `residual` [m, rad] is the largest difference from the arm that
    the table was computed from.

    The standard convention is T = R_z(θ) T_z(d) T_x(a) R_x(α) (Denavit and Hartenberg 1955; Paul 1981). The modified
    one is T = R_x(α) T_x(a) R_z(θ) T_z(d), with a and α of the link before (Craig 1986, §3.4).

    Raises InputError for another convention, shape or type, for names that do not fit, and for numbers beyond 1e9.
    """

    rows: Array
    convention: str = "standard"
    joints: tuple[str, ...] = ()
    types: tuple[str, ...] = ()
    base: Array = field(default_factory=lambda: np.eye(4))
    tool: Array = field(default_factory=lambda: np.eye(4))
    residual: float = 0.0

    def __post_init__(self) -> None:
        rows = as_floats(self.rows, "table", "rows of a [m], alpha [rad], d [m], theta [rad]")
        if rows.ndim != 2 or rows.shape[1] != 4 or not len(rows) or np.abs(rows).max() > LARGEST:
            raise InputError(
                f"table must be rows of a, alpha, d, theta (n, 4), none beyond {LARGEST:g}; got {rows.shape}"
            )
        n = len(rows)
        names = require_names(self.joints, "joints") if self.joints else tuple(f"joint{i + 1}" for i in range(n))
        types = require_names(self.types, "types") if self.types else (TYPES[0],) * n
        if len(names) != n or len(set(names)) != n or not all(name.strip() and name.isprintable() for name in names):
            raise InputError(f"joints must be {n} different names, one per row of the table; got {list(names)}")
        if len(types) != n or not set(types) <= set(TYPES):
            raise InputError(f"types must be {n} words, each {' or '.join(TYPES)}; got {list(types)}")
        require_choice(self.convention, CONVENTIONS, "convention")
        poses = {name: frozen(require_one(as_pose(getattr(self, name), name), name, 2)) for name in (BASE, TOOL)}
        for name, value in {"rows": frozen(rows), "joints": names, "types": types, **poses}.items():
            object.__setattr__(self, name, value)

    def urdf(self, name: str) -> str:
        """The URDF of the table's arm, from the link `base` to the link `tool`. Each joint is unbounded."""
        fixed = [self._fixed(row) for row in self.rows]
        if self.convention == "standard":
            places, end = [self.base, *fixed[:-1]], fixed[-1] @ self.tool
        else:
            places, end = [self.base @ fixed[0], *fixed[1:]], self.tool
        robot, link = ET.Element("robot", name=name), BASE
        ET.SubElement(robot, "link", name=BASE)
        limit = {"lower": -np.inf, "upper": np.inf, "velocity": np.inf, "effort": np.inf}
        for joint, kind, place in zip(self.joints, self.types, places, strict=True):
            kind = "continuous" if kind == TYPES[0] else kind
            add_joint(robot, joint, kind, (link, f"{joint}_link"), place, (0.0, 0.0, 1.0), limit)
            link = f"{joint}_link"
        add_joint(robot, f"{TOOL}_mount", "fixed", (link, TOOL), end)
        ET.indent(robot)
        return ET.tostring(robot, encoding="unicode") + "\n"

    def _fixed(self, row: Array) -> Array:
        """The transform (4, 4) of a row with its coordinate at 0."""
        a, alpha, d, theta = row
        about_x, about_z = np.eye(4), np.eye(4)
        about_x[:3, :3], about_x[0, 3] = exp(np.array([1.0, 0.0, 0.0]), alpha), a
        about_z[:3, :3], about_z[2, 3] = exp(np.array([0.0, 0.0, 1.0]), theta), d
        return about_z @ about_x if self.convention == "standard" else about_x @ about_z


def read_dh(path: str | os.PathLike[str], convention: str = "standard") -> tuple[DhTable, Limits]:
    """The table in a CSV file, and the limits in it by joint.

    Its header names a, alpha, d and theta, each with or without a unit (`a [mm]`, `alpha [deg]`). A missing column is
    0. Further columns are joint, type, lower, upper, velocity and effort, in SI. Raises InputError with the line.
    """
    known = {word: word for word in (*UNITS, "joint", "type", *LIMIT_NAMES)} | {"α": "alpha", "θ": "theta"}
    header, *rows = [*csv_rows(csv_lines(path, BOUNDS), str(path))] or [Row(0, [])]
    columns = {quantity_and_unit(cell.strip(), known): k for k, cell in enumerate(header.cells)}
    at = {str(name): k for (name, _), k in columns.items()}
    if not rows or not {*UNITS} & {*at} or len(at) < len(header.cells) or "None" in at:
        raise InputError(f"{path}: its first line must name columns, each once, out of {', '.join(known)}; then rows")
    table, limits = np.zeros((len(rows), len(UNITS))), Limits()
    given = [(name, unit or UNITS[str(name)]) for name, unit in columns if name in UNITS]
    for name, unit in given:
        if unit not in FACTORS[UNITS[str(name)]]:
            raise InputError(f"{path}: {name} is in {unit!r}; allowed are {', '.join(FACTORS[UNITS[str(name)]])}")
    for i, row in enumerate(rows):
        numbers = row.numbers([at[str(name)] for name, _ in given], len(header.cells), str(path))
        for (name, unit), number in zip(given, numbers, strict=True):
            table[i, [*UNITS].index(str(name))] = number * FACTORS[UNITS[str(name)]][unit]
    words = {
        name: tuple(row.cells[at[name]].strip() for row in rows) if name in at else () for name in ("joint", "type")
    }
    made = DhTable(table, convention, words["joint"], words["type"])
    for joint, row in zip(made.joints, rows, strict=True):
        said = [name for name in LIMIT_NAMES if name in at and row.cells[at[name]].strip()]
        numbers = row.numbers([at[name] for name in said], len(header.cells), str(path))
        limits[joint] = dict(zip(said, numbers, strict=True))
    return made, limits
