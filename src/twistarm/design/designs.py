"""Arms side by side: reach, dexterity, payload, mass and the time of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.arm import Arm, require_arm
from ..ik import reachable, solve_ik
from ..ik.targets import Target
from ..planning import JointMove, PathError, plan
from ..support.checks import Array, Progress, reporting, require
from ..support.display import Brief
from ..support.errors import InputError, LimitError, NotConvergedError, TwistarmError, quote
from ..support.messages import joined
from ..theory.manipulability import POOR, Manipulability, scaled_jacobian
from .mapping import sphere
from .panel import Panel
from .parking import best_parking
from .payload import payload, with_extremes
from .voxel_map import Grid

SAMPLES, CUBES = 2000, 40  # Configurations, and cubes along the diameter of the ball that holds the tool.


@dataclass(frozen=True, eq=False, repr=False)
class Design(Brief):
    """An arm in numbers, over random configurations inside its limits. NaN is unknown. `notes` say why.

    `reach` [m] is `arm.reach`, and `farthest` [m] the greatest distance of the tool from the base's origin. `volume`
    [m³] is that of the positions that inverse kinematics reaches, by a random point in each of 40³ cubes, to 1 %.
    `condition` is the median condition number in the directions that the arm has. `singular` is the share of
    configurations where it is above 100. `payload` [kg] is the least and `median_payload` the median, at rest.
    `mass` [kg] is that of the moving links. `duration` [s] is that of the motion.
    `panel` is the share of a panel's tasks that the arm does, parked where it does most.
    """

    name: str
    arm: Arm
    reach: float
    farthest: float
    volume: float
    condition: float
    singular: float
    payload: float
    median_payload: float
    mass: float
    duration: float
    notes: tuple[str, ...]
    panel: float = np.nan


def compare_designs(
    arms: Sequence[Arm],
    poses: Sequence[Target | Array] = (),
    panel: Panel | None = None,
    progress: Progress | None = None,
) -> tuple[Design, ...]:
    """Each arm in the same numbers, estimated by samples to about 1 %.

    Args:
        arms: Two arms or more. Equal names get numbers.
        poses: Two targets or more for the tool. Each arm plans joint moves through them, at rest at each. () for no
            motion. An arm that misses a pose has the duration NaN, and a note.
        panel: Tasks that `best_parking` tries with each arm, or None.
        progress: Called with the fraction done, or None.

    Raises:
        InputError: There are fewer than two arms, or a single pose.
    """
    if not isinstance(arms, Sequence) or len(arms) < 2:
        raise InputError(f"arms must be a list of two or more; got {quote(arms)}")
    if not isinstance(poses, Sequence) or len(poses) == 1:
        raise InputError(f"poses must be a list of two targets or more, or (); got {quote(poses)}")
    if panel is not None:
        require(panel, Panel, "panel", "which load_panel reads")
    names = [require_arm(arm).name for arm in arms]
    names = [f"{name} ({i + 1})" if names.count(name) > 1 else name for i, name in enumerate(names)]
    report_progress, found = reporting(progress), list[Design]()
    for name, arm in zip(names, arms, strict=True):
        found.append(_design(name, arm, poses, panel))
        report_progress(len(found) / len(arms))
    return tuple(found)


def _design(name: str, arm: Arm, poses: Sequence[Target | Array], panel: Panel | None) -> Design:
    volume = least = median = mass = duration = share = np.nan
    notes: list[str] = []
    try:
        if len(poses):
            start = solve_ik(arm, poses[0]).require()
            duration = plan(arm, [JointMove(pose) for pose in poses[1:]], start=start).duration
    except (NotConvergedError, PathError, LimitError) as error:
        notes.append(joined(": ", ["no motion", error.message]))
    try:
        held, mass = payload(arm, samples=SAMPLES), arm.pinocchio.moved_mass
        least, median = float(held.mass.min()), float(np.median(held.mass))
        notes += held.notes
    except TwistarmError as error:  # no description
        notes.append(str(error))
    try:
        volume = _volume(arm)
    except TwistarmError as error:  # not in the compiled core
        notes.append(f"no volume: {error}")
    try:
        share = np.nan if panel is None else len(best_parking(arm, panel).done) / len(panel.tasks)
    except TwistarmError as error:  # not in the compiled core, or no shapes
        notes.append(f"no panel: {error}")
    # As `arm.manipulability`, whose axes take long.
    J = scaled_jacobian(arm.body_jacobian(arm.random_theta(0, SAMPLES)), arm.prismatic, arm.reach)
    measured = Manipulability(np.asarray(np.linalg.svd(J, compute_uv=False), np.float64), np.empty(0), arm.reach)
    condition = measured.condition_in(max(int(measured.rank.max()), 1))
    dexterity = float(np.median(condition)), float((condition > POOR).mean())
    numbers = arm.reach, _farthest(arm), volume, *dexterity, least, median, mass, duration
    return Design(name, arm, *numbers, tuple(notes), share)


def _farthest(arm: Arm) -> float:
    """The greatest distance [m] of the tool from the base's origin."""
    samples = arm.random_theta(0, SAMPLES)
    theta = with_extremes(arm, lambda x: -np.linalg.norm(arm.fk(x)[..., :3, 3], axis=-1, keepdims=True), samples)
    return float(np.linalg.norm(arm.fk(theta)[..., :3, 3], axis=-1).max())


def _volume(arm: Arm) -> float:
    """The volume [m³] reached.

    Centres of cubes err by half a cube at a face along the axes, as that of a rail. Random points do not. The points
    are reached exactly, or a plane would be as thick as the tolerance.
    """
    centre, radius = sphere(arm)
    grid = Grid.about(centre, radius, 2.0 * radius / CUBES)
    p = grid.centres(np.arange(grid.count))
    p += grid.voxel * np.random.default_rng(0).uniform(-0.5, 0.5, p.shape)
    return float(grid.voxel**3 * reachable(arm, p, position_tol=1e-9).converged.sum())
