"""Torque limits along a path as rows a s̈ + b ṡ² ≤ 1, and the efforts that a motion uses.

On a path q(s) the torques are m s̈ + c ṡ² + g with m = M q', c = M q'' + C(q, q') q' and g = N(q). So |τ| ≤ E is m s̈ +
c ṡ² ≤ E − g and −(m s̈ + c ṡ²) ≤ E + g. Source: Pham & Pham, A new approach to time-optimal path parameterization based
on reachability analysis, IEEE T-RO 34(3), 2018, §II.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..arm.effort_limits import EffortLimits, effort_limits
from ..support.checks import Array, as_flag
from ..support.errors import InputError, LimitError, listed
from ..support.messages import Argument, Posture, Quantity, Remedies, Text
from .piecewise import JointPath, derivative, evaluate

# Share of an effort that gravity must leave at rest. With less, the arm would hardly move.
LEAST_ROOM = 1e-3
SAMPLES, PER_PIECE = 2000, 4  # Least number of instants at which a motion is measured, in all and on each piece.
SAMPLED = 1e-4  # A motion may exceed by this share between its samples what they show.
HELD = 64  # Places on a path at which the efforts must hold the arm at rest.

Load = float | tuple[ArrayLike, ArrayLike]


@dataclass(frozen=True, eq=False)
class TorqueLimits:
    """The efforts (r,) [N m, N] of joints and motors of an arm with a `payload` of `Arm.inverse_dynamics`."""

    arm: Arm
    payload: Load
    efforts: EffortLimits

    @classmethod
    def of(cls, arm: Arm, effort: Array, payload: Load) -> TorqueLimits:
        """The limits of joints, `effort` (n,), and of the arm's motors.

        Raises InputError if no link has a mass, a joint has no limit, or the payload is negative. Raises TwistarmError
        without a description.
        """
        if not arm.pinocchio.moved_mass:
            raise InputError(f"no link that {arm.name} moves has a mass: torque limits need <inertial> in its links")
        efforts = effort_limits(arm, effort)
        lacking = [name for name, lacks in zip(arm.joint_names, efforts.unlimited, strict=True) if lacks]
        if lacking:
            give = Text("give {limits}", limits=Argument("limits", {"effort": dict.fromkeys(lacking, ...)}))
            remedies = Remedies(("write effort in <limit>", give))
            what = "no effort limit of {lacking}: {remedies}"
            raise InputError(Text(what, lacking=listed(lacking), remedies=remedies))
        found = cls(arm, payload, efforts)
        found._torques(arm.ready)  # says what is wrong with the payload
        return found

    def require_held(self, theta: Array, where: str = "") -> None:
        """Raise LimitError if the efforts do not hold arm and payload at rest at theta (..., n). `where` names it."""
        self._held(theta.reshape(-1, self.arm.n), where)

    def rows(self, path: JointPath, s: Array) -> Array:
        """a and b (2, k, 2 r) of the rows a s̈ + b ṡ² ≤ 1 at s (k,). Raises LimitError as `require_held` does."""
        q, tangent, bend = (path(s, order) for order in range(3))
        gravity, room = self._held(q)
        rates = (np.zeros_like(q), tangent), (tangent, bend)
        return np.stack([_both_ways(self._torques(q, *pair) - gravity) / room for pair in rates])

    def shares(self, q: Array, q_dot: Array, q_ddot: Array) -> Array:
        """The part of the efforts beyond gravity that states (k, n) use, (k, r). 1 is at a limit, 0 at rest."""
        gravity, room = self._held(q)
        used = _both_ways(self._torques(q, q_dot, q_ddot) - gravity) / room
        return np.maximum(*np.split(used, 2, axis=1))

    def slowing(self, breakpoints: Array, coefficients: Array) -> float:
        """By which factor a motion (k + 1,), (d + 1, k, n) must be slowed to just keep the efforts.

        A motion slowed by f uses 1/f² of the efforts beyond gravity.
        """
        return float(np.sqrt(self._sampled(breakpoints, coefficients)[1].max(initial=0.0) * (1.0 + SAMPLED)))

    def require_kept(self, breakpoints: Array, coefficients: Array) -> None:
        """Raise LimitError with joint or motor, time and factor where such a motion exceeds an effort."""
        t, used = self._sampled(breakpoints, coefficients)
        k, row = np.unravel_index(used.argmax(), used.shape)
        if used[k, row] > 1.0 + SAMPLED:
            what = "{owner} would exceed its effort limit {limit} at t = {time:.4g} s: multiply times by {factor:.4g}"
            factor = float(np.sqrt(used[k, row])) * (1.0 + 5e-4)
            limit = Quantity(float(self.efforts.limits[row]), self._unit(int(row)))
            raise LimitError(Text(what, owner=self._owner(int(row)), limit=limit, time=float(t[k]), factor=factor))

    def _sampled(self, breakpoints: Array, coefficients: Array) -> tuple[Array, Array]:
        """Instants (k,) of a motion, and what it uses there of the efforts beyond gravity (k, r)."""
        steps = np.diff(breakpoints)
        count = max(PER_PIECE, -(-SAMPLES // len(steps)))
        tau = steps[:, None, None] * np.linspace(0.0, 1.0, count + 1)[:, None]
        states = (evaluate(derivative(coefficients, order)[:, :, None], tau) for order in range(3))
        t = (breakpoints[:-1, None] + tau[..., 0]).ravel()
        return t, self.shares(*(state.reshape(-1, self.arm.n) for state in states))

    def _torques(self, *motion: Array) -> Array:
        return self.arm.inverse_dynamics(*motion, payload=self.payload) @ self.efforts.W.T

    def _held(self, q: Array, where: str = "") -> tuple[Array, Array]:
        """The torques (k, r) at rest, and what they leave of the efforts in both directions (k, 2 r)."""
        gravity, limits = self._torques(q), self.efforts.limits
        room = np.concatenate([limits - gravity, limits + gravity], axis=1)
        share = np.abs(gravity) / limits
        k, row = np.unravel_index(share.argmax(), share.shape)
        if share[k, row] > 1.0 - LEAST_ROOM:
            raise self._overloaded(q[k], int(row), float(abs(gravity[k, row])), where)
        return gravity, room

    def _overloaded(self, q: Array, row: int, torque: float, where: str) -> LimitError:
        unit = self._unit(row)
        return LimitError(
            Text(
                "{where}{owner} needs {torque} to hold arm and payload at rest at {theta}; its effort limit is "
                "{limit}: {remedies}",
                where=f"{where}: " if where else "",
                owner=self._owner(row),
                torque=Quantity(torque, unit, 4),
                theta=Posture(tuple(q.tolist()), self.arm.units),
                limit=Quantity(float(self.efforts.limits[row]), unit),
                remedies=Remedies(
                    ("carry less", "go another way", Text("change the limit by {limits}", limits=Argument("limits")))
                ),
            )
        )

    def _owner(self, row: int) -> str:
        name = self.efforts.names[row]
        return f"joint {name!r}" if row < self.arm.n else name

    def _unit(self, row: int) -> str:
        units = (*self.arm.units, *(() if self.arm.actuators is None else self.arm.actuators.motor_units))
        return "N" if units[row] == "m" else "N m"


def torque_limits(arm: Arm, effort: Array, torques: bool, payload: Load) -> TorqueLimits | None:
    """The torque limits of a motion, None without `torques`."""
    if as_flag(torques, "torques"):
        return TorqueLimits.of(arm, effort, payload)
    if not (isinstance(payload, (int, float)) and payload == 0.0):
        raise InputError(
            Text("a payload counts with torque limits alone: add {torques}", torques=Argument("torques", True))
        )
    return None


def grid_rows(torques: TorqueLimits | None, path: JointPath, s: Array) -> Array:
    """a and b (2, k, 2 r) of the rows at s (k,) of a path, or (2, k, 0) without torque limits."""
    return np.zeros((2, len(s), 0)) if torques is None else np.ascontiguousarray(torques.rows(path, s))


def largest_between(torques: TorqueLimits, path: JointPath, grid: Array, x: Array) -> Array:
    """The largest a s̈ + b ṡ² (N,) in the middle of each interval, for x = ṡ² (N + 1,) on a grid (N + 1,)."""
    a, b = torques.rows(path, 0.5 * (grid[:-1] + grid[1:]))
    s_ddot, middle = 0.5 * np.diff(x) / np.diff(grid), 0.5 * (x[:-1] + x[1:])
    return np.asarray((a * s_ddot[:, None] + b * middle[:, None]).max(axis=1))


def _both_ways(torques: Array) -> Array:
    return np.concatenate([torques, -torques], axis=1)
