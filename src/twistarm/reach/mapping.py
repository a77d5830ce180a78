"""`reach_map`: the map of an arm's reach, by inverse kinematics or by random configurations."""

from __future__ import annotations

import os
import pickle
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..arm.baking import text_of
from ..ik import Approach, Position, solve_ik_batch
from ..support.checks import Array, as_direction, as_positive, as_whole, require_choice
from ..support.errors import InputError, shown
from ..sweeps.chunks import Arrays, Sweep
from ..theory.manipulability import scaled_jacobian
from .grid import Grid, sphere
from .reach_map import ReachMap, digest_of

if TYPE_CHECKING:
    from ..collision import Scene

DOWN = (0.0, 0.0, -1.0)

AROUND = tuple(each for each in product((-1.0, 0.0, 1.0), repeat=3) if any(each))
"""The 26 directions to the neighbours of a cube."""

MOST_DIRECTIONS = 10_000

CHUNK = 16_384
"""Targets of a chunk: fewer make more files, more make a longer wait at Ctrl-C."""

CONE = np.cos(np.radians(20.0))
"""A random configuration counts for its nearest direction, if that is within this angle."""


@dataclass(frozen=True)
class Job:
    """What every chunk needs. Without `directions` (N, 3) the position alone is asked for."""

    arm: Arm
    scene: Scene | None
    grid: Grid
    directions: Array
    centre: Array
    radius: float


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
    progress: Callable[[float], object] | None = None,
) -> ReachMap:
    """Map which directions of the tool an arm reaches in each cube of space.

    By "ik" the claim of a cube is that of inverse kinematics at its centre: `arm.tool_axis` along each direction,
    turning about it free. By "fk" random configurations are put into the cubes that hold the tool, a first look in
    seconds. It counts the nearest direction within 20°, and misses what no sample met.

    The grid holds every position of the tool; slides without limits count as ±1 m.

    Args:
        arm: The arm.
        voxel: The side of a cube [m].
        directions: "down", "position" for any orientation, 26 for those of a cube's neighbours, or vectors (N, 3) in
            base axes.
        scene: A `Scene` of this arm, or None. Configurations that collide then do not count.
        method: "ik" or "fk".
        samples: The number of random configurations of "fk".
        workers: Threads; None for one per processor.
        executor: Where to compute instead, as in `Sweep.run`: processes or a cluster.
        folder: A folder for a file for each chunk, from which the same call resumes.
        progress: Called with the fraction done, or None.

    Returns:
        The `ReachMap`. It has the same bits whatever computes it.

    Raises:
        InputError: An argument cannot be used, the cubes need more memory than there is, or the executor failed.
        TwistarmError: The arm is not in the compiled core.
    """
    side, tools = as_positive(voxel, "voxel"), _directions(directions)
    require_choice(method, ("ik", "fk"), "method")
    count = as_whole(samples, "samples", 1, 10**12)
    if scene is not None:
        from ..collision import require_scene

        require_scene(scene, arm).find_allowed_pairs()
    centre, radius = sphere(require_arm(arm))
    per_cube = max(len(tools), 1)
    if side > radius:
        raise InputError(f"voxel must be at most the arm's reach, {radius:.3g} m; got {side:g}: lengths are in metres")
    grid = Grid.about(centre, radius, side)
    _require_memory(grid, per_cube + 12)
    job = Job(arm, scene, grid, tools, centre, radius)
    settings = {"method": method, "scene": "" if scene is None else repr(scene), "samples": count}
    identity = [text_of(arm), _told(scene), side, tools.tolist()]
    work, items, size = (_by_ik, grid.count, max(CHUNK // per_cube, 64)) if method == "ik" else (_by_fk, count, CHUNK)
    sweep = Sweep(work, pickle.dumps(job), items, size, identity)
    seen = np.zeros(grid.count * per_cube, dtype=np.bool_)
    best = np.full((2, grid.count), np.nan, dtype=np.float32)
    for _, _, found in sweep.run(workers=workers, executor=executor, folder=folder, progress=progress):
        seen[found["codes"]] = True
        for values, each in zip(best, (found["manipulability"], found["margin"]), strict=True):
            np.fmax.at(values, found["codes"] // per_cube, each)
    counts = seen.reshape(*grid.shape, per_cube).sum(axis=-1, dtype=np.uint16)
    manipulability, margin = best.reshape(2, *grid.shape)
    return ReachMap(arm.name, arm.base, digest_of(arm), grid, tools, counts, manipulability, margin, settings)


def _directions(given: Any) -> Array:
    """Unit vectors (N, 3); none for the position alone."""
    if isinstance(given, str):
        word = require_choice(given, ("down", "position"), "directions")
        return np.array([DOWN] if word == "down" else []).reshape(-1, 3)
    if np.ndim(given) == 0 and given == len(AROUND):
        return as_direction(AROUND, "directions")
    if np.ndim(given) == 0 or np.shape(given) == (0,):
        raise InputError(f'directions must be "down", "position", 26 or vectors (N, 3); got {shown(given)}')
    units = np.atleast_2d(as_direction(given, "directions"))
    if units.ndim != 2 or not 1 <= len(units) <= MOST_DIRECTIONS:
        raise InputError(f"directions must have shape (N, 3), N from 1 to {MOST_DIRECTIONS:,}; got {units.shape}")
    return units


def _require_memory(grid: Grid, per_cube: int) -> None:
    """InputError if the map needs more memory than there is, with the voxel size that fits."""
    there, need = _free_memory(), grid.count * per_cube
    if need > there:
        fits = grid.voxel * (need / there) ** (1 / 3)
        step = 10.0 ** (np.floor(np.log10(fits)) - 1)
        raise InputError(
            f"a voxel of {grid.voxel:g} m makes {grid.count:,} cubes, which need {need / 1e9:,.1f} GB of memory, and "
            f"{there / 1e9:,.1f} GB are free; a voxel of {np.ceil(1.01 * fits / step) * step:.2g} m fits"
        )


def _free_memory() -> int:
    """Bytes that can be used: what Linux calls available; elsewhere all memory."""
    try:
        with open("/proc/meminfo", encoding="ascii") as file:
            return next(1024 * int(line.split()[1]) for line in file if line.startswith("MemAvailable"))
    except (OSError, StopIteration):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _told(scene: Scene | None) -> list[str]:
    """What tells one scene from another."""
    if scene is None:
        return []
    description = scene.arm.description
    return ["" if description is None else description.text, repr(scene.content()), repr(sorted(scene.allowed))]


# -- chunks ------------------------------------------------------------------------------------------------------


@lru_cache(maxsize=2)
def _job(data: bytes) -> Job:
    """The job, unpickled once in each process."""
    job: Job = pickle.loads(data)
    return job


def _by_ik(data: bytes, first: int, end: int) -> Arrays:
    """What is reached at the centres of cubes."""
    job = _job(data)
    cells = np.arange(first, end)
    p = job.grid.centres(cells)
    near = np.linalg.norm(p - job.centre, axis=1) <= job.radius
    if len(job.directions) > 1:  # where the position is out of reach, so is every direction
        near[near] = _answers(job.arm, p[near], None)[0]
    p, cells = p[near], cells[near]
    codes, thetas = [], []
    for k, direction in enumerate(job.directions if len(job.directions) else [None]):
        met, theta = _answers(job.arm, p, direction, job.scene)
        codes.append(cells[met] * max(len(job.directions), 1) + k)
        thetas.append(theta[met])
    return _judged(job.arm, np.concatenate(codes), np.concatenate(thetas))


def _by_fk(data: bytes, first: int, end: int) -> Arrays:
    """What random configurations reach."""
    job = _job(data)
    theta = job.arm.random_theta(np.random.default_rng([first, end]), end - first)
    if job.scene is not None:
        theta = theta[~job.scene.collides(theta)]
    g = job.arm.fk(theta)
    codes, kept = job.grid.cells(g[:, :3, 3]), np.ones(len(g), dtype=np.bool_)
    if len(job.directions):
        cosines = g[:, :3, :3] @ job.arm.tool_axis @ job.directions.T
        kept = cosines.max(axis=1) >= CONE
        codes = codes * len(job.directions) + cosines.argmax(axis=1)
    return _judged(job.arm, codes[kept], theta[kept])


def _answers(
    arm: Arm, p: Array, direction: Array | None, scene: Scene | None = None
) -> tuple[NDArray[np.bool_], Array]:
    """Which targets (k,) are met, and configurations (k, n)."""
    targets = [Position(each) if direction is None else Approach(each, direction) for each in p]
    batch = solve_ik_batch(arm, targets, scene=scene)
    return batch.converged, batch.theta


def _judged(arm: Arm, codes: NDArray[np.int64], theta: Array) -> Arrays:
    """The codes with manipulability and distance from the limits of their configurations (k, n)."""
    J = scaled_jacobian(arm.body_jacobian(theta), arm._prismatic, arm.reach)
    Jt = J.swapaxes(-1, -2)
    square = np.linalg.det(J @ Jt if arm.n >= 6 else Jt @ J)
    margin = np.minimum(theta - arm.limits.lower, arm.limits.upper - theta).min(axis=-1, initial=np.inf)
    measures = {"manipulability": np.sqrt(np.maximum(square, 0.0)), "margin": margin}
    return {"codes": codes, **{name: values.astype(np.float32) for name, values in measures.items()}}
