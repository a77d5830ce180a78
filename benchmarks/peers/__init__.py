"""The solvers that are compared, one module each.

A module has a class `Solver(robot)`, made from the robot's message (`robots.Robot`), with

  settings, distributions        a sentence for the footnotes; the distributions whose versions are noted
  solve(g, start)                theta or None, whether it claims to have converged, and what `reason` reads, if any
  batch(targets, starts, threads)   optional: theta (N, n) and converged (N,)
  kinematics()                   optional: {"one" | "unchecked" | "batch": {"fk" | "fk_jacobian": function of theta}}

It raises `Unfit` for an arm that it does not take. Its imports are inside the module. It runs in an environment made
from requirements-<name>.txt, without twistarm.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

PEERS = ("twistarm", "pinocchio", "roboticstoolbox", "pytracik", "ssik", "eaik", "placo", "pink")


class Unfit(Exception):  # noqa: N818
    """This solver does not take this arm, and why."""


def serve(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answer the messages on standard input, a line of JSON each. What libraries print goes to standard error.

    What `answer` raises is the answer {"unfit": why} or {"error": text}. Numbers pass JSON unchanged to the last bit.
    """
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        try:
            made = answer(json.loads(line))
        except Unfit as reason:
            made = {"unfit": str(reason)}
        except Exception as error:  # the conductor reports it; the worker stays
            made = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(made) + "\n")
        answers.flush()


def timed(call: Callable[[], Any], calls: int = 5) -> tuple[Any, int]:
    """What the call returns, and the ns of the fastest of several, because noise of the machine only adds time."""
    took = []
    for _ in range(calls):
        start = perf_counter_ns()
        result = call()
        took.append(perf_counter_ns() - start)
    return result, min(took)
