"""The model of calibration and wiring: an arm whose joints and motors are a little out, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arm.arm import Arm
from ..support.checks import Array
from ..theory.joints import plane_axes
from ..theory.lines import axis_points
from ..theory.poe import columns, motions
from ..theory.rotations import skew
from ..theory.screws import adjoint_of, exp, inverse_of, to_screw

# The parameters of base and tool, and the first one of the joints.
BASE, TOOL, JOINTS = slice(0, 6), slice(6, 12), 12
# How an axis moves across itself: a slide has a direction and no place.
OF_A_TURN, OF_A_SLIDE = ("shift x", "shift y", "tilt x", "tilt y"), ("tilt x", "tilt y")


class Parameter(NamedTuple):
    """One number of the model: its owner (a joint, "base" or "tool"), what it changes, and its unit."""

    owner: str
    what: str
    unit: str

    def __str__(self) -> str:
        return f"{self.owner} {self.what}"


@dataclass(frozen=True, eq=False)
class Geometry:
    """g(y) = B e^b (Π F_i e^{d_i} e^{t_i x_i} F_i⁻¹) M T e^a, with x = A P (y + s y + z).

    y are the commanded joints, P = 1; or with `drive` P (n, k) the readings of the arm's k motors from their configured
    zeros. F_i (m, 4, 4) stands on the axis of joint i with z along it. With `axes`, d_i moves and tilts the axis across
    itself: 4 numbers of a turning joint, 2 tilts of a slide. Chen, Yang & Tan 2001; Okamura & Park 1996. `base` B and
    `tool` T are starting values. `parameters` are b, a, z, d, s in this order.
    """

    arm: Arm
    base: Array
    tool: Array
    scales: bool = False
    axes: bool = True
    drive: Array | None = None

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All parameters of the model, also those that no log can show together."""
        arm, motors = self.arm, self.arm.actuators
        drives = list(zip(arm.joint_names, arm.units, strict=True))
        if self.drive is not None and motors is not None:
            drives = list(zip(motors.names, motors.motor_units, strict=True))
        moves, owners, m = {"shift": "m", "turn": "rad", "tilt": "rad"}, arm.moving_names, arm.screws.shape[1]
        if len(owners) != m:  # a joint has many columns
            owners = tuple(f"screw {i + 1}" for i in range(m))
        kinds = product(("base", "tool"), ("shift", "turn"), "xyz")
        frames = [Parameter(owner, f"{what} {axis}", moves[what]) for owner, what, axis in kinds]
        axes = [
            Parameter(name, what, moves[what[:-2]])
            for name, slides in zip(owners, self._sliding, strict=True)
            for what in (OF_A_SLIDE if slides else OF_A_TURN)
        ]
        zeros = [Parameter(name, "zero", unit) for name, unit in drives]
        scales = [Parameter(name, "scale", "1") for name, _ in drives]
        return (*frames, *zeros, *axes * self.axes, *scales * self.scales)

    @property
    def k(self) -> int:
        """How many zeros there are: one for each joint, or each motor."""
        return self.arm.n if self.drive is None else self.drive.shape[1]

    @cached_property
    def _sliding(self) -> NDArray[np.bool_]:
        v, w = np.linalg.norm(self.arm.screws.reshape(2, 3, -1), axis=1)
        return np.asarray(w < 1e-12 * v)

    @cached_property
    def axis_frames(self) -> Array:
        """F_i (m, 4, 4): on each axis at the point nearest to the frame before; x as `plane_axes` chooses it."""
        screws = self.arm.screws
        frames = np.tile(np.eye(4), (screws.shape[1], 1, 1))
        frames[:, :3, :3] = [plane_axes(axis) for axis in to_screw(screws.T).axis]
        frames[:, :3, 3] = axis_points(screws, np.zeros(3))
        return frames

    def split(self, p: Array) -> tuple[Array, Array, Array, Array, Array]:
        """b (6,), a (6,), z (k,), d (m, 6), s (k,) of parameters (P,)."""
        b, a, z, axes, s = np.split(p, np.cumsum([6, 6, self.k, self._across.sum() * self.axes]))
        d = np.zeros(self._across.shape)
        if self.axes:
            d[self._across] = axes
        return b, a, z, d, s if self.scales else np.zeros(self.k)

    @cached_property
    def _across(self) -> NDArray[np.bool_]:
        """The components (m, 6) of d that move the axis across itself."""
        across = np.zeros((len(self._sliding), 6), dtype=bool)
        across[:, :2], across[:, 3:5] = ~self._sliding[:, None], True
        return across

    def joints(self, p: Array, y: Array) -> Array:
        """The joints' values (K, n) for commanded joints, or readings of motors, y (K, k)."""
        _, _, z, _, s = self.split(p)
        driven = y * (1.0 + s) + z
        return driven if self.drive is None else driven @ self.drive.T

    def poses(self, p: Array, y: Array) -> Array:
        """The tool (K, 4, 4) seen from the frame of the measurements."""
        b, a, _, d, _ = self.split(p)
        theta = self.joints(p, y)
        if self.axes:
            D, S = self._moved(d)
            g = motions(S, theta @ self.arm.coupling.A.T)[:, -1] @ D[-1] @ self.arm.home
        else:
            g = self.arm.fk(theta)
        return self.base @ _motion(b) @ g @ self.tool @ _motion(a)

    def twists(self, p: Array, y: Array) -> tuple[Array, Array]:
        """`poses`, and the spatial twists (K, 6, P) of the tool by each parameter."""
        b, a, _, d, _ = self.split(p)
        theta, base = self.joints(p, y), self.base @ _motion(b)
        if self.axes:
            D, S = self._moved(d)
            A, F = self.arm.coupling.A, self.axis_frames
            products = motions(S, theta @ A.T)
            g, J = products[:, -1] @ D[-1] @ self.arm.home, columns(products, S) @ A
            # d_i moves what follows; the joints before it carry that.
            across = [adjoint_of(D[i] @ F[i] @ exp(d[i])) @ _right_jacobian(d[i]) for i in range(len(F))]
            owner, component = np.nonzero(self._across)
            before = np.concatenate([np.broadcast_to(np.eye(4), (len(y), 1, 4, 4)), products[:, :-1]], axis=1)
            moved = [columns(before[:, owner], np.array(across)[owner, :, component].T)]
        else:
            g, J, moved = self.arm.fk(theta), self.arm.spatial_jacobian(theta), []
        g = base @ g @ self.tool @ _motion(a)
        J = J if self.drive is None else J @ self.drive
        parts = [J, *moved]
        if self.scales:
            parts.append(J * y[:, None])
        first = np.broadcast_to(adjoint_of(base) @ _right_jacobian(b), (len(y), 6, 6))
        last = adjoint_of(g) @ _right_jacobian(a)
        return g, np.concatenate([first, last, adjoint_of(base) @ np.concatenate(parts, axis=-1)], axis=-1)

    def _moved(self, d: Array) -> tuple[Array, Array]:
        """D (m + 1, 4, 4), the displacement of all that follows i axes, and the screws (6, m) moved by them."""
        each, D = self.axis_frames @ exp(d) @ inverse_of(self.axis_frames), np.tile(np.eye(4), (len(d) + 1, 1, 1))
        for i, motion in enumerate(each):
            D[i + 1] = D[i] @ motion
        return D, (adjoint_of(D[1:]) @ self.arm.screws.T[..., None])[..., 0].T

    def corrected(self, p: Array) -> tuple[Array, Array]:
        """Space screws (6, m) and home (4, 4) of the arm with moved axes and zeros, without base and tool."""
        _, _, z, d, _ = self.split(p)
        D, S = self._moved(d)
        products = motions(S, self.arm.coupling.A @ z)
        return columns(products, S), products[-1] @ D[-1] @ self.arm.home

    def displacements(self, p: Array) -> Array:
        """What multiplies each joint's frame at rest from the left, (m, 4, 4): the axis moved, then the zero."""
        _, _, z, d, _ = self.split(p)
        zeros = exp(self.arm.screws.T, self.arm.coupling.A @ z)
        return self.axis_frames @ exp(d) @ inverse_of(self.axis_frames) @ zeros


def _motion(xi: Array) -> Array:
    """e^ξ (4, 4); most fits hold base or tool at 0, where `exp` would take most of the time."""
    return exp(xi) if xi.any() else np.eye(4)


def _right_jacobian(xi: Array) -> Array:
    """J (6, 6) with e^{ξ + δ} = e^ξ e^{J δ}: I − ad/2 + ad²/6, for small ξ. Chirikjian 2011, §10.7."""
    if not xi.any():
        return np.eye(6)
    ad = np.zeros((6, 6))
    ad[:3, :3] = ad[3:, 3:] = skew(xi[3:])
    ad[:3, 3:] = skew(xi[:3])
    return np.eye(6) - ad / 2 + ad @ ad / 6
