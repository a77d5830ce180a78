"""Calibration of a measured arm beside RobotKineCal, and hand-eye calibration beside OpenCV's on simulated logs.

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

from twistarm import calibrate, load_arm, screws
from twistarm.calibration import Measurements

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


ARMS = ("rover_arm", "rover_arm_6dof", "ur5", "panda", "so101")
POSES = (12, 16, 24, 40)
WRONG = (1.0, 3.0)  # degrees, of inner joints: of the first and the last no log shows the zero


def cameras(environments: Path, logs: int) -> None:
    """Errors of the camera's pose, by twistarm and by the best method of calibrateHandEye, on simulated logs."""
    python = python_of("opencv", environments, print)
    print(
        f"\nhand-eye calibration, {logs} logs of 12 to 40 poses, corners with 0.5 pixels of noise at 600: error of the"
    )
    print("camera, median and worst [mm] and median [°]; OpenCV by its method with the least median")
    with tempfile.TemporaryDirectory() as folder:
        command = [str(python), "-m", "benchmarks.calibration_worker", "opencv"]
        worker = Worker(command, Path(folder) / "opencv.txt", seconds=600.0)
        for name in ARMS:
            for mount in ("tool", "base"):
                for wrong in (False, True):
                    rng = np.random.default_rng(0)
                    found = [camera_log(load_arm(name), mount, wrong, k, rng, worker) for k in range(logs)]
                    print_cameras(f"{name}, camera {mount}, {'wrong' if wrong else 'exact'} zeros", found)


def camera_log(arm: Any, mount: Any, wrong: bool, k: int, rng: np.random.Generator, worker: Any) -> dict[str, Array]:
    """The errors (2,) [mm, °] of one log, by solver."""
    zeros = np.radians(rng.uniform(*WRONG, arm.n)) * rng.choice([-1, 1], arm.n) * (np.array(arm.units) == "rad") * wrong
    zeros[: arm.units.index("rad") + 1] = zeros[-1] = 0.0
    side, count = (0.06, 0.08, 0.1)[k % 3], POSES[k % 4]
    while True:
        carried, start = screws.exp(rng.normal(scale=[0.05] * 3 + [1.0] * 3)), arm.random_theta(rng, 1)[0]
        view = screws.exp(np.r_[np.zeros(3), rng.normal(scale=0.4, size=3)]) @ np.diag([1.0, -1.0, -1.0, 1.0])
        view[2, 3] = rng.uniform(0.25, 0.5) * np.clip(arm.reach, 0.5, 1.5)
        theta = np.vstack([arm.random_theta(rng, 20000), start + rng.normal(scale=0.5, size=(20000, arm.n))])
        g, at = arm.fk(theta + zeros) @ carried, arm.fk(start + zeros) @ carried
        beside = at @ view if mount == "tool" else at @ screws.inverse(view)
        tags = screws.inverse(g) @ beside if mount == "tool" else screws.inverse(beside) @ g
        inside = (np.abs(tags[:, :2, 3]) < [0.45, 0.3] * tags[:, 2:3, 3]).all(axis=1)
        near = (tags[:, 2, 3] > 0.1) & (tags[:, 2, 3] < 12 * side)
        facing = -(tags[:, :3, 2] * tags[:, :3, 3]).sum(axis=1) > 0.35 * np.linalg.norm(tags[:, :3, 3], axis=1)
        rows = rng.permutation(np.flatnonzero(inside & near & facing & (np.abs(theta) < 7.0).all(axis=1)))[:count]
        if len(rows) == count:
            break
    poses = arm.fk(theta[rows])
    moved = poses if mount == "tool" else screws.inverse(poses)
    answer = worker.ask("hand_eye", seed=k, side=side, tags=tags[rows].tolist(), g=moved.tolist())
    log = Measurements(theta[rows], rvec=np.array(answer["rvec"]), tvec=np.array(answer["tvec"]))
    ours = calibrate(arm, log, camera=mount, tag_size=side).hand_eye
    assert ours is not None
    true = arm.tool @ carried if mount == "tool" else beside
    found = {"twistarm": ours.camera} | {
        name: arm.tool @ np.array(pose) if mount == "tool" else np.array(pose) for name, pose in answer["found"].items()
    }
    return {name: pose_error(pose, true) for name, pose in found.items()}


def pose_error(found: Array, true: Array) -> Array:
    turn = np.linalg.norm(screws.log(screws.inverse(true) @ found)[3:])
    return np.array([1e3 * np.linalg.norm(found[:3, 3] - true[:3, 3]), np.degrees(turn)])


def print_cameras(what: str, found: list[dict[str, Array]]) -> None:
    names = {name for errors in found for name in errors}
    failed = np.full(2, np.inf)
    every = {name: np.array([errors.get(name, failed) for errors in found]) for name in names}
    ours = every.pop("twistarm")
    best = min(every, key=lambda name: float(np.median(every[name][:, 0])))
    texts = [
        f"{name} {np.median(errors[:, 0]):6.2f} {errors[:, 0].max():7.1f} mm {np.median(errors[:, 1]):6.3f}°"
        for name, errors in (("twistarm", ours), (best, every[best]))
    ]
    print(f"  {what:45s} {'   '.join(texts)}", flush=True)


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.calibration", description=__doc__)
    parser.add_argument(
        "--data", type=Path, default=os.environ.get("TWISTARM_CALIBRATION"), help="folder of the measured set"
    )
    parser.add_argument(
        "--folds", type=int, default=6, help="of the tracker's rows, at most; RobotKineCal takes a minute each"
    )
    parser.add_argument(
        "--cameras", type=int, default=0, metavar="N", help="N simulated logs of a camera for each case"
    )
    parser.add_argument("--environments", type=Path, default=DEFAULT_FOLDER)
    given = parser.parse_args(arguments)
    if given.cameras:
        cameras(given.environments, given.cameras)
    if given.data is None:
        if not given.cameras:
            print("nothing to calibrate: give --data FOLDER, TWISTARM_CALIBRATION or --cameras N", file=sys.stderr)
        return
    told_tracker(Path(given.data) / "ur5_tracker_grid.csv", given.environments, given.folds)


if __name__ == "__main__":
    main()
