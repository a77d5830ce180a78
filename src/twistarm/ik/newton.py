"""Newton's method on a subspace and inside a box: steps of a trust region down to where the slope vanishes."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ..checks import Array
from .quadratic import least_quadratic
from .ranges import Mask

SHARPNESS, STATIONARY = 1e-10, 1e-8
"""Slope (per rad or m) at which to stop, and up to which a point counts as stationary."""

FIRST_RADIUS, LAST_RADIUS = 0.5, 1e-9
"""Trust region [rad, m]: where a quadratic model of an arm is believed at first, and where a search gives up."""

STEPS = 60

ROUNDING = 1e-15
"""Near a minimum the decrease drowns in rounding while the slope still falls: a change by this much is none."""

SETTLED = 1e-12
"""A gain below this, with a slope that counts as none, ends a search."""

LEAST_CURVATURE = 1e-10
"""Below this a curvature is taken to be this, so that no step is without an end."""

Function = Callable[[Array], Array]


class Model(NamedTuple):
    """What is to be minimised, around x: gradient, positive definite Hessian, rows C held, the box of steps, the slope.

    The slope is the largest component of the steepest way down that rows and box leave open; up to `enough` it counts
    as none.
    """

    gradient: Array
    hessian: Array
    C: Array
    lower: Array
    upper: Array
    slope: float
    enough: float = STATIONARY


def descend(
    x: Array,
    value: Callable[[Array], float],
    model: Callable[[Array], Model],
    retract: Callable[[Array, Model], Array | None],
    stopped: Callable[[], bool],
) -> tuple[Array, bool]:
    """(x, whether it is stationary), from x downhill in `value` until the slope vanishes or `stopped`.

    `retract` brings a trial point back to where `value` is to be compared, or finds that it cannot. Source:
    J. Nocedal & S. Wright, Numerical Optimization, 2nd ed., ch. 4 and 18.
    """
    radius, here = FIRST_RADIUS, value(x)
    for _ in range(STEPS):
        m = model(x)
        if m.slope <= SHARPNESS or stopped():
            break
        while radius > LAST_RADIUS:
            box = np.maximum(m.lower, -radius), np.minimum(m.upper, radius)
            step = least_quadratic(m.hessian, m.gradient, m.C, *box).d
            trial = retract(x + step, m)
            if trial is not None and value(trial) <= here + ROUNDING:
                gain = here - value(trial)
                x, here, radius = trial, value(trial), min(2.0 * radius, FIRST_RADIUS)
                break
            radius = 0.25 * float(np.abs(step).max())
        else:
            break
        if gain <= SETTLED and m.slope <= m.enough:
            break
    return x, m.slope <= m.enough


def resting(downhill: Array, lower: Array, upper: Array) -> Mask:
    """Coordinates at a bound that the steepest way down leaves there; `lower` and `upper` bound the steps."""
    rests: Mask = (downhill == 0) & ((lower >= 0) | (upper <= 0))
    return rests


def positive(H: Array, along: Array) -> Array:
    """H on the subspace `along` (n, k), with the size of every curvature, none flat: downhill even from a saddle."""
    curvature, vectors = np.linalg.eigh(along.T @ H @ along)
    directions = along @ vectors
    hessian: Array = (directions * np.maximum(np.abs(curvature), LEAST_CURVATURE)) @ directions.T
    return hessian


def derivative(function: Function, x: Array, h: float) -> Array:
    """The symmetric part of d function/dx (n, n), by central differences of step h."""
    J = np.column_stack([function(x + h * e) - function(x - h * e) for e in np.eye(len(x))]) / (2.0 * h)
    symmetric: Array = 0.5 * (J + J.T)
    return symmetric
