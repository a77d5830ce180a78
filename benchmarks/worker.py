"""A worker process: one solver, one robot, its own environment. `python -m benchmarks.worker PEER`.

It reads one JSON object per line from its standard input and answers with one line each:

  {"do": "open", "robot": …}                  {"settings": text, "versions": {…}, "abilities": […]} or {"unfit": why}
  {"do": "solve", "targets", "starts"}        {"theta", "converged", "reasons", "ns"}: a list entry per target
  {"do": "batch", "targets", "starts", "threads"}   {"theta", "converged", "ns"}: ns of the whole call
  {"do": "kinematics", "theta", "calls", "check"}   {"one fk": {"ns", "result"}, …}: ns for each configuration,
                                              and the poses, or poses and Jacobians, of the rows to check

Nothing but the standard library and NumPy is imported here: the environment is the peer's.
"""

from __future__ import annotations

import gc
import importlib
import importlib.metadata
import sys
from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import numpy as np

from .peers import serve

Function = Callable[[np.ndarray], Any]

WARM_UP = 1_000_000  # ns of untimed calls before a chunk, because the other workers have just used the caches.
REPEATS = 5  # Of what takes too little time to be measured once.


class Worker:
    """The solver of a peer's module, with its abilities."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.solver: Any = None

    def answer(self, message: dict[str, Any]) -> dict[str, Any]:
        asked: Callable[..., dict[str, Any]] = getattr(self, f"_{message.pop('do')}")
        return asked(**message)

    def _open(self, robot: dict[str, Any]) -> dict[str, Any]:
        solver = importlib.import_module(f".peers.{self.name}", __package__).Solver
        self.solver = solver(robot)
        return {
            "settings": solver.settings,
            "versions": {name: importlib.metadata.version(name) for name in solver.distributions},
            "abilities": [name for name in ("solve", "batch", "kinematics") if hasattr(solver, name)],
        }

    def _solve(self, targets: list[Any], starts: list[Any]) -> dict[str, Any]:
        goals, begins = np.array(targets), np.array(starts)
        gc.collect()
        gc.disable()
        warm = perf_counter_ns() + WARM_UP
        while perf_counter_ns() < warm:
            self.solver.solve(goals[0], begins[-1])
        answers = [self._timed(g, start) for g, start in zip(goals, begins, strict=True)]
        gc.enable()
        theta, converged, reasons, ns = zip(*answers, strict=True)
        return {"theta": list(theta), "converged": list(converged), "reasons": list(reasons), "ns": list(ns)}

    def _timed(self, g: np.ndarray, start: np.ndarray) -> tuple[list[float] | None, bool, str, int]:
        begin = perf_counter_ns()
        answer = self.solver.solve(g, start)
        ns = perf_counter_ns() - begin
        theta, converged = answer[:2]
        reason = self.solver.reason(answer[2]) if len(answer) > 2 else ""
        return None if theta is None else np.asarray(theta, dtype=float).tolist(), bool(converged), reason, ns

    def _batch(self, targets: list[Any], starts: list[Any], threads: int) -> dict[str, Any]:
        goals, begins = np.array(targets), np.array(starts)
        self.solver.batch(goals[:100], begins[:100], threads)
        begin = perf_counter_ns()
        theta, converged = self.solver.batch(goals, begins, threads)
        ns = perf_counter_ns() - begin
        return {"theta": np.asarray(theta).tolist(), "converged": np.asarray(converged).tolist(), "ns": ns}

    def _kinematics(self, theta: list[Any], calls: int, check: list[int]) -> dict[str, Any]:
        rows = np.array(theta)
        answer: dict[str, Any] = {}
        for way, functions in self.solver.kinematics().items():
            time = _batch_time if way == "batch" else _call_time
            for name, function in functions.items():
                ns, result = time(function, rows, calls, check)
                answer[f"{way} {name}"] = {"ns": ns, "result": [_plain(part) for part in result]}
        return answer


def _call_time(function: Function, rows: np.ndarray, calls: int, check: list[int]) -> tuple[float, list[Any]]:
    """ns of one call, over `calls` of them, and what it gives for the rows to check."""
    given = [rows[i % len(rows)] for i in range(calls)]

    def each() -> None:
        for row in given:
            function(row)

    return _median_ns(each) / calls, [function(rows[i]) for i in check]


def _batch_time(function: Function, rows: np.ndarray, calls: int, check: list[int]) -> tuple[float, list[Any]]:
    """ns for each row of a batch, and what it gives for the rows to check."""
    result = function(rows)
    rows_checked = [tuple(part[i] for part in result) if isinstance(result, tuple) else result[i] for i in check]
    return _median_ns(lambda: function(rows)) / len(rows), rows_checked


def _median_ns(run: Callable[[], Any]) -> float:
    """Of REPEATS runs."""
    times = []
    for _ in range(REPEATS):
        begin = perf_counter_ns()
        run()
        times.append(perf_counter_ns() - begin)
    return float(np.median(times))


def _plain(result: Any) -> Any:
    """A pose, or a pose and a Jacobian, as lists."""
    return [np.asarray(part).tolist() for part in (result if isinstance(result, tuple) else (result,))]


if __name__ == "__main__":
    serve(Worker(sys.argv[1]).answer)
