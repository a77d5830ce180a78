"""Figures from answers: success as Pinocchio judges it, times, and what was claimed wrongly."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from .conductor import Answers
from .judge import Judge
from .problems import Problems


@dataclass
class SingleCalls:
    """One solver, one arm, one kind of problem. Times in µs; `remark` says why there are no figures."""

    arm: str
    peer: str
    kind: str
    targets: int = 0
    strict: float = float("nan")
    """The share of targets met."""
    median: float = float("nan")
    p99: float = float("nan")
    mean: float = float("nan")
    ratio: float = float("nan")
    """Of the median to twistarm's."""
    to_cold: float = float("nan")
    """Of the median to the solver's own median on cold targets."""
    wrong: int = 0
    """Answers that the solver called converged and Pinocchio does not confirm."""
    motion: float = float("nan")
    """The largest change of a joint from the start, over the answers that meet the target [rad]."""
    reasons: dict[str, int] = field(default_factory=dict)
    remark: str = ""


@dataclass
class Batch:
    """Whole batches: µs per target, and the share of targets met."""

    arm: str
    peer: str
    threads: int
    targets: int = 0
    strict: float = float("nan")
    each: float = float("nan")
    wrong: int = 0
    remark: str = ""


@dataclass
class Kinematics:
    """µs per configuration for {"one fk", "one fk_jacobian", "unchecked …", "batch …"}, and the largest difference from
    Pinocchio's numbers.
    """

    arm: str
    peer: str
    times: dict[str, float] = field(default_factory=dict)
    difference: float = float("nan")
    remark: str = ""


def single_calls(arm: str, peer: str, problems: Problems, answers: Answers | str, judge: Judge) -> SingleCalls:
    figures = SingleCalls(arm, peer, problems.kind, len(problems))
    if isinstance(answers, str):
        figures.remark = answers
        return figures
    strict = judge.errors(answers.theta, problems.targets).strict
    us = answers.ns / 1e3
    figures.strict, figures.wrong = float(strict.mean()), int((answers.converged & ~strict).sum())
    figures.median, figures.p99, figures.mean = (float(x) for x in (np.median(us), np.percentile(us, 99), us.mean()))
    if strict.any():
        figures.motion = float(np.abs(answers.theta - problems.starts)[strict].max())
    figures.reasons = dict(Counter(reason for reason in answers.reasons if reason).most_common())
    return figures


def compare(rows: list[SingleCalls]) -> None:
    """Fill in the ratios of one arm's rows."""
    medians = {(row.peer, row.kind): row.median for row in rows}
    for row in rows:
        row.ratio = row.median / medians.get(("twistarm", row.kind), float("nan"))
        row.to_cold = row.median / medians.get((row.peer, "cold"), float("nan"))
