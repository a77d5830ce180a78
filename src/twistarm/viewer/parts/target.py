"""The tool's target, dragged or typed: the configuration that meets it best, or all that meet it."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...ik import AllSolutions, AnyTarget, Approach, IKResult, Pose, Position, closed_form_of, solve_ik, solve_ik_all
from ...ik.request import as_tolerance
from ...support.checks import Array
from ...support.directions import value_in_words
from ...support.errors import InputError
from ...theory import rotations
from ..jobs import Job
from ..messages import Message
from ..scene.kinematics import Placement, link_matrices
from .show import Part, Route, Show

# Most seconds of a search. The core needs at most 3 ms. Without it, an unreachable target takes some 0.4 s.
MAX_TIME = 0.5
# Most seconds of a search in the loop, and joints: only the compiled core keeps them. A dragged target needs a tenth.
AT_ONCE, MOST_AT_ONCE = 0.2e-3, 32
LENGTH_TOL = 1e-3  # Rounding of a quaternion's length, from decimal text.

TOLERANCES = {"position": "m", "orientation": "rad"}

# The message without a target.
NO_TARGET: Message = {"type": "target", "given": None, "met": None, "words": "", "ghost": None}


class TargetPart(Part):
    """Holds at most one target. It is let go once the arm is moved by anything else."""

    def __init__(self) -> None:
        self._status = NO_TARGET
        self._shown: Array | None = None  # the configuration on show, where it is the target's answer
        self._wanted = False  # whether an answer may still come
        self._number = self._answered = 0  # of the latest target asked for, and of the one whose answer is on show
        self.routes = {
            "target": Route(self._solve, moves=True),
            "release": Route(lambda show, now: self._release()),
            "tolerances": Route(_set_tolerances),
        }

    def _solve(self, show: Show, now: float, **given: Any) -> Job | None:
        """Solve for a target from the present configuration.

        One short search answers at once; only a failure becomes a job.
        """
        target = target_asked(show.arm, given)
        show.show(show.theta)  # a running trajectory stops
        self._number += 1
        self._wanted = True
        finish = partial(self._finish, show, show.theta, self._number)
        search = partial(solve_ik, show.arm, target, show.theta, posture="theta0", **show.tolerances)
        if show.arm.n <= MOST_AT_ONCE and show.arm.compiled is not None:
            begin = time.perf_counter()
            solution = search(restarts=1, max_time=AT_ONCE)
            # A full search gives the same bits: the first converged search wins, and none was cut short.
            if solution.converged and time.perf_counter() - begin < AT_ONCE:
                finish(_answer(given, solution, show.others))
                return None
        answer = partial(_answer, given, others=show.others)
        return Job("target", "solving for the target", lambda _: answer(search(max_time=MAX_TIME)), finish)

    def messages(self, show: Show) -> Iterator[Message]:
        """The target given, whether it is met, and the words of its solution."""
        if self._shown is not None and show.theta is not self._shown:
            self._release()
        yield {"type": "tolerances", **{word: show.tolerances.get(f"{word}_tol", 0.0) for word in TOLERANCES}}
        yield self._status

    def _finish(self, show: Show, start: Array, number: int, answer: tuple[Array, Message]) -> None:
        """Show the answer unless a later target came, the user released it, or the arm moved."""
        moved = show.theta is not start and show.theta is not self._shown
        if number < self._answered or not self._wanted or moved or show.driven or show.moving:
            return
        self._answered = number
        self._shown, self._status = answer
        show.show(self._shown)

    def _release(self) -> None:
        self._status, self._shown, self._wanted = NO_TARGET, None, False


def target_asked(arm: Arm, fields: Mapping[str, Any]) -> Pose | Position | Approach:
    """The requested target: {kind, position [m], xyzw}. A position needs no direction."""
    p, xyzw = np.array(fields["position"]), fields["xyzw"]
    length = math.hypot(*xyzw)
    if abs(length - 1.0) > LENGTH_TOL:
        raise InputError(f"xyzw must be a quaternion of length 1, as 0, 0, 0, 1 is; got one of length {length:g}")
    if fields["kind"] == "position":
        return Position(p)
    R = rotations.from_xyzw(xyzw)
    if fields["kind"] == "approach":
        return Approach(p, R @ arm.tool_axis, arm.tool_axis)
    g = np.eye(4)
    g[:3, :3], g[:3, 3] = R, p
    return Pose(g)


def _set_tolerances(show: Show, now: float, **fields: float) -> None:
    """Keep the tolerances for solvers and planners; 0 is the default."""
    show.tolerances = {
        f"{word}_tol": as_tolerance(fields[word], f"{word} [{unit}]")
        for word, unit in TOLERANCES.items()
        if fields[word] != 0.0
    }


def _answer(given: dict[str, Any], solution: IKResult, others: Mapping[str, float]) -> tuple[Array, Message]:
    """The configuration to show (n,), and the message about it.

    `ghost`: where each link would stand without joint limits, if they are the reason of a miss.
    """
    free = solution.unlimited
    ghost = None if free is None else link_matrices(Placement(solution.arm), free, others)
    message = {"type": "target", "given": given, "met": solution.converged, "words": solution.explain(), "ghost": ghost}
    return solution.theta, message


MAX_SHOWN = 32  # Most configurations to step through: the nearest inside the limits, then those beyond.
AT_SOLUTION = 1e-3  # An arm within this [rad, m] of a configuration is at it.
# The message before a search.
NO_SOLUTIONS: Message = {"type": "solutions", "asked": False, "places": [], "words": "", "ghosts": []}


class Choices(NamedTuple):
    """theta (k, n), those inside the limits first, how many these are, and the message."""

    theta: Array
    inside: int
    message: Message


class Solutions(Part):
    """Holds the configurations of one target. They are let go once the arm is moved by anything else."""

    def __init__(self) -> None:
        self._choices: Choices | None = None
        self._at: int | None = None  # the configuration that was chosen
        self._stands: int | None = None  # the one where the arm stands
        self._where: Array | None = None  # where the arm stands for it, or is on its way to
        self._number = 0  # of the latest question
        self.routes = {
            "solutions": Route(self._find, moves=True),
            "solution": Route(self._step, moves=True),
            "solutions_end": Route(lambda show, now: self.release()),
        }

    def messages(self, show: Show) -> Iterator[Message]:
        """The configurations, and which of them was chosen."""
        if self._choices is not None and show.goal is not self._where:
            self.release()
        yield NO_SOLUTIONS if self._choices is None else self._choices.message
        yield {"type": "solution", "at": self._at, "stands": self._stands}

    def _find(self, show: Show, now: float, **fields: Any) -> Job:
        target, start = target_asked(show.arm, fields), show.goal
        self._number += 1
        find = partial(_found, show.arm, target, start, dict(show.others), show.tolerances)
        finish = partial(self._finish, show, start, self._number)
        return Job("solutions", "looking for all configurations", lambda _: find(), finish)

    def _finish(self, show: Show, start: Array, number: int, choices: Choices) -> None:
        """Show them, unless another was asked for meanwhile, or something moved the arm."""
        if number == self._number and show.goal is start and not show.driven:
            self.take(choices, start)

    def take(self, choices: Choices, where: Array) -> None:
        """Hold these configurations; the arm stands at `where` (n,)."""
        here = choices.inside > 0 and np.abs(choices.theta[0] - where).max(initial=0.0) < AT_SOLUTION
        self._choices, self._where = choices, where
        self._at = self._stands = 0 if here else None

    def _step(self, show: Show, now: float, place: int, ease: bool) -> None:
        """Choose a configuration. The arm goes there if it is inside the limits; otherwise its ghost shows."""
        if self._choices is None or place >= len(self._choices.theta):
            raise InputError("these configurations were let go, because the arm was moved: ask for all of them again")
        assert self._where is not None
        inside = place < self._choices.inside
        show.go(self._choices.theta[place] if inside else self._where, ease, now)
        self._at, self._where = place, show.goal
        self._stands = place if inside else self._stands

    @property
    def theta(self) -> Array | None:
        """The configurations (k, n) that are held; None without any."""
        return None if self._choices is None else self._choices.theta

    def release(self) -> None:
        """Let the configurations go."""
        self._choices = self._at = self._stands = self._where = None


def _found(
    arm: Arm, target: AnyTarget, start: Array, others: Mapping[str, float], tolerances: Mapping[str, Any]
) -> Choices:
    """All configurations; joints that the target does not determine stay where they are."""
    held = {name: float(start[arm.joint_names.index(name)]) for name in closed_form_of(arm, target).held}
    values = [
        f"{name} at {value_in_words(value, arm.units[arm.joint_names.index(name)])}" for name, value in held.items()
    ]
    words = [f"held where the arm stands, because the target leaves it free: {', '.join(values)}"] if values else []
    return choices_of(solve_ik_all(arm, target, start, fixed_joints=held, **tolerances), others, words)


def choices_of(solutions: AllSolutions, others: Mapping[str, float], more: Sequence[str] = ()) -> Choices:
    """The configurations and their message; `more`: further lines of words."""
    theta = np.vstack([solutions.theta, solutions.outside])[:MAX_SHOWN]
    placement = Placement(solutions.arm)
    message = {
        "type": "solutions",
        "asked": True,
        "places": [_place(solutions, each, i) for i, each in enumerate(theta)],
        "words": "\n".join([*solutions.explain().splitlines(), *more]),
        "ghosts": [link_matrices(placement, each, others) for each in theta],
    }
    return Choices(theta, min(len(solutions), MAX_SHOWN), message)


def _place(solutions: AllSolutions, theta: Array, i: int) -> dict[str, list[str]]:
    """The free joints of a configuration and the joints beyond their limits, in words."""
    if i < len(solutions):
        return {"free": list(solutions.free[i]), "beyond": []}
    arm, limits = solutions.arm, solutions.arm.limits
    beyond = []
    for name, value, lower, upper, unit in zip(
        arm.joint_names, theta, limits.lower, limits.upper, arm.units, strict=True
    ):
        if not lower <= value <= upper:
            sign, limit = ("<", lower) if value < lower else (">", upper)
            beyond.append(f"{name} {value_in_words(value, unit)} {sign} {value_in_words(limit, unit)}")
    return {"free": [], "beyond": beyond}
