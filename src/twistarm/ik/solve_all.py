"""`solve_ik_all`: every configuration that reaches a target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm, require_arm
from ..support.checks import Array, Progress, as_flag, as_given, as_number, as_whole, frozen, require_callback
from ..support.errors import InputError, NoClosedFormError, quote, unknown_name
from ..support.messages import Quantity, Text
from .all_solutions import AllSolutions
from .answer import Configurations
from .closed_form.methods import Method, closest_miss_of, known_method, method_for
from .closed_form.roots import Root
from .gathering import Gathering, Members
from .ranges import locked_joints
from .request import Deadline, checked, in_radians
from .targets import AnyTarget, Approach, Pose, TargetLike, checked_target, target_for
from .task_space import ORIENTATION_TOL, POSITION_TOL, Tolerances

if TYPE_CHECKING:
    from ..collision import Scene

DEFAULT_SAMPLES = 32

ROOT_TOL = 1e-9  # Greatest errors [m, rad] of a root, whatever the tolerances are.


def solve_ik_all(
    arm: Arm,
    target: TargetLike,
    theta0: ArrayLike | None = None,
    *,
    fixed_joints: Mapping[str, float] | None = None,
    redundancy_samples: int = DEFAULT_SAMPLES,
    include_turns: bool = False,
    closed_form: bool = False,
    position_tol: float = POSITION_TOL,
    orientation_tol: float = ORIENTATION_TOL,
    max_time: float | None = None,
    scene: Scene | None = None,
    progress: Progress | None = None,
) -> AllSolutions:
    """Every configuration inside the limits that reaches `target`, verified, nearest to `theta0` first.

    Distance is the largest joint difference, in shares of the joint's range (else 2π or 1 m).

    The closed form solves an arm's family: joints with parallel or intersecting axes, and at most three others.
    Elimination, an eigenvalue problem, solves five or six joints that turn about any axes. Newton's method corrects
    each answer until forward kinematics reaches the target to rounding. Answers that do not reach it are dropped. Where
    neither applies, searches from many starts are tried, and `complete` is False. Tolerances count where no
    configuration reaches the target exactly. The list then has one of each branch that searches find within them.

    A `Pose` takes up to six joints, an `Approach` up to five, a `Position` up to three. Arms with fewer joints reach
    the targets that fit them. `explain()` says how far off another is. Of too many joints some are held: at the values
    in `fixed_joints`, else at `redundancy_samples` values. A joint that only rolls the tool about an `Approach`'s axis
    keeps theta0's value.

    Two answers less than 0.01 rad or m apart are one if the target is also reached halfway. Answers on one connected
    self-motion are one, with a free joint at theta0's value if possible.

    Sources: MLS §3.3; Pieper 1968; Elias & Wen, IK-Geo, 2022; Raghavan & Roth 1993.

    Args:
        arm: The arm.
        target: `Pose`, `Position`, `Approach` or pose (4, 4). A `TolerancedPose` is only searched for.
        theta0: Configuration (n,) [rad, m] from which distances are counted, by default `arm.ready`.
        fixed_joints: {joint: value} [rad, m] of joints to hold there.
        redundancy_samples: Number of values of each other held joint, in (0, 1000]; at most 4,096 combinations.
        include_turns: Whether configurations that differ by whole turns count as different, inside the limits.
        closed_form: Whether to raise NoClosedFormError rather than to search.
        position_tol: Greatest position error of an answer [m].
        orientation_tol: Greatest rotation error of an answer [rad].
        max_time: Greatest time [s], or None for no limit. Answers of a millisecond, and the choice of the method in
            the first call for an arm, ignore it.
        scene: A `Scene` of this arm, or None. `colliding` then marks the configurations that collide.
        progress: Called with the fraction of sampled values and searches that are done, or None.

    Returns:
        The `AllSolutions`: theta (k, n), k ≥ 0, and whether these are all. After a timeout it holds what was found,
        with `complete` False and `timed_out` True.

    Raises:
        InputError: The target, theta0, a value of fixed_joints or a number cannot be used.
        UnknownNameError: `fixed_joints` names no joint of the arm.
        NoClosedFormError: `closed_form` is set and the arm has none for such a target. The message says why.
        TwistarmError: The arm is not in the compiled core. The message says how to get it.
    """
    if scene is not None:
        from ..collision import require_scene

        require_scene(scene, arm)
    # What is plainly right goes straight to the core; checking it here would cost more than solving it.
    # Types and values both: 32.0 or an array fails the test and is checked below.
    plain = type(redundancy_samples) is int and redundancy_samples == DEFAULT_SAMPLES and type(closed_form) is bool
    plain = plain and include_turns is False and fixed_joints is None and max_time is None and progress is None
    answer = _at_once(require_arm(arm), target, theta0, position_tol, orientation_tol) if plain else None
    if answer is None or not len(answer):
        require_arm(arm).require_core("solve_ik_all")
        goal = checked_target(arm, target)
        request = checked(arm, theta0, None, position_tol, orientation_tol, 1, 0, max_time)
        require_callback(progress, "progress", "(fraction)")
        as_flag(include_turns, "include_turns")
        as_flag(closed_form, "closed_form")
        count = as_whole(redundancy_samples, "redundancy_samples", 1, 1000)
        method, near = _method_and_start(arm, goal, request.theta0, fixed_joints, closed_form)
        exact, deadline = request.tolerances.at_most(ROOT_TOL), Deadline.after(request.max_time)
        task = Gathering(arm, goal, exact, near, method, deadline, progress)
        answer = _answered(task, request.tolerances, count, include_turns)
    return answer if scene is None else replace(answer, _colliding=scene.collides(answer.theta))


def _method_and_start(
    arm: Arm, goal: AnyTarget, theta0: Array, fixed_joints: Mapping[str, float] | None, closed_form: bool
) -> tuple[Method, Array]:
    """The method with the joints at their fixed values, and theta0 (n,) with these. NoClosedFormError without one."""
    fixed = checked_fixed_joints(arm, fixed_joints)
    method = method_for(arm, goal, tuple(fixed))
    if closed_form and method.family is None:
        miss = f"{closest_miss_of(arm, method)[1]}; elimination solves it numerically, without closed_form=True"
        raise NoClosedFormError(f"{arm.name} has no closed form for a {type(goal).__name__}: {method.reason or miss}")
    near = np.array(theta0)
    near[list(fixed)] = list(fixed.values())
    return method, near


def _answered(task: Gathering, tolerances: Tolerances, count: int, include_turns: bool) -> AllSolutions:
    """The answers, exact ones where there are any, else within the tolerances."""
    answer = _exact_answers(task, count, include_turns)
    if not (len(answer) or answer.timed_out or tolerances == task.tolerances):
        roots, run, hits = task.within_tolerances(tolerances)
        families = [Members([root], root.theta[None]) for root in roots]
        answer = task.assembled(families, include_turns, (run, hits), False) if roots else answer
    return replace(answer, _tolerances=tolerances)


def _exact_answers(task: Gathering, count: int, include_turns: bool) -> AllSolutions:
    """The answers of the method, with `count` values of each sampled joint."""
    method, values = task.method, task.held_values(count)
    known = None if method.core is None else task.compiled(values)
    if method.verifier is not None and not method.sampled:
        known = task.eliminated(values[0])
    more = 0 if known is not None and method.exact else task.searches
    if known is not None and not method.sampled:
        if known.families:
            known = None  # the core keeps one of all families that move the same joints
        elif not include_turns:
            return AllSolutions(
                task.arm, known.rows, known.inside, task.near, method, task.complete, task.target, task.tolerances
            )  # fmt: skip
    if known is None:
        found, starts, hits = task.solved(values)
    else:
        pairs = zip(known.theta, known.moves, strict=True)
        found = [Root(theta, tuple(np.flatnonzero(moves).tolist())) for theta, moves in pairs]
        starts, hits = (len(values), known.hits) if len(values) > 1 else (0, 0)
    if (
        method.algebraic
        and method.sampled
        and not task.inside([root.theta for root in found])
        and not task.deadline.passed
    ):
        members, tried, converged = replace(task, progress=None).solved(task.values_found())
        found, starts, hits = found + members, starts + tried, hits + converged
    families = task.families(found)
    missed = False
    if more:
        beside, run, converged = task.searched(more, found, int(method.algebraic))
        before, families = len(families), task.families(found + beside) if beside else families
        missed = len(families) > before
        if missed or not method.exact:
            starts, hits = starts + run, hits + converged
    return task.assembled(families, include_turns, (starts, hits), not missed)


def _at_once(
    arm: Arm, target: TargetLike, theta0: ArrayLike | None, position_tol: float, orientation_tol: float
) -> AllSolutions | None:
    """The core's answer, where it has the family and all arguments are plainly right."""
    # An array becomes a `Pose` only when somebody asks for it: that takes as long as the configurations.
    given = np.array(as_given(target)) if type(target) is np.ndarray else target_for(arm, target)
    like, numbers = (Pose, given) if isinstance(given, np.ndarray) else (type(given), given.numbers)
    method = known_method(arm, like, given.axis.tobytes() if isinstance(given, Approach) else None)
    if method is None or method.core is None or method.sampled:
        return None
    if type(position_tol) is not float or not in_radians(orientation_tol):
        return None
    start, tolerances = arm.ready if theta0 is None else theta0, Tolerances(position_tol, orientation_tol)
    exact = tolerances.at_most(ROOT_TOL)
    answer = method.core.solve(numbers, start, None, exact.position, exact.orientation)
    found = None if answer is None else Configurations(*answer)
    if found is None or found.families:
        return None
    return AllSolutions(arm, found.rows, found.inside, frozen(start), method, method.exact, given, tolerances)


def checked_fixed_joints(arm: Arm, fixed_joints: Mapping[str, float] | None) -> dict[int, float]:
    """{joint's index: value}, base to tip, with the joints that have limits of one value."""
    fixed = {i: float(arm.limits.lower[i]) for i in locked_joints(arm)}
    if fixed_joints is None:
        return fixed
    if not isinstance(fixed_joints, Mapping):
        raise InputError(f"fixed_joints must be a mapping such as {{'elbow': 0.3}}; got {quote(fixed_joints)}")
    for name, value in fixed_joints.items():
        if name not in arm.joint_names:
            raise unknown_name("joint", name, arm.joint_names, within=arm.name, listing="arm.joint_names")
        number = as_number(value, f"fixed_joints[{name!r}]")
        i = arm.joint_names.index(name)
        if not arm.limits.lower[i] <= number <= arm.limits.upper[i]:
            raise InputError(
                Text(
                    "joint {joint!r} cannot be fixed at {value}, outside its limits {lower} … {upper}",
                    joint=name,
                    value=Quantity(number, arm.units[i]),
                    lower=Quantity(arm.limits.lower[i], arm.units[i]),
                    upper=Quantity(arm.limits.upper[i], arm.units[i]),
                )
            )
        fixed[i] = number
    return dict(sorted(fixed.items()))
