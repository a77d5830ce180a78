"""Calibration of measured arms beside RobotKineCal and MUKCa, on rows and placements that were not fitted.

`--data FOLDER` holds ur5_tracker_grid.csv and sockets/ (README.md says whose they are).

A ball in two sockets: how still it stands and how far apart the two are. Beside ours stands the objective of MUKCa
(Franzese et al. 2025, arXiv 2503.12584), solved by SciPy: the origins of all joints and of the ball, 6 numbers each,
with the means of the predicted balls, their distance, and a ridge.
"""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from itertools import combinations
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from twistarm import Arm, load_arm
from twistarm.calibration import Measurements, calibrate
from twistarm.theory.rotations import exp as turn
from twistarm.theory.rotations import from_rpy, to_rpy

from .conductor import DEFAULT_FOLDER, NotInstalled, Worker, WorkerError, python_of

Array = np.ndarray[Any, np.dtype[np.float64]]
Placements = dict[str, list[Array]]

FOLDS, BLOCK = 5, 0.2
ROBOTS = {"kuka_14": "iiwa14.urdf", "panda_1": "panda.urdf"}
APART, RIDGE = 0.05, 1e-4


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


def placements(folder: Path) -> Placements:
    """{placement: theta (K, n) in each of the two sockets}."""
    return {
        place.name: [np.loadtxt(place / f"hole_{k}.csv", delimiter=",") for k in (0, 1)]
        for place in sorted(folder.iterdir())
    }


def spread(balls: list[Array]) -> tuple[float, float]:
    """The mean distance of the balls from their socket's mean, and the error of the distance of the two means [m]."""
    means = [p.mean(axis=0) for p in balls]
    off = np.concatenate([np.linalg.norm(p - mean, axis=1) for p, mean in zip(balls, means, strict=True)])
    return float(off.mean()), float(abs(np.linalg.norm(means[0] - means[1]) - APART))


def ours(arm: Arm, data: Placements, fitted: tuple[str, ...]) -> Any:
    theta = np.vstack([rows for name in fitted for rows in data[name]])
    points = [f"{name} {k}" for name in fitted for k in (0, 1) for _ in data[name][k]]
    apart = {(f"{name} 0", f"{name} 1"): APART for name in fitted}
    return calibrate(arm, Measurements(theta, point=points), distances=apart).predict


def theirs(arm: Arm, data: Placements, fitted: tuple[str, ...]) -> Any:
    assert arm.description is not None
    chain = arm.description.chain(arm.base, arm.tip_link)
    nominal = np.array([np.r_[joint.origin[:3, 3], to_rpy(joint.origin[:3, :3])] for joint in chain])
    free = [i for i, joint in enumerate(chain) if joint.moving or i == len(chain) - 1]

    def balls(origins: Array, theta: Array) -> Array:
        p, R, columns = np.zeros((len(theta), 3)), np.tile(np.eye(3), (len(theta), 1, 1)), iter(theta.T)
        for joint, origin in zip(chain, origins, strict=True):
            p, R = p + R @ origin[:3], R @ from_rpy(origin[3:])
            if joint.moving:
                R = R @ turn(next(columns)[:, None] * joint.twist[3:])
        return p

    def moved(values: Array) -> Array:
        origins = nominal.copy()
        origins[free] = values.reshape(-1, 6)
        return origins

    def residual(values: Array) -> Array:
        origins, parts = moved(values), []
        for name in fitted:
            both = [balls(origins, rows) for rows in data[name]]
            means, count = [p.mean(axis=0) for p in both], sum(map(len, both))
            parts += [((p - mean) / np.sqrt(count)).ravel() for p, mean in zip(both, means, strict=True)]
            parts.append(np.array([np.linalg.norm(means[0] - means[1]) - APART]))
        parts.append(np.sqrt(len(fitted) * RIDGE) * (origins - nominal)[free[:-1]].ravel())
        return np.concatenate(parts)

    found = least_squares(residual, nominal[free].ravel(), xtol=1e-12, ftol=1e-12, gtol=1e-14, max_nfev=60)
    return lambda theta: balls(moved(found.x), theta)


def told_sockets(folder: Path) -> None:
    print("\nTwo sockets, placements not fitted: mean distance from the socket's mean, error of the 50 mm [mm]")
    for robot, urdf in ROBOTS.items():
        arm, data = load_arm(folder / urdf, tip="ball_link"), placements(folder / robot)
        for count in range(1, len(data)):
            rows: dict[str, list[tuple[float, float]]] = {"nominal": [], "twistarm": [], "MUKCa's objective": []}
            took = dict.fromkeys(rows, 0.0)
            for fitted in combinations(data, count):
                for name, fit in (("twistarm", ours), ("MUKCa's objective", theirs)):
                    begin = process_time()
                    predict = fit(arm, data, fitted)
                    took[name] += process_time() - begin
                    rows[name] += [
                        spread([predict(theta) for theta in data[each]]) for each in data if each not in fitted
                    ]
                nominal = [[arm.fk(theta)[:, :3, 3] for theta in data[each]] for each in data if each not in fitted]
                rows["nominal"] += map(spread, nominal)
            for name, pairs in rows.items():
                off, apart = 1e3 * np.array(pairs).T
                seconds = took[name] * (len(data) - count) / len(pairs)
                print(
                    f"  {robot:8s} {count} fitted  {name:18s} spread {off.mean():.3f} "
                    f"({off.min():.3f} … {off.max():.3f})   distance {apart.mean():.3f}   {seconds:5.1f} s",
                    flush=True,
                )


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=__doc__)
    parser.add_argument(
        "--data", type=Path, default=os.environ.get("TWISTARM_CALIBRATION"), help="folder of measured sets"
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
    told_sockets(Path(given.data) / "sockets")


if __name__ == "__main__":
    main()
