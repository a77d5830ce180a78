"""What is wrong with a log: another unit, too few rows, a joint at rest, a correction no arm needs, a moved base."""

from __future__ import annotations

import numpy as np

from ..arm.arm import Arm
from ..support.checks import Array
from ..support.errors import InputError, listed
from ..support.unit_hints import theta_hint
from ..support.units import UNITS
from ..theory.rotations import skew
from .measurements import Bools, Measurements
from .problem import Problem

LITTLE = {"rad": float(np.radians(15.0)), "m": 0.05}
"""A joint that moved by less has hardly moved."""

MOVED = 6.0
"""A base that moved lowers the squares by more than so many times what six more parameters do by chance."""

FAR_TILT, FAR_SHIFT = 0.2, 0.1
"""An axis that would tilt by more [rad], or move by more reaches, is no matter of tolerances."""

TURNED = 0.2
"""Orientations that are out by more [rad] are written in another way."""

LEAST_PART = 6
"""Rows on each side of the moment when a base moved."""


def require_metres(log: Measurements, arm: Arm) -> None:
    """InputError for positions farther apart than the arm reaches many times over, with the likely unit."""
    spread = float(np.ptp(log.position[log.located], axis=0).max()) if log.located.any() else 0.0
    if spread > 20.0 * arm.reach:
        unit = min(UNITS["m"], key=lambda unit: abs(np.log(spread * UNITS["m"][unit] / arm.reach)))
        raise InputError(
            f"the positions lie {spread:.4g} m apart, and the arm reaches {arm.reach:.3g} m: are they in {unit}? "
            f"Name the unit in the header, as in x [{unit}]"
        )


def refuse_unusable(problem: Problem, fitted: Bools) -> tuple[str, ...]:
    """InputError for a log that nothing can be fitted to; what else is odd, in words. `fitted` (Q,) may move."""
    log, arm = problem.log, problem.geometry.arm
    hint = theta_hint(log.theta, arm.units, arm.limits.lower, arm.limits.upper)
    if hint:
        raise InputError(f"{hint}: name the unit in the header, as in {arm.joint_names[arm.units.index('rad')]} [deg]")
    require_metres(log, arm)
    rows, numbers, least = len(log.theta), problem.numbers, int(fitted[:12].sum()) + 3 * len(problem.places)
    if numbers <= least:
        raise InputError(
            f"{rows} rows give {numbers} numbers; base, tool and places alone have {least} unknowns: measure more"
        )
    odd = []
    if numbers < 2 * fitted.sum():
        need = int(np.ceil(2 * fitted.sum() * rows / numbers))
        odd.append(f"{rows} rows are few for {fitted.sum()} unknowns: measure {need}, twice as many numbers")
    if not (log.located.any() or any(log.wire) or problem.distances):
        odd.append("points and planes alone do not show the arm's size: give the distance of two points, or positions")
    return tuple(odd)


def faults_of(problem: Problem, q: Array, first: Array) -> tuple[str, ...]:
    """What spoils the fit q (Q,): a joint at rest, a correction that no arm needs, or a base that moved.

    `first` (Q,) are the unknowns with base and tool fitted alone.
    """
    arm, travel = problem.geometry.arm, np.ptp(problem.log.theta, axis=0)
    least = np.minimum([LITTLE[unit] for unit in arm.units], 0.5 * (arm.limits.upper - arm.limits.lower))
    still = [name for name, moved, enough in zip(arm.joint_names, travel, least, strict=True) if moved < enough]
    if still:
        return (f"{listed(still)} hardly moves: the fit holds near one value only; move it by more than 15° or 50 mm",)
    turned = np.linalg.norm(problem.misses(q)[problem.measured[:, 3], 3:], axis=1)
    if turned.size and np.median(turned) > TURNED:
        return ("the orientations do not fit: are they qx, qy, qz, qw in this order, of the tool in device axes?",)
    moved = _moved_base(problem, q) or _moved_base(problem, first)
    left = float(np.median(np.linalg.norm(problem.misses(q)[:, :3], axis=1)))
    axes = np.abs(problem.geometry.split(q[: problem.P])[3])
    tilt, shift = float(axes[:, 3:].max()), float(axes[:, :3].max())
    if moved or not (left > 0.03 * arm.reach or tilt > FAR_TILT or shift > FAR_SHIFT * arm.reach):
        return moved
    far = f"{1000 * left:.3g} mm are left, with axes moved by up to {np.degrees(tilt):.0f}° and {1000 * shift:.0f} mm"
    return (f"no arm fits these rows: {far}; are columns swapped, signs reversed, or units mixed?",)


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
