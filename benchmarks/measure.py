"""The measurements on one arm: single calls of every kind, batches, forward kinematics and Jacobians.

Figures are rows, dictionaries of names and values: times in µs, `strict` the share of targets that Pinocchio confirms,
`wrong` the answers that a solver called converged and Pinocchio does not confirm, `remark` why there are no figures.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import problems as make
from .conductor import Answers, Worker, WorkerError, interleave
from .problems import Judge, Robot, make_robot

Row = dict[str, Any]

ROUNDS = 5  # Of batches and kinematics, in turn; their median is reported.
CHECKED = 100  # Configurations of a batch whose poses and Jacobians Pinocchio checks.


@dataclass(frozen=True)
class Plan:
    """How much is measured, from which seed."""

    targets: int
    unreachable: int
    batch: int
    calls: int
    seed: int


@dataclass
class Results:
    """Everything that was found."""

    single: list[Row] = field(default_factory=list)
    batch: list[Row] = field(default_factory=list)
    kinematics: list[Row] = field(default_factory=list)
    settings: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)
    """Peers that could not be installed, and why."""


def measure(
    arm: str, pythons: dict[str, Path], plan: Plan, folder: Path, results: Results, say: Callable[[str], None]
) -> None:
    """Add one arm's figures to the results."""
    robot = make_robot(arm, folder)
    judge = Judge(robot)
    say(f"{arm}: {len(pythons)} solvers get ready")
    workers, unfit, abilities = opened(robot, pythons, folder, results)
    try:
        rows = []
        for problems in (
            make.cold(robot, judge, plan.targets),
            make.cold(robot, judge, plan.targets, plan.seed),
            make.warm(robot, judge, plan.targets),
            make.unreachable(robot, judge, plan.unreachable),
        ):
            say(f"{arm}: {len(problems)} {problems.kind} targets for each of {len(workers)} solvers")
            answers = unfit | interleave(workers, problems, len(robot.joints))
            rows += [single_calls(arm, peer, problems, answers[peer], judge) for peer in pythons]
        medians = {(row["peer"], row["kind"]): row["median"] for row in rows}
        for row in rows:
            row["ratio"] = row["median"] / medians.get(("twistarm", row["kind"]), np.nan)
            row["to_cold"] = row["median"] / medians.get((row["peer"], "cold"), np.nan)
        results.single += rows
        say(f"{arm}: batches of {plan.batch} targets")
        able = {peer: worker for peer, worker in workers.items() if "batch" in abilities[peer]}
        results.batch += batches(arm, able, make.cold(robot, judge, plan.batch), judge)
        say(f"{arm}: forward kinematics and Jacobians")
        able = {peer: worker for peer, worker in workers.items() if "kinematics" in abilities[peer]}
        results.kinematics += kinematics(arm, able, robot, plan, judge)
    finally:
        for worker in workers.values():
            worker.close()


def opened(
    robot: Robot, pythons: dict[str, Path], folder: Path, results: Results
) -> tuple[dict[str, Worker], dict[str, str], dict[str, list[str]]]:
    """The workers that take this robot, why the others do not, and what each can do."""
    workers: dict[str, Worker] = {}
    unfit: dict[str, str] = {}
    abilities: dict[str, list[str]] = {}
    for peer, python in pythons.items():
        worker = Worker([str(python), "-m", "benchmarks.worker", peer], folder / f"{robot.name}-{peer}.log")
        try:
            answer = worker.ask("open", robot=asdict(robot))
        except WorkerError as reason:
            worker.close()
            unfit[peer] = str(reason)
            continue
        workers[peer] = worker
        abilities[peer] = answer["abilities"]
        results.settings[peer] = answer["settings"]
        results.versions |= answer["versions"]
    return workers, unfit, abilities


def single_calls(arm: str, peer: str, problems: make.Problems, answers: Answers | str, judge: Judge) -> Row:
    """One solver, one arm, one kind of problem. `motion` is the largest change of a joint where the target is met."""
    row: Row = {"arm": arm, "peer": peer, "kind": problems.kind, "targets": len(problems), "wrong": 0, "reasons": {}}
    row |= dict.fromkeys(("strict", "median", "p99", "mean", "motion"), np.nan) | {"remark": ""}
    if isinstance(answers, str):
        return row | {"remark": answers}
    strict, us = judge.errors(answers.theta, problems.targets).strict, answers.ns / 1e3
    moved = np.abs(answers.theta - problems.starts)[strict]
    return row | {
        "strict": float(strict.mean()),
        "wrong": int((answers.converged & ~strict).sum()),
        "median": float(np.median(us)),
        "p99": float(np.percentile(us, 99)),
        "mean": float(us.mean()),
        "motion": float(moved.max()) if strict.any() else np.nan,
        "reasons": dict(Counter(str(reason) for reason in answers.reasons if reason).most_common()),
    }


def batches(arm: str, workers: dict[str, Worker], problems: make.Problems, judge: Judge) -> list[Row]:
    """Each worker with one thread and with two, in turn; `each` is the time of a target."""
    message: dict[str, Any] = {"targets": problems.targets.tolist(), "starts": problems.starts.tolist()}
    rows = [
        {"arm": arm, "peer": peer, "threads": threads, "strict": np.nan, "each": np.nan, "wrong": 0, "remark": ""}
        for peer in workers
        for threads in (1, 2)
    ]
    times: list[list[float]] = [[] for _ in rows]
    for _ in range(ROUNDS):
        for row, took in zip(rows, times, strict=True):
            if row["remark"]:
                continue
            try:
                answer = workers[row["peer"]].ask("batch", threads=row["threads"], **message)
            except WorkerError as reason:
                row["remark"] = str(reason)
                continue
            took.append(answer["ns"] / 1e3 / len(problems))
            strict = judge.errors(np.array(answer["theta"]), problems.targets).strict
            wrong = int((np.array(answer["converged"]) & ~strict).sum())
            row |= {"each": float(np.median(took)), "strict": float(strict.mean()), "wrong": wrong}
    return rows


def kinematics(arm: str, workers: dict[str, Worker], robot: Robot, plan: Plan, judge: Judge) -> list[Row]:
    """Forward kinematics, alone and with the body Jacobian, for one configuration and for a batch, in turn.

    `times` are those of a configuration, and `difference` is the largest from Pinocchio's numbers.
    """
    theta = make.configurations(robot, plan.seed, plan.batch)[:, 0]
    check = np.linspace(0, len(theta) - 1, min(CHECKED, len(theta))).astype(int)
    expected = judge.fk(theta[check]), judge.jacobian(theta[check])
    rows = [{"arm": arm, "peer": peer, "times": {}, "difference": np.nan, "remark": ""} for peer in workers]
    times: list[dict[str, list[float]]] = [{} for _ in rows]
    for _ in range(ROUNDS):
        for row, took in zip(rows, times, strict=True):
            message = {"theta": theta.tolist(), "calls": plan.calls, "check": check.tolist()}
            try:
                answer = workers[row["peer"]].ask("kinematics", **message)
            except WorkerError as reason:
                row["remark"] = str(reason)
                continue
            for name, part in answer.items():
                took.setdefault(name, []).append(part["ns"] / 1e3)
            row["times"] = {name: float(np.median(each)) for name, each in took.items()}
            row["difference"] = max(_difference(part["result"], expected) for part in answer.values())
    return rows


def _difference(result: list[list[Any]], expected: tuple[np.ndarray, np.ndarray]) -> float:
    """Of poses, or poses and Jacobians, row by row, from Pinocchio's."""
    given = [np.array(part) for part in zip(*result, strict=True)]
    return max(float(np.abs(part - right).max()) for part, right in zip(given, expected, strict=False))
