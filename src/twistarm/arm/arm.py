"""The arm: a chain of joints from base to tip with its kinematics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..description.tree import GRAVITY
from ..support.checks import (
    Array,
    as_number,
    as_pose,
    as_theta,
    as_twist,
    as_vector,
    require,
    require_broadcast,
    require_mapping,
    require_one,
)
from ..support.errors import InputError, TwistarmError, listed, quote, unknown_name, warn
from ..theory.manipulability import Manipulability, manipulability_of
from ..theory.screws import adjoint, inverse
from . import engine
from .arm_data import ArmData
from .pinocchio_model import why_no_pinocchio

NOTHING: Mapping[str, float] = MappingProxyType({})


class Arm(ArmData):
    """A robot arm with n independent joint coordinates `theta` (..., n) [rad or m], base to tip.

    g_st(theta) = Π exp(ξ_i (A θ)_i) · home is the product of exponentials, MLS §3.2.2. `screws` (6, m) has the columns
    ξ_i, and `home` (4, 4) is the pose at theta = 0. `coupling` is the mimic coupling (A, b), whose b is in `screws` and
    `home`. Poses are seen from the base link. Every method accepts any finite theta, also outside the limits, with any
    leading axes.

    `actuators` are the motors that an arm.toml describes. `disabled_collisions` are the sorted pairs of links that an
    SRDF exempts from collision checks. `moving_names` are the moving joints of the chain, base to tip. There is one per
    column of `screws`, and followers count. `known_ready` is the ready configuration of a baked arm.

    An arm is plain data and picklable. The compiled core computes `fk` and the Jacobians, and NumPy without the core.
    """

    # -- engines -------------------------------------------------------------------------------------------------

    @cached_property
    def compiled(self) -> engine.Chain | None:
        """The arm in the compiled core. None without a core (`engine.why_not()`) or for more than 64 joints."""
        bounds = self.limits.lower, self.limits.upper
        numbers = self.screws, self.home, self.coupling.A
        return engine.chain_of(*numbers, bounds, self.sampling_bounds, self.reach)

    def require_core(self, what: str) -> engine.Chain:
        """The arm in the compiled core. Without it raise TwistarmError, which names `what` and the remedy."""
        if self.compiled is None:
            raise TwistarmError(f"{what} needs the compiled core: {self.why_not_compiled}")
        return self.compiled

    @property
    def why_not_compiled(self) -> str:
        """Why the arm is not in the compiled core. Empty if it is."""
        if self.compiled is not None:
            return ""
        count = max(self.coupling.A.shape)
        return engine.why_not() or f"its chains have at most {engine.MOST_JOINTS} joints; {self.name} has {count}"

    @cached_property
    def _numpy(self) -> engine.NumpyChain:
        return engine.NumpyChain(self.screws, self.home, self.coupling.A)

    @cached_property
    def _engine(self) -> Any:
        """The engine of `fk` and the Jacobians: the compiled core if it has the arm, else NumPy."""
        return self._numpy if self.compiled is None else self.compiled

    def by_exponentials(self, theta: ArrayLike) -> tuple[Array, Array, Array]:
        """g_st (..., 4, 4), J^s and J^b (..., 6, n) by product of exponentials in NumPy, without the compiled core."""
        x = self._asked_at(theta)
        g, body = self._numpy.fk_and_body_jacobian(x)
        return g, self._numpy.spatial_jacobian(x), body

    def by_pinocchio(self, theta: ArrayLike) -> tuple[Array, Array, Array]:
        """g_st (..., 4, 4), J^s and J^b (..., 6, n) by Pinocchio, independent of the engine of `fk`."""
        x = self._asked_at(theta)
        answers = self.pinocchio.kinematics(x.reshape(-1, self.n), self.base, self.tip_link)
        g, spatial, body = (answer.reshape(*x.shape[:-1], *answer.shape[1:]) for answer in answers)
        return g @ self.tool, spatial, adjoint(inverse(self.tool)) @ body

    # -- forward kinematics --------------------------------------------------------------------------------------

    def fk(self, theta: ArrayLike) -> Array:
        """Forward kinematics g_st(theta), (..., 4, 4): the tool seen from the base."""
        return self._computed(self._engine.fk, theta, (4, 4))

    def pose(self, theta: ArrayLike, frame: str) -> Array:
        """Pose (..., 4, 4) of a frame of `frame_names` seen from the base.

        Args:
            theta: Configurations (..., n) [rad, m].
            frame: A name of `frame_names`.

        Raises:
            InputError: theta does not fit the arm.
            UnknownNameError: The arm has no such frame.
        """
        if not isinstance(frame, str) or frame not in self.frame_names:
            listing = f"{len(self.frame_names)} frames: arm.frame_names or `twistarm info ARM --json`"
            within = self.name if self.description is not None else f"{self.name}, {self._whence}"
            raise unknown_name("frame", frame, self.frame_names, within=within, listing=listing)
        if frame == self.tip:
            return self.fk(theta)
        x = self._asked_at(theta)
        return self._link_poses(x, {}, [frame])[frame] if self.description else self._identity(x)

    def poses(self, theta: ArrayLike, other_joints: Mapping[str, float] | None = None) -> dict[str, Array]:
        """Pose (..., 4, 4) of every frame in the base frame, {frame: g}.

        Args:
            theta: Configurations (..., n) [rad, m].
            other_joints: Values of joints outside the chain by name (fingers, a second arm) [rad, m]; 0 where absent.

        Raises:
            InputError: theta does not fit the arm, or a value is not a finite number.
            UnknownNameError: There is no such joint outside the chain.
        """
        x = self._asked_at(theta)
        others = {} if other_joints is None else require_mapping(other_joints, "other_joints", "{'finger_joint': 0.02}")
        masters = {affine.master for affine in self.couplings.values() if affine.master is not None}
        outside = sorted(masters - set(self.joint_names))
        for name in others:
            if name not in outside:
                listing = f"independent joints outside the chain: {listed(outside) or 'none'}"
                raise unknown_name("joint outside the chain", name, outside, within=self.name, listing=listing)
        if self.description is None:
            return {self.base: self._identity(x), self.tip: self.fk(x)}
        poses = self._link_poses(x, others, self.description.links)
        if self.tip not in poses:
            poses[self.tip] = poses[self.tip_link] @ self.tool
        return poses

    def _link_poses(self, x: Array, others: Mapping[str, float], links: Iterable[str]) -> dict[str, Array]:
        """Pose (..., 4, 4) of links in the base frame, by Pinocchio if it is installed."""
        rows = x.reshape(-1, self.n)
        if why_no_pinocchio():
            poses = self.walked_poses(rows, others)
        else:
            model = self.pinocchio
            poses = model.link_poses([model.q(row, others) for row in rows], self.base, links)
        return {link: poses[link].reshape(*x.shape[:-1], 4, 4) for link in links}

    def walked_poses(self, theta: Array, others: Mapping[str, float] = NOTHING) -> dict[str, Array]:
        """Every link's pose (N, 4, 4) in the base frame, by exponentials along the tree of joints.

        Args:
            theta: Configurations (N, n) [rad, m].
            others: Values of joints outside the chain. The rest are at 0.
        """
        if self.description is None:
            raise InputError(f"{self.name} has no description, so only its tool has a pose: use fk")
        poses = self.description.link_poses(self.joint_values(theta, others))
        back = inverse(poses[self.base])
        return {link: np.array(np.broadcast_to(back @ g, (len(theta), 4, 4))) for link, g in poses.items()}

    def joint_values(self, theta: ArrayLike, others: Mapping[str, float] = NOTHING) -> dict[str, Array]:
        """The value (...) of each moving joint, couplings included.

        Args:
            theta: Configurations (..., n) [rad, m].
            others: Values of joints outside the chain. The rest are at 0.
        """
        x = np.moveaxis(self._asked_at(theta), -1, 0)
        columns = dict(zip(self.joint_names, x, strict=True)) | {k: np.array(value) for k, value in others.items()}
        zero = np.zeros(x.shape[1:])
        return {
            name: affine.multiplier * columns.get(affine.master or "", zero) + affine.offset + zero
            for name, affine in self.couplings.items()
        }

    # -- differential kinematics ---------------------------------------------------------------------------------

    def spatial_jacobian(self, theta: ArrayLike) -> Array:
        """Spatial Jacobian J^s (..., 6, n): V^s = J^s θ̇ with V^s = (ġ g⁻¹)^∨, linear part first. MLS §3.4.1."""
        return self._computed(self._engine.spatial_jacobian, theta, (6, self.n))

    def body_jacobian(self, theta: ArrayLike) -> Array:
        """Body Jacobian J^b (..., 6, n): V^b = J^b θ̇ with V^b = (g⁻¹ ġ)^∨, linear part first. MLS §3.4.1."""
        return self._computed(self._engine.body_jacobian, theta, (6, self.n))

    def hybrid_jacobian(self, theta: ArrayLike) -> Array:
        """(..., 6, n): velocity of the tool's origin and its angular velocity, both in base axes.

        Neither spatial nor body: diag(R, R) J^b; Pinocchio calls it LOCAL_WORLD_ALIGNED.
        """
        R = self.fk(theta)[..., :3, :3]
        J = self.body_jacobian(theta)
        return np.concatenate([R @ J[..., :3, :], R @ J[..., 3:, :]], axis=-2)

    def manipulability(self, theta: ArrayLike, length: float | None = None) -> Manipulability:
        """Singular values, condition number and ellipsoids of the body Jacobian, with metres measured in `length`.

        Args:
            theta: Configurations (..., n) [rad, m].
            length: The length [m] that counts like 1 rad. By default `reach`.

        Raises:
            InputError: theta does not fit the arm, or length is not positive.
        """
        scale = self.reach if length is None else as_number(length, "length")
        if not scale > 0:
            raise InputError(f"length must be positive, in metres; got {scale:g}")
        x, unit = self._asked_at(theta), np.where(self.prismatic, scale, 1.0)
        return manipulability_of(
            self.body_jacobian(x), self.prismatic, scale,
            lambda index, steps: self.body_jacobian(x[index] + steps * unit),
        )  # fmt: skip

    def fk_and_body_jacobian(self, theta: Array) -> tuple[Array, Array]:
        """g_st (..., 4, 4) and J^b (..., 6, n) in one pass, for inner loops. The units of theta are not checked."""
        both = None if self.compiled is None else self.compiled.fk_and_body_jacobian(theta)
        return self._numpy.fk_and_body_jacobian(self._theta_of(theta)) if both is None else both

    # -- statics -------------------------------------------------------------------------------------------------

    def joint_torques(self, theta: ArrayLike, wrench_body: ArrayLike) -> Array:
        """τ = J_bᵀ F (..., n) [N m or N]: the joints' torques when the tool exerts F on the world. MLS §3.4.2.

        Args:
            theta: Configurations (..., n) [rad, m].
            wrench_body: Wrenches F = (f, τ) (..., 6) [N, N m], in tool axes at the tool's origin.

        Raises:
            InputError: theta or the wrench has another shape, or is not finite.
        """
        F = as_twist(wrench_body, "wrench_body")
        return np.einsum("...in,...i->...n", self.body_jacobian(theta), F)

    def inverse_dynamics(
        self,
        theta: ArrayLike,
        theta_dot: ArrayLike | None = None,
        theta_ddot: ArrayLike | None = None,
        *,
        payload: float | tuple[ArrayLike, ArrayLike] = 0.0,
        gravity: ArrayLike | None = None,
    ) -> Array:
        """τ = M(θ) θ̈ + C(θ, θ̇) θ̇ + N(θ), (..., n) [N m or N]: the inverse dynamics, with the base at rest.

        Of theta alone they are the torques N(θ) that hold the arm still against gravity.

        Every joint of the description counts that theta moves, mimic followers too: τ = Aᵀ τ_joints with their coupling
        A. Locked joints are fixed. The model has no friction, no elasticity and no inertia of motors. A link without
        `<inertial>` weighs nothing. Sources: MLS §4.3; Featherstone 2008, §5.3 (recursive Newton-Euler, by Pinocchio).

        Args:
            theta: Configurations (..., n) [rad, m].
            theta_dot: Velocities (..., n) [rad/s, m/s]. None is at rest.
            theta_ddot: Accelerations (..., n) [rad/s², m/s²]. None is none.
            payload: A point mass at the tool [kg], or the mass and its place (3,) in tool axes [m].
            gravity: Acceleration of free fall (3,) [m/s²], in base axes. None is `self.gravity`.

        Raises:
            InputError: An argument has another shape, or the payload is negative.
            TwistarmError: The arm has no description, and so no masses.

        Warns:
            UserWarning: No link that moves has a mass.
        """
        rates = [(theta_dot, "theta_dot"), (theta_ddot, "theta_ddot")]
        given = [np.zeros(self.n) if x is None else as_theta(x, self.n, name, self.joint_names) for x, name in rates]
        motion = [self._asked_at(theta), *given]
        require_broadcast(
            **{name: x.shape[:-1] for name, x in zip(("theta", "theta_dot", "theta_ddot"), motion, strict=True)}
        )
        pair = payload if isinstance(payload, (tuple, list)) and len(payload) == 2 else (payload, np.zeros(3))
        mass = as_number(pair[0], "the payload's mass", 0.0, unit="kg")
        offset = as_vector(pair[1], "the payload's place")
        if not self.pinocchio.moved_mass:
            warn(f"no link that {self.name} moves has a mass: its own weight counts as 0", UserWarning)
        load = mass, self.tool[:3, :3] @ require_one(offset, "the payload's place", 1) + self.tool[:3, 3]
        at = np.broadcast_arrays(*motion)
        rows = [x.reshape(-1, self.n) for x in at]
        fall = require_one(as_vector(self.gravity if gravity is None else gravity, "gravity"), "gravity", 1)
        efforts = self.pinocchio.inverse_dynamics(rows, self.base, fall, self.tip_link, load)
        return efforts.reshape(at[0].shape)

    @property
    def gravity(self) -> Array:
        """The acceleration of free fall (3,) [m/s²] in base axes: (0, 0, −9.81) unless an MJCF gives another.

        An MJCF gives it in the world. The base then has its pose with all joints at 0.
        """
        if self.description is None or self.description.gravity is None:
            return np.array(GRAVITY)
        R = self.description.link_poses({})[self.base][:3, :3]
        return np.asarray(R.T @ self.description.gravity)

    def with_tool(self, g_tip_tool: ArrayLike, name: str) -> Arm:
        """A new arm with a tool frame `name` beyond the present tip.

        Args:
            g_tip_tool: The tool's pose (4, 4), seen from the present tip.
            name: The name of the new frame.

        Raises:
            InputError: g_tip_tool is not one pose in SE(3), or the arm has a frame of that name.
        """
        g = require_one(as_pose(g_tip_tool, "g_tip_tool"), "g_tip_tool", 2)
        if not isinstance(name, str) or not name.strip():
            raise InputError(f"the tool's name must be a text, and not an empty one; got {quote(name)}")
        if name in self.frame_names:
            raise InputError(f"{self.name} has a frame {name!r} already; give the tool another name")
        end = self.home[:3, 3]
        home = self.home @ g
        reach = self.reach + float(np.linalg.norm(home[:3, 3] - end))
        return replace(self, tip=name, tool=self.tool @ g, home=home, reach=reach, known_ready=None)

    # -- inside --------------------------------------------------------------------------------------------------

    def _identity(self, theta: Array) -> Array:
        """The base seen from itself, one for each configuration."""
        return np.tile(np.eye(4), (*theta.shape[:-1], 1, 1))

    def _computed(self, kernel: Callable[[Any], Array | None], theta: ArrayLike, shape: tuple[int, ...]) -> Array:
        """`kernel` of theta (..., n), a method of `_engine`. The core may answer None at first: see there."""
        answer = None if self.compiled is None else kernel(theta)
        if answer is None:
            x = self._asked_at(theta)
            rows = engine.answered(kernel(np.require(x.reshape(-1, self.n), np.float64, ["C", "A"])))
            answer = rows.reshape(*x.shape[:-1], *shape)
        return answer


def require_arm(arm: Any) -> Arm:
    """`arm`, or InputError."""
    return require(arm, Arm, "arm", "as load_arm returns it")
