"""Targets and starts, repeatable from a seed.

cold         target: the pose of a configuration uniform in the limits; start: another one
fresh        the same from the seed of this run
warm         target: the pose of a configuration 0.01 rad away from the start
unreachable  the targets of cold, moved straight away from the first joint to 1.05 to 1.5 times the arm's reach
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .judge import Judge
from .robots import ARMS, Robot

SEED = 20260701
"""Of the problems that every run has in common."""

WARM_DISTANCE = 0.01
"""From the start of a warm problem to its solution [rad], the norm over the joints."""

FARTHEST = 1.5
"""Unreachable targets lie at 1.05 to this times the reach."""


@dataclass(frozen=True)
class Problems:
    """N targets (N, 4, 4) and starts (N, n)."""

    kind: str
    targets: np.ndarray
    starts: np.ndarray

    def __len__(self) -> int:
        return len(self.targets)

    def part(self, start: int, stop: int) -> Problems:
        return Problems(self.kind, self.targets[start:stop], self.starts[start:stop])


def generator(robot: Robot, seed: int) -> np.random.Generator:
    return np.random.default_rng([seed, list(ARMS).index(robot.name)])


def configurations(robot: Robot, seed: int, count: int) -> np.ndarray:
    """(count, 3, n): goal and start, uniform in the limits, and a unit vector. The first ones are equal for any
    count.
    """
    rng = generator(robot, seed)
    return np.array([_draw(rng, np.array(robot.lower), np.array(robot.upper)) for _ in range(count)])


def cold(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    goal, start, _ = configurations(robot, seed, count).swapaxes(0, 1)
    return Problems("cold" if seed == SEED else "fresh", judge.fk(goal), start)


def warm(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    _, start, direction = configurations(robot, seed, count).swapaxes(0, 1)
    step = WARM_DISTANCE * direction
    out = (start + step < robot.lower) | (start + step > robot.upper)
    return Problems("warm", judge.fk(start + np.where(out, -step, step)), start)


def unreachable(robot: Robot, judge: Judge, count: int, seed: int = SEED) -> Problems:
    problems = cold(robot, judge, count, seed)
    centre = np.array(robot.axis_frames)[0, :3, 3]
    ray = problems.targets[:, :3, 3] - centre
    far = np.random.default_rng([seed, count]).uniform(1.05, FARTHEST, (count, 1)) * robot.reach
    problems.targets[:, :3, 3] = centre + far * ray / np.linalg.norm(ray, axis=1, keepdims=True)
    return Problems("unreachable", problems.targets, problems.starts)


def chunks(problems: Problems, size: int) -> Iterator[Problems]:
    for start in range(0, len(problems), size):
        yield problems.part(start, start + size)


def _draw(rng: np.random.Generator, lower: np.ndarray, upper: np.ndarray) -> list[np.ndarray]:
    goal, start, direction = rng.uniform(lower, upper), rng.uniform(lower, upper), rng.normal(size=lower.size)
    return [goal, start, direction / np.linalg.norm(direction)]
