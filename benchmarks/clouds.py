"""Point clouds as obstacles: checks, nearest pairs, the servo, replacement, and motions round them.

Allowed: a check 3 × that of 20 boxes; the nearest pair 2 ms; a step of the servo 0.5 ms with voxels of 2 cm and 1.2 ms
with 5 mm, all with 100,000 points; no pause over 10 ms in another thread while a cloud is replaced.
With --problems FOLDER: MotionBenchMaker's problems (as in benchmarks.obstacles), their surfaces as one cloud, beside
the same problems as they are. Spheres of the arm and cubes of voxels, by algebra, judge the motions. Allowed: a motion
for 98 % of the problems whose ends lie in no voxel, in 2.5 × the processor time.
"""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.spatial import cKDTree

from twistarm import Arm, FreeMove, PathError, Scene, load_arm, plan
from twistarm.arm.bodies import Body
from twistarm.control.servo import ServoState

from .obstacles import CHECKS, LIMITS, STEP, held, interleaved, problem

Points = np.ndarray

ARMS = ("ur5", "panda")
POINTS, VOXELS = 100_000, (0.02, 0.005)
FINE = 0.005  # Voxels of the problems [m].
SEEN = 1.3  # Points farther from the base [m] are out of the arm's reach.
SECONDS = 20.0  # For one motion, of wall time.
TICK = 1e-3  # Of the thread beside a replacement [s].


def surface(body: Body, spacing: float) -> Points:
    """Points (k, 3) on the surface of a box, cylinder or sphere, no farther apart than `spacing` [m]."""
    size = np.array(body.size)
    if body.kind == "sphere":
        count = int(np.ceil(4.0 * np.pi * (2.0 * size[0] / spacing) ** 2))
        z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
        turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
        across = np.sqrt(1.0 - z * z)
        points = size[0] * np.column_stack([across * np.cos(turn), across * np.sin(turn), z])
    elif body.kind == "cylinder":
        radius, length = size
        turn = np.linspace(0.0, 2.0 * np.pi, int(np.ceil(2.0 * np.pi * radius / spacing)) + 1)[:-1]
        ring = np.column_stack([np.cos(turn), np.sin(turn)])
        high = _steps(length, spacing)
        side = np.column_stack([np.tile(radius * ring, (len(high), 1)), np.repeat(high, len(ring))])
        radii = np.linspace(0.0, radius, int(np.ceil(radius / spacing)) + 1)
        disc = np.concatenate([r * ring for r in radii])
        ends = [np.column_stack([disc, np.full(len(disc), z)]) for z in (-0.5 * length, 0.5 * length)]
        points = np.concatenate([side, *ends])
    else:
        faces = []
        for axis in range(3):
            one, other = (_steps(size[(axis + k) % 3], spacing) for k in (1, 2))
            grid = np.stack(np.meshgrid(one, other), axis=-1).reshape(-1, 2)
            for side in (-0.5, 0.5):
                face = np.empty((len(grid), 3))
                face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = side * size[axis], *grid.T
                faces.append(face)
        points = np.concatenate(faces)
    return points @ body.pose[:3, :3].T + body.pose[:3, 3]


def _steps(length: float, spacing: float) -> Points:
    return np.linspace(-0.5 * length, 0.5 * length, int(np.ceil(length / spacing)) + 1)


class Judge:
    """Spheres of an arm against cubes of voxels, by Pinocchio's frames and algebra alone."""

    def __init__(self, arm: Arm, scene: Scene, points: Points, voxel: float) -> None:
        self._arm, self._half = arm, 0.5 * voxel
        self._centres = (np.unique(np.floor(points / voxel), axis=0) + 0.5) * voxel
        self._tree = cKDTree(self._centres)
        model = arm.pinocchio.model
        self._model, self._data = model, model.createData()
        moving = [body for body in scene.links if model.frames[model.getFrameId(body.carrier)].parentJoint]
        kinds = {type(body.shape).__name__ for body in moving}
        assert kinds == {"Sphere"}, kinds
        self._spheres = [(model.getFrameId(body.carrier), body.pose[:3, 3], body.shape.radius) for body in moving]

    def hits(self, samples: Points) -> int:
        """How many of these configurations (k, n) have a sphere in a voxel."""
        return sum(self._hit(self._arm.pinocchio.q(theta)) for theta in samples)

    def _hit(self, q: Points) -> bool:
        pin.framesForwardKinematics(self._model, self._data, q)
        places = [self._data.oMf[frame].act(centre) for frame, centre, _ in self._spheres]
        radii = [radius for *_, radius in self._spheres]
        near = self._tree.query_ball_point(places, np.array(radii) + np.sqrt(3.0) * self._half)
        for place, radius, found in zip(places, radii, near, strict=True):
            beyond = np.maximum(np.abs(self._centres[found] - place) - self._half, 0.0)
            if (np.linalg.norm(beyond, axis=1) < radius).any():
                return True
        return False


@dataclass
class Solved:
    """Processor times [ms] to a motion among the shapes and in their cloud; NaN for none."""

    voxels: int = 0
    shapes: float = np.nan
    cloud: float = np.nan
    wrong: int = 0  # samples in a voxel


def solved(arm: Arm, file: Path) -> Solved | None:
    """One problem with its shapes, then with their cloud. None if one of its ends lies in a voxel."""
    scene, start, goal = problem(arm, file, file.parent / f"request{file.stem[5:]}.yaml")
    points = np.concatenate([surface(body, 0.5 * FINE) for body in scene.obstacles.values()])
    points = points[np.linalg.norm(points, axis=1) < SEEN]
    cloud = Scene.load(arm, file)
    for name in cloud.obstacles:
        cloud.remove(name)
    cloud.add_points("cloud", points, FINE)
    judge = Judge(arm, cloud, points, FINE)
    if judge.hits(np.array([start, goal])):
        return None
    cloud.find_allowed_pairs()
    for each in (scene, cloud):
        each.is_free(start, start), each.distance(start)  # what is made once for a scene
    found = Solved(len(cloud.obstacles["cloud"].shape.centres))
    for what, among in (("shapes", scene), ("cloud", cloud)):
        try:
            begin = time.process_time()
            motion = plan(arm, FreeMove(goal), start=start, scene=among, max_time=SECONDS)
            setattr(found, what, 1e3 * (time.process_time() - begin))
            if among is cloud:
                count = int(np.ceil((motion.peak(1) * motion.duration).max() / (5.0 * STEP))) + 1
                found.wrong = judge.hits(motion(np.linspace(0.0, motion.duration, count)))
        except PathError as error:  # noqa: PERF203
            print(f"    {file.parent.name} {file.stem}, {what}: {error}")
    return found


def problems(folder: Path, count: int) -> None:
    arm = load_arm(folder / "panda_spherized.urdf", tip="panda_hand", srdf=folder / "panda.srdf", limits=LIMITS)
    print("processor time [ms] to a proven motion, median and p95; samples in a voxel by algebra")
    rows: list[Solved | None] = []
    for group in sorted(path for path in (folder / "problems").iterdir() if path.is_dir()):
        found = [solved(arm, file) for file in sorted(group.glob("scene*.yaml"))[:count]]
        print(f"{group.name:24s} {row(found)}", flush=True)
        rows += found
    print(f"{'all':24s} {row(rows)}")


def row(found: list[Solved | None]) -> str:
    free = [each for each in found if each is not None]
    shapes, cloud = (np.array([getattr(each, what) for each in free]) for what in ("shapes", "cloud"))
    both = np.isfinite(shapes) & np.isfinite(cloud)
    text = f"ends in a voxel {len(found) - len(free):3d}"
    for what, times in (("shapes", shapes), ("cloud", cloud)):
        done = times[np.isfinite(times)]
        figures = f"{np.median(done):6.0f} {np.percentile(done, 95):7.0f}" if len(done) else f"{'–':>14s}"
        text += f"   {what} {len(done):3d}/{len(free):<3d} {figures}"
    ratio = np.median(cloud[both]) / np.median(shapes[both]) if both.any() else np.nan
    wrong, voxels = sum(each.wrong for each in free), np.median([each.voxels for each in free] or [0])
    return f"{text}  {ratio:5.2f} ×   wrong {wrong}   {voxels:,.0f} voxels"


def seen(arm: Arm, voxel: float, high: float = 0.0) -> Points:
    """The POINTS voxels (POINTS, 3) nearest to the base of a floor, two walls and, with `high` [m], a board there."""
    far = 300 * voxel
    steps = np.arange(-far, far, voxel) + 0.5 * voxel
    across, along = (each.ravel() for each in np.meshgrid(steps, steps))
    level, wall = np.full(len(across), -0.1 * arm.reach), np.full(len(across), 0.7 * arm.reach)
    sides = [(across, along, level), (across, wall, along), (-wall, across, along)]
    sides += [(across, along, level + high)] if high else []
    points = np.concatenate([np.column_stack(side) for side in sides])
    return points[np.argsort(np.linalg.norm(points, axis=1))[:POINTS]]


def answers(name: str, voxel: float) -> None:
    """A check beside that among 20 boxes, the nearest pair, a step of the servo, and pauses by replacement."""
    arm = load_arm(name, limits={"velocity": 1.5, "acceleration": 3.0})
    boxes, cloud, rng = Scene(arm, margin=0.005), Scene(arm, margin=0.005), np.random.default_rng(5)
    for k, way in enumerate(rng.normal(size=(20, 3))):
        at = way / np.linalg.norm(way) * arm.reach * rng.uniform(0.45, 1.3)
        boxes.add_box(f"box {k}", rng.uniform(0.04, 0.2, 3), at)
    points, others = seen(arm, voxel), seen(arm, voxel, 0.6 * arm.reach)
    cloud.add_points("cloud", points, voxel)
    thetas = arm.random_theta(0, CHECKS)
    free = [theta for theta in arm.random_theta(2, 400) if not cloud.collides(theta)]
    state = ServoState.at(arm, free[0])
    found = interleaved(
        {
            "boxes": lambda: [boxes.collides(theta) for theta in thetas],
            "cloud": lambda: [cloud.collides(theta) for theta in thetas],
            "distance": lambda: [cloud.distance(theta) for theta in free[:CHECKS]],
            "servo": lambda: held(arm, state, cloud),
        },
        20,
    )
    each = {what: 1e6 * seconds / CHECKS for what, seconds in found.items()}
    ratio = each["cloud"] / each["boxes"]
    print(
        f"  {name:8s} voxels of {1e3 * voxel:2.0f} mm   check {each['cloud']:6.1f} µs, {ratio:5.2f} × 20 boxes   "
        f"nearest pair {each['distance']:6.0f} µs   servo {each['servo']:6.0f} µs",
        flush=True,
    )
    for what, work in (("at rest", lambda: time.sleep(1.0)), ("replacing", lambda: replaced(cloud, points, others))):
        print(f"  {'':8s} {what:9s}  pauses of a thread that ticks each ms: {pauses(work)}", flush=True)


def replaced(cloud: Scene, *points: Points) -> None:
    for each in points:
        cloud.replace_points("cloud", each)


def pauses(work: Callable[[], object]) -> str:
    """The longest pauses [ms] of a thread beside `work`, in words."""
    ticks, running = [time.perf_counter()], threading.Event()

    def tick() -> None:
        while not running.wait(TICK):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.perf_counter()
    work()
    taken = time.perf_counter() - began
    running.set()
    thread.join()
    gaps = 1e3 * np.sort(np.diff(ticks))
    return f"longest {gaps[-1]:.1f} ms, 99 % below {np.percentile(gaps, 99):.1f} ms, in {taken:.1f} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=Path, metavar="FOLDER", help="MotionBenchMaker's problems for the Panda")
    parser.add_argument("--count", type=int, default=100, help="problems of each set")
    asked = parser.parse_args()
    print(f"{POINTS:,} points, each in a voxel of its own")
    for name in ARMS:
        for voxel in VOXELS:
            answers(name, voxel)
    if asked.problems is not None:
        problems(asked.problems, asked.count)


if __name__ == "__main__":
    main()
