"""The tool's target, which a page has solved, and all configurations that reach a target."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ...arm.arm import Arm
from ...ik import AllSolutions, AnyTarget, Approach, Pose, Position, closed_form_of, solve_ik_all
from ...ik.request import as_tolerance
from ...support.checks import Array, pose_of
from ...support.directions import value_in_words
from ...support.errors import InputError
from ...theory import rotations
from ..jobs import Job
from ..messages import Message
from .arm_data import checked_theta, require_all_inside
from .show import Part, Route, Show

LENGTH_TOL = 1e-3  # Rounding of a quaternion's length, from decimal text.

TOLERANCES = {"position": "m", "orientation": "rad"}

# The message without a target.
NO_TARGET: Message = {"type": "target", "given": None, "converged": None, "words": "", "ghost": None}


class TargetPart(Part):
    """Holds at most one target. It is let go once the arm is moved by anything else."""

    def __init__(self) -> None:
        self._status = NO_TARGET
        self._answer: Array | None = None  # the configuration on show, where it is the target's answer
        self.routes = {
            "target": Route(self._take, moves=True),
            "release": Route(lambda show, now: self._release()),
            "tolerances": Route(_set_tolerances),
        }

    def _take(
        self,
        show: Show,
        now: float,
        stage: int,
        theta: list[float],
        converged: bool,
        words: str,
        ghost: list[float],
        **given: Any,
    ) -> None:
        """Show the page's answer to its target: theta (n,) inside the limits, and how well that meets it.

        `stage`: the number in the hello of the arm that it is for. `ghost` (n,): the answer without joint limits, if
        these are the reason of a miss; else empty.
        """
        if stage != show.number:
            raise InputError("another arm was loaded meanwhile: give the target again")
        target_from(show.arm, given)
        answer, free = checked_theta(show.arm, theta), checked_theta(show.arm, ghost or theta)
        require_all_inside(show.arm, answer)
        show.show(answer)
        self._answer = answer
        ghost_shown = free.tolist() if ghost else None
        self._status = {"type": "target", "given": given, "converged": converged, "words": words, "ghost": ghost_shown}

    def messages(self, show: Show) -> Iterator[Message]:
        """The target given, whether it is reached, and the words of its solution."""
        if self._answer is not None and show.theta is not self._answer:
            self._release()
        yield {"type": "tolerances", **{word: show.tolerances.get(f"{word}_tol", 0.0) for word in TOLERANCES}}
        yield self._status

    def _release(self) -> None:
        self._status, self._answer = NO_TARGET, None


def target_from(arm: Arm, fields: Mapping[str, Any]) -> Pose | Position | Approach:
    """The requested target: {kind, position [m], xyzw}. A position needs no direction."""
    p, xyzw = np.array(fields["position"]), fields["xyzw"]
    length = math.hypot(*xyzw)
    if abs(length - 1.0) > LENGTH_TOL:
        raise InputError(f"give a quaternion of length 1, such as 0, 0, 0, 1; got one of length {length:g}")
    if fields["kind"] == "position":
        return Position(p)
    R = rotations.from_xyzw(xyzw)
    if fields["kind"] == "approach":
        return Approach(p, R @ arm.tool_axis, arm.tool_axis)
    return Pose(pose_of(R, p))


def _set_tolerances(show: Show, now: float, **fields: float) -> None:
    """Keep the tolerances for solvers and planners; 0 is the default."""
    show.tolerances = {
        f"{word}_tol": as_tolerance(fields[word], f"{word} [{unit}]")
        for word, unit in TOLERANCES.items()
        if fields[word] != 0.0
    }


MAX_SHOWN = 32  # Most configurations to step through: the nearest inside the limits, then those beyond.
AT_SOLUTION = 1e-3  # An arm within this [rad, m] of a configuration is at it.
# The message before a search.
NO_SOLUTIONS: Message = {"type": "solutions", "requested": False, "places": [], "words": "", "theta": []}


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
        self._current: int | None = None  # the one where the arm stands
        self._goal: Array | None = None  # where the arm stands for it, or is on its way to
        self._number = 0  # of the latest question
        self.routes = {
            "solutions": Route(self._find, moves=True),
            "solution": Route(self._step, moves=True),
            "solutions_end": Route(lambda show, now: self.release()),
        }

    def messages(self, show: Show) -> Iterator[Message]:
        """The configurations, and which of them was chosen."""
        if self._choices is not None and show.goal is not self._goal:
            self.release()
        yield NO_SOLUTIONS if self._choices is None else self._choices.message
        yield {"type": "solution", "at": self._at, "current": self._current}

    def _find(self, show: Show, now: float, **fields: Any) -> Job:
        target, start = target_from(show.arm, fields), show.goal
        self._number += 1
        find = partial(_find_all, show.arm, target, start, show.tolerances)
        finish = partial(self._finish, show, start, self._number)
        return Job("solutions", "looking for all configurations", lambda _: find(), finish)

    def _finish(self, show: Show, start: Array, number: int, choices: Choices) -> None:
        """Show them, unless another was asked for meanwhile, or something moved the arm."""
        if number == self._number and show.goal is start and not show.driven:
            self.take(choices, start)

    def take(self, choices: Choices, goal: Array) -> None:
        """Hold these configurations. The arm stands at `where` (n,)."""
        here = choices.inside > 0 and np.abs(choices.theta[0] - goal).max(initial=0.0) < AT_SOLUTION
        self._choices, self._goal = choices, goal
        self._at = self._current = 0 if here else None

    def _step(self, show: Show, now: float, place: int, ease: bool) -> None:
        """Choose a configuration. The arm goes there if it is inside the limits. Otherwise its ghost shows."""
        if self._choices is None or place >= len(self._choices.theta):
            raise InputError("the arm has moved since: press All configurations again")
        assert self._goal is not None
        inside = place < self._choices.inside
        show.go(self._choices.theta[place] if inside else self._goal, ease, now)
        self._at, self._goal = place, show.goal
        self._current = place if inside else self._current

    @property
    def theta(self) -> Array | None:
        """The configurations (k, n) that are held. None without any."""
        return None if self._choices is None else self._choices.theta

    def release(self) -> None:
        """Let the configurations go."""
        self._choices = self._at = self._current = self._goal = None


def _find_all(arm: Arm, target: AnyTarget, start: Array, tolerances: Mapping[str, Any]) -> Choices:
    """All configurations. Joints that the target does not determine stay where they are."""
    held = {name: float(start[arm.joint_names.index(name)]) for name in closed_form_of(arm, target).held}
    values = [
        f"{name} at {value_in_words(value, arm.units[arm.joint_names.index(name)])}" for name, value in held.items()
    ]
    words = [f"The target leaves joints free; they stay where they are: {', '.join(values)}"] if values else []
    return choices_of(solve_ik_all(arm, target, start, fixed_joints=held, **tolerances), words)


def choices_of(solutions: AllSolutions, more: Sequence[str] = ()) -> Choices:
    """The configurations and their message. `more`: further lines of words."""
    theta = np.vstack([solutions.theta, solutions.outside])[:MAX_SHOWN]
    message = {
        "type": "solutions",
        "requested": True,
        "places": [_place(solutions, row, i) for i, row in enumerate(theta)],
        "words": "\n".join([*solutions.explain().splitlines(), *more]),
        "theta": theta.tolist(),
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
