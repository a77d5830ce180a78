"""Times of motions beside toppra and ruckig: durations and computing times, in one interleaved run.

Allowed along a path: within 1 % of toppra on its automatic grid, computed faster than by toppra on 100 intervals, no
limit exceeded by more than 1e-6 of it. From rest to rest: no longer than ruckig, in 200 µs. A straight line of 0.5 m:
20 ms.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from .conductor import DEFAULT_FOLDER, NotInstalled, Worker, WorkerError, python_of

JOINTS, WAYPOINTS = 7, 10
VELOCITY, ACCELERATION, JERK = 2.0, 5.0, 50.0  # Limits of every joint [rad/s, rad/s², rad/s³].

Row = tuple[str, str, dict[str, Any]]
ALONG: tuple[Row, ...] = (
    ("twistarm", "twistarm", {}),
    ("toppra, 100 intervals", "toppra", {"grid": 100}),
    ("toppra, automatic grid", "toppra", {"grid": None}),
)
TO: tuple[Row, ...] = (("twistarm", "twistarm", {}), ("ruckig", "ruckig", {}))
LINE: tuple[Row, ...] = (("twistarm", "twistarm", {}),)

# twistarm reaches an acceleration limit in this time [s] if there is no jerk limit. Peers get that jerk.
RISE = 0.1


def limits() -> dict[str, list[float]]:
    return {"velocity": [VELOCITY] * JOINTS, "acceleration": [ACCELERATION] * JOINTS, "jerk": [JERK] * JOINTS}


def path(random: np.random.Generator) -> dict[str, Any]:
    """A natural cubic spline through random waypoints, evenly spaced in s."""
    spline = CubicSpline(
        np.linspace(0.0, 1.0, WAYPOINTS), random.uniform(-2.0, 2.0, (WAYPOINTS, JOINTS)), bc_type="natural"
    )
    return {"breakpoints": spline.x.tolist(), "coefficients": spline.c.tolist(), **limits()}


def way(random: np.random.Generator) -> dict[str, Any]:
    """A way of every joint, some long, some short."""
    return {"way": (random.uniform(-3.0, 3.0, JOINTS) * 10.0 ** random.uniform(-4.0, 0.0, JOINTS)).tolist(), **limits()}


def unequal(random: np.random.Generator) -> dict[str, Any]:
    """A way with limits of their own for each joint, some of them without one of jerk."""
    factors = 10.0 ** random.uniform(-1.0, 1.0, (3, JOINTS))
    velocity, acceleration, jerk = factors * np.array([[VELOCITY], [ACCELERATION], [JERK]])
    jerk = np.where(random.random(JOINTS) < 0.3, acceleration / RISE, jerk)
    return way(random) | {"velocity": velocity.tolist(), "acceleration": acceleration.tolist(), "jerk": jerk.tolist()}


def line(random: np.random.Generator) -> dict[str, Any]:
    """A line of 0.5 m that the arm can follow is drawn from the seed."""
    return {"seed": int(random.integers(2**32)), "arm": "ur5", "length": 0.5}


def table(
    title: str, do: str, rows: tuple[Row, ...], cases: list[dict[str, Any]], worker: Callable[[str], Worker]
) -> None:
    """Medians over the cases, which all libraries solve in turn, and ratios to twistarm's."""
    answers: dict[str, list[dict[str, Any]]] = {name: [] for name, _, _ in rows}
    failed: dict[str, str] = {}
    for case in cases:
        for name, peer, settings in rows:
            if name in failed:
                continue
            try:
                answers[name].append(worker(peer).ask(do, **case, **settings))
            except (WorkerError, NotInstalled) as error:
                failed[name] = str(error)
    print(f"\n{title}: median of {len(cases)}")
    ours = answers["twistarm"]
    for name, found in answers.items():
        if name in failed:
            print(f"  {name:24s} {failed[name]}")
            continue
        took = np.array([each["ns"] for each in found]) / 1e3
        longer = np.array([each["duration"] / own["duration"] for each, own in zip(found, ours, strict=True)])
        times = np.array([each["ns"] / own["ns"] for each, own in zip(found, ours, strict=True)])
        beyond = f"   limits passed by {max(each['excess'] for each in found):8.1e}" if "excess" in found[0] else ""
        print(
            f"  {name:24s} {np.median(took):9.1f} µs ({np.median(times):6.2f} ×)   duration {np.median(longer):.5f} × "
            f"({longer.min():.5f} … {longer.max():.5f}){beyond}"
        )


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.timing", description=__doc__)
    options.add_argument("--count", type=int, default=50, help="paths, and ways from rest to rest (default 50)")
    options.add_argument("--seed", type=int, default=20260701)
    options.add_argument("--environments", type=Path, default=DEFAULT_FOLDER, metavar="FOLDER")
    asked = options.parse_args()
    random = np.random.default_rng(asked.seed)
    workers: dict[str, Worker] = {}
    with tempfile.TemporaryDirectory() as folder:

        def worker(peer: str) -> Worker:
            if peer not in workers:
                python = python_of(peer, asked.environments, lambda text: print(text, file=sys.stderr))
                workers[peer] = Worker(
                    [str(python), "-m", "benchmarks.timing_worker", peer], Path(folder) / f"{peer}.log"
                )
            return workers[peer]

        def cases(make: Callable[[np.random.Generator], dict[str, Any]]) -> list[dict[str, Any]]:
            return [make(random) for _ in range(asked.count)]

        title = f"{JOINTS} joints, {VELOCITY:g} rad/s, {ACCELERATION:g} rad/s²"
        table(
            f"time-optimal along a spline through {WAYPOINTS} waypoints, {title}", "along", ALONG, cases(path), worker
        )
        table(f"from rest to rest, {title}, {JERK:g} rad/s³", "to", TO, cases(way), worker)
        table(
            "from rest to rest, limits of their own for each joint, some of no jerk", "to", TO, cases(unequal), worker
        )
        table("a straight line of 0.5 m of a UR5", "line", LINE, cases(line), worker)
        for each in workers.values():
            each.close()


if __name__ == "__main__":
    main()
