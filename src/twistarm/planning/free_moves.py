"""Free moves: a path round obstacles by OMPL's RRT-Connect, shortened and proven free; and collisions of motions."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from itertools import pairwise
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ..arm.arm import Arm
from ..collision import Scene, require_scene
from ..limits.joint_limits import JointLimits
from ..support.checks import Array
from ..support.errors import missing_extra
from ..support.messages import Argument, Quantity, Remedies, Text
from .refusal import PathError
from .segments import CLEARANCE
from .trajectory import Trajectory

# Distance [rad, m] of the checked states of a path, for one attempt after the other.
STEPS = (0.1, 0.05, 0.02, 0.01, 0.005)
# For the last tries: the share of the clearance that states keep, that of the time, and the distances of states.
LAST_SHARE, LAST_TIME, LAST_STEPS = 0.05, 0.5, (0.02, 0.01, 0.005)
UNLIMITED = np.pi  # How far joints without limits may go beyond start and goal: every direction, once.
BESIDE = 0.3  # So near [rad, m] to start and goals states may keep less clearance, where those have less.
REACH = 0.5  # The longest path [rad, m] that a tree grows at once.
SHORTCUTS = 50  # Random shortcuts that are tried on a path.
SAMPLES = 300  # States by which the length of a path is measured.
STILL = 1e-9  # A path shorter than this [m, rad] is none.


def free_path(
    scene: Scene, start: Array, goal: Array, others: Callable[[], Array], limits: JointLimits, max_time: float,
    clearance: float = CLEARANCE, seed: int = 0,
) -> Array:  # fmt: skip
    """Waypoints (k, n) of a collision-free path from start to goal (n,), or to one of `others` (k, n).

    A free straight path to the goal is taken. Only otherwise `others` is called. RRT-Connect (Kuffner & LaValle, ICRA
    2000) then plans on states with a `clearance` [m]. It grows a tree from the start, and one from all goals. OMPL's
    simplifier shortens the path. `Scene.is_free` then proves it. If that fails, the search is repeated with smaller
    steps. Half of the time is kept for last tries with a twentieth of the clearance.

    Raises:
        PathError: Start or goal collides, or no path was found in `max_time` [s] of wall time.
        MissingExtraError: OMPL is not installed.
    """
    require_clear(scene, start, goal)
    if scene.is_free(start, goal):
        return np.array([start, goal])
    began, worked = time.monotonic(), time.process_time()
    goals = np.vstack([goal, others()])
    ends = np.vstack([start, goals])
    lower, upper = ends.min(axis=0), ends.max(axis=0)
    # A curve may end beyond a limit by rounding, which OMPL would refuse.
    lower = np.where(np.isfinite(limits.lower), np.minimum(limits.lower, lower), lower - UNLIMITED)
    upper = np.where(np.isfinite(limits.upper), np.maximum(limits.upper, upper), upper + UNLIMITED)
    tries = (clearance, STEPS, 1.0 - LAST_TIME), (LAST_SHARE * clearance, LAST_STEPS, 1.0)
    for distance, steps, share in tries:
        is_free, latest = roomy(scene, distance, ends), began + share * max_time
        for step in steps:
            path = _searched(is_free, start, goals, lower, upper, step, latest - time.monotonic(), seed)
            if path is None:
                break
            if all(scene.is_free(before, after) for before, after in pairwise(path)):
                return path
    to = " to any configuration of the target" if len(goals) > 1 else ""
    kept, last = (Quantity(distance, "m") for distance in (clearance, LAST_SHARE * clearance))
    more = Text(", with {room} of clearance and at last {last}", room=kept, last=last)
    spent = time.process_time() - worked
    raise no_path(f"free path{to}", max_time, spent, more, {"max_time": "longer", "clearance": "smaller"})


def roomy(scene: Scene, clearance: float, ends: Array) -> Callable[[Array], bool]:
    """A check of states with this clearance [m]. Near the ends (k, n) half of their clearance is enough."""
    is_free = scene.checks(clearance)
    near = [0.5 * max(scene.distance(theta).metres - scene.largest_margin, 0.0) for theta in ends]
    if min(near) >= clearance:
        return is_free
    beside = scene.checks(min(near))
    return lambda theta: is_free(theta) or (bool((np.abs(ends - theta).max(axis=1) < BESIDE).any()) and beside(theta))


def no_path(path: str, max_time: float, worked: float, more: str, remedies: Mapping[str, str]) -> PathError:
    """The error of a search in vain. `worked`: the processor's time [s]. `remedies`: arguments, and what to give."""
    less = (Text(f"a {how} {{{name}}}", **{name: Argument(name)}) for name, how in remedies.items())
    what = "no {path} was found in {time:g} s of wall time ({worked:.2g} s of the processor{more}); give {remedies}"
    given = Remedies(("another goal", *less))
    return PathError(Text(what, path=path, time=max_time, worked=worked, more=more, remedies=given))


def require_clear(scene: Scene, start: Array, goal: Array) -> None:
    """Raise PathError if start or goal (n,) collides."""
    for theta, name in ((start, "start"), (goal, "goal")):
        contacts = scene.contacts(theta)
        if contacts:
            raise PathError(f"the {name} collides: {contacts[0]}", theta=theta)


def _searched(
    is_free: Callable[[Array], bool],
    start: Array, goals: Array, lower: Array, upper: Array,
    step: float, seconds: float, seed: int,
) -> Array | None:  # fmt: skip
    """A shortened path (k, n) to one of `goals`, with free states every `step` [rad, m]; None after so many seconds."""
    base, geometric = _import_ompl(seed)
    space, bounds = base.RealVectorStateSpace(len(start)), base.RealVectorBounds(len(start))
    for i, (least, most) in enumerate(zip(lower.tolist(), upper.tolist(), strict=True)):
        bounds.setLow(i, least)
        bounds.setHigh(i, most)
    space.setBounds(bounds)

    read = itemgetter(*range(len(start)))

    def numbers(state: Any) -> Array:
        return np.array(read(state), ndmin=1)

    def state_at(theta: Array) -> Any:
        state = space.allocState()
        for i, value in enumerate(theta.tolist()):
            state[i] = value
        return state

    setup = geometric.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: is_free(numbers(state)))
    setup.getSpaceInformation().setStateValidityCheckingResolution(step / float(space.getMaximumExtent()))
    planner = geometric.RRTConnect(setup.getSpaceInformation())
    planner.setRange(REACH)
    setup.setPlanner(planner)
    roots = base.GoalStates(setup.getSpaceInformation())
    for goal in goals:
        roots.addState(state_at(goal))
    setup.addStartState(state_at(start))
    setup.setGoal(roots)
    if seconds <= 0.0:  # only here, so that an arm without OMPL hears of it in any case
        return None
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None
    found = setup.getSolutionPath()
    _shorten(found, geometric.PathSimplifier(setup.getSpaceInformation()))
    path = np.array([numbers(found.getState(k)) for k in range(found.getStateCount())])
    path[0], path[-1] = start, goals[np.abs(goals - path[-1]).max(axis=1).argmin()]
    return path


def _shorten(path: Any, simplifier: Any) -> None:
    """Shorten a path of OMPL by its simplifier."""
    simplifier.ropeShortcutPath(path)
    simplifier.reduceVertices(path)
    simplifier.partialShortcutPath(path, SHORTCUTS, SHORTCUTS)
    simplifier.reduceVertices(path)


def _import_ompl(seed: int) -> tuple[Any, Any]:
    """OMPL's modules `base` and `geometric`. Its generator takes the seed once in a process."""
    try:
        from ompl import base, geometric, util
    except ImportError as error:
        raise missing_extra("planning round obstacles", "ompl", "obstacles") from error
    util.setLogLevel(util.LOG_NONE)
    if not _SEEDED:
        util.RNG.setSeed(seed + 1)  # OMPL refuses 0
        _SEEDED.append(seed)
    return base, geometric


_SEEDED: list[int] = []


class Hit(NamedTuple):
    """A collision of a motion: on the way to waypoint `leg` + 1, after a share of it, at `theta` (n,), in words."""

    leg: int
    share: float
    theta: Array
    words: str

    def __str__(self) -> str:
        return self.words


def first_collision(scene: Scene, motion: Trajectory) -> Hit | None:
    """The first collision of a motion, or None."""
    found = scene.first_collision(motion)
    if found is None:
        return None
    leg = int(np.clip(np.searchsorted(motion.times, found.time, side="right") - 1, 0, max(len(motion.times) - 2, 0)))
    pairs = ", ".join(map(str, found.contacts[:2])) or "a near miss"
    share = _share_before(found.time, scene.arm, motion, leg)
    return Hit(leg, share, found.theta, f"it collides {found.time:.2f} s after the start: {pairs}")


def _share_before(time: float, arm: Arm, motion: Trajectory, leg: int) -> float:
    """The part of the tool's path from waypoint `leg` to the next that lies before a time [s].

    If the tool's origin stays, the path of the joints counts.
    """
    begin, end = motion.times[[leg, min(leg + 1, len(motion.times) - 1)]]
    theta = motion(np.concatenate([np.linspace(begin, time, SAMPLES), np.linspace(time, end, SAMPLES)]))
    for states in (arm.fk(theta)[:, :3, 3], theta):
        steps = np.linalg.norm(np.diff(states, axis=0), axis=1)
        if steps.sum() > STILL:
            return float(steps[:SAMPLES].sum() / steps.sum())
    return 0.0


def require_free(scene: Scene, arm: Arm, motion: Trajectory) -> None:
    """Raise PathError if a motion through waypoints collides; a start in collision may be left."""
    hit = first_collision(require_scene(scene, arm).leaving(motion.waypoints[0]), motion)
    if hit is not None:
        place = f"the way from waypoint {hit.leg} to {hit.leg + 1} (0 is the start)"
        why = f"{hit}; add waypoints round it"
        raise PathError(why, hit.share, hit.theta, "collision", segment=hit.leg, place=place)
