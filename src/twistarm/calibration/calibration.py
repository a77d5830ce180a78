"""The result of a calibration: the corrected arm and description, its parameters, and what was left over."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..arm.arm import Arm
from ..collision.scene import Scene, require_scene
from ..description.chain import walk_chain
from ..description.document import Reading
from ..description.packages import package_index
from ..description.source_text import SourceText
from ..description.urdf import build_description
from ..support.checks import Array, as_flag, as_theta, as_whole, require
from ..support.display import short_repr
from ..support.errors import InputError
from ..theory.rotations import log_of, skew, to_rpy
from ..theory.screws import adjoint_of, exp, inverse_of
from .camera import HandEye, poses_of
from .geometry import BASE, JOINTS, TOOL, Parameter
from .measurements import Bools
from .problem import OUTLIER, Problem, of_joints

# The share of the error of base and tool alone that the corrected arm must stay below, on rows not fitted.
SURE = 0.95
TO_THE_NOISE = 2.0  # Rows whose median residual is no more [standard deviations] fit.
ELSEWHERE = 5.0  # An expected error so many times that of rows left out shows that the log is from few places.

CANDIDATES = 1000
VIEWS = 30  # So many times more random configurations are tried before a camera, which sees its tag in few.

# [m, rad] that the arm of the copy may differ from the corrected one: 16 digits of angles leave less.
SAME = 1e-9


class Estimate(NamedTuple):
    """One parameter: its value and standard deviation [m, rad, 1]. `seen`: the log shows it; else it is held at 0."""

    parameter: Parameter
    value: float
    std: float
    seen: bool

    @property
    def of_joint(self) -> bool:
        """Whether it is a joint's, not of base, tool or a place."""
        return not self.parameter.owner.startswith(("base", "tool", "point ", "plane ", "wire "))

    def __str__(self) -> str:
        """In words, in mm and degrees: "axis 0.81 mm toward its x ± 0.05 mm"."""
        unit, (kind, _, axis) = self.parameter.unit, self.parameter.what.partition(" ")
        value, std = amount(self.value, unit), amount(self.std, unit)
        motions = {"shift": f"axis {value} toward its {axis}", "tilt": f"axis tilted {value} about its {axis}"}
        return f"{motions.get(kind, f'{self.parameter.what} {value}')} ± {std}"


@dataclass(frozen=True, eq=False, repr=False)
class Calibration:
    """What a log tells of an arm's geometry.

    `unknowns` (Q,) solve the `problem`, and `first` (Q,) those with base and tool fitted alone. The log shows those
    that are `seen` (Q,), among those `fitted`. `weights` (K,) are those of the rows. `held_out` and `held_out_before`
    are the mean errors [m] on rows left out of the fit at random, with all and with base and tool alone. `warnings` say
    what is odd about the log. `faults` are those that spoil the correction.
    """

    problem: Problem
    unknowns: Array
    first: Array
    seen: Bools
    fitted: Bools
    weights: Array
    held_out: float = np.inf
    held_out_before: float = np.inf
    warnings: tuple[str, ...] = ()
    faults: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return short_repr("Calibration", {"arm": self.arm.name, "held_out": self.held_out, "confirmed": self.confirmed})

    @property
    def _p(self) -> Array:
        return self.unknowns[: self.problem.P]

    @cached_property
    def arm(self) -> Arm:
        """The corrected arm: axes and zeros, without scales."""
        geometry = self.problem.geometry
        screws, home = geometry.corrected(self._p)
        moving = geometry.arm.moving_names
        return replace(geometry.arm, screws=screws, home=home, description=None, moving_names=moving)

    @property
    def base(self) -> Array:
        """The base (4, 4) in the frame of the measurements."""
        return np.asarray(self.problem.geometry.base @ exp(self.unknowns[BASE]))

    @property
    def tool(self) -> Array:
        """The measured point (4, 4) beyond the tip."""
        return np.asarray(self.problem.geometry.tool @ exp(self.unknowns[TOOL]))

    @property
    def before(self) -> Array:
        """The errors (K,) [m] of the rows with base and tool fitted alone."""
        return self.problem.errors(self.first)

    @property
    def after(self) -> Array:
        """The errors (K,) [m] of the rows with all."""
        return self.problem.errors(self.unknowns)

    @property
    def outliers(self) -> tuple[int, ...]:
        """The rows, from 1, that do not fit."""
        loud = self.problem.normalised_residual(self.unknowns)
        return tuple((np.flatnonzero(loud > OUTLIER * max(1.0, float(np.median(loud)))) + 1).tolist())

    @cached_property
    def estimates(self) -> tuple[Estimate, ...]:
        """All parameters."""
        covariance = self._covariance(self.seen, self.unknowns)
        std = np.where(self.seen, np.sqrt(np.maximum(np.diag(covariance), 0.0)), np.inf)
        columns = np.where(self.seen, self.unknowns, 0.0).tolist(), std.tolist(), self.seen.tolist()
        return tuple(map(Estimate, self.problem.parameters, *columns))

    @cached_property
    def hand_eye(self) -> HandEye | None:
        """Camera and tag of a camera's log. They belong to the corrected arm if rows left out confirm it."""
        problem, camera, corrected = self.problem, self.problem.camera, self.confirmed_here and not self.sound
        if camera is None:
            return None
        q = self.unknowns if corrected else self.first
        C = self._covariance(self.seen & (corrected | ~of_joints(problem)), q)
        geometry, measured = problem.geometry, camera.in_camera(poses_of(problem.log))
        computed = camera.in_camera(geometry.poses(q[: problem.P], problem.log.theta))
        shift = np.linalg.norm((computed - measured)[:, :3, 3], axis=1)
        turn = np.linalg.norm(log_of(np.swapaxes(measured[:, :3, :3], 1, 2) @ computed[:, :3, :3]), axis=1)
        base, tool = geometry.base @ exp(q[BASE]), geometry.arm.tool @ geometry.tool @ exp(q[TOOL])
        Ad = adjoint_of(base)  # the base's deviations are in its axes, those of its inverse in the other's
        spread = np.concatenate([np.diag(Ad @ C[BASE, BASE] @ Ad.T), np.diag(C)[TOOL]])
        spread[~self.seen[:JOINTS]] = np.inf
        std = np.sqrt(spread.reshape(4, 3).sum(axis=1)).tolist()
        base_std, tool_std = (std[0], std[1]), (std[2], std[3])
        beside, carried = (inverse_of(base), base_std, geometry.arm.base), (tool, tool_std, geometry.arm.tip_link)
        first, second = (carried, beside) if camera.mount == "tool" else (beside, carried)
        return HandEye(*first, *second, (float(np.median(shift)), float(np.median(turn))), corrected)

    def _covariance(self, free: Bools, q: Array) -> Array:
        """The covariance (Q, Q) of the `free` unknowns at q. Noise is at least the stated; more in a louder log."""
        r = self.problem.residual(q, self.weights)
        A = self.problem.slopes(q, self.weights)[:, free]
        louder = max(1.0, float(r @ r) / max(1, len(r) - A.shape[1]))
        covariance, size = np.zeros((len(free), len(free))), np.linalg.norm(A, axis=0)
        inverse = np.linalg.pinv((A / size).T @ (A / size), rcond=1e-12)
        covariance[np.ix_(free, free)] = louder * inverse / np.outer(size, size)
        return covariance

    @cached_property
    def sound(self) -> bool:
        """The arm needs no correction: base and tool alone fit to the noise, and rows left out show no gain by more."""
        shown = not self.faults and bool((self.seen & of_joints(self.problem)).any())
        loud = float(np.median(self.problem.normalised_residual(self.first)))
        return shown and SURE * self.held_out_before <= self.held_out < np.inf and loud < TO_THE_NOISE

    @cached_property
    def confirmed_here(self) -> bool:
        """Rows left out confirm the arm, corrected or sound, where the log was taken, and the log has no faults."""
        return self.sound or (not self.faults and self.held_out < SURE * self.held_out_before)

    @cached_property
    def confirmed(self) -> bool:
        """Rows that were not fitted confirm the arm, corrected or `sound`, also elsewhere in reach.

        One placement of points, a plane or a wire is not enough: its place is fitted too. Rows left out then only show
        that the tool stood still. Positions near each other are not enough either. More than `ELSEWHERE` times their
        error, or their noise, may be expected elsewhere.
        """
        if self.problem.log.located.any():
            noise = float(np.median(self.problem.sigma))
            return self.confirmed_here and self.expected <= ELSEWHERE * max(self.held_out, noise)
        return self.confirmed_here and len(np.unique(self.problem.group_of_row)) > 1

    @property
    def why_not(self) -> str:
        """Why the correction is not confirmed; empty if it is."""
        if self.faults or self.confirmed:
            return "".join(self.faults[:1])
        kept = f"rows left out keep {1000 * self.held_out:.3g} mm"
        if self.confirmed_here:
            return f"{kept}, but all are from one place: measure at others, as --next names them"
        what = f"{kept}, and {1000 * self.held_out_before:.3g} mm without the correction"
        return f"{what}: this log shows none; use the arm as described, or measure more, or better"

    def require(self, *, here: bool = False) -> Calibration:
        """Itself, or InputError if the correction is not confirmed; with `here`, where the log was taken is enough."""
        if not (self.confirmed or (as_flag(here, "here") and self.confirmed_here)):
            raise InputError(self.why_not)
        return self

    @property
    def unseen(self) -> tuple[Parameter, ...]:
        """The parameters that this log does not show beside the others."""
        return tuple(estimate.parameter for estimate in self.estimates if not estimate.seen)

    @property
    def places(self) -> dict[str, Array]:
        """Where the named points and anchors are (3,) [m]."""
        found = self.unknowns[self.problem.P :].reshape(-1, 3)
        return {name: found[k] for k, (kind, name) in enumerate(self.problem.places) if kind != "plane"}

    def predict(self, theta: ArrayLike) -> Array:
        """The positions (N, 3) [m] that would be measured at commanded theta (N, n) [rad, m]."""
        x = as_theta(theta, self.arm.n, "theta", self.arm.joint_names)
        p = self.problem.geometry.poses(self._p, x.reshape(-1, self.arm.n))[:, :3, 3]
        return p.reshape(*x.shape[:-1], 3)

    def changes(self) -> tuple[str, ...]:
        """The corrections of each joint in words, in mm and degrees: "elbow: axis 0.81 mm toward its x ± …"."""
        corrections: dict[str, list[str]] = {}
        for estimate in self.estimates:
            if estimate.seen and estimate.of_joint:
                corrections.setdefault(estimate.parameter.owner, []).append(str(estimate))
        return tuple(f"{owner}: {', '.join(parts)}" for owner, parts in corrections.items())

    @property
    def zeros(self) -> Array:
        """What is added to each commanded joint (n,) [rad, m]: 0 where the log does not show it."""
        return np.array([estimate.value for estimate in self.estimates if estimate.parameter.what == "zero"])

    def motor_offsets(self) -> Mapping[str, float]:
        """The `offset` of each motor for arm.toml that corrects the joints' zeros: o − G z [rad, m].

        It takes the place of the zeros in the origins of the corrected description. Raises InputError for an arm
        without actuators.
        """
        motors = self.problem.geometry.arm.actuators
        if motors is None:
            raise InputError(f"{self.arm.name} has no actuators: its zeros go into the origins of the description")
        return dict(zip(motors.names, (motors.offset - motors.G @ self.zeros).tolist(), strict=True))

    def next_postures(self, count: int = 10, *, scene: Scene | None = None) -> Array:
        """The configurations (count, n) to measure next, which show most beside the log: D-optimal, one by one.

        Each next one maximises det(I + σ⁻² J C Jᵀ) for the covariance C so far. Candidates are 1,000 random
        configurations, without those that collide in `scene`. Raises InputError for another count.
        """
        as_whole(count, "count", 1, CANDIDATES)
        camera, geometry = self.problem.camera, self.problem.geometry
        theta = self.arm.random_theta(0, CANDIDATES if camera is None else VIEWS * CANDIDATES)
        if camera is not None:
            theta = theta[camera.visible(geometry.poses(self._p, theta), self.problem.log)][:CANDIDATES]
        if scene is not None:
            theta = theta[~require_scene(scene, self.problem.geometry.arm).collides(theta)]
        J, C, chosen = self._slopes(theta)[:, :3] / self.problem.noise[0], self._spread, list[int]()
        if camera is not None:
            J = camera.image(geometry.poses(self._p, theta))[1] @ self._slopes(theta) / camera.noise
        identity = np.eye(J.shape[1])
        for _ in range(min(count, len(theta))):
            gain = np.linalg.slogdet(identity + J @ C @ np.swapaxes(J, 1, 2))[1]
            gain[chosen] = -np.inf
            chosen.append(int(gain.argmax()))
            CJ = C @ J[chosen[-1]].T
            C = C - CJ @ np.linalg.solve(identity + J[chosen[-1]] @ CJ, CJ.T)
        return np.asarray(theta[chosen])

    @cached_property
    def expected(self) -> float:
        """The error [m] to expect at random configurations: √(mean tr J C Jᵀ).

        What is held has its usual tolerance.

        Without measured positions, and before a camera, a motion of the whole arm does not count.
        """
        theta = self.arm.random_theta(1, CANDIDATES // 4)
        J, p = self._slopes(theta)[:, :3], self.predict(theta)
        if self.problem.camera is not None or not self.problem.log.located.any():
            moved = np.concatenate([np.broadcast_to(np.eye(3), (len(p), 3, 3)), -skew(p)], axis=2).reshape(-1, 6)
            Q, flat = np.linalg.qr(moved)[0], J.reshape(len(moved), -1)
            J = (flat - Q @ (Q.T @ flat)).reshape(J.shape)
        return float(np.sqrt(np.trace(J @ self._spread @ np.swapaxes(J, 1, 2), axis1=1, axis2=2).mean()))

    @cached_property
    def _spread(self) -> Array:
        """The covariance (P, P) of the geometry, also of what is held at 0."""
        return self._covariance(self.fitted, self.unknowns)[: self.problem.P, : self.problem.P]

    def _slopes(self, theta: Array) -> Array:
        """The derivatives (N, 6, P) of the tool's positions and turns by the parameters."""
        g, V = self.problem.geometry.twists(self._p, theta)
        return np.concatenate([V[:, :3] - skew(g[:, :3, 3]) @ V[:, 3:], V[:, 3:]], axis=1)


def amount(value: float, unit: str) -> str:
    """A value [m, rad, 1] in words, in mm and degrees."""
    if unit == "1":
        return f"{value:.2g}"
    return f"{1000 * value:.2f} mm" if unit == "m" else f"{np.degrees(value):.3f}°"


def corrected_urdf(calibration: Calibration, *, zeros: bool = True, here: bool = False) -> str:
    """The text of the arm's URDF with corrected joint origins; that of a xacro file is expanded.

    With `zeros` the joints' zeros are in the origins too, so commands stay as they are; without, they belong into
    arm.toml (`Calibration.motor_offsets`). Base and tool of the measurement are not part of it. The copy is read
    again, and its screws and home must be the corrected ones. With `here` a correction will do that is confirmed only
    where the log was taken (`Calibration.confirmed_here`).

    Raises:
        InputError: The correction is not confirmed, the arm has no description, or joints moved that have no origin
            of their own.
    """
    arm = (
        require(calibration, Calibration, "calibration", "as calibrate makes it")
        .require(here=here)
        .problem.geometry.arm
    )
    if arm.description is None:
        raise InputError(f"{arm.name} has no description: load its URDF, not a baked file or screws")
    p = calibration.unknowns[: calibration.problem.P].copy()
    if not as_flag(zeros, "zeros"):
        p[JOINTS : JOINTS + arm.n] = 0.0
    source = SourceText(arm.description.text)
    elements = {joint.get("name"): joint for joint in source.robot.findall("joint")}
    for name, origin in _origins(calibration, p).items():
        if arm.description.joints[name].part_of or name not in elements:
            raise InputError(f"joint {name!r} shares its origin with others: correct it by hand")
        xyz, rpy = (" ".join(map(repr, part.tolist())) for part in (origin[:3, 3], to_rpy(origin[:3, :3])))
        written = elements[name].find("origin")
        if written is None:
            source.insert(elements[name], f'<origin xyz="{xyz}" rpy="{rpy}"/>')
        else:
            source.set(written, xyz=xyz, rpy=rpy, quat_xyzw=None)
    text = source.edited()
    _require_same(calibration, p, text)
    return text


def _origins(calibration: Calibration, p: Array) -> dict[str, Array]:
    """The new origin (4, 4) of each joint that moved: O G⁻¹ D G, with its frame at rest G and its motion D."""
    arm = calibration.problem.geometry.arm
    assert arm.description is not None
    g, origins = np.eye(4), {}
    values = dict(zip(arm.moving_names, arm.coupling.b, strict=True))
    moved = dict(zip(arm.moving_names, calibration.problem.geometry.displacements(p), strict=True))
    for joint in arm.description.chain(arm.base, arm.tip_link):
        g = g @ joint.origin
        if joint.moving:
            if np.abs(moved[joint.name] - np.eye(4)).max() > 0.0:
                origins[joint.name] = joint.origin @ inverse_of(g) @ moved[joint.name] @ g
            g = g @ exp(joint.twist, values[joint.name])
    return origins


def _require_same(calibration: Calibration, p: Array, text: str) -> None:
    arm = calibration.problem.geometry.arm
    assert arm.description is not None
    path = arm.description.path or Path("corrected.urdf")
    copy = build_description(text, Reading(path, package_index(path)))
    masterless = {name: affine.offset for name, affine in arm.couplings.items() if affine.master is None}
    locked = {name: value for name, value in masterless.items() if copy.joints[name].scalar}
    chain = walk_chain(copy, arm.base, arm.tip_link, arm.tool, locked)
    screws, home = calibration.problem.geometry.corrected(p)
    off = float(max(np.abs(chain.screws - screws).max(), np.abs(chain.home - home).max()))
    if off > SAME:
        raise InputError(
            f"the corrected copy would be another arm, {off:.2g} off; please report it with the description"
        )
