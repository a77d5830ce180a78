"""One library that times motions, in its own environment. `python -m benchmarks.timing_worker PEER`.

It reads one JSON object per line and answers with one line each, as `worker.py` does:

  {"do": "along", "breakpoints", "coefficients", "velocity", "acceleration", "grid"}   {"duration", "excess", "ns"}
  {"do": "to", "way", "velocity", "acceleration", "jerk"}                             {"duration", "ns"}
  {"do": "line", "seed", "arm", "length"}                                             {"duration", "ns"}

`grid` is the number of intervals, or null for an automatic grid. `excess` is the largest excess over a limit, as a part
of it, by the library's own evaluation at 20 times as many instants as the result has pieces. `ns` is the least of
several calls.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from .peers import serve, timed

Answer = dict[str, Any]
Asked = dict[str, Any]


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
    ("twistarm", "line"): twistarm_line,
    ("toppra", "along"): toppra_along,
    ("ruckig", "to"): ruckig_to,
}


if __name__ == "__main__":
    serve(lambda asked: ANSWERS[sys.argv[1], asked["do"]](asked))
