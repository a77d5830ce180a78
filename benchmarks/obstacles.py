"""Collision checks, distances, the servo and motions round obstacles, beside Pinocchio alone.

Allowed: a check 1.1 × Pinocchio's with its broadphase manager; the nearest pair 0.5 × `computeDistances` of hulls and
1.1 × of spheres; a batch 1.05 × single checks on one thread, 0.8 × on two; a step of the servo 100 µs.
With --problems FOLDER: MotionBenchMaker's problems (panda_spherized.urdf, panda.srdf, and a folder of problems with
scene*.yaml and request*.yaml for each set), beside roboplan. Pinocchio checks each motion by dense samples, without a
broadphase. Allowed: a proven motion in 1.5 × roboplan's processor time with its step of 0.05, 0.5 × with 0.01.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import yaml

from twistarm import Arm, FreeMove, PathError, Scene, load_arm, plan
from twistarm.control.servo import ServoState, servo_step

from .conductor import DEFAULT_FOLDER, NotInstalled, Worker, WorkerError, python_of

ARMS = ("ur5", "panda")
ROUNDS, CHECKS, BATCH = 100, 20, 2000
# The problems ignore the soft limit of panda_joint4: four goals are beyond it, but inside the URDF's <limit>.
LIMITS = {"acceleration": 5.0, "upper": {"panda_joint4": 0.0873}}
STEP = 1e-3  # Between two samples of a motion that Pinocchio checks no joint moves farther [rad].
PEER, PEER_STEPS = "roboplan", (0.05, 0.01)  # Its default step [rad], and one with which most of its paths hold.
SECONDS = 60.0  # For one motion, of wall time: a busy machine searches less in it.


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


def problems(folder: Path, count: int, environments: Path) -> None:
    """MotionBenchMaker's problems: processor times to a proven motion, beside the peer's to a timed one."""
    arm = load_arm(folder / "panda_spherized.urdf", tip="panda_hand", srdf=folder / "panda.srdf", limits=LIMITS)
    print("processor time [ms], median and p95; paths in collision by Pinocchio's samples; ratios of medians")
    steps = "".join(f"{f'{PEER}, step {step}':>40s}" for step in PEER_STEPS)
    print(f"{'set':24s} solved {'motion':>15s} wrong{steps}")
    rows: list[Solved] = []
    with peer(environments) as beside:
        for group in sorted(path for path in (folder / "problems").iterdir() if path.is_dir()):
            files = sorted(group.glob("scene*.yaml"))[:count]
            found = [solved(arm, folder, file, group / f"request{file.stem[5:]}.yaml", beside) for file in files]
            print(f"{group.name:24s} {row(found)}", flush=True)
            rows += found
    print(f"{'all':24s} {row(rows)}")


@contextmanager
def peer(environments: Path) -> Iterator[Worker | None]:
    """The peer's process, or None where it cannot be installed."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            python = python_of(PEER, environments, lambda text: print(text, file=sys.stderr))
        except NotInstalled as error:
            print(f"{PEER} cannot be installed: {error}")
            yield None
            return
        worker = Worker([str(python), "-m", "benchmarks.obstacles_worker"], Path(folder) / "log.txt")
        yield worker
        worker.close()


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


@dataclass
class Solved:
    """Processor times [ms] to a motion for one problem, and to the peer's; NaN for none. Which of them collide."""

    motion: float = np.nan
    collides: bool = False
    peers: list[float] = field(default_factory=lambda: [np.nan] * len(PEER_STEPS))
    peers_collide: list[bool] = field(default_factory=lambda: [False] * len(PEER_STEPS))


def solved(arm: Arm, folder: Path, scene_file: Path, request: Path, beside: Worker | None) -> Solved:
    """One problem by twistarm, then by the peer."""
    scene, start, goal = problem(arm, scene_file, request)
    found = Solved()
    try:
        begin = time.process_time()
        motion = plan(arm, FreeMove(goal), start=start, scene=scene, max_time=SECONDS)
        found.motion = 1e3 * (time.process_time() - begin)
        count = int(np.ceil((motion.peak(1) * motion.duration).max() / STEP)) + 1
        found.collides = colliding(arm, scene, motion(np.linspace(0.0, motion.duration, count)))
    except PathError as error:
        print(f"    {scene_file.parent.name} {scene_file.stem}: {error}")
    if beside is None:
        return found
    objects = [
        {"name": f"object {i}", "kind": body.kind, "size": body.size, "pose": body.pose.tolist()}
        for i, body in enumerate(scene._checker.bodies)
        if body.obstacle
    ]
    files = {"urdf": str(folder / "panda_spherized.urdf"), "srdf": str(folder / "panda.srdf"), "group": "panda_arm"}
    beside.ask("scene", **files, fixed=[arm.base], acceleration=LIMITS["acceleration"], objects=objects)
    for k, step in enumerate(PEER_STEPS):
        try:
            ends = {"start": start.tolist(), "goal": goal.tolist()}
            answer = beside.ask("plan", **ends, step=step, seconds=SECONDS)
        except WorkerError as error:
            print(f"    {scene_file.parent.name} {scene_file.stem}: {PEER} with {step}: {error}")
            continue
        found.peers[k] = answer["ns"] / 1e6
        samples = [straight(*ends) for ends in pairwise(np.array(answer["path"]))]
        found.peers_collide[k] = colliding(arm, scene, np.concatenate(samples))
    return found


def straight(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Samples (k, n) on the straight way."""
    return np.linspace(one, other, int(np.ceil(np.abs(other - one).max() / STEP)) + 2)


def colliding(arm: Arm, scene: Scene, samples: np.ndarray) -> bool:
    """Whether some of the samples (k, n) collide, by Pinocchio alone."""
    model, geometry = arm.pinocchio.model, scene._checker._geometry
    data, shapes = model.createData(), geometry.createData()
    return any(pin.computeCollisions(model, data, geometry, shapes, arm.pinocchio.q(x), True) for x in samples)


def row(found: list[Solved]) -> str:
    motions = np.array([each.motion for each in found])
    done = int(np.isfinite(motions).sum())
    text = f"{done:3d}/{len(found):<3d} {told(motions)} {sum(each.collides for each in found):5d}"
    for k in range(len(PEER_STEPS)):
        times = np.array([each.peers[k] for each in found])
        both = np.isfinite(times) & np.isfinite(motions)
        ratio = np.median(motions[both]) / np.median(times[both]) if both.any() else np.nan
        wrong = sum(each.peers_collide[k] for each in found)
        text += f"{int(np.isfinite(times).sum()):6d} {told(times)} wrong {wrong:3d} {ratio:5.2f} ×"
    return text


def told(times: np.ndarray) -> str:
    times = times[np.isfinite(times)]
    return f"{np.median(times):7.0f} {np.percentile(times, 95):7.0f}" if len(times) else f"{'–':>15s}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=Path, metavar="FOLDER", help="MotionBenchMaker's problems for the Panda")
    parser.add_argument("--environments", type=Path, default=DEFAULT_FOLDER, metavar="FOLDER")
    parser.add_argument("--count", type=int, default=100, help="problems of each set")
    asked = parser.parse_args()
    print(f"one check of random configurations, median of {ROUNDS} interleaved rounds")
    for name in ARMS:
        for boxes in (0, 20):
            checks(name, boxes)
    if asked.problems is not None:
        problems(asked.problems, asked.count, asked.environments)


if __name__ == "__main__":
    main()
