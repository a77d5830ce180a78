"""One library that times motions, in its own environment. `python -m benchmarks.timing_worker PEER`.

It reads one JSON object per line and answers with one line each, as `worker.py` does:

  {"do": "along", "breakpoints", "coefficients", "velocity", "acceleration", "grid"}   {"duration", "excess", "ns"}
  {"do": "to", "way", "velocity", "acceleration", "jerk"}                             {"duration", "ns"}
  {"do": "through", "waypoints", "velocity", "acceleration"}                          {"duration", "excess", "ns"}
  {"do": "line", "seed", "arm", "length"}                                             {"duration", "ns"}

`grid` is the number of intervals, or null for an automatic grid. `excess` is the largest excess over a limit, as a part
of it, by the library's own evaluation at 20 times as many instants as the result has pieces. `ns` is the least of
several calls.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import numpy as np

CALLS = 5
"""Repetitions. The fastest counts, because noise of the machine only adds time."""

Answer = dict[str, Any]
Asked = dict[str, Any]


def timed(call: Callable[[], Any], calls: int = CALLS) -> tuple[Any, int]:
    """What the call returns, and the ns of the fastest."""
    took = []
    for _ in range(calls):
        start = perf_counter_ns()
        result = call()
        took.append(perf_counter_ns() - start)
    return result, min(took)


def excess(rates: tuple[np.ndarray, np.ndarray], asked: Asked) -> float:
    """By which part the largest velocity or acceleration passes its limit."""
    limits = asked["velocity"], asked["acceleration"]
    return max(float((np.abs(rate) / limit).max()) for rate, limit in zip(rates, limits, strict=True)) - 1.0


def twistarm_along(asked: Asked) -> Answer:
    from twistarm.limits import JointLimits
    from twistarm.planning.piecewise import JointPath, derivative, evaluate
    from twistarm.planning.time_law import PathBounds
    from twistarm.planning.time_optimal import time_optimal

    path = JointPath(np.array(asked["breakpoints"]), np.array(asked["coefficients"]))
    given = {rate: np.array(asked[rate]) for rate in ("velocity", "acceleration")}
    free = vars(JointLimits.unbounded(path.n))
    bounds = PathBounds(JointLimits(**{**free, **given}))
    law, ns = timed(lambda: time_optimal(path, bounds))
    breakpoints, coefficients = law.along(path)
    tau = np.diff(breakpoints)[:, None] * np.linspace(0.0, 1.0, 20)
    rates = [
        np.concatenate([evaluate(derivative(coefficients, order), at[:, None]) for at in tau.T]) for order in (1, 2)
    ]
    return {"duration": law.duration, "ns": ns, "excess": excess((rates[0], rates[1]), asked)}


def twistarm_to(asked: Asked) -> Answer:
    from twistarm.limits import JointLimits
    from twistarm.planning.s_curve import double_s
    from twistarm.planning.time_law import PathBounds

    way = np.array(asked["way"])
    given = {rate: np.array(asked[rate]) for rate in ("velocity", "acceleration", "jerk")}
    bounds = PathBounds(JointLimits(**{**vars(JointLimits.unbounded(len(way))), **given}))
    (breakpoints, _), ns = timed(lambda: double_s(np.zeros_like(way), way, bounds))
    return {"duration": float(breakpoints[-1]), "ns": ns}


def twistarm_through(asked: Asked) -> Answer:
    from twistarm import arm_from_screws, plan_joint

    n = len(asked["velocity"])
    names = [f"joint{i + 1}" for i in range(n)]
    given = {rate: dict(zip(names, asked[rate], strict=True)) for rate in ("velocity", "acceleration")}
    arm = arm_from_screws(np.eye(6)[:, [5] * n], np.eye(4), joints=names, limits=given)
    motion, ns = timed(lambda: plan_joint(arm, asked["waypoints"], kind="time_optimal"))
    t = np.linspace(0.0, motion.duration, 20 * len(motion.breakpoints))
    return {"duration": motion.duration, "ns": ns, "excess": excess((motion(t, 1), motion(t, 2)), asked)}


def twistarm_line(asked: Asked) -> Answer:
    from twistarm import LineMove, PathError, load_arm, plan

    arm, random = load_arm(asked["arm"], limits={"acceleration": 5.0}), np.random.default_rng(asked["seed"])
    while True:
        start, way = random.uniform(arm.limits.lower, arm.limits.upper), random.normal(size=3)
        move = LineMove.by(asked["length"] * way / np.linalg.norm(way), frame="base")
        try:
            motion, ns = timed(lambda start=start, move=move: plan(arm, move, start=start))
        except PathError:
            continue
        return {"duration": motion.duration, "ns": ns}


def toppra_along(asked: Asked) -> Answer:
    import toppra
    from scipy.interpolate import PPoly
    from toppra import algorithm, constraint

    toppra.setup_logging("CRITICAL")
    pieces = PPoly(np.array(asked["coefficients"]), np.array(asked["breakpoints"]))
    both = np.array([[-1.0, 1.0]])
    velocity, acceleration = (np.array(asked[rate])[:, None] * both for rate in ("velocity", "acceleration"))
    path = toppra.SplineInterpolator(pieces.x, pieces(pieces.x), bc_type="natural")
    grid = None if asked["grid"] is None else np.linspace(0.0, pieces.x[-1], asked["grid"] + 1)

    def solve() -> Any:
        limits = [constraint.JointVelocityConstraint(velocity), constraint.JointAccelerationConstraint(acceleration)]
        found = algorithm.TOPPRA(
            limits, path, gridpoints=grid, solver_wrapper="seidel", parametrizer="ParametrizeConstAccel"
        )
        return found.compute_trajectory(), len(found.gridpoints)

    (motion, points), ns = timed(solve)
    t = np.linspace(0.0, motion.duration, 20 * points)
    return {"duration": float(motion.duration), "ns": ns, "excess": excess((motion(t, 1), motion(t, 2)), asked)}


def ruckig_to(asked: Asked) -> Answer:
    import ruckig

    n = len(asked["way"])
    otg, given, motion = ruckig.Ruckig(n), ruckig.InputParameter(n), ruckig.Trajectory(n)
    given.current_position, given.target_position = [0.0] * n, asked["way"]
    given.max_velocity, given.max_acceleration, given.max_jerk = asked["velocity"], asked["acceleration"], asked["jerk"]
    _, ns = timed(lambda: otg.calculate(given, motion))
    return {"duration": float(motion.duration), "ns": ns}


ANSWERS: dict[tuple[str, str], Callable[[Asked], Answer]] = {
    ("twistarm", "along"): twistarm_along,
    ("twistarm", "to"): twistarm_to,
    ("twistarm", "through"): twistarm_through,
    ("twistarm", "line"): twistarm_line,
    ("toppra", "along"): toppra_along,
    ("ruckig", "to"): ruckig_to,
}


def main() -> None:
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        asked = json.loads(line)
        try:
            answer = ANSWERS[sys.argv[1], asked["do"]](asked)
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
