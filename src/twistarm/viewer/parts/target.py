"""The tool's target, dragged or typed, and the configuration that meets it best."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from ...arm.arm import Arm
from ...ik import Approach, IKResult, Pose, Position, solve_ik
from ...ik.request import as_tolerance
from ...support.checks import Array
from ...support.errors import InputError
from ...theory import rotations
from ..protocol.jobs import Job
from ..protocol.messages import Message
from ..scene.placement import ghost
from .part import Part, Route, Show

MAX_TIME = 0.5
"""Most seconds of a search. The core needs at most 3 ms. Without it, an unreachable target takes some 0.4 s."""

AT_ONCE = 0.2e-3
"""Most seconds of a search in the loop, which only the compiled core keeps. A dragged target needs a tenth."""

LENGTH_TOL = 1e-3
"""Rounding of a quaternion's length, from decimal text."""

TOLERANCES = {"position": "m", "orientation": "rad"}

NO_TARGET: Message = {"type": "target", "given": None, "met": None, "words": "", "ghost": None}
"""The message without a target."""


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
        others = show.others
        if (solution := solved_at_once(show.arm, search)) is not None:
            finish(_answer(given, solution, others))
            return None
        return Job(
            "target", "solving for the target", lambda _: _answer(given, search(max_time=MAX_TIME), others), finish
        )

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


def solved_at_once(arm: Arm, search: Callable[..., IKResult]) -> IKResult | None:
    """The solution of the first `search`, if it succeeds within AT_ONCE, else None.

    A full search gives the same bits: the first converged search wins, and none was cut short.
    """
    if arm.compiled is None:
        return None
    begin = time.perf_counter()
    solution = search(restarts=1, max_time=AT_ONCE)
    in_time = time.perf_counter() - begin < AT_ONCE
    return solution if solution.converged and in_time else None


def _answer(given: dict[str, Any], solution: IKResult, others: Mapping[str, float]) -> tuple[Array, Message]:
    """The configuration to show (n,), and the message about it."""
    message = {"type": "target", "given": given, "met": solution.converged, "words": solution.explain()}
    return solution.theta, {**message, "ghost": ghost(solution, others)}
