"""All configurations that meet a pose: times, counts and exactness beside EAIK, ik-geo and ssik, in one run.

Allowed: errors of at most 1e-9 m or rad, and never fewer distinct answers inside the limits than EAIK or ssik.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from .conductor import DEFAULT_FOLDER, NotInstalled, Worker, WorkerError, python_of
from .problems import Judge, Robot, make_robot

PEERS = ("twistarm", "eaik", "ik_geo", "ssik")
HOLDING = {"panda": 6}  # The surplus joint, held at its value in the configuration that made the target.
EXACT, SAME = 1e-9, 1e-5  # What an answer may miss [m, rad], and below which two are one [rad].


def missed(judge: Judge, g: np.ndarray, answers: np.ndarray) -> np.ndarray:
    """Position [m] or rotation error [rad], the greater, of answers (N, n) to one pose, (N,)."""
    errors = judge.errors(answers, np.broadcast_to(g, (len(answers), 4, 4)))
    return np.asarray(np.maximum(errors.position, errors.rotation))


def distinct(judge: Judge, g: np.ndarray, answers: np.ndarray) -> int:
    """How many different ones are exact and inside the limits, whole turns left aside."""
    inside = ((answers >= judge.lower - EXACT) & (answers <= judge.upper + EXACT)).all(axis=1)
    kept: list[np.ndarray] = []
    for theta in answers[inside & (missed(judge, g, answers) <= EXACT)]:
        if all(np.abs((theta - other + np.pi) % (2 * np.pi) - np.pi).max() > SAME for other in kept):
            kept.append(theta)
    return len(kept)


def told(robot: Robot, judge: Judge, workers: dict[str, Worker], random: np.random.Generator, count: int) -> None:
    """One arm's table: every library gets the same target in turn."""
    made: dict[str, list[tuple[float, int, float]]] = {name: [] for name in workers}
    failed: dict[str, str] = {}
    held = HOLDING.get(robot.name)
    ask: dict[str, Any] = {"robot": asdict(robot), "held": held}
    order = list(workers)
    for _ in range(count):
        theta = random.uniform(robot.lower, robot.upper)
        g = judge.fk(theta[None])[0]
        order = order[1:] + order[:1]
        for name in order:
            if name in failed:
                continue
            try:
                value = None if held is None else theta[held]
                answer = workers[name].ask(
                    "all", **ask, g=g.tolist(), start=random.uniform(robot.lower, robot.upper).tolist(), value=value
                )
            except WorkerError as error:
                failed[name] = str(error)
                continue
            found = np.array(answer["theta"]).reshape(-1, len(robot.joints))
            worst = float(missed(judge, g, found).max(initial=0.0))
            made[name].append((answer["ns"] / 1e3, distinct(judge, g, found), worst))
    what = "" if held is None else f", {robot.joints[held]} held"
    print(f"\n{robot.name}{what}: {count} poses of random configurations")
    for name in workers:
        if name in failed:
            print(f"  {name:10s} {failed[name]}")
            continue
        took, number, worst = (np.array(column) for column in zip(*made[name], strict=True))
        own = np.array([each[1] for each in made["twistarm"]])
        fewer = f"   ours fewer: {(own < number).sum()} times" if len(own) == len(number) else ""
        print(
            f"  {name:10s} {np.median(took):9.1f} µs   distinct and exact {number.sum():6d}   "
            f"worst of all given {worst.max():8.1e}{fewer}"
        )


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.all_solutions", description=__doc__)
    options.add_argument("--arms", nargs="+", default=["ur5", "jaco", "so101", "panda", "rover_arm_6dof"])
    options.add_argument("--peers", nargs="+", choices=PEERS, default=list(PEERS))
    options.add_argument("--count", type=int, default=200, help="targets for each arm (default 200)")
    options.add_argument("--seed", type=int, default=20260701)
    options.add_argument("--environments", type=Path, default=DEFAULT_FOLDER, metavar="FOLDER")
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        workers: dict[str, Worker] = {}
        for peer in asked.peers:
            try:
                python = python_of(peer, asked.environments, lambda text: print(text, file=sys.stderr))
            except NotInstalled as error:
                print(f"{peer}: {error}")
                continue
            command = [str(python), "-m", "benchmarks.all_solutions_worker", peer]
            workers[peer] = Worker(command, Path(folder) / f"{peer}.log")
        for name in asked.arms:
            robot = make_robot(name, Path(folder))
            told(robot, Judge(robot), workers, np.random.default_rng(asked.seed), asked.count)
        for worker in workers.values():
            worker.close()


if __name__ == "__main__":
    main()
