"""Logs with the mistakes that students make: is each named, and is a wrong correction written?"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import Arm, InputError
from twistarm.calibration import calibrate, corrected_urdf
from twistarm.theory.rotations import exp as turn
from twistarm.theory.rotations import to_xyzw

from .calibration_truth import ORIENTATION, POSITION, Truth, aligned, arms, truth_of

Array = np.ndarray[Any, np.dtype[np.float64]]

ROWS = 60
BETTER = 0.3
"""A written correction must leave less than this part of the nominal arm's error."""


@dataclass(frozen=True)
class Case:
    """A log with a mistake, the words of which one must be told ("" where nothing needs to be), and options."""

    what: str
    words: tuple[str, ...]
    theta: Array
    positions: Array
    quaternions: Array | None = None
    options: dict[str, float] = field(default_factory=dict)


def cases(truth: Truth, rng: np.random.Generator) -> Iterator[Case]:
    arm = truth.arm
    theta = arm.random_theta(rng, ROWS)
    g = truth.poses(theta)
    noise = rng.normal(scale=POSITION, size=(ROWS, 3))
    p = g[:, :3, 3] + noise
    q = to_xyzw(g[:, :3, :3] @ turn(rng.normal(scale=ORIENTATION, size=(ROWS, 3))))
    turning = np.array(arm.units) == "rad"
    i = int(np.flatnonzero(turning)[-1])
    names = arm.joint_names
    yield Case("none", ("",), theta, p)
    yield Case("none, poses", ("",), theta, p, q)
    yield Case("degrees for radians", ("degrees",), np.where(turning, np.degrees(theta), theta), p)
    one = theta.copy()
    one[:, i] = np.degrees(one[:, i])
    yield Case(f"degrees, {names[i]} alone", ("degrees", "units"), one, p)
    yield Case("mm for m", ("millimetres", "[mm]"), theta, 1000.0 * p)
    yield Case("cm for m", ("centimetres", "[cm]"), theta, 100.0 * p)
    yield Case("noise in mm", ("noise",), theta, p, options={"position_noise": 0.1})
    for j in range(arm.n - 1):
        swapped = theta.copy()
        swapped[:, [j, j + 1]] = swapped[:, [j + 1, j]]
        yield Case(f"{names[j]} and {names[j + 1]} swapped", ("swapped",), swapped, p)
    yield Case("x and y swapped", ("swapped",), theta, p[:, [1, 0, 2]])
    for j in range(arm.n):
        yield Case(f"{names[j]} reversed", ("reversed",), theta * np.where(np.arange(arm.n) == j, -1.0, 1.0), p)
    for size in (5e-4, 5e-3, 5e-2):
        pushed = p + np.where(np.arange(ROWS) < ROWS // 2, 0.0, size)[:, None] * [0.8, 0.6, 0.0]
        yield Case(f"base moved by {1e3 * size:g} mm", ("moved near",), theta, pushed)
    yield Case("rows twice", ("twice", "repeats"), np.vstack([theta, theta[:5]]), np.vstack([p, p[:5]]))
    for few in (2, 4, 6, 8, 10):
        yield Case(f"{few} rows", ("rows",), theta[:few], p[:few])
    for spread in (0.0, 1e-3):
        locked = theta.copy()
        locked[:, 2] = 0.1 + spread * rng.normal(size=ROWS)
        yield Case(
            f"{names[2]} locked, encoder's noise {spread:g}", (names[2],), locked, truth.poses(locked)[:, :3, 3] + noise
        )
    yield Case("rows shuffled", ("nothing fits", "order", "shifted"), theta, p[rng.permutation(ROWS)])
    path = np.array([np.interp(np.linspace(0, 5, ROWS), np.arange(6), along) for along in arm.random_theta(rng, 6).T]).T
    late = truth.poses(path)[:, :3, 3] + noise
    yield Case("tracker one row late, on a path", ("nothing fits", "order", "shifted", "late"), path[:-1], late[1:])
    for size in (0.02, 0.5):
        wild = p.copy()
        wild[rng.choice(ROWS, 3, replace=False)] += size * rng.normal(size=(3, 3))
        yield Case(f"5 % outliers of {1e3 * size:g} mm", ("rows that do not fit",), theta, wild)
    yield Case("quaternion with w first", ("quaternion", "qw", "w first"), theta, p, q[:, [3, 0, 1, 2]])
    small = {"position_noise": POSITION / 10, "orientation_noise": ORIENTATION / 10}
    yield Case("noise stated 10 × too small", ("noise",), theta, p, q, small)
    large = {"position_noise": 10 * POSITION, "orientation_noise": 10 * ORIENTATION}
    yield Case("noise stated 10 × too large", ("noise",), theta, p, q, large)
    yield Case("positions 5 % too large", ("is it this arm",), theta, 1.05 * p)


def write(case: Case, arm: Arm, file: Path) -> None:
    quaternions = np.empty((len(case.theta), 0)) if case.quaternions is None else case.quaternions
    header = [*arm.joint_names, "x", "y", "z", *(["qx", "qy", "qz", "qw"] if case.quaternions is not None else [])]
    rows = np.hstack([case.theta, case.positions, quaternions])
    np.savetxt(file, rows, delimiter=",", header=",".join(header), comments="")


def outcome(case: Case, arm: Arm, file: Path) -> tuple[str, str, Any]:
    """What happened to the file, what was told, and the calibration or None."""
    try:
        r = calibrate(arm, file, **case.options)  # type: ignore[arg-type]
    except InputError as error:
        return "refused", str(error), None
    told = [*r.warnings, *([f"rows that do not fit: {r.outliers}"] if r.outliers else [])]
    try:
        corrected_urdf(r)
    except InputError:
        return "not written", "; ".join(told), r
    return "written", "; ".join(told), r


def told_faults(names: list[str]) -> None:
    print("\nMistakes, 60 rows: named?, what was written, its error on new postures beside the nominal arm's [mm]")
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            rng = np.random.default_rng(0)
            truth = truth_of(arms(Path(folder))[name](), rng)
            fresh = truth.arm.random_theta(77, 300)
            exact = truth.poses(fresh)[:, :3, 3]
            nominal = error((truth.arm.fk(fresh) @ truth.tool)[:, :3, 3], exact)
            for case in cases(truth, rng):
                file = Path(folder) / "log.csv"
                write(case, truth.arm, file)
                done, told, r = outcome(case, truth.arm, file)
                named = any(word in told for word in case.words)
                left = "" if r is None else f"{error(r.predict(fresh), exact):9.2f} / {nominal:.2f}"
                wrong = done == "written" and error(r.predict(fresh), exact) > BETTER * nominal
                print(
                    f"  {'WRONG ' if wrong else '      '}{name:10s} {case.what:45s} {'named ' if named else 'silent'} "
                    f"{done:12s}{left:18s} {told[:120]}",
                    flush=True,
                )


def error(found: Array, exact: Array) -> float:
    return float(1e3 * np.linalg.norm(aligned(found, exact) - exact, axis=1).mean())
