"""The greatest mass at the tool by the limits of efforts. What joints and motors need for a wanted one."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arm.arm import Arm, require_arm
from ..arm.effort_limits import EffortLimits, effort_limits
from ..description.inertias import check_inertias
from ..planning import Trajectory
from ..support.checks import LARGEST_ARRAY, Array, as_number, as_whole
from ..support.display import Brief
from ..support.errors import InputError, listed

DT = 0.01  # Time between states of a motion [s].
UNLOADED = 1e-9  # An effort per mass [N m/kg, N/kg] below this is the rounding of 0.
MASS_CODES = ("inertial-unusable", "mass-missing", "inertia-implausible")  # Findings that make torques wrong.
# Samples from which each cost descends, and its steps: they begin at a quarter of the range.
STARTS, ROUNDS = 4, 24


class Needs(NamedTuple):
    """The greatest |effort| [N m, N], speed [rad/s, m/s] and power [W] of r joints and motors, (r,).

    `share` is effort / limit: above 1 where it is too much, 0 without a limit.
    """

    names: tuple[str, ...]
    effort: Array
    speed: Array
    power: Array
    share: Array


@dataclass(frozen=True, eq=False, repr=False)
class Payload(Brief):
    """The greatest mass (...) [kg] at the tool in each state of an arm, and the joint or motor that limits it.

    The rows `names` (r) are n joints, then k motors. Their efforts [N m, N] are linear in the mass m: `own` + m
    `per_kg`, both (..., r). So `mass` is the exact solution of |own + m per_kg| ≤ `limits` (r,). It is 0 where the arm
    cannot hold itself, and inf where no row carries a payload. It is NaN, unknown, where only rows without a limit
    carry it. `limiting` (...) is the row that limits, or that the arm itself overloads most; −1 for none. `speeds`
    (..., r) are those of the rows. `notes` say what the description lacks. `t` (...) [s] are instants of a motion.
    """

    arm: Arm
    theta: Array
    names: tuple[str, ...]
    own: Array
    per_kg: Array
    speeds: Array
    limits: Array
    mass: Array
    limiting: NDArray[np.int_]
    notes: tuple[str, ...]
    t: Array | None = None

    @property
    def worst(self) -> int:
        """The state with the least mass, an index into `mass.ravel()`. Unknown masses come last."""
        return int(np.nan_to_num(self.mass, nan=np.inf).argmin())

    def needs(self, mass: float = 0.0) -> Needs:
        """What joints and motors need over all states with a payload of that mass [kg], without friction.

        Power is |effort · speed| at one instant. Raises InputError for a mass below 0.
        """
        efforts = self.own + as_number(mass, "mass", 0.0) * self.per_kg
        values = np.abs([efforts, self.speeds, efforts * self.speeds])
        effort, speed, power = values.reshape(3, -1, len(self.names)).max(axis=1)
        return Needs(self.names, effort, speed, power, effort / self.limits)


def payload(
    arm: Arm,
    theta: ArrayLike | Trajectory | None = None,
    theta_dot: ArrayLike | None = None,
    theta_ddot: ArrayLike | None = None,
    *,
    offset: ArrayLike = (0.0, 0.0, 0.0),
    samples: int = 2000,
) -> Payload:
    """The greatest mass at the tool in each configuration, along a motion, or anywhere inside the limits.

    The payload is a point mass. The limits are the joints' `limits.effort` and those of `arm.actuators`. Motors that
    share joints have the efforts of least norm. `Arm.inverse_dynamics` says what the model leaves out.

    Without theta it takes random configurations. From their extremes it descends to the least mass and to the greatest
    effort of each joint. It may miss a minimum.

    Args:
        arm: The arm, with a description.
        theta: Configurations (..., n) [rad, m], the name of one, a `Trajectory`, or None. A trajectory counts every
            0.01 s, and on both sides of its breakpoints.
        theta_dot: Velocities (..., n) [rad/s, m/s]. None is at rest. A trajectory has its own.
        theta_ddot: Accelerations (..., n) [rad/s², m/s²]. None is none. A trajectory has its own.
        offset: The place of the mass (3,) [m], in tool axes.
        samples: How many random configurations, without theta.

    Raises:
        InputError: An argument has another shape, theta holds no configuration, or the trajectory is another arm's.
        TwistarmError: The arm has no description, and so no masses.
    """
    limits, motion, t = effort_limits(require_arm(arm)), list[Any]([theta, theta_dot, theta_ddot]), None
    if isinstance(theta, Trajectory):
        if theta.joint_names != arm.joint_names or theta_dot is not None or theta_ddot is not None:
            raise InputError("a trajectory must be of this arm, and has its own rates: leave out theta_dot, theta_ddot")
        # Accelerations may jump at breakpoints; a trajectory gives them from above.
        t = np.union1d(theta.sample(DT).t, [*theta.breakpoints, *np.nextafter(theta.breakpoints[1:], 0.0)])
        motion = [theta(t, order) for order in range(3)]
    elif theta is None:
        motion[0] = arm.random_theta(0, as_whole(samples, "samples", 1, LARGEST_ARRAY))
        motion[0] = with_extremes(arm, partial(_costs, arm, limits, offset, motion[1:]), motion[0])
    own, per_kg = _efforts(arm, limits, offset, *motion)
    if not own.size:
        raise InputError("theta must hold one configuration or more")
    x = np.broadcast_to(arm.theta_from(motion[0]), (*own.shape[:-1], arm.n))
    speeds = np.broadcast_to(np.zeros(arm.n) if motion[1] is None else np.asarray(motion[1]), x.shape) @ limits.C.T
    found, notes = _greatest(own, per_kg, limits), tuple(_gaps(arm, limits.unlimited))
    return Payload(arm, x, limits.names, own, per_kg, speeds, limits.limits, *found, notes, t)


def _efforts(arm: Arm, limits: EffortLimits, offset: ArrayLike, *motion: Any) -> tuple[Array, Array]:
    """The efforts (..., r) of the rows of `limits` in a motion without a payload, and what each kg of one adds."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a note of the report says that no link has a mass
        own, loaded = (arm.inverse_dynamics(*motion, payload=(mass, offset)) @ limits.W.T for mass in (0.0, 1.0))
    return own, loaded - own


def _costs(arm: Arm, limits: EffortLimits, offset: ArrayLike, rates: list[Any], theta: Array) -> Array:
    """What is least at the extremes (..., 1 + 2n): the mass, and minus the efforts of joints, own and by a payload."""
    own, per_kg = _efforts(arm, limits, offset, theta, *rates)
    mass = np.nan_to_num(_greatest(own, per_kg, limits)[0], nan=np.inf)[..., None]
    return np.concatenate([mass, -np.abs(own[..., : arm.n]), -np.abs(per_kg[..., : arm.n])], axis=-1)


def with_extremes(arm: Arm, costs: Callable[[Array], Array], theta: Array) -> Array:
    """Theta (s, n), and below it local minima of each of the `costs`, (..., n) to (..., c), to 1e-3 of the range.

    A cost descends from its least samples by the best step along one joint, halved where none helps.
    """
    lower, upper = arm.sampling_bounds
    moves = np.vstack([np.zeros(arm.n), np.eye(arm.n), -np.eye(arm.n)]) * (upper - lower) / 4
    starts = costs(theta).argsort(axis=0)[:STARTS]
    x, column = theta[starts.ravel()], np.tile(np.arange(starts.shape[1]), len(starts))
    size, row = np.ones(len(x)), np.arange(len(x))
    for _ in range(ROUNDS):
        tried = np.clip(x[:, None] + size[:, None, None] * moves, lower, upper)
        best = costs(tried)[row, :, column].argmin(axis=1)
        x = tried[row, best]
        size[best == 0] /= 2
    return np.vstack([theta, x])


def _greatest(own: Array, per_kg: Array, limits: EffortLimits) -> tuple[Array, NDArray[np.int_]]:
    """The greatest m ≥ 0 (...) with |own + m per_kg| ≤ limits in every row, and the row that limits it."""
    loaded, share, room = np.abs(per_kg) > UNLOADED, np.abs(own) / limits.limits, np.full(own.shape, np.inf)
    np.divide(limits.limits - np.sign(per_kg) * own, np.abs(per_kg), out=room, where=loaded)
    held, least = (share <= 1.0).all(axis=-1), room.min(axis=-1)
    unknown = np.isinf(least) & (loaded[..., : len(limits.unlimited)] & limits.unlimited).any(axis=-1)
    limiting = np.where(np.isinf(least), -1, room.argmin(axis=-1))
    mass = np.where(held, np.where(unknown, np.nan, least), 0.0)
    return mass, np.where(held, limiting, share.argmax(axis=-1))


def _gaps(arm: Arm, unlimited: NDArray[np.bool_]) -> Iterator[str]:
    """A sentence for each gap. `unlimited` (n,) marks joints without an effort limit."""
    if not arm.pinocchio.moved_mass:
        yield "no link that moves has a mass: the arm's own weight counts as 0, and a real arm holds less"
    if arm.description is not None:
        found = (*arm.findings, *check_inertias(arm.description))
        yield from (f"{gap.place}: {gap.what}" for gap in found if gap.code in MASS_CODES)
    if unlimited.any():
        lacking = listed(name for name, lacks in zip(arm.joint_names, unlimited, strict=True) if lacks)
        so = "the payload is unknown" if unlimited.all() else "the payload is an upper bound"
        yield f"no effort limit of {lacking}: {so}; write effort in <limit>, or in [limits] of an arm.toml"
    turning = arm.limits.effort[np.array(arm.units) == "rad"]
    if len(turning) > 2 and np.isfinite(turning[0]) and (turning == turning[0]).all():
        yield f"all turning joints have the effort limit {turning[0]:g} N m: a placeholder?"
    if arm.actuators is not None and arm.actuators.undriven:
        yield f"the motors do not determine {listed(arm.actuators.undriven)}: limits of motors do not count"
