"""Collision checks, distances, the servo and motions round obstacles, beside Pinocchio alone.

Allowed: a check 1.1 × Pinocchio's with its broadphase manager; the nearest pair 0.5 × `computeDistances` of hulls and
1.1 × of spheres; a batch 1.05 × single checks on one thread, 0.8 × on two; a step of the servo 100 µs.
With --problems FOLDER: MotionBenchMaker's problems (panda_spherized.urdf, panda.srdf, and a folder of problems with
scene*.yaml and request*.yaml for each set). Pinocchio checks each motion by dense samples, without a broadphase.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import yaml

from twistarm import Arm, FreeMove, PathError, Scene, Trajectory, load_arm, plan
from twistarm.control.servo import ServoState, servo_step
from twistarm.planning.free_moves import free_path

ARMS = ("ur5", "panda")
ROUNDS, CHECKS, BATCH = 100, 20, 2000
# The problems ignore the soft limit of panda_joint4: four goals are beyond it, but inside the URDF's <limit>.
LIMITS = {"acceleration": 5.0, "upper": {"panda_joint4": 0.0873}}
STEP = 1e-3  # Between two samples of a motion that Pinocchio checks no joint moves farther [rad].


def interleaved(calls: dict[str, Callable[[], object]], rounds: int = ROUNDS) -> dict[str, float]:
    """The median time [s] of each call, in turn."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            start = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - start)
    return {name: float(np.median(values)) for name, values in times.items()}


def checks(name: str, boxes: int) -> None:
    """Checks, batches and nearest pairs beside Pinocchio's on the same shapes; the servo with the scene and without."""
    arm = load_arm(name, limits={"velocity": 1.5, "acceleration": 3.0})
    scene, rng = Scene(arm, margin=0.005), np.random.default_rng(5)
    for k, way in enumerate(rng.normal(size=(boxes, 3))):
        at = way / np.linalg.norm(way) * arm.reach * rng.uniform(0.45, 1.3)
        scene.add_box(f"box {k}", rng.uniform(0.04, 0.2, 3), at)
    thetas, many = arm.random_theta(0, CHECKS), arm.random_theta(1, BATCH)
    model, geometry = arm.pinocchio.model, scene._checker._geometry
    data, shapes = model.createData(), geometry.createData()
    scene._checker._ask(shapes, range(len(scene._checker.pairs)))
    manager = pin.BroadPhaseManager_SSaPCollisionManager(model, geometry, shapes)
    Q = [arm.pinocchio.q(theta) for theta in thetas]
    alone = [pin.computeCollisions(model, data, geometry, shapes, q, True) for q in Q]
    assert alone == scene.collides(thetas).tolist() == scene.collides(thetas, threads=2).tolist()
    state = ServoState.at(arm, thetas[alone.index(False)])
    found = interleaved(
        {
            "check": lambda: [scene.collides(theta) for theta in thetas],
            "broadphase": lambda: [pin.computeCollisions(model, data, manager, q, True) for q in Q],
            "plain": lambda: [pin.computeCollisions(model, data, geometry, shapes, q, True) for q in Q],
            "distance": lambda: [scene.distance(theta) for theta in thetas],
            "distances": lambda: [pin.computeDistances(model, data, geometry, shapes, q) for q in Q],
            "servo": lambda: held(arm, state, None),
            "servo in a scene": lambda: held(arm, state, scene),
        }
    )
    batch = interleaved(
        {
            "single": lambda: [scene.collides(theta) for theta in many],
            "1": lambda: scene.collides(many),
            "2": lambda: scene.collides(many, threads=2),
        },
        5,
    )
    each = {what: 1e6 * seconds / CHECKS for what, seconds in found.items()}
    print(
        f"  {name:8s} {len(scene._checker.pairs):4d} pairs  check {each['check']:6.1f} µs   "
        f"{each['check'] / each['broadphase']:5.2f} × broadphase   {each['check'] / each['plain']:5.2f} × plain   "
        f"batch {batch['1'] / batch['single']:5.2f} × and on two threads {batch['2'] / batch['single']:5.2f} × single\n"
        f"  {'':18s}   nearest pair {each['distance']:6.1f} µs   {each['distance'] / each['distances']:5.2f} × all   "
        f"servo {each['servo']:6.1f} µs, in the scene {each['servo in a scene']:6.1f} µs"
    )


def held(arm: Arm, state: ServoState, scene: Scene | None) -> None:
    """A held twist of `CHECKS` steps."""
    for _ in range(CHECKS):
        state, _ = servo_step(arm, state, (0.1, 0.05, -0.05, 0.0, 0.1, 0.0), 0.01, scene=scene)


def problems(folder: Path, count: int) -> None:
    """MotionBenchMaker's problems: solved, times to a path and to a proven motion in time."""
    arm = load_arm(folder / "panda_spherized.urdf", tip="panda_hand", srdf=folder / "panda.srdf", limits=LIMITS)
    print(f"{'set':26s} solved   path [ms]: median   p95    motion [ms]: median   p95   samples in collision")
    everything: list[tuple[float, float]] = []
    for group in sorted(path for path in (folder / "problems").iterdir() if path.is_dir()):
        times, failed, wrong = [], [], 0
        for scene_file in sorted(group.glob("scene*.yaml"))[:count]:
            number = scene_file.stem.removeprefix("scene")
            scene, start, goal = problem(arm, scene_file, group / f"request{number}.yaml")
            try:
                took, motion = solved(arm, scene, start, goal)
            except PathError as error:
                failed.append(f"{number}: {error}")
                continue
            times.append(took)
            wrong += colliding(arm, scene, motion)
        everything += times
        print(f"{group.name:26s} {len(times):3d}/{len(times) + len(failed):<3d} {row(times)}   {wrong}", flush=True)
        print(*(f"    {each}" for each in failed), sep="\n", end="\n" * bool(failed))
    print(f"{'all':26s} {len(everything):7d} {row(everything)}")


def problem(arm: Arm, scene_file: Path, request: Path) -> tuple[Scene, np.ndarray, np.ndarray]:
    """The scene, the start and the goal (n,)."""
    asked: dict[str, Any] = yaml.safe_load(request.read_text("utf-8"))
    state = dict(zip(*(asked["start_state"]["joint_state"][key] for key in ("name", "position")), strict=True))
    goal = {each["joint_name"]: each["position"] for each in asked["goal_constraints"][0]["joint_constraints"]}
    scene = Scene.load(arm, scene_file)
    scene.find_allowed_pairs()
    first, last = (np.array([values[name] for name in arm.joint_names]) for values in (state, goal))
    scene.is_free(first, first)  # what is made once for a scene
    return scene, first, last


def solved(arm: Arm, scene: Scene, start: np.ndarray, goal: np.ndarray) -> tuple[tuple[float, float], Trajectory]:
    """The seconds to a proven path and to a proven motion, and the motion."""
    began = time.perf_counter()
    free_path(scene, start, goal, arm.limits, 5.0)
    path = time.perf_counter() - began
    motion = plan(arm, FreeMove(goal), start=start, scene=scene, max_time=5.0)
    return (path, time.perf_counter() - began - path), motion


def colliding(arm: Arm, scene: Scene, motion: Trajectory) -> int:
    """How many samples of a motion collide, by Pinocchio alone."""
    steps = int(np.ceil((motion.peak(1) * motion.duration).max() / STEP))
    model, geometry = arm.pinocchio.model, scene._checker._geometry
    data, shapes = model.createData(), geometry.createData()
    samples = motion(np.linspace(0.0, motion.duration, steps + 1))
    return sum(pin.computeCollisions(model, data, geometry, shapes, arm.pinocchio.q(x), True) for x in samples)


def row(times: list[tuple[float, float]]) -> str:
    if not times:
        return "–"
    path, motion = 1e3 * np.array(times).T
    return (
        f"{np.median(path):18.0f} {np.percentile(path, 95):7.0f} {np.median(motion):18.0f} "
        f"{np.percentile(motion, 95):7.0f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=Path, metavar="FOLDER", help="MotionBenchMaker's problems for the Panda")
    parser.add_argument("--count", type=int, default=100, help="problems of each set")
    asked = parser.parse_args()
    print(f"one check of random configurations, median of {ROUNDS} interleaved rounds")
    for name in ARMS:
        for boxes in (0, 20):
            checks(name, boxes)
    if asked.problems is not None:
        problems(asked.problems, asked.count)


if __name__ == "__main__":
    main()
