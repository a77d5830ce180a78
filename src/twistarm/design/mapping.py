"""`reach_map`: the map of an arm's reach, by inverse kinematics or by random configurations."""

from __future__ import annotations

import os
import pickle
from concurrent.futures import Executor
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..arm.baking import text_of
from ..ik import Approach, Position, reachable, solve_ik_batch
from ..ik.reached import reach_ball
from ..support.checks import Array, Progress, as_direction, as_positive, as_whole, require_choice
from ..support.errors import InputError
from ..theory.manipulability import scaled_jacobian
from .chunks import Arrays, Sweep
from .voxel_map import Grid, ReachMap, digest_of

if TYPE_CHECKING:
    from ..collision import Scene

# The 26 directions to the neighbours of a cube.
AROUND = tuple(offset for offset in product((-1.0, 0.0, 1.0), repeat=3) if any(offset))

MOST_DIRECTIONS = 10_000

MOST_BYTES = 2e9  # Memory of the largest map: of each cube a byte for each direction, and 12 more.
CHUNK = 4096  # Targets of a chunk. Fewer make more files, and more a longer wait at Ctrl-C.
RESTARTS = 100  # Searches for a target. With 32 a map of an arm of six joints misses 1 % of its cubes.
CONE = np.cos(np.radians(20.0))  # A random configuration counts for the nearest direction, within this angle.


def reach_map(
    arm: Arm,
    voxel: float = 0.05,
    directions: str | int | ArrayLike = "down",
    *,
    scene: Scene | None = None,
    method: str = "ik",
    samples: int = 1_000_000,
    workers: int | None = None,
    executor: Executor | None = None,
    folder: str | os.PathLike[str] | None = None,
    progress: Progress | None = None,
) -> ReachMap:
    """Map which directions of the tool an arm reaches in each cube of space.

    By "ik" a cube has the verdicts of inverse kinematics at its centre: `arm.tool_axis` along each direction, turning
    about it free. By "fk" random configurations count in the cubes that hold the tool, for the nearest direction within
    20°. This first look takes seconds and misses what no sample hits.

    The grid holds every position of the tool. Slides without limits count as ±1 m.

    Args:
        arm: The arm.
        voxel: The side of a cube [m].
        directions: "down", "position" for any orientation, 26 for those to the neighbours of a cube, or vectors (N, 3)
            in base axes.
        scene: A `Scene` of this arm, or None. Configurations that collide do not count.
        method: "ik" or "fk".
        samples: The number of random configurations of "fk".
        workers: Threads. None for one per processor.
        executor: Where to compute instead, as in `Sweep.run`: processes or a cluster.
        folder: A folder for a file per chunk, from which the same call resumes.
        progress: Called with the fraction done, or None.

    Returns:
        The `ReachMap`, the same bits on any number of workers.

    Raises:
        InputError: An argument cannot be used, there are too many cubes, or the executor failed.
        TwistarmError: The arm is not in the compiled core.
    """
    side, towards = as_positive(voxel, "voxel"), _directions(directions)
    count = as_whole(samples, "samples", 1, 10**12)
    by_ik = require_choice(method, ("ik", "fk"), "method") == "ik"
    scene_identity: list[Any] = []
    if scene is not None:
        from ..collision import require_scene
        from ..collision.scene_file import scene_text

        require_scene(scene, arm).find_allowed_pairs()
        content, description = scene_text(scene.content(), Path()), scene.arm.description
        scene_identity = [content, description and description.text, scene.exact, sorted(scene.allowed)]
    per_cube = max(len(towards), 1)
    grid = _grid(require_arm(arm), side, per_cube)
    settings = {"method": method, "samples": count, "scene": "" if scene is None else repr(scene)}
    sweep = Sweep(
        _by_ik if by_ik else _by_fk,
        pickle.dumps((arm, scene, grid, towards)),
        grid.count if by_ik else count,
        max(CHUNK // per_cube, 64) if by_ik else 8 * CHUNK,
        [text_of(arm), side, towards.tolist(), scene_identity],
    )
    seen = np.zeros(grid.count * per_cube, dtype=np.bool_)
    best = {name: np.full(grid.count, np.nan, dtype=np.float32) for name in ("manipulability", "margin")}
    for _, found in sweep.run(workers=workers, executor=executor, folder=folder, progress=progress):
        seen[found["codes"]] = True
        for name, values in best.items():
            np.fmax.at(values, found["codes"] // per_cube, found[name])
    counts = seen.reshape(*grid.shape, per_cube).sum(axis=-1, dtype=np.uint16)
    quantities = {name: values.reshape(grid.shape) for name, values in best.items()}
    return ReachMap(arm.name, arm.base, digest_of(arm), grid, towards, counts, **quantities, settings=settings)


def _grid(arm: Arm, side: float, per_cube: int) -> Grid:
    """The grid for so many directions. InputError for cubes larger than the arm, and for a map beyond the memory."""
    centre, radius = sphere(arm)
    if side > radius:
        raise InputError(f"voxel must be at most the arm's reach, {radius:.3g} m; got {side:g}: lengths are in metres")
    grid = Grid.about(centre, radius, side)
    if grid.count * (per_cube + 12) > MOST_BYTES:
        fits = side * (grid.count * (per_cube + 12) / MOST_BYTES) ** (1 / 3)
        many = f"{grid.count:,} cubes, too many for {MOST_BYTES / 1e9:g} GB of memory"
        raise InputError(f"a voxel of {side:g} m makes {many}; a voxel of {1.1 * fits:.2g} m fits")
    return grid


def _directions(given: Any) -> Array:
    """Unit vectors (N, 3). None for the position alone."""
    if isinstance(given, str):
        down = require_choice(given, ("down", "position"), "directions") == "down"
        return np.array([[0.0, 0.0, -1.0]]) if down else np.empty((0, 3))
    around = isinstance(given, int) and given == len(AROUND)
    name = 'directions, where not "down", "position" or 26,'
    units = np.atleast_2d(as_direction(AROUND if around else given, name))
    if units.ndim != 2 or not 1 <= len(units) <= MOST_DIRECTIONS:
        raise InputError(f"{name} must have shape (N, 3), N from 1 to {MOST_DIRECTIONS:,}; got {units.shape}")
    return units


def sphere(arm: Arm) -> tuple[Array, float]:
    """The centre (3,) and radius [m] of a sphere that the tool's origin never leaves. Unlimited slides count ±1 m."""
    _, centre, radius = reach_ball(arm, Position([0.0] * 3), arm.sampling_bounds)
    return centre, radius


@lru_cache(maxsize=2)
def _job(data: bytes) -> Any:
    """Arm, scene, grid and directions, unpacked once in each process."""
    return pickle.loads(data)


def _by_ik(data: bytes, first: int, end: int) -> Arrays:
    """What is reached at the centres of cubes."""
    arm, scene, grid, towards = _job(data)
    cells, found = np.arange(first, end), []
    if len(towards) > 1:  # where the position is out of reach, so is every direction
        cells = cells[_reached(arm, None, grid.centres(cells), None)[0]]
    p = grid.centres(cells)
    for k, direction in enumerate(towards if len(towards) else (None,)):
        reached, theta = _reached(arm, scene, p, direction)
        found.append((cells[reached] * max(len(towards), 1) + k, theta[reached]))
    return _measured(arm, *map(np.concatenate, zip(*found, strict=True)))


def _by_fk(data: bytes, first: int, end: int) -> Arrays:
    """What random configurations reach."""
    arm, scene, grid, towards = _job(data)
    theta = arm.random_theta(np.random.default_rng([first, end]), end - first)
    if scene is not None:
        theta = theta[~scene.collides(theta)]
    g = arm.fk(theta)
    codes, kept = grid.cells(g[:, :3, 3]), np.ones(len(g), dtype=np.bool_)
    if len(towards):
        cosines = g[:, :3, :3] @ arm.tool_axis @ towards.T
        codes, kept = codes * len(towards) + cosines.argmax(axis=1), cosines.max(axis=1) >= CONE
    return _measured(arm, codes[kept], theta[kept])


def _reached(arm: Arm, scene: Scene | None, p: Array, direction: Array | None) -> tuple[NDArray[np.bool_], Array]:
    """Which targets (k,) are reached, and the configurations (k, n)."""
    reached, theta = reachable(arm, p, direction=direction, restarts=RESTARTS)
    if scene is not None:
        hit = np.flatnonzero(reached)[scene.collides(theta[reached])]
        targets = [Position(p[i]) if direction is None else Approach(p[i], direction) for i in hit]
        free = solve_ik_batch(arm, targets, scene=scene)
        reached[hit], theta[hit] = free.converged, free.theta
    return reached, theta


def _measured(arm: Arm, codes: NDArray[np.int64], theta: Array) -> Arrays:
    """The codes, with manipulability and distance from the limits of the configurations (k, n)."""
    J = scaled_jacobian(arm.body_jacobian(theta), arm.prismatic, arm.reach)
    Jt = J.swapaxes(-1, -2)
    square = np.linalg.det(J @ Jt if arm.n >= 6 else Jt @ J)
    margin = np.minimum(theta - arm.limits.lower, arm.limits.upper - theta).min(axis=-1)
    measures = {"manipulability": np.sqrt(np.maximum(square, 0.0)), "margin": margin}
    return {"codes": codes, **{name: values.astype(np.float32) for name, values in measures.items()}}
