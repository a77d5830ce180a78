"""Calibration of a measured arm beside RobotKineCal, on rows that were not fitted.

`--data FOLDER` holds ur5_tracker_grid.csv (README.md says whose it is).
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from twistarm import load_arm

from .conductor import DEFAULT_FOLDER, NotInstalled, Worker, WorkerError, python_of

Array = np.ndarray[Any, np.dtype[np.float64]]

FOLDS, BLOCK = 5, 0.2


def kabsch(a: Array, b: Array) -> Array:
    """The rigid motion (4, 4) that takes points a (K, 3) nearest to b."""
    ca, cb = a.mean(axis=0), b.mean(axis=0)
    U, _, Vt = np.linalg.svd((b - cb).T @ (a - ca))
    g = np.eye(4)
    g[:3, :3] = U @ np.diag([1, 1, np.linalg.det(U @ Vt)]) @ Vt
    g[:3, 3] = cb - g[:3, :3] @ ca
    return g


def tracker_rows(file: Path) -> tuple[Array, Array]:
    """Commanded theta (K, 6) [rad] and measured positions (K, 3) [m]."""
    rows = np.genfromtxt(file, delimiter=",", names=True)
    theta = np.radians(np.column_stack([rows[f"joint_{i}"] for i in range(1, 7)]))
    return theta, np.column_stack([rows[f"{a}_t"] - rows[f"{a}_dif"] for a in "xyz"]) / 1000.0


def base_and_tool(arm: Any, theta: Array, positions: Array) -> tuple[Array, Array]:
    """The base (4, 4) and the point beyond the tip (3,) that fit best with the nominal arm, in turn."""
    g, tool = arm.fk(theta), np.zeros(3)
    for _ in range(200):
        base = kabsch(g[:, :3, :3] @ tool + g[:, :3, 3], positions)
        R = (base[:3, :3] @ g[:, :3, :3]).reshape(-1, 3)
        left = positions - g[:, :3, 3] @ base[:3, :3].T - base[:3, 3]
        tool = np.linalg.lstsq(R, left.ravel(), rcond=None)[0]
    return base, tool


def splits(positions: Array, rng: np.random.Generator) -> dict[str, list[Array]]:
    """Rows left out: random folds, and the fifth of the rows farthest along x, y and z, to both sides."""
    K = len(positions)
    order = rng.permutation(K)
    few = int(BLOCK * K)
    sorted_rows = [np.argsort(positions[:, axis]) for axis in range(3)]
    blocks = [rows for along in sorted_rows for rows in (along[:few], along[-few:])]
    return {"random folds": [order[k::FOLDS] for k in range(FOLDS)], "a block left out": blocks}


def told_tracker(file: Path, environments: Path, most: int) -> None:
    arm, (theta, positions) = load_arm("ur5"), tracker_rows(file)
    print(f"\nUR5, {len(theta)} postures with a tracker: mean error on rows left out [mm], processor time of a fit [s]")
    with tempfile.TemporaryDirectory() as folder:
        workers = {}
        for name in ("twistarm", "robotkinecal"):
            try:
                python = python_of(name, environments, print)
            except NotInstalled as error:
                print(f"  {name} cannot be installed: {error}")
                continue
            command = [str(python), "-m", "benchmarks.calibration_worker", name]
            workers[name] = Worker(command, Path(folder) / f"{name}.txt", seconds=600.0)
        for what, folds in splits(positions, np.random.default_rng(0)).items():
            told_splits(arm, theta, positions, f"{what}, {min(most, len(folds))}", folds[:most], workers)


def told_splits(arm: Any, theta: Array, positions: Array, what: str, folds: list[Array], workers: Any) -> None:
    errors: dict[str, list[float]] = {name: [] for name in ("base and tool alone", *workers)}
    seconds: dict[str, list[float]] = {name: [] for name in workers}
    for out in folds:
        kept = np.setdiff1d(np.arange(len(theta)), out)
        base, tool = base_and_tool(arm, theta[kept], positions[kept])
        home, seen = arm.home.copy(), (positions - base[:3, 3]) @ base[:3, :3]
        home[:3, 3] += home[:3, :3] @ tool
        g = arm.fk(theta[out])
        errors["base and tool alone"].append(missed(g[:, :3, :3] @ tool + g[:, :3, 3], seen[out]))
        for name, worker in list(workers.items()):
            message = {"arm": "ur5", "screws": arm.screws.tolist(), "home": home.tolist()}
            try:
                answer = worker.ask(
                    "fit",
                    **message,
                    theta=theta[kept].tolist(),
                    positions=seen[kept].tolist(),
                    asked=theta[out].tolist(),
                )
            except WorkerError as error:
                print(f"  {name}: {error}")
                del workers[name], errors[name]
                continue
            errors[name].append(missed(np.array(answer["predicted"]), seen[out]))
            seconds[name].append(answer["ns"] / 1e9)
    for name, each in errors.items():
        took = f"   {np.median(seconds[name]):6.1f} s" if name in seconds else ""
        print(f"  {what:20s} {name:20s} mean {np.mean(each):.4f}   worst {max(each):.4f}{took}", flush=True)


def missed(found: Array, exact: Array) -> float:
    return float(1e3 * np.linalg.norm(found - exact, axis=1).mean())


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=__doc__)
    parser.add_argument(
        "--data", type=Path, default=os.environ.get("TWISTARM_CALIBRATION"), help="folder of the measured set"
    )
    parser.add_argument(
        "--folds", type=int, default=6, help="of the tracker's rows, at most; RobotKineCal takes a minute each"
    )
    parser.add_argument("--environments", type=Path, default=DEFAULT_FOLDER)
    given = parser.parse_args(arguments)
    if given.data is None:
        print("nothing to calibrate: give --data FOLDER or TWISTARM_CALIBRATION", file=sys.stderr)
        return
    told_tracker(Path(given.data) / "ur5_tracker_grid.csv", given.environments, given.folds)


if __name__ == "__main__":
    main()
