"""An arm's family as numbers for the compiled core, which solves it in a microsecond."""

from __future__ import annotations

from collections.abc import Set
from typing import NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...support.checks import Array
from ...theory.screws import inverse
from .chain import Chain
from .families import Family
from .joint_axis import JointAxis, Plane, Point

SAMPLE = 0.3
"""Value [rad, m] of held joints in the search for their family. Almost every value shows it."""


class ClosedFormParameters(NamedTuple):
    """A family and its axes with held joints at 0, in the core's form (twistarm::solved_arm)."""

    first: int
    last: int
    keeps: int
    axes: Array
    joint: Array
    kept: Array
    held: Array
    held_axes: Array
    rate: Array
    home: Array
    idle: Array


def family_numbers(
    arm: Arm, chain: Chain, family: Family, held: tuple[int, ...], idle: Set[int]
) -> ClosedFormParameters:
    """The numbers of a family with joints `held`. `idle` joints may have any value in an answer.

    The core gets the values of held joints in every call, so its axes have these joints at 0.
    """
    axes, _ = chain.held(held, np.full(len(held), SAMPLE))
    fitted = family.fitted(axes)
    left = [i for i in range(len(chain.axes)) if i not in held]
    joints = [left[i] for i in family.order]
    back = [inverse(_carried(chain, held, joint)) for joint in joints]
    at_zero = [axis.seen(g) for axis, g in zip(fitted.axes, back, strict=True)]
    # A slide of the group may stand elsewhere among the joints; what turns carries the normal.
    carrier = next((i for i in range(family.first, family.last) if not fitted.axes[i].slides), family.first)
    keeps, kept = _kept(None if fitted.kept is None else fitted.kept.moved(back[carrier]))
    return ClosedFormParameters(
        family.first, family.last, keeps, _numbers(at_zero),
        np.array([joint if joint < arm.n else -1 for joint in joints], dtype=np.float64),
        kept, np.array(held, dtype=np.float64), _numbers([chain.axes[i] for i in held]),
        np.array(chain.rates), np.array(arm.home), np.array([float(i in idle) for i in range(arm.n)]),
    )  # fmt: skip


def _kept(kept: Point | Plane | None) -> tuple[int, Array]:
    """What the group keeps: nothing, a point or a plane, and its four numbers."""
    if kept is None:
        return 0, np.zeros(4)
    return (2, np.append(kept.n, kept.d)) if isinstance(kept, Plane) else (1, np.append(kept.p, 0.0))


def _carried(chain: Chain, held: tuple[int, ...], joint: int) -> Array:
    """The motion (4, 4) that the held joints before this one have given it."""
    g = np.eye(4)
    for i in held:
        if i < joint:
            g = g @ chain.axes[i].motion(SAMPLE)
    return g


def _numbers(axes: list[JointAxis]) -> Array:
    """(k, 7): w, o, and 1 for a slide."""
    return np.array([[*axis.w, *axis.o, float(axis.slides)] for axis in axes]).reshape(-1, 7)
