"""What is wrong with a calibration's log: too few rows, other units, locked joints, rows twice, a base that moved."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from ..support.checks import Array
from ..support.errors import InputError, listed
from ..support.unit_hints import theta_hint
from ..theory.rotations import skew
from .problem import Problem, kabsch

MOVED = 6.0
"""A base that moved lowers the squares by more than so many times what six more parameters do by chance."""

FAR_TILT, FAR_SHIFT = 0.2, 0.1
"""An axis that would tilt by more [rad], or move by more reaches, is no matter of tolerances."""

LEAST_PART = 6
"""Rows on each side of the moment when a base moved."""


def refuse_unusable(problem: Problem, unknowns: int) -> tuple[str, ...]:
    """InputError for a log that nothing can be fitted to; what else is odd, in words."""
    log, arm = problem.log, problem.geometry.arm
    hint = theta_hint(log.theta, arm.units, arm.limits.lower, arm.limits.upper)
    if hint:
        raise InputError(f"{hint}: name the unit in the header, as in {arm.joint_names[0]} [deg]")
    _require_metres(problem)
    said = []
    locked = [name for name, moved in zip(arm.joint_names, np.ptp(log.theta, axis=0), strict=True) if moved < 1e-6]
    if locked:
        said.append(f"{listed(locked)} never moves: its zero and axis cannot be told from the others")
    scalars = int(problem.measured.sum()) + len(problem.distances)
    places = 3 * len(problem.places)
    if scalars < places + 12:
        raise InputError(
            f"{len(log.theta)} rows give {scalars} numbers; base, tool and {len(problem.places)} unknown places alone "
            f"are {places + 12} unknowns: measure more rows"
        )
    if scalars < 2 * unknowns:
        need = int(np.ceil(2 * unknowns * len(log.theta) / scalars))
        said.append(f"{len(log.theta)} rows are few for {unknowns} unknowns: measure {need}, twice as many numbers")
    return (*said, *_twice(problem), *_collapsing(problem))


def _require_metres(problem: Problem) -> None:
    log, reach = problem.log, problem.geometry.arm.reach
    spread = float(np.ptp(log.position[log.located], axis=0).max()) if log.located.any() else 0.0
    if spread > 20.0 * reach:
        raise InputError(
            f"the positions lie {spread:.4g} m apart, and the arm reaches {reach:.3g} m: they look like millimetres; "
            "name the unit in the header, as in x [mm]"
        )


def _twice(problem: Problem) -> tuple[str, ...]:
    log = problem.log
    rows = np.column_stack([log.theta, np.nan_to_num(log.position), np.nan_to_num(log.length)])
    names = [hash((a, b, c)) % 2**31 for a, b, c in zip(log.point, log.plane, log.wire, strict=True)]
    _, first, count = np.unique(np.column_stack([rows, names]), axis=0, return_index=True, return_counts=True)
    again = np.sort(first[count > 1])
    return (f"rows stand there twice, the first of them {log.label[again[0]]}: they count twice",) if again.size else ()


def _collapsing(problem: Problem) -> tuple[str, ...]:
    """What resting points without a known length cannot show."""
    log = problem.log
    resting = not log.located.any() and not any(log.wire) and any(log.point)
    if not resting or problem.distances:
        return ()
    return ("points at rest do not show the arm's size: give the distance of two of them",)


def suspicions(problem: Problem, q: Array, first: Array) -> tuple[str, ...]:
    """What the fit q (Q,) shows to be wrong: residuals or corrections that no arm has, and a base that moved.

    `first` (Q,) are the unknowns with base and tool fitted alone.
    """
    rms = float(np.linalg.norm(problem.misses(q)[:, :3], axis=1).mean())
    reach, odd = problem.geometry.arm.reach, ""
    axes = np.abs(problem.geometry.split(q[: len(problem.geometry.parameters)])[3])
    tilt, shift = float(axes[:, 3:].max()), float(axes[:, :3].max())
    if rms > 0.03 * reach:
        odd = f"nothing fits: {1000 * rms:.0f} mm are left in the mean"
    elif tilt > FAR_TILT or shift > FAR_SHIFT * reach:
        odd = f"axes would move by up to {np.degrees(tilt):.0f}° and {1000 * shift:.0f} mm, more than an arm is out"
    swapped = _swapped(problem) if odd else ""
    if swapped:
        return (f"{odd}; {swapped}",)
    moved = _moved_base(problem, q) or _moved_base(problem, first)
    return moved or ((f"{odd}; are columns swapped, signs reversed, or units mixed?",) if odd else ())


def _swapped(problem: Problem) -> str:
    """The exchange of two columns that halves what a base alone leaves; else an empty text."""
    log, arm = problem.log, problem.geometry.arm
    if log.located.sum() < 4:
        return ""
    m = log.position[log.located]

    def left(theta: Array, m: Array) -> float:
        p = arm.fk(theta)[log.located, :3, 3]
        g = kabsch(p, m)
        return float(np.linalg.norm(p @ g[:3, :3].T + g[:3, 3] - m, axis=1).mean())

    found = {"two of x, y, z look swapped, or one has the wrong sign": left(log.theta, m * [-1.0, 1.0, 1.0])}
    for i, j in combinations(range(arm.n), 2):
        theta = log.theta.copy()
        theta[:, [i, j]] = theta[:, [j, i]]
        found[f"the columns {arm.joint_names[i]} and {arm.joint_names[j]} look swapped"] = left(theta, m)
    words = min(found, key=lambda each: found[each])
    return words if found[words] < 0.5 * left(log.theta, m) else ""


def _moved_base(problem: Problem, q: Array) -> tuple[str, ...]:
    """The row at which a rigid motion of the base explains the residuals best, if it explains much."""
    at = np.flatnonzero(problem.log.located)
    if len(at) < 4 * LEAST_PART:
        return ()
    r = problem.misses(q)[at, :3]
    size = np.linalg.norm(r, axis=1)
    r = r * np.minimum(1.0, np.quantile(size, 0.75) / np.maximum(size, 1e-12))[:, None]  # an outlier counts as others
    p = problem.log.position[at] - problem.log.position[at].mean(axis=0)
    A = np.concatenate([np.broadcast_to(np.eye(3), (len(at), 3, 3)), -skew(p)], axis=2)
    H, b = np.cumsum(np.einsum("kij,kil->kjl", A, A), axis=0), np.cumsum(np.einsum("kij,ki->kj", A, r), axis=0)
    cuts = np.unique(np.linspace(LEAST_PART, len(at) - LEAST_PART, 60).astype(int))
    gains = [
        b[c - 1] @ np.linalg.lstsq(H[c - 1], b[c - 1], rcond=1e-9)[0]
        + (b[-1] - b[c - 1]) @ np.linalg.lstsq(H[-1] - H[c - 1], b[-1] - b[c - 1], rcond=1e-9)[0]
        for c in cuts
    ]
    best = int(np.argmax(gains))
    # What is left is at least the noise: less than that shows nothing.
    left = max((float((r * r).sum()) - float(gains[best])) / (3 * len(at)), float(np.median(problem.sigma)) ** 2)
    if gains[best] / 12 < MOVED * left or gains[best] < 0.3 * (r * r).sum():
        return ()
    near = problem.log.label[at[cuts[best]]]
    return (f"the base or the tracker seems to have moved near {near}: fit the parts alone",)
