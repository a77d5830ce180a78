"""A family's closed form: all candidates for x with E₁(x₁) ⋯ Eₖ(xₖ) = G.

E_L, E_K, E_R are the products of the joints before, in and behind the group. E_K = E_L⁻¹ G E_R⁻¹ keeps the point or
plane X in place: E_L X = G E_R⁻¹ X. Seen from the other side of G, the joints behind come before the others. So one
chain of at most three joints has to move X to its place under G.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...support.checks import Array
from ...theory.screws import inverse
from .families import FittedFamily
from .joint_axis import JointAxis, Plane, Point, across, product
from .placing import Placed, place, settle
from .trigonometric import NEAREST

NO_ORIGIN = np.zeros(3)

ROUNDED = 1e-12
"""A candidate that misses by less than this [m, or a rotation's numbers] is an answer up to rounding."""

VALUES_TRIED = 16
"""Values tried for a free joint if the present one gives no answer: evenly over a turn or 2π m, nearest first."""


class Candidate(NamedTuple):
    """Values (k,) in the order of the chain, and the joints with arbitrary values."""

    x: Array
    free: frozenset[int]


def candidates(fitted: FittedFamily, G: Array, near: Array, slack: float) -> Iterator[list[Candidate]]:
    """Every x (k,) with E₁(x₁) ⋯ Eₖ(xₖ) = G (4, 4), and near misses: forward kinematics decides.

    A joint that may have any value takes that of `near` (k,). Such a candidate may be an answer only with another
    value, or with others elsewhere. So further lists follow, of candidates with free joints, where those joints have
    other values. Newton's method brings these to all answers nearby.
    """
    found = list(_with(fitted, G, near, slack))
    yield found
    open_joints = {i for each in found if each.free and _miss(fitted, each, G) > ROUNDED for i in each.free}
    for nth in range(1, VALUES_TRIED) if open_joints else ():
        elsewhere = np.array(near)
        elsewhere[list(open_joints)] += 2.0 * math.pi / VALUES_TRIED * ((nth + 1) // 2) * (-1 if nth % 2 == 0 else 1)
        yield [candidate for candidate in _with(fitted, G, elsewhere, slack) if candidate.free]


def _miss(fitted: FittedFamily, candidate: Candidate, G: Array) -> float:
    """The largest number of E₁(x₁) ⋯ Eₖ(xₖ) − G."""
    return float(np.abs(product(fitted.axes, candidate.x[list(fitted.family.order)]) - G).max())


def _with(fitted: FittedFamily, G: Array, near: Array, slack: float) -> Iterator[Candidate]:
    order = fitted.family.order
    before, group, behind = fitted.parts
    wanted = [float(near[i]) for i in order]
    b, e = len(before), len(before) + len(group)
    chain = (*(axis.seen(G) for axis in behind), *before)
    for beside in _place_others(chain, fitted.kept, G, (*wanted[e:], *wanted[:b]), slack):
        x_behind, x_before = beside.x[: len(behind)], beside.x[len(behind) :]
        E = inverse(product(before, np.array(x_before))) @ G @ inverse(product(behind, np.array(x_behind)))
        for inside in within_group(fitted.kept, group, E, tuple(wanted[b:e]), NEAREST if beside.free else slack):
            x = np.empty(len(order))
            x[list(order)] = [*x_before, *inside.x, *x_behind]
            places = [i - len(behind) if i >= len(behind) else e + i for i in beside.free]
            yield Candidate(x, frozenset(order[i] for i in (*places, *(b + i for i in inside.free))))


def _place_others(
    chain: tuple[JointAxis, ...], kept: Point | Plane | None, G: Array, near: tuple[float, ...], slack: float
) -> list[Placed]:
    return [Placed(())] if kept is None else place(chain, kept, kept.moved(G), near, slack)


def within_group(
    kept: Point | Plane | None, group: tuple[JointAxis, ...], E: Array, near: tuple[float, ...], slack: float
) -> list[Placed]:
    """All x with E₁(x₁) ⋯ Eₖ(xₖ) = E, k ≤ 3, for a group that fixes `kept`. k ≤ 6 for a decoupled one."""
    if kept is None:
        return decoupled(group, E, near, slack)
    if isinstance(kept, Point):
        return rotating(tuple(axis.w for axis in group), E[:3, :3], near, slack)
    return sliding(group, kept.n, E, near, slack)


def rotating(w: tuple[Array, ...], R: Array, near: tuple[float, ...], slack: float) -> list[Placed]:
    """All x with e^{ŵ₁x₁} ⋯ e^{ŵₖxₖ} = R (3, 3), k ≤ 3.

    With three axes, the angle from w₁ to R w₃ gives x₂ (`_middle_turns`). Then x₁ turns e^{ŵ₂x₂} w₃ to R w₃, and x₃ is
    the remaining turn. Where x₂ brings w₃ along w₁ the wrist is singular: x₁ is free.
    """
    axes = tuple(JointAxis(each, NO_ORIGIN, slides=False) for each in w)
    if not w:
        return [Placed(())]
    if len(w) == 1:
        u = across(w[0])[0]
        return [Placed((settle(axes[0], Point(u), Point(R @ u), near[0])[0],))]
    if len(w) == 2:
        return _first_then_last(axes, R, w[1], near, slack)
    found = []
    for x in _middle_turns(axes[1], w[0], w[2], R @ w[2], slack):
        found += _first_then_last(axes, R, axes[1].motion(x)[:3, :3] @ w[2], near, slack, x)
    return found


def _middle_turns(middle: JointAxis, first: Array, last: Array, goal: Array, slack: float) -> list[float]:
    """The turns of `last` (3,) about the middle axis to the angle of `goal` from `first`.

    The three directions make a triangle on the sphere with the sides α, γ and β. Its half-angle formulas give the angle
    at the middle axis to rounding. Its cosine would lose half the digits for a nearly singular wrist.
    """
    alpha, gamma, beta = _angle(middle.w, first), _angle(middle.w, last), _angle(first, goal)
    s = 0.5 * (alpha + beta + gamma)
    sine, cosine = math.sin(s - alpha) * math.sin(s - gamma), math.sin(s) * math.sin(s - beta)
    if min(sine, cosine) < -slack:
        return []
    opening = 2.0 * math.atan2(math.sqrt(max(sine, 0.0)), math.sqrt(max(cosine, 0.0)))
    aligned = settle(middle, Point(last), Point(first), 0.0)[0]
    return [aligned + opening, aligned - opening] if sine > 0.0 and cosine > 0.0 else [aligned + opening]


def _angle(a: Array, b: Array) -> float:
    """Between unit vectors a and b (3,) [rad]."""
    return math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))


def _first_then_last(
    axes: tuple[JointAxis, ...],
    R: Array,
    moved: Array,
    near: tuple[float, ...],
    slack: float,
    middle: float | None = None,
) -> list[Placed]:
    """x₁ turns `moved` to where R takes the last axis. The last joint turns the rest."""
    x, free = settle(axes[0], Point(moved), Point(R @ axes[-1].w), near[0])
    left = axes[0].motion(-x)[:3, :3] @ R
    between = () if middle is None else (middle,)
    if middle is not None:
        left = axes[1].motion(-middle)[:3, :3] @ left
    last = rotating((axes[-1].w,), left, near[-1:], slack)[0].x
    return [Placed((x, *between, *last), frozenset({0} if free else ()))]


def sliding(
    group: tuple[JointAxis, ...], normal: Array, E: Array, near: tuple[float, ...], slack: float
) -> list[Placed]:
    """All x with E₁(x₁) ⋯ Eₖ(xₖ) = E (4, 4), k ≤ 3, of turns about the normal and slides across it.

    The angles add up. One turn takes the whole angle, and the slides are two lengths in the plane. With more turns, the
    joints before the last place a point of its axis.
    """
    turning = [i for i, axis in enumerate(group) if not axis.slides]
    u, v = across(normal)
    whole = math.atan2(float(v @ E[:3, :3] @ u), float(u @ E[:3, :3] @ u))
    senses = [float(np.sign(group[i].w @ normal)) for i in turning]
    if len(turning) == 1:
        return [Placed(_with_slides(group, turning, (senses[0] * whole,), E))]
    last = turning[-1]
    if last < len(group) - 1:
        backward = sliding(group[::-1], normal, inverse(E), tuple(-x for x in near[::-1]), slack)
        end = len(group) - 1
        return [Placed(tuple(-x for x in each.x[::-1]), frozenset(end - i for i in each.free)) for each in backward]
    X = Point(group[last].o)
    found = []
    for rest in place(group[:last], X, X.moved(E), near[:last], slack):
        turned = sum(sense * rest.x[i] for sense, i in zip(senses[:-1], turning[:-1], strict=True))
        found.append(Placed((*rest.x, senses[-1] * (whole - turned)), rest.free))
    return found


def decoupled(group: tuple[JointAxis, ...], E: Array, near: tuple[float, ...], slack: float) -> list[Placed]:
    """All x with E₁(x₁) ⋯ Eₖ(xₖ) = E (4, 4): up to three turns, by the rotation, and three slides."""
    turning = [i for i, axis in enumerate(group) if not axis.slides]
    turned = rotating(tuple(group[i].w for i in turning), E[:3, :3], tuple(near[i] for i in turning), slack)
    return [
        Placed(_with_slides(group, turning, turns.x, E), frozenset(turning[i] for i in turns.free)) for turns in turned
    ]


def _with_slides(
    group: tuple[JointAxis, ...], turning: list[int], turns: tuple[float, ...], E: Array
) -> tuple[float, ...]:
    """x (k,) from its turns. The slides, which are linear, take the origin where E does, by least squares."""
    x = np.zeros(len(group))
    x[turning] = turns
    slides = [i for i, axis in enumerate(group) if axis.slides]
    directions = np.array([product(group[:i], x[:i])[:3, :3] @ group[i].w for i in slides]).reshape(-1, 3).T
    x[slides] = np.linalg.lstsq(directions, E[:3, 3] - product(group, x)[:3, 3], rcond=None)[0]
    return tuple(float(value) for value in x)
