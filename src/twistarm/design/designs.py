"""Arms side by side: reach, dexterity, payload, mass and the time of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arm.arm import Arm, require_arm
from ..checking.doctor.postures import POOR
from ..ik import solve_ik
from ..ik.targets import Target
from ..planning import JointMove, PathError, plan
from ..support.checks import Array, as_whole
from ..support.display import Brief
from ..support.errors import InputError, LimitError, NotConvergedError, TwistarmError, shown
from .extremes import with_extremes
from .payload import payload

SAMPLES = 2000

POINTS, CELLS = 200_000, 24
"""Tool positions, and the cubes along their longest side."""

ALIKE = 0.005
"""A smaller relative difference is not told: samples differ by as much."""


@dataclass(frozen=True, eq=False, repr=False)
class Design(Brief):
    """An arm in numbers, over random configurations inside its limits. NaN is unknown; `notes` tell why.

    `reach` [m] is the greatest distance of the tool from the base's origin, `volume` [m³] what its origin sweeps.
    `condition` and `manipulability` (Yoshikawa) are medians, in the directions that the arm has, metres measured in
    its own length. `singular` is the share of configurations with a condition above 100. `payload` [kg] is the least
    and `median_payload` the median over the configurations. `mass` [kg] moves. `duration` [s] is that of the motion.
    """

    name: str
    arm: Arm
    reach: float
    volume: float
    condition: float
    manipulability: float
    singular: float
    payload: float
    median_payload: float
    mass: float
    duration: float
    notes: tuple[str, ...]

    def against(self, other: Design) -> str:
        """What this design does better and worse than another, in a sentence."""
        said = []
        for verb, unit, mine, its in (
            ("reaches", "%", self.reach, other.reach),
            ("sweeps in volume", "%", self.volume, other.volume),
            ("holds", "kg", self.payload, other.payload),
            ("holds in the median", "kg", self.median_payload, other.median_payload),
            ("weighs", "kg", self.mass, other.mass),
            ("takes", "s", self.duration, other.duration),
        ):
            if ALIKE * its < abs(mine - its) < np.inf:  # nor NaN
                size = abs(mine - its) * (100.0 / its if unit == "%" else 1.0)
                said.append(f"{verb} {size:.2g} {unit} {'more' if mine > its else 'less'}")
        if not said:
            return f"{self.name} does the same as {other.name}"
        return f"{self.name} {' and '.join(filter(None, [', '.join(said[:-1]), said[-1]]))} than {other.name}"


def compare_designs(
    arms: Sequence[Arm],
    poses: Sequence[Target | Array] = (),
    *,
    samples: int = SAMPLES,
    rng: int | np.random.Generator = 0,
) -> tuple[Design, ...]:
    """Each arm in the same numbers. Estimates by samples, to about 1 %.

    Args:
        arms: Two arms or more. Equal names get numbers.
        poses: Two targets or more for the tool; each arm plans joint moves through them. () for no motion.
        samples: How many random configurations, for everything but the volume.
        rng: Their seed, or a NumPy Generator.

    Returns:
        A `Design` for each arm, in order. An arm that misses a pose has the duration NaN, and a note.

    Raises:
        InputError: There are fewer than two arms, a single pose, or an unusable argument.
    """
    if not isinstance(arms, Sequence) or len(arms) < 2:
        raise InputError(f"arms must be a list of two or more; got {shown(arms)}")
    if not isinstance(poses, Sequence | np.ndarray) or len(poses) == 1:
        raise InputError(f"poses must be a list of two targets or more, or (); got {shown(poses)}")
    as_whole(samples, "samples", 1, POINTS)
    names = [require_arm(arm).name for arm in arms]
    names = [f"{name} ({i + 1})" if names.count(name) > 1 else name for i, name in enumerate(names)]
    return tuple(_design(name, arm, poses, samples, rng) for name, arm in zip(names, arms, strict=True))


def _design(
    name: str, arm: Arm, poses: Sequence[Target | Array], samples: int, rng: int | np.random.Generator
) -> Design:
    theta, notes = arm.random_theta(rng, samples), list[str]()
    measured = arm.manipulability(theta)
    rank = max(int(measured.rank.max()), 1)
    condition, gain = measured.condition_in(rank), measured.singular_values[:, :rank].prod(axis=-1)
    least = median = mass = duration = np.nan
    try:
        held = payload(arm, samples=samples, rng=rng)
        least, median = float(held.mass.min()), float(np.median(held.mass[:samples]))
        mass = arm.pinocchio.moved_mass
        notes += held.notes
    except TwistarmError as error:  # no description
        notes.append(str(error))
    try:
        if len(poses):
            start = solve_ik(arm, poses[0]).require()
            duration = plan(arm, [JointMove(pose) for pose in poses[1:]], start=start).duration
    except (NotConvergedError, PathError, LimitError) as error:
        notes.append(f"no motion: {error}")
    reach, volume = _reach(arm, rng)
    medians, singular = np.median([condition, gain], axis=1).tolist(), float((condition > POOR).mean())
    return Design(
        name, arm, reach, volume, medians[0], medians[1], singular, least, median, mass, duration, tuple(notes)
    )


def _reach(arm: Arm, rng: int | np.random.Generator) -> tuple[float, float]:
    """The reach [m], and the volume [m³] of the cubes that hold a position. They protrude at the surface."""
    far = with_extremes(
        arm, lambda x: -np.linalg.norm(arm.fk(x)[..., :3, 3], axis=-1, keepdims=True), arm.random_theta(rng, SAMPLES)
    )
    p = arm.fk(arm.random_theta(rng, POINTS))[:, :3, 3]
    edge = float(np.ptp(p, axis=0).max()) / CELLS
    cubes = np.unique(((p - p.min(axis=0)) / max(edge, 1e-9)).astype(np.int64) @ (2 * CELLS) ** np.arange(3))
    return float(np.linalg.norm(arm.fk(far)[:, :3, 3], axis=-1).max()), edge**3 * len(cubes)
