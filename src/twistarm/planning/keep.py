"""Keep: the part of the tool's pose that a free move keeps, and proofs along motions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..ik.targets import AnyTarget, Approach, Pose, Position, one_direction, one_vector
from ..support.checks import Array, Matrix, Row, as_positive, as_reals, as_rotation, frozen, pose_of, require_radians
from ..support.directions import numbers
from ..support.display import Brief
from ..support.errors import InputError, quote
from ..support.messages import Quantity, Text, joined
from ..theory import rotations
from ..theory.lines import axis_points, least_turn
from ..theory.screws import to_screw
from .configurations import shortest
from .piecewise import bernstein, shifted

Flags = NDArray[np.bool_]

ROUNDING = 1e-9  # How far [rad, m] beyond its tolerances a pose still counts as kept.
STEPS = 12  # Gauss-Newton steps of a projection. Two or three are usual.
DAMPING = 1e-6  # Of a step, beside squared rows of the Jacobian.
LONGEST_STEP = 0.5  # The longest step [rad, m] of a joint in a projection.
AIM = 0.95  # Which share of the distance from the middle a projection aims at, so that it ends inside.
LEVELS = 40  # How often the proof halves an interval.
MOST_INTERVALS = 100_000  # More open intervals than this end a proof, in some 0.1 s.
INSET = 0.003  # How far [m] states keep inside a box, at most; a share of its width where it is narrow.
VERTICAL = frozen([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Keep(Brief):
    """What the tool keeps all along a `FreeMove`: a direction, its orientation, a box, a plane, or several.

    direction: where the tool axis points, (3,) in base axes. The angle between R @ tool_axis and it is at most `tol`.
    True: where it points at the start.

    tool_axis: the axis (3,) in tool axes; None: `arm.tool_axis`, as for an `Approach`. True: the axis of the tool that
    points along `direction` at the start.

    orientation: a rotation R (3, 3), tool to base; the angle to it is at most `tol`. True: that of the start.

    tol: the largest angle [rad], 0.05 by default, at most π/2.

    box: least and greatest (x, y, z) of the tool's origin, (2, 3) [m] in base axes. A side is open at ±inf.

    plane: a point [m] of a plane and its normal, (2, 3) in base axes. The tool's origin is at most `position_tol` off.

    position_tol: the largest distance from the plane [m], 0.002 by default.

    Raises InputError where nothing is kept, and for unusable numbers. `plan` raises PathError for a start that does not
    keep all. That is every start where parts contradict each other.
    """

    direction: Row | Literal[True] | None = None
    tool_axis: Row | Literal[True] | None = None
    orientation: Matrix | Literal[True] | None = None
    tol: float = 0.05
    box: Matrix | None = None
    plane: Matrix | None = None
    position_tol: float = 0.002

    def __post_init__(self) -> None:
        if self.tool_axis is not None and self.direction is None:
            raise InputError("tool_axis says which axis of the tool points along direction: give direction too")
        if all(part is None for part in (self.direction, self.orientation, self.box, self.plane)):
            raise InputError("a Keep needs what to keep: direction, orientation, box or plane")
        if self.tool_axis is True and self.direction is True:
            raise InputError("give direction or tool_axis: one follows from the other at the start")
        checked: dict[str, Any] = {name: as_positive(getattr(self, name), name) for name in ("tol", "position_tol")}
        require_radians(checked["tol"], "tol")
        for name, check in (("direction", one_direction), ("tool_axis", one_direction), ("orientation", as_rotation)):
            value = getattr(self, name)
            checked[name] = value if value is None or value is True else frozen(check(value, name))
        if self.box is not None:
            low, high = rows = _rows(self.box, "box", "the least and the greatest (x, y, z) [m]")
            if (low >= high).any():
                k = int(np.argmax(low >= high))
                raise InputError(
                    f"the box is empty along {'xyz'[k]}: its least, {low[k]:g} m, must be below its greatest, "
                    f"{high[k]:g} m (a plane keeps the tool's origin in a plane)"
                )
            checked["box"] = frozen(rows)
        if self.plane is not None:
            point, normal = _rows(self.plane, "plane", "a point [m] and the normal")
            checked["plane"] = frozen([one_vector(point, "the plane's point"), one_direction(normal, "its normal")])
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @classmethod
    def level(cls, tol: float = 0.05) -> Keep:
        """Keep upright what is upright at the start, such as a cup: turning about the vertical is free.

        Args:
            tol: The largest angle [rad] from upright.
        """
        return cls(direction=VERTICAL, tool_axis=True, tol=tol)

    def at(self, arm: Arm, g: Array) -> Keep:
        """The same with numbers in place of True and None, for a start.

        Args:
            arm: The arm.
            g: The pose (4, 4) of its tool at the start.
        """
        R, given = g[:3, :3], dict[str, Any]()
        if self.direction is not None:
            axis = arm.tool_axis if self.tool_axis is None else self.tool_axis
            given["tool_axis"] = R.T @ self.direction if axis is True else axis
            given["direction"] = R @ axis if self.direction is True else self.direction
        if self.orientation is not None:
            given["orientation"] = R if self.orientation is True else self.orientation
        return replace(self, **given)

    def weaker(self, arm: Arm) -> Iterator[Keep]:
        """What arms of few joints may keep of an orientation: the tool axis, then what is upright.

        All parts must be numbers, as of `at`.
        """
        if self.orientation is None:
            return
        R = np.asarray(self.orientation)
        if self.direction is not None:
            yield replace(self, orientation=None)
            return
        for axis in (arm.tool_axis, R.T @ VERTICAL):
            yield replace(self, orientation=None, tool_axis=axis, direction=R @ axis)

    def constrain(self, target: AnyTarget) -> AnyTarget:
        """Constrain a target by the rotation that is kept, where it leaves its rotation free."""
        if not isinstance(target, Position):
            return target
        if self.orientation is None:
            if self.direction is None:
                return target
            return Approach(target.p, np.asarray(self.direction), np.asarray(self.tool_axis))
        R = np.asarray(self.orientation)
        if self.direction is not None:
            turn = least_turn(R @ np.asarray(self.tool_axis), np.asarray(self.direction))
            if np.linalg.norm(turn) > self.tol:  # only rotations between the two keep both
                R = rotations.exp(0.5 * turn) @ R
        return Pose(pose_of(R, target.p))

    def describe(self) -> str:
        """What is kept in words, with numbers for all parts, as of `at`."""
        kept: list[str] = []
        tol, off = Quantity(self.tol, "rad", 3), Quantity(self.position_tol, "m", 3)
        if self.orientation is not None:
            kept.append(Text("the orientation within {tol}", tol=tol))
        if self.direction is not None:
            axis, along = (numbers(np.asarray(part)) for part in (self.tool_axis, self.direction))
            kept.append(Text("the tool axis {axis} within {tol} of {along}", axis=axis, tol=tol, along=along))
        kept += ["the tool's origin in a box"] if self.box is not None else []
        kept += [Text("the tool's origin within {off} of a plane", off=off)] if self.plane is not None else []
        return joined(", ", kept)


AS_AT_START: Mapping[str, Callable[..., Keep]] = {
    "level": Keep.level,
    "direction": partial(Keep, direction=True),
    "orientation": partial(Keep, orientation=True),
}
"""What may be kept as it is at the start, by name: makers that take `tol`."""


def _rows(value: Any, name: str, what: str) -> Array:
    """Check two rows (2, 3) without NaN."""
    rows = as_reals(value, name, what)
    if rows.shape != (2, 3) or np.isnan(rows).any():
        raise InputError(f"{name} must be {what}, each of three numbers; got {quote(value)}")
    return rows


@dataclass(frozen=True, eq=False)
class Constraint:
    """A `Keep` of an arm, with numbers for all of its parts.

    Rotations: the error is φ u, the turn by φ [rad] about u in tool axes from what is kept. Its rate is u · ω.
    Positions: lower ≤ rows @ p ≤ upper [m].
    """

    arm: Arm
    keep: Keep

    @cached_property
    def _half_spaces(self) -> tuple[Array, Array, Array, Array]:
        """Unit rows (k, 3), lower and upper (k,) [m], and how far states keep inside them (k,)."""
        rows, lower, upper = [], [], []
        if self.keep.box is not None:
            rows, (lower, upper) = [*np.eye(3)], ([*side] for side in np.asarray(self.keep.box))
        if self.keep.plane is not None:
            point, normal = np.asarray(self.keep.plane)
            rows, at, off = [*rows, normal], float(normal @ point), self.keep.position_tol
            lower, upper = [*lower, at - off], [*upper, at + off]
        low, high = np.array(lower), np.array(upper)
        return np.array(rows).reshape(-1, 3), low, high, np.minimum(INSET, 0.5 * (high - low))

    @cached_property
    def _across(self) -> Array:
        """Two unit vectors (2, 3) across the tool axis."""
        return np.linalg.svd(np.asarray(self.keep.tool_axis)[None, :])[2][1:]

    def _turns(self, R: Array) -> Iterator[tuple[Array, Array, Array | None]]:
        """For each rotation that is kept: φ (m,), φ u (m, 3) at R (m, 3, 3), and the rows that count (None: all)."""
        if self.keep.direction is not None:
            along, axis = np.asarray(self.keep.direction) @ R, np.asarray(self.keep.tool_axis)
            yield *_turn(along @ rotations.skew(axis), along @ axis), self._across
        if self.keep.orientation is not None:
            E = np.asarray(self.keep.orientation).T @ R
            w = np.stack([E[:, 2, 1] - E[:, 1, 2], E[:, 0, 2] - E[:, 2, 0], E[:, 1, 0] - E[:, 0, 1]], axis=1)
            yield *_turn(w, np.trace(E, axis1=1, axis2=2) - 1.0), None

    def excess(self, g: Array) -> tuple[Array, Array]:
        """How far poses g (m, 4, 4) are beyond the tolerances: angles (m,) [rad] and lengths (m,) [m]; ≤ 0 inside."""
        rows, lower, upper, _ = self._half_spaces
        turns = [angle - self.keep.tol for angle, _, _ in self._turns(g[:, :3, :3])]
        at = g[:, :3, 3] @ rows.T
        return (
            np.max(turns, axis=0) if turns else np.full(len(g), -inf),
            np.maximum(lower - at, at - upper).max(axis=1, initial=-inf),
        )

    def fault(self, theta: Array) -> str:
        """What a configuration (n,) does not keep, in words; empty if it keeps all."""
        turn, offset = (float(excess[0]) for excess in self.excess(self.arm.fk(theta)[None]))
        if turn > ROUNDING:
            what = "the orientation" if self.keep.direction is None else "the tool axis"
            angle, tol = Quantity(turn + self.keep.tol, "rad", 3), Quantity(self.keep.tol, "rad", 3)
            return Text("{what} is {angle} off, and at most {tol} is kept", what=what, angle=angle, tol=tol)
        if offset > ROUNDING:
            return Text("the tool's origin is {off} outside what is kept", off=Quantity(offset, "m", 3))
        return ""

    def projected(self, theta: Array, share: float, lower: Array, upper: Array) -> tuple[Array, Flags]:
        """Configurations (m, n) near theta that keep all within `share` of the tolerances, and which do.

        θ ← θ − Jᵀ (J Jᵀ + λ 1)⁻¹ e with the errors beyond the tolerances, inside the limits. Source: Berenson et al.,
        Manipulation Planning on Constraint Manifolds, ICRA 2009.
        """
        theta, open_ = np.array(theta), np.arange(len(theta))
        converged = np.zeros(len(theta), dtype=bool)
        for step in range(STEPS + 1):
            g, J = self.arm.fk(theta[open_]), self.arm.body_jacobian(theta[open_])
            e, rows = self._pull(g, J, share)
            done = ~e.any(axis=1)
            converged[open_[done]] = True
            open_, e, rows = open_[~done], e[~done], rows[~done]
            if not len(open_) or step == STEPS:
                break
            by = np.clip(shortest(e, rows, DAMPING * np.eye(e.shape[1])), -LONGEST_STEP, LONGEST_STEP)
            theta[open_] = np.clip(theta[open_] + by, lower, upper)
        return theta, converged

    def tangent(self, theta: Array, way: Array, share: float) -> Array:
        """The way (n,) without its part that leads out of a share of the tolerances at theta."""
        _, rows = self._pull(self.arm.fk(theta)[None], self.arm.body_jacobian(theta)[None], share)
        return np.asarray(way + shortest((rows[0] @ way)[None], rows, DAMPING * np.eye(rows.shape[1]))[0])

    def _pull(self, g: Array, J: Array, share: float) -> tuple[Array, Array]:
        """Errors (m, k) beyond a share of the tolerances, and their rows (m, k, n). They aim a little inside."""
        errors, jacobians = [], []
        R = g[:, :3, :3]
        for angle, error, across in self._turns(R):
            beyond = angle > share * self.keep.tol
            part = np.where(beyond, 1.0 - AIM * share * self.keep.tol / np.maximum(angle, 1e-12), 0.0)[:, None]
            e, rows = error * part, J[:, 3:]
            errors.append(e if across is None else e @ across.T)
            jacobians.append((rows if across is None else across @ rows) * beyond[:, None, None])
        normals, lower, upper, inset = self._half_spaces
        if len(normals):
            at, inset = g[:, :3, 3] @ normals.T, (1.0 - share) * inset
            low, high = lower + inset, upper - inset
            aim = np.clip(at, low + (1.0 - AIM) * inset, high - (1.0 - AIM) * inset)
            beyond = (at < low) | (at > high)
            errors.append(np.where(beyond, at - aim, 0.0))
            jacobians.append((normals @ R @ J[:, :3]) * beyond[..., None])
        return np.concatenate(errors, axis=1), np.concatenate(jacobians, axis=1)

    def unproven(self, coefficients: Array, durations: Array) -> Flags:
        """Which pieces (s,) of polynomials (d + 1, s, n) are not proven to keep all.

        Within an interval the angle changes by at most Σ w_j |Δθ_j|, the position by Σ v_j |Δθ_j| (`rates`). What is
        left open by its middle is halved.
        """
        powers = np.arange(len(coefficients) - 1, 0, -1.0)[:, None]
        most = np.abs(bernstein(coefficients, durations)).max(axis=(0, 1), initial=0.0)
        w, v = rates(self.arm, most)
        piece, half = np.arange(len(durations)), 0.5 * durations
        middle, bad = half, np.zeros(len(durations), dtype=bool)
        for _ in range(LEVELS):
            about = shifted(coefficients[:, piece], middle)
            moved = (np.abs(about[:-1]) * (half**powers)[:, :, None]).sum(axis=0)
            turn, offset = self.excess(self.arm.fk(about[-1]))
            bad[piece[(turn > ROUNDING) | (offset > ROUNDING)]] = True
            left = ((turn + moved @ w > ROUNDING) | (offset + moved @ v > ROUNDING)) & ~bad[piece]
            piece, middle, half = piece[left], middle[left], 0.5 * half[left]
            if not len(piece):
                return bad
            if len(piece) > MOST_INTERVALS:
                break
            piece, middle, half = np.tile(piece, 2), np.concatenate([middle - half, middle + half]), np.tile(half, 2)
        bad[piece] = True
        return bad


def _turn(w: Array, cosine: Array) -> tuple[Array, Array]:
    """φ (m,) and φ u (m, 3) by sin φ u, or a multiple of it, and the same multiple of cos φ."""
    sine = np.sqrt((w * w).sum(axis=1))
    angle = np.arctan2(sine, cosine)
    return angle, w * (angle / np.maximum(sine, 1e-300))[:, None]


def rates(arm: Arm, most: Array) -> tuple[Array, Array]:
    """Bounds (n,) of the tool's angular [rad] and linear [m] speed by each joint alone at rate 1.

    They hold while |theta| is at most `most` (n,), which counts for joints that slide. A joint turns the tool's origin
    on a radius of at most the lengths from axis to axis up to the tool, at rest, and what joints between them slide.
    """
    spread, tool, inward = np.abs(arm.coupling.A.T), arm.home[:3, 3], arm.screws[:, ::-1]  # from the tool to the base
    screws, feet = to_screw(inward.T), axis_points(inward, tool)
    turns = np.isfinite(screws.pitch)
    turning = np.where(turns, screws.magnitude, 0.0)
    slide = screws.magnitude * np.where(turns, np.abs(screws.pitch), 1.0)
    slid = slide * (most @ spread)[::-1]
    radius = np.cumsum(np.linalg.norm(np.diff(np.vstack([tool, feet]), axis=0), axis=1) + slid) - slid
    return spread @ turning[::-1], spread @ (turning * radius + slide)[::-1]
