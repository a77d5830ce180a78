"""The measurements on one arm: single calls of every kind, batches, forward kinematics and Jacobians."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from . import problems as make
from .conductor import Worker, WorkerError, interleave
from .figures import Batch, Kinematics, SingleCalls, compare, single_calls
from .judge import Judge
from .robots import Robot, make_robot

ROUNDS = 5
"""Of batches and kinematics, in turn; their median is reported."""

CHECKED = 100
"""Configurations of a batch whose poses and Jacobians Pinocchio checks."""


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

    single: list[SingleCalls] = field(default_factory=list)
    batch: list[Batch] = field(default_factory=list)
    kinematics: list[Kinematics] = field(default_factory=list)
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
        for problems in kinds(robot, judge, plan):
            say(f"{arm}: {len(problems)} {problems.kind} targets for each of {len(workers)} solvers")
            answers = unfit | interleave(workers, problems, len(robot.joints))
            rows += [single_calls(arm, peer, problems, answers[peer], judge) for peer in pythons]
        compare(rows)
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
        worker = Worker([str(python), "-m", f"{__package__}.worker", peer], folder / f"{robot.name}-{peer}.log")
        try:
            answer = worker.ask("open", robot=robot.as_message())
        except WorkerError as reason:
            worker.close()
            unfit[peer] = str(reason)
            continue
        workers[peer] = worker
        abilities[peer] = answer["abilities"]
        results.settings[peer] = answer["settings"]
        results.versions |= answer["versions"]
    return workers, unfit, abilities


def kinds(robot: Robot, judge: Judge, plan: Plan) -> list[make.Problems]:
    return [
        make.cold(robot, judge, plan.targets),
        make.cold(robot, judge, plan.targets, plan.seed),
        make.warm(robot, judge, plan.targets),
        make.unreachable(robot, judge, plan.unreachable),
    ]


def batches(arm: str, workers: dict[str, Worker], problems: make.Problems, judge: Judge) -> list[Batch]:
    """Each worker with one thread and with two, in turn."""
    rows = {(peer, threads): Batch(arm, peer, threads, len(problems)) for peer in workers for threads in (1, 2)}
    times: dict[tuple[str, int], list[float]] = {key: [] for key in rows}
    message: dict[str, Any] = {"targets": problems.targets.tolist(), "starts": problems.starts.tolist()}
    for round_ in range(ROUNDS):
        for (peer, threads), row in rows.items():
            if row.remark:
                continue
            try:
                answer = workers[peer].ask("batch", threads=threads, **message)
            except WorkerError as reason:
                row.remark = str(reason)
                continue
            times[peer, threads].append(answer["ns"] / 1e3 / len(problems))
            row.each = float(np.median(times[peer, threads]))
            if round_ == 0:
                strict = judge.errors(np.array(answer["theta"]), problems.targets).strict
                row.strict = float(strict.mean())
                row.wrong = int((np.array(answer["converged"]) & ~strict).sum())
    return list(rows.values())


def kinematics(arm: str, workers: dict[str, Worker], robot: Robot, plan: Plan, judge: Judge) -> list[Kinematics]:
    """Forward kinematics, alone and with the body Jacobian, for one configuration and for a batch, in turn."""
    theta = make.configurations(robot, plan.seed, plan.batch)[:, 0]
    check = np.linspace(0, len(theta) - 1, min(CHECKED, len(theta))).astype(int)
    expected = judge.fk(theta[check]), judge.jacobian(theta[check])
    rows = {peer: Kinematics(arm, peer) for peer in workers}
    times: dict[str, dict[str, list[float]]] = {peer: {} for peer in workers}
    for round_ in range(ROUNDS):
        for peer, row in rows.items():
            try:
                answer = workers[peer].ask("kinematics", theta=theta.tolist(), calls=plan.calls, check=check.tolist())
            except WorkerError as reason:
                row.remark = str(reason)
                continue
            for name, part in answer.items():
                times[peer].setdefault(name, []).append(part["ns"] / 1e3)
            row.times = {name: float(np.median(each)) for name, each in times[peer].items()}
            if round_ == 0:
                row.difference = max(_difference(part["result"], expected) for part in answer.values())
    return list(rows.values())


def _difference(result: list[list[Any]], expected: tuple[np.ndarray, np.ndarray]) -> float:
    """Of poses, or poses and Jacobians, row by row, from Pinocchio's."""
    given = [np.array(part) for part in zip(*result, strict=True)]
    return max(float(np.abs(part - right).max()) for part, right in zip(given, expected, strict=False))
