"""The method to find all configurations for a kind of target: a family, elimination, or a search.

It follows from the axes alone. It is looked for once for each arm and kind, and kept with the arm.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Set
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...arm import engine
from ...arm.arm import Arm
from ...arm.arm_data import kept
from ...support.checks import Array
from ...support.errors import InputError
from ...theory.screws import inverse
from ..ranges import locked_joints
from ..targets import AnyTarget, Approach, Pose, Position, TargetLike, checked_target
from .chain import MOST_JOINTS, AxisChain, JointAxis, Plane, chain_for, goal, product
from .elimination import Candidates, Elimination, Lines, elimination_for
from .families import (
    DECOUPLED,
    EXACT_MISS,
    NEAR_MISS,
    Family,
    closest_miss,
    families,
    family_in_words,
    missed_in_words,
    off_in_words,
)  # fmt: skip

if TYPE_CHECKING:
    from ..._core import ClosedForm

SAMPLE = 0.3  # Value [rad, m] of held joints in the search for their family. Almost every value shows it.


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
    arm: Arm, chain: AxisChain, family: Family, held: tuple[int, ...], idle: Set[int]
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
    kept = None if fitted.kept is None else fitted.kept.moved(back[carrier])
    keeps, four = 0, np.zeros(4)
    if kept is not None:
        keeps, four = (2, np.append(kept.n, kept.d)) if isinstance(kept, Plane) else (1, np.append(kept.p, 0.0))
    return ClosedFormParameters(
        family.first, family.last, keeps, _numbers(at_zero),
        np.array([joint if joint < arm.n else -1 for joint in joints], dtype=np.float64),
        four, np.array(held, dtype=np.float64), _numbers([chain.axes[i] for i in held]),
        np.array(chain.rates), np.array(arm.home), np.array([float(i in idle) for i in range(arm.n)]),
    )  # fmt: skip


def _carried(chain: AxisChain, held: tuple[int, ...], joint: int) -> Array:
    """The motion (4, 4) that the held joints before this one have given it."""
    before = tuple(chain.axes[i] for i in held if i < joint)
    return product(before, np.full(len(before), SAMPLE))


def _numbers(axes: list[JointAxis]) -> Array:
    """(k, 7): w, o, and 1 for a slide."""
    return np.array([[*axis.w, *axis.o, float(axis.slides)] for axis in axes]).reshape(-1, 7)


SLACK = 1e-6  # Relative miss of a subproblem that is rounding on an exact arm, as when it is stretched.
# The same for axes that miss their family. A root of the true arm may not be one of the exact arm.
SLACK_NEARLY = 0.05
MOST_WAYS = 1000  # Most choices of held joints to try. Ten joints have 210 for a pose, twenty some 39,000.
FITS_APPROACH = 5  # Joints that an `Approach` determines.

CLOSED_FORM, ELIMINATION, SEARCH = "closed form", "elimination", "search from many starts"


@dataclass(frozen=True, eq=False)
class Method:
    """A way by a `family`, or by elimination if it is `elimination`. With neither, `reason` says why.

    `held`: joints of the arm that are `given` or sampled, because the target does not determine them. `idle`: held
    joints that move only free parts of the target, so one value is enough. `numbers` and `core`: the family for the
    core and in it. `verifier`: what verifies the candidates of elimination in the core.
    """

    chain: AxisChain
    held: tuple[int, ...]
    given: tuple[int, ...]
    idle: tuple[int, ...]
    family: Family | None = None
    elimination: Elimination | None = None
    off: float = 0.0
    reason: str = ""
    numbers: ClosedFormParameters | None = None
    core: ClosedForm | None = None
    verifier: ClosedForm | None = None

    @property
    def algebraic(self) -> bool:
        """Whether there is a family or an elimination."""
        return self.family is not None or self.elimination is not None

    @property
    def exact(self) -> bool:
        """Whether the candidates hold every answer: by an exact family or by elimination."""
        return self.elimination is not None or (self.family is not None and self.off <= EXACT_MISS)

    @property
    def name(self) -> str:
        """The way in a word or two."""
        return CLOSED_FORM if self.family is not None else ELIMINATION if self.elimination is not None else SEARCH

    def in_words(self, arm: Arm) -> str:
        """The family, or why the axes have none."""
        if self.family is None:
            if self.elimination is None:
                return self.reason
            return f"{'five' if self.elimination.still else 'six'} joints that turn, with any axes"
        axes, _ = self.chain.held(self.held, np.full(len(self.held), SAMPLE))
        fitted = self.family.fitted(axes)
        what = family_in_words(arm, fitted, self.chain.left(self.held))
        return what if self.exact else f"{what} but for {off_in_words(fitted)}"

    @cached_property
    def sampled(self) -> tuple[int, ...]:
        """Held joints, beside those given, that give other configurations for each value."""
        return tuple(i for i in self.held if i not in self.idle and i not in self.given)

    def candidates(self, arm: Arm, target: AnyTarget, near: Array, values: Array, exact: bool) -> Array:
        """Candidates theta (k, n), held joints at `values`. Free joints are at `near` (n,) first, then elsewhere.

        `exact`: whether only rounding of numbers, not of axes, makes candidates miss a subproblem.
        """
        if self.elimination is not None:
            lines, G = self._lines(goal(arm, target), values)
            return self._theta(self.elimination.nearby(lines, G), values)
        if len(self.held) == arm.n:
            return values[None]
        assert self.core is not None, "the solvers ask for the core"
        return engine.answered(self.core.candidates(target.numbers, near, values, SLACK if exact else SLACK_NEARLY))

    def eliminated(self, arm: Arm, target: AnyTarget, values: Array) -> Iterator[Candidates]:
        """The candidates (k, n) of elimination in one way after another, for what leaves no doubt."""
        assert self.elimination is not None
        lines, G = self._lines(goal(arm, target), values)
        for way in self.elimination.ways:
            x, answers = self.elimination.candidates(lines, way, G)
            yield Candidates(self._theta(x, values), answers)

    def _lines(self, G: Array, values: Array) -> tuple[Lines, Array]:
        """The lines that elimination solves, and the factor G (4, 4) without held joints."""
        assert self.elimination is not None
        if not self.held:
            return self._own_lines, G
        axes, behind = self.chain.held(self.held, self.chain.rates[list(self.held)] * values)
        return self.elimination.lines(axes), G @ behind

    @cached_property
    def _own_lines(self) -> Lines:
        assert self.elimination is not None
        return self.elimination.lines(self.chain.axes)

    def _theta(self, x: Array, values: Array) -> Array:
        """theta (k, n) of x, without what the target leaves free."""
        held, solved = list(self.held), [i for i in range(self.chain.n) if i not in self.held]
        theta = np.empty((len(x), self.chain.n))
        theta[:, held] = values
        theta[:, solved] = x[:, : len(solved)] / self.chain.rates[solved]
        return theta

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "core": None, "verifier": None}  # what is compiled belongs to this process


_METHODS = "closed-form methods"  # Their key among what is kept with an arm.


def known_method(arm: Arm, like: type[AnyTarget], axis: bytes | None) -> Method | None:
    """The kept method for targets of this type, for an Approach with this tool axis. None before `method_for`."""
    methods: dict[object, Method] = kept(arm, _METHODS, dict)
    return methods.get((like, (), axis, False))


def method_for(arm: Arm, target: AnyTarget, given: tuple[int, ...] = (), *, families_alone: bool = False) -> Method:
    """The method for targets like this one, with the joints `given` held, and others if necessary.

    A joint with limits of one value is given. `families_alone`: without elimination, which takes long to set up.
    """
    given = tuple(sorted({*given, *locked_joints(arm)}))
    key = type(target), given, target.axis.tobytes() if isinstance(target, Approach) else None, families_alone
    methods: dict[object, Method] = kept(arm, _METHODS, dict)
    if key not in methods:
        methods[key] = _in_core(arm, target, _find_method(arm, target, given, families_alone=families_alone))
    return methods[key]


def family_for(arm: Arm, target: AnyTarget) -> Method | None:
    """The family in the core for targets like this one, with at most one sampled joint, or None.

    If the axes nearly fit a family, it is that of the nearest exact arm (`Method.exact`).
    """
    free = {Pose: 0, Approach: 1, Position: 3}.get(type(target), MOST_JOINTS)
    if arm.n - len(locked_joints(arm)) + free > MOST_JOINTS + 1:
        return None
    method = method_for(arm, target, families_alone=True)
    return method if method.core is not None and len(method.sampled) <= 1 else None


def _in_core(arm: Arm, target: AnyTarget, method: Method) -> Method:
    """The method, with its family in the core, or what verifies its candidates there."""
    family = method.family
    if method.elimination is not None:  # all joints together, as the core is not asked to solve for them
        left = len(method.chain.left(method.held))
        family = Family(DECOUPLED, tuple(range(left)), 0, left)
    if family is None or not family.order:  # with every joint given nothing is solved
        return method
    numbers = family_numbers(arm, method.chain, family, method.held, {*method.held} - {*method.given})
    made = None if arm.compiled is None else engine.asked("ClosedForm", arm.compiled, target.kind, *numbers)
    if method.elimination is not None:
        return replace(method, verifier=made)
    return replace(method, numbers=numbers, core=made)


def _find_method(arm: Arm, target: AnyTarget, given: tuple[int, ...], *, families_alone: bool = False) -> Method:
    try:
        chain = chain_for(arm, target)
    except InputError as error:
        return Method(AxisChain((), np.ones(arm.n), arm.reach), given, given, (), reason=str(error))
    idle = tuple(i for i in range(arm.n) if i not in given and chain.idle(i))
    surplus = chain.surplus(given)
    rest = [i for i in range(arm.n) if i not in idle and i not in given]
    first = (*given, *idle[:surplus])
    more = max(surplus - len(idle), 0)
    if math.comb(len(rest), more) > MOST_WAYS:
        reason = f"{more} of its {len(rest)} joints would have to be held, in too many ways to try"
        return Method(chain, given, given, idle, reason=reason)
    ways = [tuple(sorted((*first, *held))) for held in itertools.combinations(rest[::-1], more)]
    found = _by_family(arm, chain, ways, given, idle)
    if families_alone or (found is not None and found.exact):
        return found or Method(chain, given, given, idle)
    return found or _by_elimination(arm, chain, ways, given, idle)


def _by_family(
    arm: Arm, chain: AxisChain, ways: list[tuple[int, ...]], given: tuple[int, ...], idle: tuple[int, ...]
) -> Method | None:
    """The way to hold joints that leaves the axes nearest to a family."""
    best: Method | None = None
    for held in ways:
        axes, _ = chain.held(held, np.full(len(held), SAMPLE))
        if len(axes) > MOST_JOINTS:
            continue
        for fitted in families(axes, arm.reach)[:1]:
            off = fitted.off_share(arm.reach)
            if best is None or off < best.off - EXACT_MISS:
                best = Method(chain, held, given, tuple(i for i in idle if i in held), fitted.family, off=off)
    return best


def _by_elimination(
    arm: Arm, chain: AxisChain, ways: list[tuple[int, ...]], given: tuple[int, ...], idle: tuple[int, ...]
) -> Method:
    """The first choice of held joints that leaves axes for elimination, or why no choice does."""
    for held in ways:
        axes, _ = chain.held(held, np.full(len(held), SAMPLE))
        way = elimination_for(axes, arm.reach)
        if way is not None:
            return Method(chain, held, given, tuple(i for i in idle if i in held), elimination=way)
    misses = [miss for held in ways if (miss := _miss(arm, chain, held)) is not None]
    none = 0.0, "no three of its axes that follow one another meet in a point or are parallel"
    return Method(chain, ways[0] if ways else (), given, idle, reason=min(misses, default=none)[1])


def closest_miss_of(arm: Arm, method: Method) -> tuple[float, str]:
    """How far the axes miss their family or the nearest: in shares of the reach or rad, and in words.

    (0, "") where they miss nothing.
    """
    if method.exact and method.family is not None:
        return 0.0, ""
    return _miss(arm, method.chain, method.held, method.family) or (0.0, "")


def _miss(arm: Arm, chain: AxisChain, held: tuple[int, ...], family: Family | None = None) -> tuple[float, str] | None:
    axes, _ = chain.held(held, np.full(len(held), SAMPLE))
    if not axes or len(axes) > MOST_JOINTS:
        return None
    miss = closest_miss(axes, arm.reach) if family is None else family.fitted(axes)
    if miss is None:
        return None
    return miss.off_share(arm.reach), missed_in_words(arm, miss, axes, chain.left(held))


@dataclass(frozen=True)
class ClosedFormReport:
    """How `solve_ik_all` finds every configuration of an arm, for one kind of `target`.

    method: "closed form", "elimination" or "search from many starts". family: the family in words; for a search, why
    the axes have none. exact: whether every configuration is found, with the joints `held` at their values. held:
    joints that the target does not determine, base to tip. miss: which axes miss a family by least, and by how much; ""
    if none do. nearly: whether that is so little that it looks like rounding.
    """

    target: str
    method: str
    family: str
    exact: bool
    held: tuple[str, ...] = ()
    miss: str = ""
    nearly: bool = False

    def __str__(self) -> str:
        held = f", for each value of {' and '.join(self.held)}" if self.held else ""
        miss = f"; {self.miss}" if self.method == ELIMINATION and self.miss else ""
        return f"{self.method}, {self.family}{held}{miss}"


def closed_form_of(arm: Arm, like: TargetLike | None = None) -> ClosedFormReport:
    """The report for targets like this one. By default an approach for five joints, else a pose."""
    target = _usual(arm) if like is None else checked_target(arm, like)
    method = method_for(arm, target)
    off, miss = closest_miss_of(arm, method)
    held = tuple(arm.joint_names[i] for i in method.sampled)
    return ClosedFormReport(
        type(target).__name__, method.name, method.in_words(arm), method.exact, held, miss,
        nearly=bool(miss) and off <= NEAR_MISS,
    )  # fmt: skip


def _usual(arm: Arm) -> AnyTarget:
    g = arm.home
    approach = Approach(g[:3, 3], g[:3, :3] @ arm.tool_axis, arm.tool_axis)
    return approach if arm.n == FITS_APPROACH and not method_for(arm, approach).sampled else Pose(g)
