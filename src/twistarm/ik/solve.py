"""`solve_ik`: an exact answer where there is one; else the nearest and the reason. With a scene, a free one."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..arm.engine import answered
from ..support.checks import Array
from . import textbook
from .answer import CONVERGED, record_type
from .certainty import decided
from .ranges import joint_ranges
from .request import Deadline, Options, Request, checked, in_radians, named
from .solution import IKResult
from .targets import Pose, TargetLike, checked_target, target_for
from .task_space import ORIENTATION_TOL, POSITION_TOL

if TYPE_CHECKING:
    from ..collision import Scene

# Widths [rad, m] of the starts about theta0 in each round of searches; inf for the whole range.
SPREADS = (0.3, 1.0, np.inf, np.inf, np.inf, np.inf, np.inf, np.inf)
EACH_ROUND = 64  # Searches.


def solve_ik(
    arm: Arm,
    target: TargetLike,
    theta0: ArrayLike | None = None,
    *,
    position_tol: float = POSITION_TOL,
    orientation_tol: float = ORIENTATION_TOL,
    restarts: int = 100,
    max_time: float | None = None,
    rng: int | np.random.Generator = 0,
    posture: ArrayLike | str | None = None,
    scene: Scene | None = None,
) -> IKResult:
    """Inverse kinematics: joint coordinates inside the limits that bring the tool to `target`.

    The first search begins at `theta0`, brought inside the limits. The starts of the others depend only on the target,
    the seed `rng` and their number. So the same call gives the same bits, unless `max_time` cuts it short. Continuous
    joints come back as near to theta0 as the limits allow. If a search finds a configuration within 0.2 rad (0.2
    reaches) of theta0, that is the answer. Otherwise, for a target within 0.02 reaches and 3° of theta0's pose, the
    nearest found is the answer. `notes` says so.

    Every search aims at the target itself. Where no search finds an exact answer, one that misses by no more than the
    tolerances counts.

    A redundant arm moves in the null space toward `posture`, to a minimum of ‖θ − posture‖².

    With a `scene` an answer that reaches the target collides with nothing. If the first answer collides, more searches
    follow, from starts of one seed. The nearest free configuration that they find is the answer. If every one collides,
    `stop` is IN_COLLISION, and `contacts` are the pairs. `posture`, `rng` and `restarts` count for the first answer
    alone.

    A target that cannot be reached is no error. The solution is then the nearest configuration. It has the least
    position error inside the limits, then the least rotation error. `stop` and `explain()` say why.

    Args:
        arm: The arm.
        target: `Pose`, `Position`, `Approach`, `TolerancedPose`, or a pose (4, 4).
        theta0: Start (n,) [rad, m], {joint: value} or the name of one. By default `arm.ready`.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        restarts: Greatest number of searches.
        max_time: Greatest time [s]. None for no limit.
        rng: Seed, or a NumPy Generator.
        posture: Preferred configuration (n,), its name, "theta0", "middle" (of the limits), or None.
        scene: A `Scene` of this arm, or None.

    Returns:
        The `IKResult`: theta (n,), its errors [m, rad], `converged`, `stop` and `explain()`.

    Raises:
        InputError: The target, the start, the posture or a number cannot be used.
    """
    begun = time.monotonic()
    if scene is not None:
        from ..collision import require_scene

        require_scene(scene, arm)
    options = position_tol, orientation_tol, restarts, rng, max_time
    # Without a call for an Arm itself: short searches take microseconds.
    if (arm if type(arm) is Arm else require_arm(arm)).compiled is not None:
        found = _by_core(arm, target, theta0, posture, options)
    else:
        goal, request = checked_target(arm, target), checked(arm, theta0, posture, *options)
        if posture is not None and not (isinstance(posture, str) and posture == "theta0"):
            arm.require_core("a posture other than 'theta0'")
        found = IKResult(arm, textbook.solve(arm, goal, request), goal)
    if scene is None or not found.converged or not scene.collides(found.theta):
        return found
    return collision_free(scene, found, Deadline(np.inf if max_time is None else begun + max_time))


def _by_core(arm: Arm, target: TargetLike, theta0: Any, posture: Any, options: Options) -> IKResult:
    """The compiled core's answer."""
    assert arm.compiled is not None
    # An array of a pose becomes a `Pose` only when somebody asks for it: that takes as long as the search.
    given = None if type(target) is np.ndarray else target_for(arm, target)
    kind, numbers = (Pose.kind, target) if given is None else (given.kind, given.numbers)
    start = arm.ready if theta0 is None else named(arm, theta0)
    preferred = None if posture is None else named(arm, posture, start)
    answer = arm.compiled.solve(kind, numbers, start, *options, preferred) if in_radians(options[1]) else None
    if answer is None:  # see `arm.engine`
        request, given = checked(arm, theta0, posture, *options), checked_target(arm, target)
        how = *request.options, request.posture
        answer = answered(arm.compiled.solve(given.kind, given.numbers, request.theta0, *how))
    stop, memory = answer
    found = IKResult(arm, memory, given)
    if stop == CONVERGED:
        return found
    return IKResult(arm, decided(arm, found.target, found.record, options[-1] is None), given)


def collision_free(scene: Scene, first: IKResult, deadline: Deadline) -> IKResult:
    """The nearest free configuration that reaches the target of `first`, or `first` with its contacts.

    `first` reaches the target and collides. Searches start near theta0, then at random configurations.
    """
    arm, start = first.arm, first.record["theta0"]
    for candidates in _rounds(arm, first, start):
        near = candidates[np.argsort(np.linalg.norm(candidates - start, axis=1), kind="stable")]
        for theta in near[~scene.collides(near)] if len(near) else ():
            found = solve_ik(arm, first.target, theta, **first.tolerances.keywords, max_time=deadline.left)
            if found.converged and not scene.collides(found.theta):
                why = f"the configuration nearest to theta0 collides: {scene.contacts(first.theta)[0]}"
                return replace(found, _avoided=why)
        if deadline.passed:
            break
    return replace(first, _contacts=scene.contacts(first.theta))


def _rounds(arm: Arm, first: IKResult, start: Array) -> Iterator[Array]:
    """Configurations (k, n) that reach the target, several at a time."""
    tolerances, chain, target = first.tolerances, arm.require_core("solve_ik with a scene"), first.target
    numbers = np.repeat(target.numbers[None], EACH_ROUND, axis=0)
    rng, ranges = np.random.default_rng(0), joint_ranges(arm)  # one seed: equal calls give equal bits
    for spread in SPREADS:
        starts = arm.random_theta(rng, EACH_ROUND)
        if np.isfinite(spread):
            starts = np.array([ranges.inside(start + rng.normal(0.0, spread, arm.n)) for _ in range(EACH_ROUND)])
        found = np.empty(EACH_ROUND, record_type(arm.n))
        how = Request(starts, None, tolerances, restarts=1, seed=0, max_time=np.inf).options
        chain.solve_batch(target.kind, numbers, starts, *how, None, 1, None, found)
        theta = found["theta"][found["stop"] == CONVERGED]
        yield np.array([ranges.wrapped(row, start) for row in theta]).reshape(-1, arm.n)
