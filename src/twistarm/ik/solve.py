"""`solve_ik`: an exact answer where there is one; where there is none, the nearest and the reason."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..arm import Arm, require_arm
from . import textbook
from .answer import Answer
from .request import Request, checked
from .solution import IKSolution
from .targets import KINDS, AnyTarget, Approach, Pose, TargetLike, target_for


def solve_ik(
    arm: Arm,
    target: TargetLike,
    theta0: ArrayLike | None = None,
    *,
    position_tol: float = 1e-6,
    orientation_tol: float = 1e-6,
    restarts: int = 100,
    max_time: float | None = None,
    rng: int | np.random.Generator = 0,
    posture: ArrayLike | str | None = None,
) -> IKSolution:
    """Inverse kinematics: joint coordinates inside the limits that bring the tool to `target`.

    `target`: Pose, Position, Approach or Task; a bare (4, 4) means Pose. `theta0` (n,), by default `arm.ready`, is
    where the search begins; it is brought inside the limits first. Joints that may turn for ever come back as near to
    it as the limits allow. Tolerances in m and rad. At most `restarts` searches, the first from theta0, the others
    from starts that depend on the seed `rng` and their number alone: the same call gives the same bits, unless
    `max_time` [s] cuts it short. For a target within 1 cm and 1° of the pose of theta0 the answer stays within 0.2 rad
    (0.2 m) of theta0 where it can; `notes` says where it does not.

    `posture`: where a redundant arm would rather stand while it meets the target: "theta0", "centre" (the middle of
    the limits) or a configuration (n,). The answer is then moved in the null space to a minimum of ‖θ − posture‖².

    A target that cannot be met is no error: the solution is then the nearest configuration (the least position error
    inside the limits, then the least rotation error with the position held), `stop` says why, `explain()` says it
    in words. Raises InputError for what cannot be a target, a start or a tolerance.
    """
    chain = require_arm(arm).compiled
    if chain is not None:
        # What is plainly right goes straight to the core; checking it here would cost more than solving it.
        given = target if isinstance(target, KINDS) else None
        if isinstance(given, Approach):
            given = given.of(arm)
        kind, numbers = (Pose.kind, target) if given is None else (given.kind, given.numbers)
        start = arm.ready if theta0 is None else theta0
        answer = chain.solve(kind, numbers, start, position_tol, orientation_tol, restarts, rng, max_time, posture)
        if answer is not None:
            return IKSolution(arm, answer, given)
    asked = target_for(arm, target)
    request = checked(arm, theta0, posture, (position_tol, orientation_tol), restarts, max_time, rng)
    return IKSolution(arm, solved(arm, asked, request), asked)


def solved(arm: Arm, target: AnyTarget, request: Request) -> Answer:
    """The answer to one target, by the compiled core or, without it, by the textbook solver."""
    if arm.compiled is None:
        return textbook.solve(arm, target, request)
    tolerances, max_time = request.tolerances, None if math.isinf(request.max_time) else request.max_time
    answer = arm.compiled.solve(
        target.kind,
        target.numbers,
        request.theta0,
        tolerances.position,
        tolerances.orientation,
        request.restarts,
        request.seed,
        max_time,
        request.posture,
    )
    assert answer is not None
    return answer
