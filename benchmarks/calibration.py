"""Calibration: measured arms beside RobotKineCal and MUKCa, simulated truth, and logs with a student's mistakes.

`--data FOLDER` holds ur5_tracker_grid.csv and sockets/ (README.md says whose they are); without it only what is
simulated is run.
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

from twistarm import load_arm

from .calibration_faults import told_faults
from .calibration_sockets import ours, placements, spread, theirs
from .calibration_truth import KINDS, arms, kabsch, score, truth_at_zero
from .conductor import Worker, WorkerError
from .environments import DEFAULT_FOLDER, NotInstalled, python_of
from .servo_arms import MODELS

Array = np.ndarray[Any, np.dtype[np.float64]]

PARTS = ("tracker", "sockets", "truth", "faults")
FOLDS, BLOCK = 5, 0.2
ROBOTS = {"kuka_14": "iiwa14.urdf", "panda_1": "panda.urdf"}


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


def told_truth(names: list[str], kinds: list[str], seeds: int) -> None:
    print(
        "\nSimulated truth: error of a coordinate on new postures in σ of the noise, worst of the seeds (nominal arm)"
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, make in arms(Path(folder)).items():
            if names and name not in names:
                continue
            if "TWISTARM_MODELS" not in os.environ and name in MODELS:
                continue
            arm = make()
            for kind in kinds:
                try:
                    found = [score(arm, kind, seed) for seed in range(seeds)]
                except ValueError as error:
                    print(f"  {name:15s} {kind:10s} {error}", flush=True)
                    continue
                ratios = [end for each in found for end in each.ratio]
                claimed = sorted({one for each in found for one in each.claimed})
                off, nominal = max(each.off for each in found), max(each.nominal for each in found)
                print(
                    f"  {name:15s} {kind:10s} {off:6.2f} ({nominal:3.0f})   "
                    f"seen {min(e.seen for e in found)}…{max(e.seen for e in found)}   "
                    f"σ {min(ratios):.2f}…{max(ratios):.2f}   "
                    f"confirmed {sum(e.confirmed for e in found)} of {seeds}   "
                    f"{np.mean([e.seconds for e in found]):5.1f} s"
                    + (f"   claimed: {', '.join(claimed)}" if claimed else ""),
                    flush=True,
                )
            for kind in [each for each in ("positions", "poses") if each in kinds]:
                z, changed = truth_at_zero(arm, kind, 5)
                print(
                    f"  {name:15s} {kind:10s} numbers of the joints: worst {np.abs(z).max():.1f} σ, "
                    f"rms {np.sqrt((z * z).mean()):.2f}, chosen otherwise {changed}",
                    flush=True,
                )


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=__doc__)
    parser.add_argument(
        "--data", type=Path, default=os.environ.get("TWISTARM_CALIBRATION"), help="folder of measured sets"
    )
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--arms", nargs="+", default=[], help="of the simulated ones, all by default")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument(
        "--folds", type=int, default=6, help="of the tracker's rows, at most; RobotKineCal takes a minute each"
    )
    parser.add_argument("--environments", type=Path, default=DEFAULT_FOLDER)
    given = parser.parse_args(arguments)
    measured = [part for part in ("tracker", "sockets") if part in given.parts]
    if measured and given.data is None:
        print(f"without --data no {' and no '.join(measured)}", file=sys.stderr)
    elif measured:
        folder = Path(given.data)
        if "tracker" in measured:
            told_tracker(folder / "ur5_tracker_grid.csv", given.environments, given.folds)
        if "sockets" in measured:
            told_sockets(folder / "sockets")
    if "truth" in given.parts:
        told_truth(given.arms, list(given.kinds), given.seeds)
    if "faults" in given.parts:
        told_faults(given.arms or ["ur5", "rover_arm"])


if __name__ == "__main__":
    main()
